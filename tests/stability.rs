//! Scenes made to break ray tracers, each with an oracle that holds exactly. They lie beside the
//! checkout and are skipped where absent; the numbers T01 to T45 are theirs.

use std::path::PathBuf;

use scenes::{Rendered, render_file, shared};

#[allow(dead_code, reason = "each test takes its part")]
#[path = "support/scenes.rs"]
mod scenes;

type Rgb = [u8; 3];

const BLACK: Rgb = [0; 3];

struct Suite(PathBuf);

impl Suite {
    fn open() -> Option<Self> {
        shared("stability").map(Suite)
    }

    #[track_caller]
    fn try_render(&self, name: &str) -> Result<Rendered, String> {
        let mut images = render_file(&self.0.join(format!("{name}.gml")))?;
        assert_eq!(images.len(), 1, "{name}");
        Ok(images.remove(0))
    }

    #[track_caller]
    fn render(&self, name: &str) -> Picture {
        let Rendered { image, counts, .. } =
            self.try_render(name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (width, height) = (image.width as usize, image.height as usize);
        Picture {
            name: name.to_owned(),
            width,
            height,
            pixels: image.pixels,
            n_blocked: counts.blocked,
        }
    }

    /// All images are the same, and not empty.
    #[track_caller]
    fn same(&self, names: &[&str]) {
        let first = self.render(names[0]);
        first.assert_shown();
        for name in &names[1..] {
            let other = self.render(name);
            let n_different =
                first.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count();
            assert_eq!(n_different, 0, "pixels of {name} that differ from {}", names[0]);
        }
    }

    #[track_caller]
    fn empty(&self, name: &str) {
        self.render(name).check(|_, _| BLACK);
    }
}

struct Picture {
    name: String,
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
    n_blocked: u64,
}

impl Picture {
    /// The pixel in column `x` of row `y`.
    fn at(&self, x: usize, y: usize) -> Rgb {
        self.pixels[y * self.width + x]
    }

    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let width = self.width;
        (0..self.width * self.height).map(move |idx| (idx % width, idx / width))
    }

    /// Something is seen.
    #[track_caller]
    fn assert_shown(&self) {
        assert!(self.pixels.iter().any(|&p| p != BLACK), "{} is empty", self.name);
    }

    /// Every pixel is the one that a function of its place gives.
    #[track_caller]
    fn check(&self, expected: impl Fn(usize, usize) -> Rgb) {
        let wrong: Vec<_> =
            self.places().filter(|&(x, y)| self.at(x, y) != expected(x, y)).collect();
        if let Some(&(x, y)) = wrong.first() {
            let (found, expected) = (self.at(x, y), expected(x, y));
            panic!(
                "{}: {} pixels, first ({x}, {y}): {found:?}, not {expected:?}",
                self.name,
                wrong.len()
            );
        }
    }

    /// The pixels that are not black are those for which a function of their place says so.
    #[track_caller]
    fn check_mask(&self, is_hit: impl Fn(usize, usize) -> bool) {
        let wrong =
            self.places().filter(|&(x, y)| (self.at(x, y) != BLACK) != is_hit(x, y)).count();
        assert_eq!(wrong, 0, "{}: pixels on the wrong side of the outline", self.name);
    }

    /// Twice the squared distance of a pixel's centre from the image's centre, in pixels; exact.
    fn off_center(&self, x: usize, y: usize) -> i64 {
        let across = 2 * x as i64 + 1 - self.width as i64;
        let down = 2 * y as i64 + 1 - self.height as i64;
        across * across + down * down
    }
}

macro_rules! suite {
    ($($(#[$doc:meta])* fn $name:ident($suite:ident) $body:block)*) => {
        $(
            $(#[$doc])*
            #[test]
            fn $name() {
                let Some($suite) = Suite::open() else { return };
                $body
            }
        )*
    };
}

suite! {
    /// b² - 4ac cancels as the square of the distance.
    fn t01_far_spheres_have_the_right_outline(suite) {
        for (name, distance, fov) in [
            ("t01_far_sphere_1e+02", 1e2, 1.718_744_487_289_261_6_f64),
            ("t01_far_sphere_1e+05", 1e5, 0.001_718_873_385_263_554_2),
            ("t01_far_sphere_1e+08", 1e8, 1.718_873_385_392_469_6e-6),
        ] {
            let picture = suite.render(name);
            let half = 48.0 / (fov / 2.0).to_radians().tan();
            let limit = half * half / (distance * distance - 1.0);
            picture.check_mask(|x, y| picture.off_center(x, y) as f64 <= limit);
        }
        suite.same(&["t01_far_sphere_1e+05", "t01_far_sphere_1e+08"]);
    }

    /// Any absolute tolerance is wrong at one end.
    fn t02_scale_does_not_matter(suite) {
        suite.same(&["t02_scale_inv_1e+00", "t02_scale_inv_1e+06", "t02_scale_inv_1e-06"]);
    }

    fn t03_a_planet_is_as_flat_as_a_plane(suite) {
        suite.same(&["t03_planet", "t03o_plane"]);
    }

    /// The near root is 0 or a hair off; the far side is what is seen.
    fn t04_an_eye_on_a_sphere_sees_its_inside(suite) {
        for name in ["t04_eye_on_sphere", "t04b_eye_in_hollow"] {
            let picture = suite.render(name);
            // Blue is 0.5 everywhere, and red and green follow u and v.
            picture.check(|x, y| { let [r, g, _] = picture.at(x, y); [r, g, 127] });
            assert!(picture.pixels.iter().any(|p| p[0] > 150) && picture.pixels.iter().any(|p| p[1] > 150));
        }
    }

    fn t05_an_eye_in_a_cube_sees_a_room_without_shadows(suite) {
        let picture = suite.render("t05_eye_in_cube");
        assert!(picture.pixels.iter().all(|&p| p != BLACK));
        assert_eq!(picture.n_blocked, 0);
    }

    fn t06_the_horizon_is_sharp_and_the_checkers_are_antisymmetric(suite) {
        let picture = suite.render("t06_horizon");
        picture.check_mask(|_, y| y >= 24);
        for (x, y) in picture.places().filter(|&(_, y)| y >= 24) {
            assert_ne!(picture.at(x, y), picture.at(47 - x, y), "({x}, {y})");
        }
    }

    fn t07_the_apex_of_a_cone_is_met(suite) {
        let picture = suite.render("t07_cone_apex");
        picture.check_mask(|x, y| picture.at(y, 48 - x) != BLACK);
        assert_eq!(picture.at(24, 24), [45, 30, 15]);
    }

    /// The eye is the apex: inside the cone the base is seen, outside the wall behind.
    fn t08_an_eye_at_the_apex_sees_the_base(suite) {
        let picture = suite.render("t08_cone_generators");
        picture.check(|x, y| if picture.off_center(x, y) < 48 * 48 { [229, 153, 76] } else { [76, 76, 229] });
    }

    fn t09_tangent_solids_share_nothing(suite) {
        suite.empty("t09_tangent_intersect");
        suite.same(&["t09b_tangent_diff", "t09o_A_only"]);
    }

    fn t10_a_contact_shadow_has_no_stray_pixels(suite) {
        let picture = suite.render("t10_sphere_on_plane");
        picture.assert_shown();
        let brightness = |x: usize, y: usize| picture.at(x, y).iter().map(|&c| i32::from(c)).sum::<i32>();
        let inner = |&(x, y): &(usize, usize)| x > 0 && y > 0 && x < 47 && y < 47;
        // A lit pixel in shadow, or the reverse, is off from all around it by this much or more.
        const LIT: i32 = 60;
        let is_stray = |&(x, y): &(usize, usize)| {
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            let steps = around.map(|(i, j)| brightness(x, y) - brightness(i, j));
            steps.iter().all(|&step| step > LIT) || steps.iter().all(|&step| step < -LIT)
        };
        assert_eq!(picture.places().filter(inner).filter(is_stray).count(), 0);
    }

    fn t11_the_second_operand_paints_coincident_surfaces(suite) {
        let picture = suite.render("t11_union_coincident");
        assert!(picture.pixels.contains(&[0, 0, 255]));
        picture.check(|x, y| if picture.at(x, y) == BLACK { BLACK } else { [0, 0, 255] });
    }

    fn t12_nothing_is_left_of_a_solid_less_itself(suite) {
        for shape in ["sphere", "cube", "cylinder", "cone"] {
            suite.empty(&format!("t12_{shape}_minus_self"));
        }
    }

    /// The two copies differ by 1e-16, unless one knows that they do not.
    fn t13_nor_of_a_solid_less_itself_turned_by_a_symmetry(suite) {
        for name in ["t13_minus_rotated_self", "t13b_sphere_rot_diff", "t13c_cube_120_diff", "t13d_cube_3x30_diff"] {
            suite.empty(name);
        }
    }

    fn t14_a_flush_drill_opens_the_hole(suite) {
        suite.same(&["t14_drill_flush", "t14o_drill_through"]);
        suite.same(&["t14b_drill_flush_scaled", "t14bo_drill_through"]);
    }

    fn t15_a_touching_solid_takes_nothing_away(suite) {
        suite.same(&["t15_touch_diff", "t15o_A_only"]);
    }

    fn t16_touching_solids_have_no_seam(suite) {
        suite.same(&["t16_seam_union", "t16o_box_2x1x1"]);
        suite.same(&["t16b_eight_cubes", "t16bo_box"]);
    }

    fn t17_no_light_leaks_through_a_thin_shell(suite) {
        suite.same(&["t17_thin_shell", "t17o_solid"]);
    }

    /// Shell k lies between radii (k - 1)/100 and k/100; every second one is solid.
    fn t18_a_hundred_nested_shells_are_cut_cleanly(suite) {
        let picture = suite.render("t18_nested_100");
        let is_yellow = |[r, g, b]: Rgb| r == g && r > 0 && u32::from(b) * 4 < u32::from(r);
        let mut n_seen = 0;
        for (x, y) in picture.places() {
            let tan = 30f64.to_radians().tan();
            let radius = 2.5 * tan / 48.0 * (picture.off_center(x, y) as f64).sqrt();
            if radius < 1.01 {
                let shell = (100.0 * radius).floor() as i64;
                assert_eq!(is_yellow(picture.at(x, y)), shell % 2 == 1 || shell >= 99, "({x}, {y}) {radius}");
                n_seen += 1;
            }
        }
        assert_eq!(n_seen, 880);
    }

    fn t19_a_thousand_reflections_add_up(suite) {
        // 255 * 0.001 * the sum of 0.999^k for k up to 1000, rounded down.
        suite.render("t19_parallel_mirrors").check(|_, _| [161; 3]);
    }

    fn t20_mirrored_scenes_give_mirrored_images(suite) {
        let picture = suite.render("t20_mirror_symmetry");
        picture.assert_shown();
        picture.check(|x, y| picture.at(47 - x, y));
    }

    fn t21_t22_t25_transforms_that_cancel_leave_no_trace(suite) {
        suite.same(&["t21_rot_identity", "t21b_rot_4x90", "t21c_rot_360x1", "t22_scale_chain", "t25_translate_1e7"]);
    }

    fn t23_a_pancake_is_a_plane(suite) {
        suite.same(&["t23_pancake", "t23o_plane"]);
    }

    /// A convex solid casts no shadow on its lit side.
    fn t26_convex_solids_do_not_shadow_themselves(suite) {
        for shape in ["sphere", "cube", "cylinder", "cone"] {
            let picture = suite.render(&format!("t26_acne_{shape}"));
            picture.assert_shown();
            assert_eq!(picture.n_blocked, 0, "{shape}");
        }
    }

    fn t27_a_low_sun_lights_all_the_ground(suite) {
        suite.render("t27_plane_low_sun").check(|_, y| if y >= 24 { [127; 3] } else { BLACK });
    }

    /// A u of 1, or a hair below 0, would be an index outside the table of colours.
    fn t29_to_t31_seams_and_poles_stay_in_range(suite) {
        for name in ["t29_uv_seam", "t30_uv_pole", "t31_cyl_axis", "t31b_cyl_bore", "t24_shear", "t23b_needle"] {
            suite.render(name).assert_shown();
        }
    }

    fn t33_the_edge_of_a_spotlight_is_a_circle(suite) {
        let picture = suite.render("t33_spot_edge");
        picture.check_mask(|x, y| 4 * picture.off_center(x, y) <= 48 * 48);
    }

    fn t34_a_light_on_a_plane_does_not_light_it(suite) {
        suite.render("t34_light_on_plane").check(|_, y| if y >= 24 { [63; 3] } else { BLACK });
    }

    fn t35_directions_have_no_length(suite) {
        suite.same(&["t35_dir_1e200", "t35b_dir_1em200", "t35o_dir_1"]);
    }

    fn t36_a_scale_of_zero_is_an_error(suite) {
        let error = suite.try_render("t36_zero_scale").err().expect("an error");
        assert!(error.starts_with("E0306 at"), "{error}");
    }

    fn t38_checkers_follow_their_texture_coordinates(suite) {
        let picture = suite.render("t38_checker_tie");
        // The wall is 10 away, so that u = (2x - 39)/4 and v = (39 - 2y)/4.
        let cell = |quarters: i64| quarters.div_euclid(4);
        picture.check(|x, y| {
            let sum = cell(2 * x as i64 - 39) + cell(39 - 2 * y as i64);
            if sum.rem_euclid(2) == 0 { [255; 3] } else { [25; 3] }
        });
    }

    fn t39_fifty_half_spaces_leave_no_hole(suite) {
        let picture = suite.render("t39_planes_50");
        picture.assert_shown();
        for y in 0..picture.height {
            let row: Vec<bool> = (0..picture.width).map(|x| picture.at(x, y) != BLACK).collect();
            let n_edges = row.windows(2).filter(|pair| pair[0] != pair[1]).count();
            assert!(n_edges <= 2, "row {y}");
        }
    }

    fn t41_half_gray_is_rounded_down(suite) {
        suite.render("t41_half_tie").check(|_, _| [127; 3]);
    }

    fn t43_mirrored_solids_keep_their_outline(suite) {
        let (mirrored, plain) = (suite.render("t43_neg_scale"), suite.render("t43o_pos"));
        plain.assert_shown();
        mirrored.check_mask(|x, y| plain.at(x, y) != BLACK);
    }

    fn t45_boolean_identities_hold(suite) {
        for pair in [
            &["t45a_A-(B+C)", "t45b_(A-B)-C"][..],
            &["t45c_A*(B+C)", "t45d_(A*B)+(A*C)"],
            &["t45e_(A-B)+(A*B)", "t45f_A", "t45k_(A-B)+(A*B)rot"],
            &["t45g_A+B", "t45h_B+A"],
            &["t45i_A-(A-B)", "t45j_A*B"],
        ] {
            suite.same(pair);
        }
    }

    /// What has no oracle of its own renders, at least.
    fn all_others_render(suite) {
        for name in ["t06b_grazing_plane", "t06o_plane_fov1", "t26o_noshadow", "t40_chaos_spheres", "t42_acne_csg", "t44_zoo"] {
            suite.render(name).assert_shown();
        }
    }
}
