//! What is hard to compile and must be, by both engines: recursion whose depth depends on data, with
//! limits met as the interpreter meets them, and values of several types.

use jit::shaders::Evaluation;
use renderer::surface::SurfacePoint;
use support::agreement::{Told, agree};
use vm::machine::Limits;

#[allow(unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
}

const LIMITS: Limits = Limits { fuel: 10_000_000, max_depth: 100_000, max_memory: 1 << 30 };

/// A surface function whose colour is the given expression three times.
fn surface(before: &str, gray: &str) -> String {
    format!("{before} {{ /v /u /face {gray} /x x x x point 1.0 0.0 1.0 }}")
}

/// Calls a surface function at 36 points; says how it was evaluated.
fn call(text: &str, limits: Limits) -> (Evaluation, Vec<Told>) {
    call_at(36, text, limits)
}

/// The same at `n` points, u from 0 to 1.
fn call_at(n: u8, text: &str, limits: Limits) -> (Evaluation, Vec<Told>) {
    let points = (0..n).map(|k| {
        let u = f64::from(k) / f64::from(n - 1);
        SurfacePoint { face: k % 6, u, v: f64::from(n - 1 - k) / f64::from(n - 1) }
    });
    let agreed = agree(text, limits, points).expect("it leaves a surface function");
    (agreed.evaluation, agreed.results)
}

fn assert_native(text: &str) {
    let (evaluation, results) = call(text, LIMITS);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}: {text}");
    assert!(results.iter().all(Result::is_ok), "{results:?}: {text}");
}

/// `n own apply`, twice for each n.
const FIB: &str = "{ /self /n n 2 lessi { n } { \
     n 1 subi self self apply n 2 subi self self apply addi } if } /fib";

#[test]
fn one_number_in_and_one_out() {
    let sum = "{ /self /n n 1 lessi { 0.25 } { \
         n 1 subi self self apply 0.5 mulf n real addf } if } /sum";
    assert_native(&surface(sum, "u 200.0 mulf floor sum sum apply"));
    assert_native(&surface(FIB, "u 12.0 mulf floor fib fib apply real"));
}

#[test]
fn noise_of_octaves_as_data_says() {
    let noise = "[0.1 0.7 0.3 0.9 0.5] /lattice \
         { /x x floor 5 modi /i i 0 lessi { i negi } { i } if /i lattice i get } /noise \
         { /self /gain /x /n n 0 eqi { 0.0 } { \
             x noise apply gain mulf \
             n 1 subi x 2.0 mulf gain 0.5 mulf self self apply addf } if } /fbm";
    assert_native(&surface(noise, "face 2 addi u 7.0 mulf 0.5 fbm fbm apply"));
}

#[test]
fn points_closures_and_arrays_pass_through() {
    let points = "{ /self /p /n n 1 lessi { p } { \
         n 1 subi p getx 0.5 mulf p gety p getz point self self apply /q \
         q getz q getx p gety point } if } /walk";
    assert_native(&surface(points, "v 9.0 mulf floor u v 0.5 point walk walk apply getx"));
    let closures = "{ /self /f /n n 1 lessi { u f apply } { \
         n 1 subi { f apply 0.5 mulf } self self apply n real addf } if }";
    // The closure grows with each call: the interpreter's.
    let text = surface("", &format!("{closures} /go face {{ }} go go apply"));
    assert!(matches!(call(&text, LIMITS).0, Evaluation::Declined(_)));
    let arrays = "{ /self /a /n n 1 lessi { a 0 get } { \
         n 1 subi [a 1 get a 0 get 0.5 mulf] self self apply n real addf } if } /go";
    assert_native(&surface(arrays, "u 50.0 mulf floor [u v] go go apply"));
    let one_closure = "{ /self /f /n n 1 lessi { 0.5 } { \
         n 1 subi f self self apply f apply } if } /go";
    assert_native(&surface(one_closure, "u 50.0 mulf floor { v mulf } go go apply"));
}

#[test]
fn two_functions_call_each_other() {
    let text = "{ /me /you /n n 1 lessi { 0.0 } { n 1 subi me you you apply 1.0 addf } if } /a \
         { /me /you /n n 1 lessi { 0.5 } { n 1 subi me you you apply 2.0 mulf } if } /b";
    assert_native(&surface(text, "u 40.0 mulf floor b a a apply"));
}

#[test]
fn loops_within_and_around() {
    let text = "{ /loop /i /x i 1 lessi { x } { x 0.5 mulf i 1 subi loop loop apply } if } /halve \
         { /self /n n 1 lessi { 0.5 } { \
             n 1 subi self self apply n halve halve apply 1.0 addf } if } /go";
    assert_native(&surface(text, "u 30.0 mulf floor go go apply"));
    let around = format!(
        "{FIB} {{ /loop /i /x i 1 lessi {{ x }} {{ \
             x i fib fib apply real addf i 1 subi loop loop apply }} if }} /go"
    );
    assert_native(&surface(&around, "v u 9.0 mulf floor go go apply"));
}

#[test]
fn more_values_than_arguments() {
    // It takes what lies below its arguments on the way back, and leaves two for one.
    let text = "{ /self /n n 1 lessi { } { \
         /x n real x addf n 1 subi self self apply 0.5 addf } if } /go";
    assert_native(&surface(text, "v u 30.0 mulf floor go go apply"));
    // A value too few: an error, the same as ever.
    let (_, results) = call(&surface(text, "u 30.0 mulf floor go go apply"), LIMITS);
    assert!(results.iter().any(Result::is_err));
}

#[test]
fn results_of_other_types_stay_interpreted() {
    let text = "{ /self /n n 1 lessi { 1 } { n 1 subi self self apply real } if } /go";
    let (evaluation, results) = call(&surface(text, "face go go apply real"), LIMITS);
    assert!(matches!(evaluation, Evaluation::Declined(_)), "{evaluation:?}");
    assert!(results.iter().any(Result::is_err));
}

#[test]
fn errors_deep_within_are_the_interpreters() {
    let text = "[0.1 0.2] /a { /self /n n 1 lessi { 0.5 } { \
         n 1 subi self self apply a n get addf } if } /go";
    let (evaluation, results) = call(&surface(text, "face go go apply"), LIMITS);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
    let n_failed = results.iter().filter(|result| result.is_err()).count();
    assert_eq!(n_failed, 24, "faces 2 to 5");
    assert!(results[2].as_ref().is_err_and(|told| told.contains("Subscript(2, 2)")));
}

#[test]
fn depth_and_fuel_run_out_as_they_do_interpreted() {
    let text = surface(
        "{ /self /n n 1 lessi { 0.5 } { n 1 subi self self apply 0.5 addf } if } /go",
        "u 35000.0 mulf floor go go apply",
    );
    // Each point is 1000 calls deeper than the one before.
    for (limits, problem, n_expected) in [
        (Limits { max_depth: 20_000, ..LIMITS }, "DepthLimit(20000)", 16),
        (Limits { fuel: 100_000, ..LIMITS }, "FuelLimit(100000)", 26),
    ] {
        let (evaluation, results) = call(&text, limits);
        assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
        let n_failed = results.iter().filter(|r| r.as_ref().is_err_and(|t| t.contains(problem)));
        assert_eq!(n_failed.count(), n_expected, "{results:?}");
    }
    // So deep that the native stack is too small, for all that the limits say.
    let deep = text.replace("35000.0", "350000.0");
    let (_, results) = call(&deep, Limits { max_depth: 1_000_000, ..LIMITS });
    assert!(results.iter().all(Result::is_ok));
}

#[test]
fn memory_runs_out_as_it_does_interpreted() {
    let text = format!(
        "{{ /self /n n 1 lessi {{ 0.5 }} {{ [n real {}] /a n 1 subi self self apply a 0 get addf }} if }} /go",
        "1.0 ".repeat(500)
    );
    let limits = Limits { max_memory: 64 << 20, ..LIMITS };
    let text = surface(&text, "u 5000.0 mulf floor go go apply");
    let (evaluation, results) = call_at(5, &text, limits);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
    let failed = results.last().expect("five");
    assert!(failed.as_ref().is_err_and(|told| told.contains("MemoryLimit")), "{failed:?}");
    assert!(results[..4].iter().all(Result::is_ok), "{results:?}");
}

/// What a loop takes along and makes anew adds up in the interpreter's memory, though native code
/// makes no array at all.
#[test]
fn memory_of_loops_runs_out_as_it_does_interpreted() {
    let text = "{ /self /a /n n 1 lessi { a 0 get } { n 1 subi [ a 0 get 1.0 addf ] self self apply } if } /go";
    let limits = Limits { max_memory: 64 << 20, fuel: 1_000_000_000, ..LIMITS };
    let text = surface(text, "u 2000000.0 mulf floor [ 0.0 ] go go apply");
    let (evaluation, results) = call_at(5, &text, limits);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
    let failed = |told: &Told| told.as_ref().is_err_and(|told| told.contains("MemoryLimit"));
    assert!(results[..2].iter().all(Result::is_ok) && failed(&results[4]), "{results:?}");
}

#[test]
fn a_recursion_that_never_ends_is_stopped() {
    let text = "{ /self /n n 0 eqi { 0.5 } { n 1 subi self self apply 0.5 addf } if } /go";
    let (evaluation, results) = call(&surface(text, "face 1 addi negi go go apply"), LIMITS);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
    assert!(results.iter().all(|r| r.as_ref().is_err_and(|told| told.contains("Limit"))));
    let never =
        "{ /self /n n 0 eqi { n self self apply } { n 1 subi self self apply } if 1.0 addf } /go";
    let (_, results) = call(&surface(never, "face go go apply"), LIMITS);
    assert!(results.iter().all(Result::is_err));
}

#[test]
fn values_of_several_types_are_told_apart_where_they_are_used() {
    let mixed = "face 3 lessi { u } { face } if /x";
    for text in [
        // An operand, one of a comparison that jumps, a condition, a result.
        surface("", &format!("{mixed} v 0.5 lessf {{ x }} {{ 1.0 }} if 2.0 mulf")),
        surface("", &format!("{mixed} x 0.5 lessf {{ 1.0 }} {{ 2.0 }} if")),
        surface("", "face 3 lessi { u } { v 0.5 lessf } if /x x { 1.0 } { 0.0 } if"),
        format!("{{ /v /u /face {mixed} u v v point x 1.0 1.0 }}"),
    ] {
        let (evaluation, results) = call(&text, LIMITS);
        assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}: {text}");
        assert!(results.iter().any(Result::is_ok), "{results:?}: {text}");
        assert!(results.iter().any(Result::is_err), "{results:?}: {text}");
    }
}

/// Reals on either side of where operators change what they do: signs of zeros, the ends of `clampf`,
/// and of what `floor` has an integer for.
#[test]
fn reals_at_the_edges_of_operators() {
    let two_63 = 9_223_372_036_854_775_808.0;
    let edges = [
        0.0,
        -0.0,
        0.25,
        -0.25,
        1.0,
        -1.0,
        1.0 + f64::EPSILON,
        -3.0,
        two_63,
        -two_63,
        f64::from_bits(f64::to_bits(two_63) - 1),
        -f64::from_bits(f64::to_bits(two_63) + 1),
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    let points = || {
        let point = |u| move |v| SurfacePoint { face: 0, u, v };
        edges.into_iter().flat_map(move |u| edges.into_iter().map(point(u)))
    };
    // Constants stand on either side of operators, and go to where branches meet.
    let expressions = [
        "u frac",
        "u clampf",
        "u floor real",
        "u floor v floor addi real",
        "1.5 u subf u 1.5 subf mulf",
        "2.0 u divf 3.0 v mulf addf",
        "u 2.0 mulf 2.0 v mulf subf",
        "u 0.25 divf v -8.0 divf addf u 3.0 divf subf",
        "u 4.0e-320 divf v 1.7e308 divf addf",
        "0.25 v addf u lessf { 0.75 } { v 1.0 lessf { v } { -0.0 } if } if",
        "1.0 u lessf { u 1.0 lessf { 0.0 } { 1.0 } if } { u } if",
    ];
    let mut n_errors = 0;
    for gray in expressions {
        let text = surface("", gray);
        let agreed = agree(&text, LIMITS, points()).expect("it leaves a surface function");
        let evaluation = agreed.evaluation;
        assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}: {text}");
        n_errors += agreed.results.iter().filter(|result| result.is_err()).count();
    }
    // Those of `floor`: of five reals alone, and of a sum also where it overflows.
    assert!(n_errors > 2 * 5 * edges.len(), "{n_errors}");
}

/// Whole parts as subscripts, where one addition finds them: reals around the bounds, and around those
/// beyond which that addition rounds.
#[test]
fn subscripts_at_the_edges_of_arrays() {
    let mut edges = vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE];
    for near in [0.0, 1.0, 3.0, 4.0, 2_f64.powi(32), 1e300] {
        edges.extend([near, near.next_up(), near.next_down()]);
    }
    for power in 50..54 {
        let near = 2_f64.powi(power);
        edges.extend([near - 1.0, near, near + 1.0, near + 2.0, near + 3.0, near * 1.5]);
    }
    let points = || {
        let reals = edges.iter().flat_map(|real| [*real, -real]);
        reals.map(|u| SurfacePoint { face: 2, u, v: u * 0.5 })
    };
    for gray in [
        "[0.25 0.5 0.75] u floor get",
        "[1 2 3] u floor get real",
        "[true false true] v floor get { u } { v } if",
        "[0.1 0.2 0.3 point 0.4 0.5 0.6 point] u floor get /p p getz p gety p getx subf addf",
        "[[0.1 0.2] [0.3 0.4] [0.5 0.6]] u floor get v floor get",
        "[{ 0.5 } { u }] v floor get apply",
        // What is more than a subscript stays an integer, and what is not one on all ways fails on all.
        "[0.25 0.5 0.75] /a u floor /i v u lessf { a i get } { 0.125 } if",
        "u floor /unused [0.25 0.5 0.75] v floor get",
        "[0.25 0.5 0.75] u floor /i i get i real addf",
    ] {
        let text = surface("", gray);
        let agreed = agree(&text, LIMITS, points()).expect("it leaves a surface function");
        assert!(matches!(agreed.evaluation, Evaluation::Native { .. }), "{:?}", agreed.evaluation);
        let n_errors = agreed.results.iter().filter(|result| result.is_err()).count();
        let n_points = agreed.results.len();
        assert!(n_errors > n_points / 4 && n_errors < n_points, "{n_errors} of {n_points}: {gray}");
    }
}

/// All three numbers of points in tables, as results and in between.
#[test]
fn points_of_tables_lie_where_they_belong() {
    let table = "[ [0.1 0.2 0.3 point 0.4 0.5 0.6 point] [0.7 0.8 0.9 point 1.0 1.1 1.2 point] ] /t \
         [1 2 3] /others";
    for color in [
        "p",
        "p getz p gety p getx point",
        "p getx 0.5 p getz point",
        "p gety p gety p getz point",
        "q getx p gety p getz point",
        "others face 2 modi get real p gety p getz point",
    ] {
        let text = format!(
            "{table} {{ /v /u /face u 1.9 mulf floor /i v 1.9 mulf floor /j \
             t i get j get /p t j get i get /q {color} p gety p getz q getx }}"
        );
        assert_native(&text);
    }
}

/// A shader says by a red that is NaN that the interpreter is to be asked: that one says the same.
#[test]
fn red_may_be_no_number() {
    let text =
        "{ /v /u /face face 3 lessi { 0.0 v 0.0 mulf divf } { u } if v u point 1.0 0.5 2.0 }";
    let (evaluation, results) = call(text, LIMITS);
    assert!(matches!(evaluation, Evaluation::Native { .. }), "{evaluation:?}");
    let is_nan = |told: &Told| matches!(told, Ok([red, ..]) if f64::from_bits(*red).is_nan());
    assert_eq!(results.iter().filter(|told| is_nan(told)).count(), 18, "{results:?}");
}

/// As many results as there are registers, and one more.
#[test]
fn results_of_recursion_are_as_many_as_registers() {
    for (n, is_native) in [(8, true), (9, false)] {
        let halved: String = (0..n).map(|k| format!("a {k} get 0.5 mulf ")).collect();
        let text = format!(
            "{{ /self /u /n n 1 lessi {{ [ {} ] }} {{ n 1 subi u self self apply /a [ {halved} ] }} if }} /go",
            "u ".repeat(n)
        );
        let text = surface(&text, "v 9.0 mulf floor u go go apply 1 get");
        let (evaluation, results) = call(&text, LIMITS);
        match evaluation {
            Evaluation::Native { .. } => assert!(is_native, "{n}"),
            Evaluation::Declined(why) => {
                assert!(!is_native && why.reason.contains("too many values"), "{}", why.reason)
            }
            other => panic!("{other:?}"),
        }
        assert!(results.iter().all(Result::is_ok), "{results:?}");
    }
}

/// Results that are constants, of any number and in any place, beside others.
#[test]
fn constant_results_lie_where_they_belong() {
    for known in 0_u32..64 {
        let result = |place: u32| {
            if known >> place & 1 == 1 {
                format!("{}.5", place + 1)
            } else {
                format!("u {}.0 addf", place + 10)
            }
        };
        let [red, green, blue, kd, ks, n] = std::array::from_fn(|place| result(place as u32));
        let text = format!("{{ /v /u /face {red} {green} {blue} point {kd} {ks} {n} }}");
        let (evaluation, results) = call(&text, LIMITS);
        let is_known = known == 63;
        assert_eq!(matches!(evaluation, Evaluation::Native { .. }), !is_known, "{evaluation:?}");
        let bits = |place: u32| {
            let number = f64::from(place);
            if known >> place & 1 == 1 { number + 1.5 } else { number + 10.0 }.to_bits()
        };
        // The first point has u = 0.
        assert_eq!(results[0], Ok(std::array::from_fn(|place| bits(place as u32))), "{text}");
    }
}
