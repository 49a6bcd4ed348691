//! A hierarchy against testing every box.

use glam::DVec3;

use super::*;
use crate::bounds::Bounds;
use crate::numeric::vec3::Vec3;
use crate::ray::{Beam, Conditioning, Medium, Ray};

/// Numbers in [0, 1), the same in every run (Steele, Lea and Flood, "Fast splittable pseudorandom
/// number generators", 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn triple(&mut self, size: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| (self.next() - 0.5) * size)
    }

    fn line(&mut self) -> Line {
        let dir = self.triple(1.0).map(|d| if d.abs() < 0.05 { 0.0 } else { d });
        let ray = Ray {
            origin: Vec3::from_f64s(self.triple(20.0)),
            dir: Vec3::from_f64s(dir),
            on: None,
            medium: Medium::Unknown,
        };
        Line::new::<f64>(&ray, Conditioning { linear: 1.0, shift: 0.0 }, 0.0)
    }

    fn boxes(&mut self, n: usize) -> Vec<Bounds> {
        let mut make = || {
            let size = 4.0 * self.next().powi(4);
            let lo = DVec3::from_array(self.triple(20.0));
            Bounds { lo, hi: lo.map(|x| x + size * self.next()) }
        };
        (0..n).map(|_| make()).collect()
    }
}

fn hierarchy(boxes: &[Bounds]) -> Hierarchy {
    Hierarchy::new((0..).zip(boxes).map(|(number, bounds)| Item::new(number, bounds)).collect())
}

fn visited(hierarchy: &Hierarchy, line: &Line, t_end: f64) -> Vec<u32> {
    let mut pending = Pending::default();
    let mut candidates = hierarchy.candidates(line, &mut pending);
    let mut items: Vec<u32> = std::iter::from_fn(|| candidates.next(t_end)).collect();
    items.sort_unstable();
    let mut candidates = hierarchy.candidates(line, &mut pending);
    let in_any_order = std::iter::from_fn(|| candidates.next_unordered(t_end));
    let mut in_any_order: Vec<u32> = in_any_order.collect();
    in_any_order.sort_unstable();
    assert_eq!(in_any_order, items);
    items
}

/// Where a line enters a box that has been rounded to the nearest, and not outward.
fn enters(line: &Line, bounds: &Bounds) -> Option<f64> {
    let [lo, hi] = [bounds.lo, bounds.hi].map(|end| end.to_array().map(|x| x as f32));
    let boxes = Boxes { lo: lo.map(|end| [end]), hi: hi.map(|end| [end]) };
    let ([enter], met) = line.enters(&boxes, f64::INFINITY);
    (met == 1).then_some(enter)
}

#[test]
fn all_boxes_that_a_ray_meets_are_visited_once() {
    let mut random = Random(1);
    for n in [0, 1, 2, 5, 17, 300, 6000] {
        let boxes = random.boxes(n);
        let hierarchy = hierarchy(&boxes);
        let mut n_visited = 0;
        for _ in 0..100 {
            let line = random.line();
            let found = visited(&hierarchy, &line, f64::INFINITY);
            assert!(found.is_sorted_by(|a, b| a < b), "{n}: an item is visited twice");
            for (number, bounds) in (0..).zip(&boxes) {
                let is_met = enters(&line, bounds).is_some();
                assert!(!is_met || found.binary_search(&number).is_ok(), "{n}: {bounds:?}");
            }
            n_visited += found.len();
        }
        assert!(n < 300 || n_visited < n * 10, "{n_visited} visits are no better than {n} tests");
    }
}

#[test]
fn the_nearest_is_found_without_visiting_what_is_behind_it() {
    let mut random = Random(2);
    let boxes = random.boxes(3000);
    let hierarchy = hierarchy(&boxes);
    let (mut n_nearest, mut n_all) = (0, 0);
    for _ in 0..300 {
        let line = random.line();
        let expected = boxes.iter().filter_map(|bounds| enters(&line, bounds)).reduce(f64::min);
        let mut nearest = f64::INFINITY;
        let mut pending = Pending::default();
        let mut candidates = hierarchy.candidates(&line, &mut pending);
        while let Some(item) = candidates.next(nearest) {
            n_nearest += 1;
            nearest = enters(&line, &boxes[item as usize]).map_or(nearest, |t| nearest.min(t));
        }
        assert_eq!(nearest, expected.unwrap_or(f64::INFINITY));
        n_all += visited(&hierarchy, &line, f64::INFINITY).len();
    }
    assert!(n_nearest * 3 < n_all * 2, "{n_nearest} of {n_all}");
}

/// The items that a line meets which begins where it is told.
fn visited_from(start: &Start, hierarchy: &Hierarchy, line: &Line) -> Vec<u32> {
    let mut pending = Pending::default();
    let mut candidates = hierarchy.candidates_from(start, line, &mut pending);
    let mut items: Vec<u32> = std::iter::from_fn(|| candidates.next(f64::INFINITY)).collect();
    items.sort_unstable();
    items
}

#[test]
fn lines_of_a_beam_miss_nothing_by_where_they_start() {
    let mut random = Random(7);
    for n in [0, 1, 3, 9, 300, 6000] {
        let boxes = random.boxes(n);
        let hierarchy = hierarchy(&boxes);
        let (mut n_opened, mut n_met) = (0, 0);
        for round in 0..200 {
            let origin = random.triple(20.0);
            // Beams of all widths, along axes too, and to both sides of them.
            let size = random.next().powi(4);
            let middle = if round % 4 == 0 { [0.0; 3] } else { random.triple(4.0) };
            let mut line_at = |[x, y]: [f64; 2]| {
                let [x, y] = [middle[0] + size * x, middle[1] + size * y];
                let dir = Vec3::from_f64s([x, y, middle[2].signum()]);
                let origin = Vec3::from_f64s(origin);
                let ray = Ray { origin, dir, on: None, medium: Medium::Unknown };
                Line::new::<f64>(&ray, Conditioning { linear: 1.0, shift: 0.0 }, 0.0)
            };
            let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(&mut line_at);
            let start = Start::new(&hierarchy, Beam::between(&corners));
            for _ in 0..20 {
                let [x, y, _] = random.triple(2.0);
                let line = line_at([x, y]);
                assert!(start.holds(&line));
                let found = visited_from(&start, &hierarchy, &line);
                let from_root = visited(&hierarchy, &line, f64::INFINITY);
                // An only child is not asked whether its box is met.
                let is_missed = |item: &u32| found.binary_search(item).is_err();
                assert!(!from_root.iter().any(is_missed), "{found:?}, from the root {from_root:?}");
                assert!(found.len() <= from_root.len() + 1);
                n_met += from_root.len();
            }
            n_opened += usize::from(start.n_children() > 0);
        }
        assert!(n < 300 || n_opened > 20, "{n}: {n_opened} of 200 beams meet anything");
        assert!(n < 300 || n_met > 1000, "{n}: {n_met} items were there to be missed");
    }
}

#[test]
fn a_beam_to_both_sides_meets_boxes_that_end_at_its_origin() {
    let line = |x, y| {
        let (origin, dir) = (Vec3::from_f64s([0.0, 0.0, -1.0]), Vec3::from_f64s([x, y, 1.0]));
        let ray = Ray { origin, dir, on: None, medium: Medium::Unknown };
        Line::new::<f64>(&ray, Conditioning { linear: 1.0, shift: 3.0 }, 0.0)
    };
    let corners = [line(-0.1, -0.1), line(0.1, -0.1), line(-0.1, 0.1), line(0.1, 0.1)];
    // Three times the error of the origin, by which the beam is wider.
    let end = -3.0 * 2.0_f32.powi(-45);
    let boxes = Boxes { lo: [[-1.0], [-0.5], [3.0]], hi: [[end], [0.5], [4.0]] };
    assert_eq!(line(-0.1, 0.0).enters(&boxes, f64::INFINITY).1, 1);
    assert_eq!(Beam::between(&corners).meets(&boxes), 1);
}

#[test]
fn a_beam_holds_only_lines_between_its_corners() {
    let line = |x: f64, y: f64, size: f64| {
        let (origin, dir) = (Vec3::from_f64s([0.0, 0.0, -1.0]), Vec3::from_f64s([x, y, 1.0]));
        let ray = Ray { origin, dir, on: None, medium: Medium::Unknown };
        Line::new::<f64>(&ray, Conditioning { linear: 1.0, shift: size }, 0.0)
    };
    let corner = |x, y| line(x, y, 1.0);
    let beam =
        Beam::between(&[corner(1.0, 1.0), corner(2.0, 1.0), corner(1.0, 3.0), corner(2.0, 3.0)]);
    assert!(beam.holds(&line(1.5, 1.0, 1.0)) && beam.holds(&line(2.0, 3.0, 1.5)));
    assert!(!beam.holds(&line(2.1, 2.0, 1.0)), "to the right");
    assert!(!beam.holds(&line(1.5, 0.9, 1.0)), "below");
    assert!(!beam.holds(&line(1.5, 2.0, 100.0)), "from an origin less certain");
}

#[test]
fn boxes_are_rounded_outward() {
    for bounds in Random(6).boxes(1000) {
        let build::Box32 { lo, hi } = build::Box32::around(&bounds);
        for axis in 0..3 {
            let (lo, hi) = (f64::from(lo[axis]), f64::from(hi[axis]));
            assert!(lo <= bounds.lo[axis] && bounds.lo[axis] - lo < 1e-5, "{bounds:?}");
            assert!(hi >= bounds.hi[axis] && hi - bounds.hi[axis] < 1e-5, "{bounds:?}");
        }
    }
}

#[test]
fn unbounded_boxes_are_always_visited_and_empty_ones_never() {
    let unit = Bounds { lo: DVec3::ZERO, hi: DVec3::ONE };
    let boxes = [
        Bounds::ALL,
        Bounds::NOTHING,
        Bounds { hi: DVec3::new(1.0, f64::INFINITY, 1.0), ..unit },
        Bounds { hi: DVec3::new(1.0, 1e300, 1.0), ..unit },
        Bounds { lo: DVec3::new(0.0, 2.0, 0.0), ..unit },
    ];
    let away = Line::new::<f64>(
        &Ray {
            origin: Vec3::from_f64s([5.0, 5.0, 5.0]),
            dir: Vec3::from_f64s([1.0, 0.0, 0.0]),
            on: None,
            medium: Medium::Unknown,
        },
        Conditioning::default(),
        0.0,
    );
    assert_eq!(visited(&hierarchy(&boxes), &away, f64::INFINITY), [0, 2, 3]);
}

#[test]
fn a_hundred_thousand_boxes_in_one_place_make_no_deep_hierarchy() {
    let unit = Bounds { lo: DVec3::ZERO, hi: DVec3::ONE };
    let mut boxes = vec![unit; 100_000];
    // Each half as far away as the one before: splits by area alone would be as deep as these are
    // many.
    boxes.extend((0..60).map(|k| {
        let far = 0.5_f64.powi(k);
        Bounds { lo: DVec3::splat(far), hi: DVec3::splat(far * 1.01) }
    }));
    let hierarchy = hierarchy(&boxes);
    let through = Line::new::<f64>(
        &Ray {
            origin: Vec3::from_f64s([-1.0, -1.0, -1.0]),
            dir: Vec3::from_f64s([1.0, 1.0, 1.0]),
            on: None,
            medium: Medium::Unknown,
        },
        Conditioning::default(),
        0.0,
    );
    assert_eq!(visited(&hierarchy, &through, f64::INFINITY).len(), boxes.len());
}

#[test]
fn a_box_takes_less_than_80_bytes() {
    let boxes = Random(5).boxes(20_000);
    assert!(hierarchy(&boxes).n_bytes() < 80 * boxes.len());
}
