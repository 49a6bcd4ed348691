//! Surface functions of kernels and scenes in Rust, operation by operation: so they give the same
//! bits. Sines are those of the operators.

use std::array;

use compiler::degrees::{cos, sin};
use compiler::scalar;

/// What a surface function leaves: red, green, blue, kd, ks, n.
pub(crate) type Answer = [f64; 6];

/// A surface function, of face, u and v.
pub(crate) type Twin = fn(u8, f64, f64) -> Answer;

// Kernels.

pub(crate) fn empty(_: u8, u: f64, v: f64) -> Answer {
    [u, v, 0.5, 0.8, 0.2, 6.0]
}

pub(crate) fn checker(_: u8, u: f64, v: f64) -> Answer {
    const LIGHT: [f64; 3] = [0.9, 0.8, 0.6];
    const DARK: [f64; 3] = [0.2, 0.1, 0.1];
    static TILES: [[[f64; 3]; 3]; 3] =
        [[LIGHT, DARK, LIGHT], [DARK, LIGHT, DARK], [LIGHT, DARK, LIGHT]];
    let third = |x: f64| scalar::floor(x * 3.0).expect("small") as usize;
    let [red, green, blue] = TILES[third(v)][third(u)];
    [red, green, blue, 0.8, 0.2, 6.0]
}

pub(crate) fn marble(_: u8, u: f64, v: f64) -> Answer {
    let (x, y) = (u * 6.0, v * 4.0);
    let coarse = sin(x * 67.0 + y * 31.0);
    let fine = cos(y * 113.0 - x * 47.0 + coarse * 40.0);
    let wave = sin((x + y) * 90.0 + coarse * 75.0 + fine * 25.0);
    let calm = 1.0 - wave * wave;
    let square = calm * calm;
    let vein = square * square;
    let cloud = cos((x - y) * 130.0 + fine * 60.0) * 0.5 + 0.5;
    let soft = cloud * cloud * (3.0 - cloud * 2.0);
    let t = (vein * 0.7 + soft * 0.3).clamp(0.0, 1.0);
    let rest = 1.0 - t;
    [
        t * 0.92 + rest * 0.20,
        t * 0.88 + rest * 0.16,
        t * 0.80 + rest * 0.24,
        t * 0.35 + 0.55,
        0.45 - t * 0.25,
        t * 18.0 + 6.0,
    ]
}

pub(crate) fn mandelbrot(_: u8, u: f64, v: f64) -> Answer {
    let (cr, ci) = (u * 3.0 - 2.2, v * 2.4 - 1.2);
    let (mut re, mut im, mut n) = (0.0, 0.0, 0);
    while n < 30 {
        let (rr, ii) = (re * re, im * im);
        if rr + ii >= 4.0 {
            break;
        }
        (re, im) = (rr - ii + cr, re * im * 2.0 + ci);
        n += 1;
    }
    let t = f64::from(n) / 30.0;
    [t, t * t, 1.0 - t, 0.9, 0.1, 10.0]
}

// Scenes. The names are those in the programs.

fn frac(x: f64) -> f64 {
    (x - x.trunc()).copysign(x)
}

fn floor(x: f64) -> i64 {
    x.floor() as i64
}

fn clampf(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

/// A sine between 0 and 1.
fn half_sin(angle: f64) -> f64 {
    sin(angle) * 0.5 + 0.5
}

pub(crate) fn texture_faces_chart(face: u8, u: f64, v: f64) -> Answer {
    let lined = |t: f64| frac(t * 8.0 + 0.06) < 0.12;
    let ink = if lined(u) || lined(v) { 0.35 } else { 1.0 };
    [u * ink, v * ink, f64::from(face) * 0.24 * ink, 0.92, 0.08, 40.0]
}

pub(crate) fn texture_faces_plan(_: u8, u: f64, v: f64) -> Answer {
    let (a, b) = (u - floor(u) as f64, v - floor(v) as f64);
    let ink = if a < 0.03 || b < 0.03 { 0.15 } else { 0.75 };
    [(0.2 + a * 0.6) * ink, (0.2 + b * 0.6) * ink, 0.2 * ink, 1.0, 0.0, 1.0]
}

pub(crate) fn showpiece_copper(_: u8, u: f64, _: f64) -> Answer {
    let rib = frac(u * 24.0) - 0.5;
    let tone = rib * rib * 2.2 + 0.5;
    [0.3 * tone, 0.62 * tone, 0.55 * tone, 0.9, 0.1, 20.0]
}

pub(crate) fn showpiece_leaves(_: u8, u: f64, v: f64) -> Answer {
    let tone = sin(u * 8000.0 + sin(v * 5000.0) * 90.0) * 0.2 + 0.8;
    [0.05 * tone, 0.13 * tone, 0.07 * tone, 1.0, 0.0, 1.0]
}

pub(crate) fn showpiece_water(_: u8, u: f64, v: f64) -> Answer {
    let long = sin(v * 420.0 + sin(u * 75.0) * 120.0 + u * 31.0);
    let short = sin(v * 990.0 + sin(u * 160.0) * 70.0 - u * 210.0) * 0.6;
    let wave = (long + short) / (1.0 + v * v * 0.02);
    [0.03, 0.06, 0.09, 0.4, 0.66 + wave * 0.13, 200.0]
}

pub(crate) fn kaleidoscope_opal(_: u8, u: f64, v: f64) -> Answer {
    let r = (u * u + v * v).sqrt();
    let a = (sin(u * 400.0) + sin(v * 330.0 + 50.0)) * 0.25 + 0.5;
    let b = half_sin(r * 900.0 + 40.0);
    [
        0.75 * a + 0.2 * b + 0.08,
        0.22 * b + 0.3 * (a * a) + 0.06,
        0.55 * (1.0 - a) + 0.15 * b + 0.12,
        1.15,
        0.0,
        1.0,
    ]
}

pub(crate) fn mandelbrot_fractal(_: u8, u: f64, v: f64) -> Answer {
    const LIMIT: i64 = 80;
    let (mut x, mut y, mut n) = (0.0, 0.0, 0);
    loop {
        let (xx, yy) = (x * x, y * y);
        if n == LIMIT || 4.0 < xx + yy {
            break;
        }
        (x, y) = (xx - yy + u, x * y * 2.0 + v);
        n += 1;
    }
    if n == LIMIT {
        return [0.01, 0.01, 0.03, 0.6, 0.4, 80.0];
    }
    let a = (n as f64 + 1.0).sqrt() * 78.0 - 40.0;
    let shade = 1.0 - (n % 2) as f64 * 0.14;
    [
        half_sin(a - 175.0) * shade,
        (half_sin(a - 130.0) * 0.8 + 0.04) * shade,
        (half_sin(a - 20.0) * 0.6 + 0.25) * shade,
        0.95,
        0.05,
        30.0,
    ]
}

pub(crate) fn dominoes_planks(_: u8, u: f64, v: f64) -> Answer {
    let w = (u * 0.08 + v) * 3.0;
    let plank = floor(w);
    let tone = (plank * 29 % 11) as f64 * 0.02 + 0.75 + sin(w * 0.97 * 900.0) * 0.03;
    let tone = if w - (plank as f64) < 0.04 { 0.45 } else { tone };
    [0.72 * tone, 0.56 * tone, 0.4 * tone, 0.85, 0.15, 40.0]
}

pub(crate) fn flake_sky(_: u8, _: f64, v: f64) -> Answer {
    let h = clampf(v * 2.0 - 1.0);
    let low = 1.0 - h;
    let glow = low * low * low * low;
    [0.1 + glow * 1.0, 0.14 + low * 0.25 + glow * 0.25, 0.32 + low * 0.2, 1.6, 0.0, 1.0]
}

pub(crate) fn csg_gears_plate(_: u8, _: f64, v: f64) -> Answer {
    let tone = (sin(v * 4000.0) + sin(v * 1730.0)) * 0.02 + 0.16;
    [tone, tone * 1.1, tone * 1.3, 0.85, 0.15, 15.0]
}

pub(crate) fn marble_tiles(_: u8, u: f64, v: f64) -> Answer {
    const CARRARA: [f64; 3] = [0.92, 0.88, 0.84];
    const GREY: [f64; 3] = [0.3, 0.32, 0.38];
    const ROSSO: [f64; 3] = [0.32, 0.06, 0.07];
    const PALE: [f64; 3] = [0.75, 0.52, 0.48];
    let (i, j) = (floor(u), floor(v));
    let shift = i as f64 * 7.3;
    let [red, green, blue] = if (i + j) % 2 == 0 {
        stone(CARRARA, GREY, u, shift + j as f64 * 3.1, v)
    } else {
        stone(ROSSO, PALE, v, shift + j as f64 * 2.3, u)
    };
    let (du, dv) = (u - i as f64 - 0.5, v - j as f64 - 0.5);
    if du * du < 0.2304 && dv * dv < 0.2304 {
        [red, green, blue, 0.8, 0.2, 50.0]
    } else {
        [red, green, blue, 0.25, 0.0, 1.0]
    }
}

fn stone(base: [f64; 3], vein: [f64; 3], x: f64, y: f64, z: f64) -> [f64; 3] {
    let t = turbulence(x, y, z);
    let wave = sin((x + y + z * 0.6) * 100.0 + t * 130.0);
    let near = 1.0 - (wave * wave).sqrt();
    let sharp = near * near * near * near;
    let rest = (0.8 + t * 0.14) * (1.0 - sharp);
    array::from_fn(|c| clampf(base[c] * rest + vein[c] * sharp))
}

fn turbulence(x: f64, y: f64, z: f64) -> f64 {
    let a = sin(x * 97.0 + sin(z * 61.0 + 30.0) * 80.0);
    let b = sin(y * 173.0 + a * 95.0 + x * 41.0);
    let c = sin(z * 311.0 + b * 110.0 - y * 67.0);
    let d = sin(x * 617.0 + c * 85.0 + z * 283.0);
    a + b * 0.55 + c * 0.3 + d * 0.16
}
