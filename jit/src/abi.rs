//! What native shaders and their callers agree on.

/// Where a shader leaves its results but red, which it returns.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SurfaceOut {
    pub(crate) green: f64,
    pub(crate) blue: f64,
    pub(crate) kd: f64,
    pub(crate) ks: f64,
    pub(crate) phong_exp: f64,
}

/// Where a bounded shader leaves its results.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct BoundedOut {
    /// Red, green, blue, kd, ks, n.
    pub(crate) values: [f64; 6],
    /// How far off they may be.
    pub(crate) errors: [f64; 6],
}

/// Where a signed shader leaves its results.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct SignedOut {
    pub(crate) red: f64,
    pub(crate) sample: SurfaceOut,
    /// The signature of its decisions.
    pub(crate) decisions: u64,
}

/// A bounded or signed shader returns this when it has written its results.
pub(crate) const DONE: i32 = 0;
/// A bounded or signed shader returns this when the interpreter must do the call: nothing has been
/// written.
pub(crate) const LEFT: i32 = 1;

/// Native code: environment, face, u, v, results; red. That is NaN when the interpreter must do the call,
/// and nothing may have been written then; a red that is NaN in fact is left to the interpreter, too. So
/// one register says both, by every calling convention. The environment is what all
/// calls for one closure have in common: fuel for the rounds of loops and calls of routines, and then
/// the uniforms.
pub(crate) type SurfaceFn = unsafe extern "C" fn(
    environment: *const u64,
    face: i64,
    u: f64,
    v: f64,
    out: *mut SurfaceOut,
) -> f64;

/// Native code of a bounded shader: as [`SignedFn`], with the radii of u and v behind them.
pub(crate) type BoundedFn = unsafe extern "C" fn(
    environment: *const u64,
    face: i64,
    u: f64,
    v: f64,
    u_radius: f64,
    v_radius: f64,
    out: *mut BoundedOut,
) -> i32;

/// Native code of a signed shader: as [`SurfaceFn`], but all results are left in memory; [`DONE`] or
/// [`LEFT`].
pub(crate) type SignedFn = unsafe extern "C" fn(
    environment: *const u64,
    face: i64,
    u: f64,
    v: f64,
    out: *mut SignedOut,
) -> i32;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_lie_in_a_row() {
        use std::mem::offset_of;
        assert_eq!(size_of::<SurfaceOut>(), 40);
        let offsets = [
            offset_of!(SurfaceOut, green),
            offset_of!(SurfaceOut, blue),
            offset_of!(SurfaceOut, kd),
            offset_of!(SurfaceOut, ks),
            offset_of!(SurfaceOut, phong_exp),
        ];
        assert_eq!(offsets, [0, 8, 16, 24, 32]);
        assert_eq!((size_of::<BoundedOut>(), offset_of!(BoundedOut, errors)), (96, 48));
        assert_eq!((size_of::<SignedOut>(), offset_of!(SignedOut, decisions)), (56, 48));
    }
}
