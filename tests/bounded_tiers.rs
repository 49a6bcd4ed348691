//! Which requests for bounds are answered by what, and when.

use std::sync::Arc;

use jit::shaders::{Shaders, Tiering};
use renderer::surface::{
    Bounded, BoundedPoint, BoundedSample, SurfaceEval, SurfaceId, SurfacePoint,
};
use support::agreement::load;
use support::enclosure::{Place, Tally, bounds, check_program, numbers};
use vm::machine::Limits;
use vm::program::LoadedProgram;
use vm::surfaces::InterpSurfaces;
use vm::value::Closure;

#[allow(dead_code, unreachable_pub, reason = "shared with the fuzz targets, where it is public")]
mod support {
    pub(crate) mod agreement;
    pub(crate) mod enclosure;
}

const LIMITS: Limits = Limits { fuel: 10_000_000, max_depth: 100_000, max_memory: 1 << 30 };

/// Has decisions, and depends on all.
const WAVES: &str = "{ /v /u /face u 7.0 mulf floor 2 modi 0 eqi { v } { u v mulf sin } if /x \
     face real x v point 1.0 0.5 u }";

fn surface(text: &str) -> (Arc<LoadedProgram>, [Arc<Closure>; 1]) {
    let (program, closure) = load(text, LIMITS).expect("it leaves a surface function");
    (program, [closure])
}

/// A point of face 1, with these radii.
fn point(u: f64, u_error: f64, v: f64, v_error: f64) -> BoundedPoint {
    let bounded = |value, error| Bounded { value, error };
    BoundedPoint { face: 1, u: bounded(u, u_error), v: bounded(v, v_error) }
}

fn ask(evaluator: &mut impl SurfaceEval, at: BoundedPoint) -> Option<[Bounded; 6]> {
    evaluator.eval_bounded(SurfaceId(0), &Place(at)).as_ref().map(bounds)
}

fn exactly(evaluator: &mut impl SurfaceEval, at: BoundedPoint) -> [Bounded; 6] {
    let at = SurfacePoint { face: at.face, u: at.u.value, v: at.v.value };
    let Ok(sample) = evaluator.eval(SurfaceId(0), &at) else { panic!("it fails at {at:?}") };
    numbers(&sample).map(Bounded::exact)
}

#[test]
fn what_is_known_exactly_is_answered_exactly() {
    let at = point(0.4, 0.0, 0.3, 0.0);
    let vague = point(0.4, 1e-9, 0.3, f64::INFINITY);
    for (text, is_known_everywhere) in [
        (WAVES, false),
        ("{ /v /u /face face real /x x x x point 1.0 0.5 1.0 }", true),
        ("{ /v /u /face 0.1 0.2 0.3 point 1.0 0.5 1.0 }", true),
    ] {
        let (program, surfaces) = surface(text);
        let mut interpreted = InterpSurfaces::new(&program, &surfaces, LIMITS);
        let expected = exactly(&mut interpreted, at);
        assert_eq!(ask(&mut interpreted, at), Some(expected), "{text}");
        assert_eq!(ask(&mut interpreted, vague), None, "{text}");
        for tiering in [Tiering::Eager, Tiering::Hot] {
            let shaders = Shaders::new(&program, &surfaces, LIMITS, tiering);
            assert_eq!(ask(&mut shaders.worker(), at), Some(expected), "{text}");
        }
        let shaders = Shaders::new(&program, &surfaces, LIMITS, Tiering::Eager);
        let found = ask(&mut shaders.worker(), vague);
        assert_eq!(found.is_some_and(|found| found == expected), is_known_everywhere, "{text}");
    }
}

/// u is on a line of the texture, which is no question if it is known.
#[test]
fn a_coordinate_that_is_known_leaves_nothing_open() {
    let text = "{ /v /u /face u 8.0 mulf floor real 0.125 mulf v addf /x x x u point 1.0 0.5 v }";
    let (program, surfaces) = surface(text);
    let shaders = Shaders::new(&program, &surfaces, LIMITS, Tiering::Eager);
    let mut worker = shaders.worker();
    assert_eq!(ask(&mut worker, point(0.25, 1e-16, 0.3, 1e-16)), None);
    assert_eq!(ask(&mut worker, point(0.25, 1e-16, 0.3, 0.0)), None);
    let found = ask(&mut worker, point(0.25, 0.0, 0.3, 1e-16)).expect("it is decided");
    assert_eq!(found[2], Bounded::exact(0.25));
    assert_eq!(found[0].value, 0.25 + 0.3);
    // The radius, half a unit in the last place for either sum, and a little.
    assert!((2e-16..2.3e-16).contains(&found[0].error), "{found:?}");
}

#[test]
fn nothing_is_known_of_what_is_no_number() {
    let (program, surfaces) =
        surface("{ /v /u /face u 0.0 divf /i i 0.0 mulf /n n i u point 1.0 0.5 0.0 0.0 divf }");
    let shaders = Shaders::new(&program, &surfaces, LIMITS, Tiering::Eager);
    for at in [point(0.5, 1e-9, 0.5, 0.0), point(0.5, 0.0, 0.5, 0.0)] {
        let found = ask(&mut shaders.worker(), at).expect("nothing is to be decided");
        assert!(found[0].error == f64::INFINITY && found[5].error == f64::INFINITY, "{found:?}");
        assert!(found[1].error == f64::INFINITY || at.u.error == 0.0, "{found:?}");
        assert!(found[2].error <= 1e-9 && found[3].error == 0.0, "{found:?}");
    }
    let nothing = ask(&mut shaders.worker(), point(0.5, f64::NAN, 0.5, 0.0));
    assert!(nothing.expect("nothing is to be decided")[2].error == f64::INFINITY);
}

/// How a pixel is known must not depend on when its surface function was compiled.
#[test]
fn bounded_code_is_made_when_first_asked_for() {
    let (program, surfaces) = surface(WAVES);
    let at = point(0.4, 1e-15, 0.3, 1e-15);
    let [hot, eager] = [Tiering::Hot, Tiering::Eager].map(|tiering| {
        let shaders = Shaders::new(&program, &surfaces, LIMITS, tiering);
        ask(&mut shaders.worker(), at).expect("answered at once")
    });
    assert_eq!(hot, eager);
}

#[test]
fn threads_share_bounded_code() {
    let (program, surfaces) = surface(WAVES);
    let shaders = Shaders::new(&program, &surfaces, LIMITS, Tiering::Eager);
    let at = point(0.4, 1e-15, 0.3, 1e-15);
    let expected: Option<BoundedSample> = shaders.worker().eval_bounded(SurfaceId(0), &Place(at));
    let time = shaders.times();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let mut worker = shaders.worker();
                for _ in 0..100 {
                    assert_eq!(worker.eval_bounded(SurfaceId(0), &Place(at)), expected);
                }
            });
        }
    });
    assert!(expected.is_some());
    assert_eq!(shaders.times(), time, "nothing was compiled again");
}

/// Loops and routines, which take and return reals with radii and without.
#[test]
fn loops_and_recursion_have_bounds() {
    let sum = "{ /self /n n 1 lessi { 0.25 } { \
         n 1 subi self self apply 0.5 mulf n real addf } if } /sum";
    let mixed = "{ /self /x /y /n n 1 lessi { x y } { \
         n 1 subi y 0.5 mulf x 1.5 mulf 0.1 addf self self apply /b /a a b addf 0.3 } if } /go";
    let points = "{ /self /p /n n 1 lessi { p } { \
         n 1 subi p getx 0.5 mulf p gety p getz point self self apply /q \
         q getz q getx p gety point } if } /walk";
    let halve = "{ /loop /x x 0.001 lessf { x } { x 0.7 mulf loop loop apply } if } /go";
    for (before, gray) in [
        (sum, "u 20.0 mulf floor sum sum apply u mulf"),
        (mixed, "u 9.0 mulf floor v 0.5 go go apply /b /a a b mulf"),
        (mixed, "face 2.0 u go go apply /b /a a b subf"),
        (mixed, "u 9.0 mulf floor 2.0 0.5 go go apply /b /a a v addf b subf"),
        (points, "v 9.0 mulf floor u v 0.5 point walk walk apply getx"),
        (
            "",
            "{ /loop /x /i i 1 lessi { x } { i 1 subi x x mulf u subf loop loop apply } if } /go \
              v 5.0 mulf floor v go go apply",
        ),
        (halve, "v go go apply u mulf"),
    ] {
        let text = format!("{before} {{ /v /u /face {gray} /x x x x point 1.0 0.0 u }}");
        let mut tally = Tally::default();
        let at = |k: u32| {
            let part = |k: u32| (f64::from(k) + 0.371_9) / 20.0;
            let error = 10f64.powi(-16 + (k % 8) as i32);
            point(part(k % 20), error, part(k / 20), error)
        };
        let is_native = check_program(&text, LIMITS, (0..400).map(at), 4, &mut tally);
        assert_eq!(is_native, Some(true), "{text}");
        assert!(tally.asked == 400 && tally.part_answered() > 0.9, "{tally:?}: {text}");
    }
}
