//! Properties of the renderer on random scenes, which proptest shrinks when one fails.
//!
//! The main oracle is membership: whether a point is in a solid follows from the description by
//! undoing its transforms one by one, in code that shares nothing with the tracer. Along a ray, the
//! first change of membership is where the tracer must find its hit. Where each shape is entered and
//! left is found by minimizing and bisecting how far a point is outside, which is convex along a ray
//! for all five shapes: so nothing is too thin to be seen.
//!
//! The seed is fixed, lest the tests pass today and fail tomorrow; `GMLVM_PROPERTY_SEED` and
//! `GMLVM_PROPERTY_CASES` search elsewhere.

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use renderer::camera::{Region, View};
use renderer::image::Image;
use renderer::light::{Attenuation, Light};
use renderer::numeric::dd::Dd;
use renderer::numeric::real::Real;
use renderer::object::{Object, ShapeKind, TransformOp};
use renderer::scene::Scene;
use renderer::shade::{Illumination, RayCounts};
use renderer::surface::{Locate, SurfaceEval, SurfaceId, SurfaceSample};

/// A description of which the test knows the parts.
#[derive(Clone, Debug)]
enum Solid {
    Shape(ShapeKind, u32),
    Moved(TransformOp, Box<Solid>),
    Union(Box<Solid>, Box<Solid>),
    Intersect(Box<Solid>, Box<Solid>),
    Difference(Box<Solid>, Box<Solid>),
}

impl Solid {
    fn object(&self) -> Object<u32> {
        match self {
            Solid::Shape(kind, id) => Object::shape(*kind, *id),
            Solid::Moved(op, inner) => inner.object().transformed(*op).expect("a fine transform"),
            Solid::Union(a, b) => a.object().union(&b.object()),
            Solid::Intersect(a, b) => a.object().intersect(&b.object()),
            Solid::Difference(a, b) => a.object().difference(&b.object()),
        }
    }

    fn moved(self, op: TransformOp) -> Solid {
        Solid::Moved(op, Box::new(self))
    }

    /// Whether a point is inside; the shapes that hold it are noted by number.
    fn holds(&self, p: DVec3, shapes: &mut u64) -> bool {
        match self {
            Solid::Shape(kind, id) => {
                let inside = in_shape(*kind, p);
                *shapes |= u64::from(inside) << id;
                inside
            }
            Solid::Moved(op, inner) => inner.holds(undone(*op, p), shapes),
            Solid::Union(a, b) => a.holds(p, shapes) | b.holds(p, shapes),
            Solid::Intersect(a, b) => a.holds(p, shapes) & b.holds(p, shapes),
            Solid::Difference(a, b) => a.holds(p, shapes) & !b.holds(p, shapes),
        }
    }
}

fn in_shape(kind: ShapeKind, p: DVec3) -> bool {
    let unit = |x: f64| (0.0..=1.0).contains(&x);
    let r2 = p.x * p.x + p.z * p.z;
    match kind {
        ShapeKind::Sphere => p.length_squared() <= 1.0,
        ShapeKind::Cube => unit(p.x) && unit(p.y) && unit(p.z),
        ShapeKind::Cylinder => r2 <= 1.0 && unit(p.y),
        ShapeKind::Cone => r2 <= p.y * p.y && unit(p.y),
        ShapeKind::Plane => p.y <= 0.0,
    }
}

fn undone(op: TransformOp, p: DVec3) -> DVec3 {
    let turned = |angle: f64, a: f64, b: f64| {
        let (sin, cos) = (-angle).to_radians().sin_cos();
        (cos * a - sin * b, sin * a + cos * b)
    };
    match op {
        TransformOp::Translate(by) => p - by,
        TransformOp::Scale(by) => p / by,
        TransformOp::RotateX(angle) => {
            let (y, z) = turned(angle, p.y, p.z);
            DVec3::new(p.x, y, z)
        }
        TransformOp::RotateY(angle) => {
            let (z, x) = turned(angle, p.z, p.x);
            DVec3::new(x, p.y, z)
        }
        TransformOp::RotateZ(angle) => {
            let (x, y) = turned(angle, p.x, p.y);
            DVec3::new(x, y, p.z)
        }
    }
}

fn shape() -> impl Strategy<Value = Solid> {
    let kind = prop_oneof![
        Just(ShapeKind::Sphere),
        Just(ShapeKind::Cube),
        Just(ShapeKind::Cylinder),
        Just(ShapeKind::Cone),
        Just(ShapeKind::Plane),
    ];
    kind.prop_map(|kind| Solid::Shape(kind, 0))
}

fn transform() -> impl Strategy<Value = TransformOp> {
    let factor = prop_oneof![0.3..2.5f64, -2.5..-0.3f64];
    let shift = (-1.2..1.2f64, -1.2..1.2f64, -1.0..1.0f64);
    prop_oneof![
        shift.prop_map(|(x, y, z)| TransformOp::Translate(DVec3::new(x, y, z))),
        (factor.clone(), factor.clone(), factor)
            .prop_map(|(x, y, z)| TransformOp::Scale(DVec3::new(x, y, z))),
        (-180.0..180.0).prop_map(TransformOp::RotateX),
        (-180.0..180.0).prop_map(TransformOp::RotateY),
        (-180.0..180.0).prop_map(TransformOp::RotateZ),
    ]
}

fn solid() -> impl Strategy<Value = Solid> {
    let leaf = (shape(), proptest::collection::vec(transform(), 1..4))
        .prop_map(|(shape, ops)| ops.into_iter().fold(shape, Solid::moved));
    leaf.prop_recursive(4, 12, 2, |inner| {
        let pair = (inner.clone(), inner.clone()).prop_map(|(a, b)| (Box::new(a), Box::new(b)));
        prop_oneof![
            pair.clone().prop_map(|(a, b)| Solid::Union(a, b)),
            pair.clone().prop_map(|(a, b)| Solid::Intersect(a, b)),
            pair.prop_map(|(a, b)| Solid::Difference(a, b)),
            (inner, transform()).prop_map(|(inner, op)| inner.moved(op)),
        ]
    })
    .prop_map(|mut solid| {
        number(&mut solid, &mut 0);
        solid
    })
}

/// Numbers the shapes in order, and moves each a little in a way of its own, so that surfaces do
/// not coincide by design: shrinking likes transforms that do nothing.
fn number(solid: &mut Solid, next: &mut u32) {
    match solid {
        Solid::Shape(kind, _) => {
            let id = *next;
            *next += 1;
            let off = 0.0137 * f64::from(id + 1);
            *solid = Solid::Shape(*kind, id)
                .moved(TransformOp::RotateX(100.0 * off))
                .moved(TransformOp::Scale(DVec3::splat(1.0 + off)))
                .moved(TransformOp::Translate(DVec3::new(off, 0.7 * off, -1.3 * off)));
        }
        Solid::Moved(_, inner) => number(inner, next),
        Solid::Union(a, b) | Solid::Intersect(a, b) | Solid::Difference(a, b) => {
            number(a, next);
            number(b, next);
        }
    }
}

/// Paints shape k with red k + 1, and no light but the ambient.
struct Numbers;

impl SurfaceEval for Numbers {
    type Error = std::convert::Infallible;

    fn eval(&mut self, surface: SurfaceId, _: &impl Locate) -> Result<SurfaceSample, Self::Error> {
        let color = DVec3::new(f64::from(surface.0 + 1), 0.0, 0.0);
        Ok(SurfaceSample { color, kd: 1.0, ks: 0.0, phong_exp: 1.0 })
    }
}

fn illumination(lights: Vec<Light>) -> Illumination {
    Illumination {
        ambient: DVec3::ONE,
        lights,
        attenuation: Attenuation::Icfp,
        tint_specular: true,
        clamp_reflection: false,
        max_bounces: 0,
    }
}

fn render(object: &Object<u32>, view: &View, lights: Vec<Light>) -> (Image<[f32; 3]>, RayCounts) {
    render_in::<f64>(object, view, lights)
}

fn render_in<R: Real>(
    object: &Object<u32>,
    view: &View,
    lights: Vec<Light>,
) -> (Image<[f32; 3]>, RayCounts) {
    let scene = Scene::<R>::new(object, |id| SurfaceId(*id));
    match renderer::render(&scene, &illumination(lights), view, || Numbers, &|_| {}) {
        Ok(result) => result,
        Err(failure) => match failure.error {},
    }
}

const SIZE: u32 = 16;

fn image(object: &Object<u32>) -> Image<[f32; 3]> {
    render(object, &View::whole(SIZE, SIZE, 70.0), Vec::new()).0
}

fn precise_image(object: &Object<u32>) -> Image<[f32; 3]> {
    render_in::<Dd>(object, &View::whole(SIZE, SIZE, 70.0), Vec::new()).0
}

/// The solid seen from the eye: moved in front of it, askew to the grid of pixels.
fn in_view(solid: Solid) -> Solid {
    let askew = solid.moved(TransformOp::RotateX(17.3)).moved(TransformOp::RotateY(31.7));
    askew.moved(TransformOp::Translate(DVec3::new(0.011, 0.017, 1.5)))
}

/// How far along a ray the oracle looks.
const FAR: f64 = 1e5;

/// What the oracle cannot tell apart, in the ray's parameter and in how far a point is outside a
/// shape: a hundred times the square root of a double's precision, near which minimizing stops.
const UNCLEAR: f64 = 1e-6;

/// A shape of a solid, and what is done to it, the last first.
struct Part {
    kind: ShapeKind,
    id: u32,
    ops: Vec<TransformOp>,
}

impl Solid {
    fn parts(&self, ops: &mut Vec<TransformOp>, found: &mut Vec<Part>) {
        match self {
            Solid::Shape(kind, id) => found.push(Part { kind: *kind, id: *id, ops: ops.clone() }),
            Solid::Moved(op, inner) => {
                ops.push(*op);
                inner.parts(ops, found);
                ops.pop();
            }
            Solid::Union(a, b) | Solid::Intersect(a, b) | Solid::Difference(a, b) => {
                a.parts(ops, found);
                b.parts(ops, found);
            }
        }
    }
}

/// How far a point is outside a shape, at most 0 inside; convex, since the shapes are.
fn outside_by(kind: ShapeKind, p: DVec3) -> f64 {
    let slab = |x: f64| (-x).max(x - 1.0);
    let radius = p.x.hypot(p.z);
    match kind {
        ShapeKind::Sphere => p.length() - 1.0,
        ShapeKind::Cube => slab(p.x).max(slab(p.y)).max(slab(p.z)),
        ShapeKind::Cylinder => (radius - 1.0).max(slab(p.y)),
        ShapeKind::Cone => (radius - p.y).max(slab(p.y)),
        ShapeKind::Plane => p.y,
    }
}

fn along(dir: DVec3, t: f64) -> DVec3 {
    DVec3::new(0.0, 0.0, -1.0) + dir * t
}

impl Part {
    /// Where a ray from the eye enters and leaves the shape; `None` if it may only graze it.
    fn ends(&self, dir: DVec3) -> Option<Vec<f64>> {
        let outside = |t: f64| {
            outside_by(self.kind, self.ops.iter().fold(along(dir, t), |p, op| undone(*op, p)))
        };
        let (mut low, mut high) = (0.0, FAR);
        for _ in 0..200 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if outside(a) <= outside(b) { high = b } else { low = a }
        }
        let deepest =
            [0.0, low, FAR].into_iter().min_by(|a, b| outside(*a).total_cmp(&outside(*b)))?;
        if outside(deepest).abs() < UNCLEAR {
            return None;
        }
        let crossing = |mut inside: f64, mut beyond: f64| {
            for _ in 0..200 {
                let middle = 0.5 * (inside + beyond);
                if outside(middle) <= 0.0 { inside = middle } else { beyond = middle }
            }
            inside
        };
        let is_met = outside(deepest) < 0.0;
        let beyond = [0.0, FAR].into_iter().filter(|t| is_met && outside(*t) > 0.0);
        Some(beyond.map(|t| crossing(deepest, t)).collect())
    }
}

/// The shape whose boundary a ray from the eye crosses where the solid's membership first changes:
/// `Some(None)` if it never does, `None` if that is too close to call.
fn first_change(solid: &Solid, dir: DVec3) -> Option<Option<u32>> {
    let mut parts = Vec::new();
    solid.parts(&mut Vec::new(), &mut parts);
    let mut ends = Vec::new();
    for part in &parts {
        ends.extend(part.ends(dir)?.into_iter().map(|t| (t, part.id)));
    }
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut before = 0.0;
    let mut started = None;
    for index in 0..=ends.len() {
        let end = ends.get(index).map_or(FAR, |end| end.0);
        if end - before < UNCLEAR * end.max(1.0) {
            return None;
        }
        let inside = solid.holds(along(dir, 0.5 * (before + end)), &mut 0);
        if inside != *started.get_or_insert(inside) {
            return Some(Some(ends[index - 1].1));
        }
        before = end;
    }
    Some(None)
}

/// A number from the environment.
fn setting(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: setting("GMLVM_PROPERTY_CASES", 100) as u32,
        rng_seed: RngSeed::Fixed(setting("GMLVM_PROPERTY_SEED", 1)),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn direction(column: u32, row: u32) -> DVec3 {
    let half = 35f64.to_radians().tan() / f64::from(SIZE);
    let off = |k: u32| f64::from(2 * k + 1) - f64::from(SIZE);
    DVec3::new(off(column) * half, -off(row) * half, 1.0)
}

proptest! {
    #![proptest_config(config())]

    /// What is painted is the shape whose boundary the solid's membership changes at.
    #[test]
    fn hits_are_where_membership_changes(solid in solid()) {
        let solid = in_view(solid);
        let found = image(&solid.object());
        for (idx, pixel) in found.pixels.iter().enumerate() {
            let (column, row) = (idx as u32 % SIZE, idx as u32 / SIZE);
            let Some(expected) = first_change(&solid, direction(column, row)) else { continue };
            let painted = (pixel[0] > 0.0).then(|| pixel[0] as u32 - 1);
            prop_assert_eq!(painted, expected, "pixel ({}, {})", column, row);
        }
    }

    /// A solid less itself is nothing; with itself it is itself.
    #[test]
    fn set_operations_with_oneself(solid in solid()) {
        let object = in_view(solid).object();
        let alone = image(&object);
        let nothing = image(&object.difference(&object));
        prop_assert!(nothing.pixels.iter().all(|pixel| pixel[0] == 0.0));
        prop_assert_eq!(&image(&object.intersect(&object)).pixels, &alone.pixels);
        prop_assert_eq!(&image(&object.union(&object)).pixels, &alone.pixels);
    }

    /// Double-doubles find the same shapes, and know solids that are equal.
    #[test]
    fn precision_does_not_matter(solid in solid()) {
        let object = in_view(solid).object();
        let plain = image(&object);
        prop_assert_eq!(&precise_image(&object).pixels, &plain.pixels);
        prop_assert_eq!(&precise_image(&object.union(&object)).pixels, &plain.pixels);
        let nothing = precise_image(&object.difference(&object));
        prop_assert!(nothing.pixels.iter().all(|pixel| pixel[0] == 0.0));
    }

    /// The order of a union matters to nobody where surfaces do not coincide.
    #[test]
    fn unions_commute(a in solid(), b in solid()) {
        let (a, b) = (in_view(a).object(), in_view(b).object());
        prop_assert_eq!(image(&a.union(&b)).pixels, image(&b.union(&a)).pixels);
    }

    /// `A - (B + C) = (A - B) - C`, and `A & (B + C) = (A & B) + (A & C)`.
    #[test]
    fn set_algebra(a in solid(), b in solid(), c in solid()) {
        let [a, b, c] = [a, b, c].map(|solid| in_view(solid).object());
        let left = image(&a.difference(&b.union(&c)));
        let right = image(&a.difference(&b).difference(&c));
        prop_assert_eq!(left.pixels, right.pixels);
        let left = image(&a.intersect(&b.union(&c)));
        let right = image(&a.intersect(&b).union(&a.intersect(&c)));
        prop_assert_eq!(left.pixels, right.pixels);
    }

    /// Transforms that undo one another leave no trace, not even in the last bit.
    #[test]
    fn transforms_compose_exactly(solid in solid(), angle in -180.0..180.0f64, shift in -1e6..1e6f64) {
        let solid = in_view(solid);
        let by = DVec3::new(shift, -shift, 0.5 * shift);
        let there_and_back = [
            TransformOp::RotateX(angle),
            TransformOp::Translate(by),
            TransformOp::Scale(DVec3::new(-4.0, 0.5, 8.0)),
            TransformOp::RotateZ(90.0),
            TransformOp::RotateZ(-90.0),
            TransformOp::Scale(DVec3::new(-0.25, 2.0, 0.125)),
            TransformOp::Translate(-by),
            TransformOp::RotateX(-angle),
        ];
        let moved = there_and_back.into_iter().fold(solid.clone(), Solid::moved);
        prop_assert_eq!(image(&moved.object()).pixels, image(&solid.object()).pixels);
    }

    /// A convex solid casts no shadow on itself, wherever it is and however it is stretched: seen from
    /// outside, that is, for inside it is dark but for what is in there.
    #[test]
    fn convex_solids_do_not_shadow_themselves(
        shape in shape(),
        ops in proptest::collection::vec(transform(), 0..4),
        scale in -6..7i32,
        light in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
    ) {
        let solid = in_view(ops.into_iter().fold(shape, Solid::moved));
        prop_assume!(!solid.holds(DVec3::new(0.0, 0.0, -1.0), &mut 0));
        let about_eye = DVec3::new(0.0, 0.0, 1.0);
        let object = solid
            .moved(TransformOp::Translate(about_eye))
            .moved(TransformOp::Scale(DVec3::splat(10f64.powi(scale))))
            .moved(TransformOp::Translate(-about_eye))
            .object();
        let (x, y, z) = light;
        let color = DVec3::ONE;
        let position = DVec3::new(x, y, z) * 10f64.powi(scale);
        let lights = vec![Light::Directional { dir: DVec3::new(x, y, z), color }, Light::Point { position, color }];
        let (_, counts) = render(&object, &View::whole(SIZE, SIZE, 70.0), lights);
        prop_assert_eq!(counts.blocked, 0);
    }

    /// A part of the image is that part of the image, for any number of threads.
    #[test]
    fn regions_and_threads_do_not_matter(solid in solid(), x in 0..SIZE, y in 0..SIZE, threads in 1..8usize) {
        let object = in_view(solid).object();
        let whole = image(&object);
        let region = Region { x, y, width: SIZE - x, height: SIZE - y };
        let view = View { region, ..View::whole(SIZE, SIZE, 70.0) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (part, counts) = pool.install(|| render(&object, &view, Vec::new()));
        prop_assert_eq!(counts.primary, u64::from(region.width * region.height));
        for (idx, pixel) in part.pixels.iter().enumerate() {
            let is_in = idx as u32 % SIZE >= x && idx as u32 / SIZE >= y;
            prop_assert_eq!(*pixel, if is_in { whole.pixels[idx] } else { [0.0; 3] });
        }
    }
}
