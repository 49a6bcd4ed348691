//! What surface functions are asked with, and when they are compiled.

use jit::shaders::{Evaluation, Shaders, Tiering};
use renderer::surface::{Needs, SurfaceEval, SurfaceId, SurfacePoint};
use support::agreement::{Place, load, told};
use support::generator::LIMITS;

#[allow(dead_code, unreachable_pub, reason = "each test takes its part")]
mod support {
    pub(crate) mod agreement;
    pub(crate) mod generator;
}

#[test]
fn functions_are_told_what_they_read_and_no_more() {
    let needs = |face, u, v| Some(Needs { face, u, v });
    let cases = [
        ("{ /v /u /face 0.5 0.5 0.5 point 1.0 0.0 1.0 }", None),
        ("{ /v /u /face u u u point 1.0 0.0 1.0 }", needs(false, true, false)),
        ("{ /v /u /face v u 0.0 mulf v point 1.0 0.0 1.0 }", needs(false, true, true)),
        (
            "{ /v /u /face 0.1 0.2 0.3 point face 1 eqi { 1.0 } { 0.5 } if 0.0 1.0 }",
            needs(true, false, false),
        ),
        // Whether it fails depends on v, though no result does.
        ("{ /v /u /face v sqrt /root 0.1 0.2 0.3 point 1.0 0.0 1.0 }", needs(false, false, true)),
    ];
    for (text, expected) in cases {
        let (loaded, closure) = load(text, LIMITS).expect("a function");
        let surfaces = [closure];
        let shaders = Shaders::new(&loaded, &surfaces, LIMITS, Tiering::Eager);
        let place = Place::new(SurfacePoint { face: 1, u: 0.25, v: 0.75 });
        shaders.worker().eval(SurfaceId(0), &place).expect("no error");
        assert_eq!(place.asked.get(), expected, "{text}");
    }
}

#[test]
fn functions_are_compiled_when_it_pays() {
    let wavy = "{ /v /u /face u 360.0 mulf sin v v point 1.0 0.0 1.0 }";
    let constant = "{ /v /u /face 0.1 0.2 0.3 point 1.0 0.0 1.0 }";
    // How soon each is decided, in calls.
    let cases = [(wavy, 10_000..100_000), (constant, 500..10_000)];
    for (text, expected) in cases {
        let (loaded, closure) = load(text, LIMITS).expect("a function");
        let surfaces = [closure];
        let shaders = Shaders::new(&loaded, &surfaces, LIMITS, Tiering::Hot);
        let mut worker = shaders.worker();
        let mut n_calls = 0;
        let at = SurfacePoint { face: 0, u: 0.3, v: 0.4 };
        let first = told(worker.eval(SurfaceId(0), &at));
        while shaders.report()[0].evaluation == Evaluation::Cold {
            assert_eq!(told(worker.eval(SurfaceId(0), &at)), first, "{text}");
            n_calls += 1;
            assert!(n_calls < expected.end, "{text} is still interpreted");
        }
        assert!(n_calls >= expected.start, "{text} is decided after {n_calls} calls");
        assert_eq!(told(worker.eval(SurfaceId(0), &at)), first, "{text}");
    }
}
