//! Pixels of many samples.

use std::f64::consts::FRAC_PI_6;
use std::path::Path;

use glam::DVec3;
use renderer::camera::{Region, View};
use renderer::image::{Image, Pixel};
use renderer::light::{Attenuation, Light};
use renderer::object::{Object, ShapeKind, TransformOp};
use renderer::sampling::{Sampling, sample};
use renderer::scene::Scene;
use renderer::shade::{Illumination, RayCounts};
use renderer::surface::{Locate, Needs, SurfaceEval, SurfaceId, SurfacePoint, SurfaceSample};
use support::scenes::{Engine, Way, render_in};

mod support {
    #[allow(dead_code, reason = "each test takes its part")]
    pub(crate) mod scenes;
}

/// A surface whose colour is a function of the point, the same in all channels. Its decisions are its
/// answers.
#[derive(Clone, Copy)]
struct Paint(fn(SurfacePoint) -> f64);

impl SurfaceEval for Paint {
    type Error = std::convert::Infallible;

    fn eval(&mut self, _: SurfaceId, at: &impl Locate) -> Result<SurfaceSample, Self::Error> {
        let color = DVec3::splat((self.0)(at.locate(Needs::ALL)));
        Ok(SurfaceSample { color, kd: 1.0, ks: 0.25, phong_exp: 3.0 })
    }
}

fn render<P: Pixel>(
    object: &Object<()>,
    view: &View,
    sampling: Sampling,
    lights: Vec<Light>,
    paint: fn(SurfacePoint) -> f64,
) -> (Image<P>, RayCounts) {
    let illumination = Illumination {
        ambient: DVec3::ONE,
        lights,
        attenuation: Attenuation::Icfp,
        tint_specular: false,
        clamp_reflection: true,
        max_bounces: 2,
    };
    let scene = Scene::<f64>::new(object, |()| SurfaceId(0));
    match sample(&scene, &illumination, view, sampling, || Paint(paint), &|_| {}) {
        Ok(result) => result,
        Err(failure) => match failure.error {},
    }
}

fn moved(kind: ShapeKind, transforms: &[TransformOp]) -> Object<()> {
    let transformed = |object: Object<()>, op: &TransformOp| object.transformed(*op).expect("fine");
    transforms.iter().fold(Object::shape(kind, ()), transformed)
}

/// A cube whose front lies in the image plane, from -2 to 2 in both directions.
fn wall() -> Object<()> {
    let to_middle = TransformOp::Translate(DVec3::new(-0.5, -0.5, 0.0));
    moved(ShapeKind::Cube, &[to_middle, TransformOp::Scale(DVec3::splat(4.0))])
}

/// Two balls before a wall of mirrors, symmetric from side to side.
fn balls() -> (Object<()>, Vec<Light>) {
    let ball = |x| {
        let by = TransformOp::Translate(DVec3::new(x, 0.0, 1.5));
        moved(ShapeKind::Sphere, &[TransformOp::Scale(DVec3::splat(0.8)), by])
    };
    let floor = moved(ShapeKind::Plane, &[TransformOp::Translate(DVec3::new(0.0, -0.7, 0.0))]);
    let object = ball(-0.9).union(&ball(0.9)).union(&floor);
    let dir = DVec3::new(0.0, -1.0, 0.4);
    (object, vec![Light::Directional { dir, color: DVec3::splat(0.7) }])
}

/// A floor with stripes that are the same on both sides, and nothing that depends on where balls begin
/// to count.
fn striped(at: SurfacePoint) -> f64 {
    if (at.v * 3.0).floor() % 2.0 == 0.0 { 0.6 } else { 0.3 }
}

const ALL: [Sampling; 6] = [
    Sampling::Centre,
    Sampling::Grid(2),
    Sampling::Grid(3),
    Sampling::Grid(5),
    Sampling::Adaptive(1),
    Sampling::Adaptive(3),
];

#[test]
fn one_sample_is_that_at_the_centre() {
    let (object, lights) = balls();
    let view = View::whole(31, 17, 70.0);
    let image = |sampling| render::<[u8; 3]>(&object, &view, sampling, lights.clone(), striped);
    let centre = image(Sampling::Centre);
    assert_eq!(image(Sampling::Grid(1)), centre);
    assert_eq!(centre.1.primary, 31 * 17);
    assert_ne!(image(Sampling::Grid(2)).0, centre.0);
}

#[test]
fn a_grid_is_a_larger_image_made_smaller() {
    let (object, lights) = balls();
    for n in [2, 3, 5] {
        let image = |width, height, sampling| {
            let view = View::whole(width, height, 70.0);
            render::<[f32; 3]>(&object, &view, sampling, lights.clone(), |at| striped(at) * 4.0).0
        };
        let large = image(19 * n, 11 * n, Sampling::Centre);
        let small = image(19, 11, Sampling::Grid(n));
        for (index, pixel) in small.pixels.iter().enumerate() {
            let (column, row) = (index as u32 % 19, index as u32 / 19);
            let cells = (0..n * n).map(|cell| (column * n + cell % n, row * n + cell / n));
            let sum: f64 = cells.map(|(x, y)| f64::from(large.at(x, y))).sum();
            let mean = sum / f64::from(n * n);
            // Each number was rounded to 24 bits, once.
            let tolerance = f64::from(f32::EPSILON) * mean;
            assert!((f64::from(pixel[0]) - mean).abs() <= tolerance, "{column} {row}");
        }
    }
}

trait At {
    fn at(&self, column: u32, row: u32) -> f32;
}

impl At for Image<[f32; 3]> {
    fn at(&self, column: u32, row: u32) -> f32 {
        self.pixels[(row * self.width + column) as usize][0]
    }
}

#[test]
fn symmetric_scenes_have_symmetric_images() {
    let (object, lights) = balls();
    for (width, sampling) in ALL.into_iter().flat_map(|sampling| [(24, sampling), (25, sampling)]) {
        let view = View::whole(width, 18, 70.0);
        let image = render::<[f32; 3]>(&object, &view, sampling, lights.clone(), striped).0;
        for row in 0..18 {
            for column in 0..width / 2 {
                let (here, there) = (image.at(column, row), image.at(width - 1 - column, row));
                assert_eq!(here.to_bits(), there.to_bits(), "{sampling:?} {column} {row}");
            }
        }
    }
}

#[test]
fn equal_samples_have_their_colour_as_mean() {
    // 255 times 0.6 is 153, and would be 152 if the mean were a bit below. 0.3 is a bit below.
    for (color, byte) in [(0.6, 153), (0.2, 51), (0.3, 76), (1.0, 255), (0.1, 25), (7.0, 255)] {
        for n in 1..=Sampling::MAX_GRID {
            let paints: [fn(SurfacePoint) -> f64; 6] =
                [|_| 0.6, |_| 0.2, |_| 0.3, |_| 1.0, |_| 0.1, |_| 7.0];
            let paint = paints.into_iter().find(|paint| paint(ORIGIN) == color).expect("listed");
            let view = View::whole(1, 1, 60.0);
            let image = render::<[u8; 3]>(&wall(), &view, Sampling::Grid(n), Vec::new(), paint).0;
            assert_eq!(image.pixels, [[byte; 3]], "{color} {n}");
        }
    }
}

const ORIGIN: SurfacePoint = SurfacePoint { face: 0, u: 0.0, v: 0.0 };

#[test]
fn uniform_pixels_take_no_more_than_their_corners() {
    for (width, height) in [(7, 5), (5, 8), (3, 9), (4, 33)] {
        let view = View::whole(width, height, 10.0);
        for depth in 1..=Sampling::MAX_DEPTH {
            let sampling = Sampling::Adaptive(depth);
            let (image, counts) = render::<[u8; 3]>(&wall(), &view, sampling, Vec::new(), |_| 0.6);
            assert_eq!(image.pixels, vec![[153; 3]; (width * height) as usize]);
            // The upper corners of each eight rows once more.
            let n_rows = u64::from(height + height.div_ceil(8));
            assert_eq!(counts.primary, u64::from(width + 1) * n_rows);
        }
    }
}

/// The corners of a row that is very wide are not all kept.
#[test]
fn wide_images_take_little_memory_and_some_corners_twice() {
    let view = View::whole((1 << 16) + 5, 2, 60.0);
    let by = |at: SurfacePoint| (at.u * 1000.0).floor() / 1000.0;
    let (image, counts) = render::<[u8; 3]>(&wall(), &view, Sampling::Adaptive(1), Vec::new(), by);
    let narrow = Region { x: 65_500, y: 0, width: 41, height: 2 };
    let view = View { region: narrow, ..view };
    let (part, _) = render::<[u8; 3]>(&wall(), &view, Sampling::Adaptive(1), Vec::new(), by);
    for row in [0, 65_541] {
        assert_eq!(image.pixels[row + 65_500..][..41], part.pixels[row + 65_500..][..41]);
        assert_eq!(part.pixels[row + 65_499], [0; 3]);
    }
    let n_corners = 3 * 65_542;
    let n_within = counts.primary - n_corners;
    // Less than a thousand pixels have an edge of a stripe between their corners.
    assert!(n_within > 0 && n_within < 5 * 2 * 1000, "{n_within}");
}

/// Where all samples look different, a pixel is cut as far as it may be: the mean is that of the small
/// squares, each of which is that of its corners.
#[test]
fn all_points_of_a_pixel_count_where_all_look_different() {
    let square = |at: SurfacePoint| at.u * at.u + at.v * at.v * at.v;
    for depth in 1..=4 {
        let view = View::whole(1, 1, 90.0);
        let sampling = Sampling::Adaptive(depth);
        let (image, counts) = render::<[f32; 3]>(&wall(), &view, sampling, Vec::new(), square);
        let n = 1u32 << depth;
        assert_eq!(counts.primary, u64::from((n + 1) * (n + 1)));
        // The pixel reaches from -1 to 1, a quarter to three quarters of the wall.
        let weight = |k: u32| if k == 0 || k == n { 0.5 } else { 1.0 } / f64::from(n);
        let at = |k: u32| 0.25 + 0.5 * f64::from(k) / f64::from(n);
        let mut mean = 0.0;
        for (k, l) in (0..=n).flat_map(|k| (0..=n).map(move |l| (k, l))) {
            let point = SurfacePoint { face: 0, u: at(k), v: at(l) };
            mean += weight(k) * weight(l) * square(point);
        }
        // The result is rounded to 24 bits; all else is far below.
        let tolerance = f64::from(f32::EPSILON) * mean;
        assert!((f64::from(image.at(0, 0)) - mean).abs() <= tolerance, "{depth}");
    }
}

/// The part of a square of the side 1 with its upper left corner at (x, y) where a x + b y + c > 0.
fn coverage(x: f64, y: f64, [a, b, c]: [f64; 3]) -> f64 {
    let corners = [(x, y), (x + 1.0, y), (x + 1.0, y - 1.0), (x, y - 1.0)];
    let side = |(x, y): (f64, f64)| a * x + b * y + c;
    let mut polygon = Vec::new();
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % 4];
        if side(from) > 0.0 {
            polygon.push(from);
        }
        if (side(from) > 0.0) != (side(to) > 0.0) {
            let t = side(from) / (side(from) - side(to));
            polygon.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
        }
    }
    let next = |index: usize| polygon[(index + 1) % polygon.len()];
    let cross = polygon.iter().enumerate().map(|(i, p)| p.0 * next(i).1 - p.1 * next(i).0);
    (cross.sum::<f64>() / 2.0).abs()
}

/// The edge of a half-plane: each pixel is as bright as the part of it that is covered. In a row of
/// cells, the number of centres that are covered is off by half a cell at most; and the covered length
/// of a row, a function of the height with slopes from 0 to `slope` and a bend or two, differs from its
/// mean over the height 1/n of the row by an eighth of the slope at most. Of small squares, the line
/// meets two in a row at most, and four corners tell half of a square at worst.
#[test]
fn edges_are_as_bright_as_what_they_cover() {
    let angle = FRAC_PI_6;
    let (sin, cos) = angle.sin_cos();
    let transforms = [
        TransformOp::Translate(DVec3::new(0.0, -0.5, 0.0)),
        TransformOp::Scale(DVec3::splat(10.0)),
        TransformOp::Translate(DVec3::new(-0.31, 0.0, 0.0)),
        TransformOp::RotateZ(angle.to_degrees()),
    ];
    let object = moved(ShapeKind::Cube, &transforms);
    let (width, height) = (12, 10);
    let view = View::whole(width, height, 90.0);
    // In pixels, from the middle of the image.
    let line = [cos, sin, 0.31 * f64::from(width) / 2.0];
    for sampling in [2, 4, 7, 32].map(Sampling::Grid).into_iter().chain([Sampling::Adaptive(5)]) {
        let bound = match sampling {
            Sampling::Grid(n) => (0.5 + sin / cos / 8.0) / f64::from(n),
            _ => 1.0 / 32.0,
        };
        let image = render::<[f32; 3]>(&object, &view, sampling, Vec::new(), |_| 1.0).0;
        let mut n_partly = 0;
        for (column, row) in (0..height).flat_map(|row| (0..width).map(move |x| (x, row))) {
            let (x, y) = (f64::from(column) - 6.0, 5.0 - f64::from(row));
            let expected = coverage(x, y, line);
            n_partly += u32::from(expected > 0.0 && expected < 1.0);
            let error = (f64::from(image.at(column, row)) - expected).abs();
            assert!(error <= bound, "{sampling:?} {column} {row}: {error} of {bound}");
        }
        assert!(n_partly >= height);
    }
}

#[test]
fn bytes_are_means_of_what_is_seen() {
    // Half of the pixel is four times as bright as white.
    let half = |at: SurfacePoint| if at.u < 0.5 { 4.0 } else { 0.0 };
    let view = View::whole(1, 1, 90.0);
    for sampling in [Sampling::Grid(2), Sampling::Grid(64)] {
        let bytes = render::<[u8; 3]>(&wall(), &view, sampling, Vec::new(), half).0;
        assert_eq!(bytes.pixels, [[127; 3]]);
        let linear = render::<[f32; 3]>(&wall(), &view, sampling, Vec::new(), half).0;
        assert_eq!(linear.pixels, [[2.0; 3]]);
    }
}

#[test]
fn regions_and_threads_do_not_matter() {
    let (object, lights) = balls();
    let view = View::whole(26, 29, 70.0);
    for sampling in ALL {
        let image = |view: &View, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("some");
            pool.install(|| render::<[u8; 3]>(&object, view, sampling, lights.clone(), striped))
        };
        let whole = image(&view, 1);
        for threads in [2, 3, 7] {
            assert_eq!(image(&view, threads), whole, "{sampling:?}, {threads} threads");
        }
        let region = Region { x: 5, y: 3, width: 13, height: 20 };
        let part = image(&View { region, ..view }, 2).0;
        for (index, pixel) in part.pixels.iter().enumerate() {
            let (column, row) = (index as u32 % 26, index as u32 / 26);
            let is_in = (5..18).contains(&column) && (3..23).contains(&row);
            let expected = if is_in { whole.0.pixels[index] } else { [0; 3] };
            assert_eq!(*pixel, expected, "{sampling:?} {column} {row}");
        }
    }
}

#[test]
fn engines_agree_on_where_samples_look_different() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut n_adaptive = 0;
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        let images = |engine, sampling| {
            let way = Way { engine, sampling, reduction: 8 };
            render_in(way, &path, &text)
                .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
                .0
        };
        for sampling in [Sampling::Grid(2), Sampling::Adaptive(2)] {
            let interpreted = images(Engine::Interpreter, sampling);
            for engine in [Engine::Native, Engine::Tiered] {
                for (one, other) in interpreted.iter().zip(&images(engine, sampling)) {
                    assert_eq!(one.image, other.image, "{} {engine:?}", path.display());
                    assert_eq!(one.counts, other.counts, "{} {engine:?}", path.display());
                }
            }
            n_adaptive += usize::from(sampling == Sampling::Adaptive(2)) * interpreted.len();
        }
    }
    assert!(n_adaptive >= 10);
}
