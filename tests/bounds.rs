//! Surface functions that would keep a compiler busy for ever, if it had no bounds: they are declined
//! or compiled, and give what the interpreter gives. Without the bounds these tests do not end.

use jit::shaders::Evaluation;
use renderer::surface::SurfacePoint;
use support::agreement::agree;
use vm::machine::Limits;

#[allow(unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
}

const LIMITS: Limits = Limits { fuel: 10_000_000, max_depth: 100_000, max_memory: 1 << 30 };

fn check(before: &str, gray: &str) -> Evaluation {
    let text = format!("{before} {{ /v /u /face {gray} /x x x x point 1.0 0.0 1.0 }}");
    let points = [(0, 0.25, 0.75), (3, 0.75, 0.25)].map(|(face, u, v)| SurfacePoint { face, u, v });
    let agreed = agree(&text, LIMITS, points.into_iter()).expect("a surface function");
    assert!(agreed.results.iter().all(Result::is_ok), "{:?}", agreed.results);
    agreed.evaluation
}

fn is_native(evaluation: &Evaluation) -> bool {
    matches!(evaluation, Evaluation::Native { .. } | Evaluation::Constant)
}

/// Makes of a value an array of 2^n times the value, in n steps.
fn doubling(n: usize) -> String {
    format!("{{ {}}} /double", "/x [x x] ".repeat(n))
}

#[test]
fn values_that_share_their_parts() {
    let first = "0 get ".repeat(40);
    // Different and equal on the sides of a condition, and of different depths.
    let sides = [("u", "v"), ("u", "u"), ("u", "[v]"), ("face", "0")];
    for (a, b) in sides {
        let gray = format!(
            "u 0.5 lessf {{ {a} double apply }} {{ {b} double apply }} if /a a length real"
        );
        check(&doubling(40), &gray);
    }
    // Changed by a loop, and by a recursion.
    let looped =
        "{ /loop /i /a i 1 lessi { a } { u double apply i 1 subi loop loop apply } if } /go";
    check(&doubling(40), &format!("{looped} v double apply face go go apply {first}"));
    let recursive = "{ /self /a /n n 1 lessi { a } { \
         n 1 subi u double apply self self apply } if } /go";
    check(&doubling(40), &format!("{recursive} face v double apply go go apply {first}"));
    // Looked up by an index that is not known, again and again.
    let lookups = "dup face 3 divi get 0 get drop ".replace("dup", "a").replace("drop", "/b");
    check(&doubling(18), &format!("1.0 double apply /a {} 1.0", lookups.repeat(2000)));
}

#[test]
fn closures_that_share_their_parts() {
    let wrap = "/x x /y { x y } ".repeat(40);
    let gray = format!("u 0.5 lessf {{ u {wrap}}} {{ v {wrap}}} if /f 1.0");
    check("", &gray);
}

#[test]
fn many_values_on_the_stack_at_many_conditions() {
    let values = "u ".repeat(20_000);
    let conditions = "v 0.5 lessf { 1.0 } { 2.0 } if /x ".repeat(5_000);
    let gray = format!("[{values} {conditions}] length real");
    check("", &gray);
}

#[test]
fn loops_that_unroll() {
    let text = "{ /loop /i /x i 1 lessi { x } { x u addf i 1 subi loop loop apply } if } /go";
    check("", &format!("{text} 0.0 200000 go go apply"));
}

#[test]
fn recursion_that_spreads() {
    // Each call makes two others, of functions that do the same.
    let mut text = "{ /n n real u mulf } /f0 ".to_owned();
    for k in 1..40 {
        let below = k - 1;
        text += &format!(
            "{{ /n u 0.5 lessf {{ n f{below} apply }} {{ n 1 addi f{below} apply }} if \
                 v 0.5 lessf {{ n f0 apply }} {{ n 2 addi f0 apply }} if addf }} /f{k} "
        );
    }
    check("", &format!("{text} face f18 apply"));
    let ackermann = "{ /self /n /m m 0 eqi { n 1 addi } { n 0 eqi { m 1 subi 1 self self apply } { \
         m 1 subi m n 1 subi self self apply self self apply } if } if } /ack";
    check(ackermann, "face 2 modi face ack ack apply real");
}

#[test]
fn values_that_nest_deeply() {
    let nest = "/x [x] ".repeat(20_000);
    check("", &format!("u 0.5 lessf {{ u {nest} }} {{ v {nest} }} if /a a length real"));
    check("", &format!("u {}/a 1.0", "/x [x] ".repeat(48_000)));
    check("", &format!("u 0.5 lessf {{ u {} }} {{ v }} if /a 1.0", "/x [x] ".repeat(32_000)));
    let nest = "/x { x } ".repeat(20_000);
    check("", &format!("u 0.5 lessf {{ u {nest} }} {{ v {nest} }} if /a 1.0"));
}

/// A function that leaves a number after fifty rounds. Each takes values along that are made anew, of
/// so many others in so many levels; and each of 2^`n_conditions` ways ends in a round.
fn rebuilding(n_values: usize, levels: usize, n_alike: usize, n_conditions: usize) -> String {
    let level = format!("/part [ {} ] ", "part ".repeat(n_alike));
    let value = format!("[ {} ] {}", "z ".repeat(n_alike), level.repeat(levels));
    let names: Vec<String> = (0..n_values).map(|n| format!("value{n}")).collect();
    let binders: String = names.iter().rev().map(|name| format!("/{name} ")).collect();
    let made: String = names.iter().map(|name| format!("{value} /{name} ")).collect();
    let taken = names.join(" ");
    let ways = (0..n_conditions).fold(format!("n 1 addi {taken} self self apply "), |ways, n| {
        format!("u {n}.5 lessf {{ {ways}}} {{ {ways}}} if ")
    });
    format!(
        "v /z {{ /self {binders} /n {made} n 50 lessi {{ {ways} }} {{ n real }} if }} /loop \
         {made} 0 {taken} loop loop apply"
    )
}

#[test]
fn rounds_that_rebuild_what_they_take_along() {
    assert!(is_native(&check("", &rebuilding(1, 1, 29, 2))));
    // Comparing the rounds of all ways takes too long; and of the second, for one way.
    assert!(!is_native(&check("", &rebuilding(16, 1, 29, 7))));
    check("", &rebuilding(1, 4, 30, 6));
}

#[test]
fn closures_of_many_captured_values() {
    // Entering a function takes time with what it has captured, and so does making another.
    let rounds = |n_rounds: usize| {
        let names: Vec<String> = (0..20_000).map(|n| format!("a{n}")).collect();
        let binders: String = names.iter().map(|name| format!("/{name} ")).collect();
        let (values, uses) = ("1 ".repeat(names.len()), names.join(" "));
        let round = format!("{{ {uses} }} /closure n 1 subi self self apply");
        let before = format!(
            "{{ {binders} {{ /self /n n 0 eqi {{ 0.5 }} {{ {round} }} if }} }} /make \
             {values} make apply /loop"
        );
        check(&before, &format!("{n_rounds} loop loop apply"))
    };
    assert!(is_native(&rounds(20)));
    assert!(!is_native(&rounds(60)));
}
