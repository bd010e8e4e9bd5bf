//! Intersection of 16 rays with each analytic form, in the form's frame.
//!
//! A ray is inside a convex solid over a single interval: it enters through a front face and leaves through a back
//! face. A form returns only this interval and, on request, which part of the surface is hit at its ends and at what
//! angle.

use fearless_simd::prelude::*;

use super::lanes::{FloatLanes, MaskLanes, UintLanes, VectorLanes, inverse, splat};
use crate::simd::{greatest, least};

/// The intervals over which rays are inside a solid.
#[derive(Clone, Copy)]
pub(super) struct RaySpan<S: Simd> {
    pub enter: FloatLanes<S>,
    pub leave: FloatLanes<S>,
    /// Rays whose line intersects the solid, possibly behind the origin.
    pub valid: MaskLanes<S>,
}

/// A form that rays in its own frame can hit.
pub(super) trait AnalyticForm<S: Simd> {
    /// Intermediate results that describe the surface at the ends.
    type SurfaceTerms: Copy;

    fn span(&self, simd: S, d: &VectorLanes<S>) -> (RaySpan<S>, Self::SurfaceTerms);

    /// Returns the cosine between ray and outward normal, and the primitive, at the point where rays leave (lanes of
    /// `leaving`) or enter.
    fn surface(
        &self,
        simd: S,
        d: &VectorLanes<S>,
        span: &RaySpan<S>,
        more: &Self::SurfaceTerms,
        leaving: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>);
}

/// Returns `size` with the sign of an end of the interval: positive where rays leave, negative where they enter.
#[inline(always)]
fn signed<S: Simd>(leaving: MaskLanes<S>, size: FloatLanes<S>) -> FloatLanes<S> {
    leaving.select(size, -size)
}

/// Returns the interval between two planes perpendicular to an axis.
#[inline(always)]
fn slab<S: Simd>(simd: S, low: f32, high: f32, d: FloatLanes<S>) -> (FloatLanes<S>, FloatLanes<S>) {
    let inverse = inverse(simd, d);
    let (a, b) = (inverse * low, inverse * high);
    (least(a, b), greatest(a, b))
}

pub(super) struct PlaneForm {
    /// Height of the rays' origin.
    pub height: f32,
}

impl<S: Simd> AnalyticForm<S> for PlaneForm {
    type SurfaceTerms = ();

    #[inline(always)]
    fn span(&self, simd: S, d: &VectorLanes<S>) -> (RaySpan<S>, ()) {
        let t = inverse(simd, d.z) * -self.height;
        let valid = d.z.abs().simd_gt(splat(simd, 1e-12));
        (RaySpan { enter: t, leave: t, valid }, ())
    }

    #[inline(always)]
    fn surface(
        &self,
        simd: S,
        d: &VectorLanes<S>,
        _: &RaySpan<S>,
        (): &(),
        _: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>) {
        (d.z, UintLanes::splat(simd, 0))
    }
}

pub(super) struct BoxForm {
    /// Positions of the sides relative to the origin.
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl<S: Simd> AnalyticForm<S> for BoxForm {
    /// Parameters at which rays cross the planes perpendicular to x and y, on entry and on exit.
    type SurfaceTerms = [FloatLanes<S>; 4];

    #[inline(always)]
    fn span(&self, simd: S, d: &VectorLanes<S>) -> (RaySpan<S>, [FloatLanes<S>; 4]) {
        let (x0, x1) = slab(simd, self.low[0], self.high[0], d.x);
        let (y0, y1) = slab(simd, self.low[1], self.high[1], d.y);
        let (z0, z1) = slab(simd, self.low[2], self.high[2], d.z);
        let enter = greatest(greatest(x0, y0), z0);
        let leave = least(least(x1, y1), z1);
        (RaySpan { enter, leave, valid: enter.simd_le(leave) }, [x0, y0, x1, y1])
    }

    #[inline(always)]
    fn surface(
        &self,
        simd: S,
        d: &VectorLanes<S>,
        span: &RaySpan<S>,
        more: &[FloatLanes<S>; 4],
        leaving: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>) {
        let [x0, y0, x1, y1] = *more;
        let t = leaving.select(span.leave, span.enter);
        let across_x = t.simd_eq(leaving.select(x1, x0));
        let across_y = t.simd_eq(leaving.select(y1, y0));
        let along = across_x.select(d.x, across_y.select(d.y, d.z));
        let low = across_x
            .select(UintLanes::splat(simd, 0), across_y.select(UintLanes::splat(simd, 2), UintLanes::splat(simd, 4)));
        // A ray with a positive component enters through the lower side and leaves through the upper side.
        let upper = along.simd_gt(splat(simd, 0.0)).simd_eq(leaving);
        (signed(leaving, along.abs()), upper.select(low + UintLanes::splat(simd, 1), low))
    }
}

pub(super) struct SphereForm {
    pub origin: [f32; 3],
    pub radius: f32,
    /// Inverse of the radius; 0 if the radius is 0.
    pub inverse: f32,
}

/// Returns half of the length of a ray's chord through a ball, and the distance to its middle; half lengths of rays
/// that miss are NaN.
#[inline(always)]
fn through_ball<S: Simd>(d: &VectorLanes<S>, origin: [f32; 3], radius: f32) -> (FloatLanes<S>, FloatLanes<S>) {
    let middle = -d.dot(&origin);
    // The squared distance of the line from the centre, computed from the vector, which avoids cancellation.
    let (x, y, z) = (d.x * middle + origin[0], d.y * middle + origin[1], d.z * middle + origin[2]);
    let miss = x * x + y * y + z * z;
    ((radius * radius - miss).sqrt(), middle)
}

impl<S: Simd> AnalyticForm<S> for SphereForm {
    type SurfaceTerms = FloatLanes<S>;

    #[inline(always)]
    fn span(&self, _: S, d: &VectorLanes<S>) -> (RaySpan<S>, FloatLanes<S>) {
        let (half, middle) = through_ball(d, self.origin, self.radius);
        (RaySpan { enter: middle - half, leave: middle + half, valid: half.simd_eq(half) }, half)
    }

    #[inline(always)]
    fn surface(
        &self,
        simd: S,
        _: &VectorLanes<S>,
        _: &RaySpan<S>,
        half: &FloatLanes<S>,
        leaving: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>) {
        (signed(leaving, *half * self.inverse), UintLanes::splat(simd, 0))
    }
}

pub(super) struct CylinderForm {
    pub origin: [f32; 3],
    pub radius: f32,
    /// Inverse of the radius; 0 if the radius is 0.
    pub inverse: f32,
    /// Positions of the ends relative to the origin.
    pub low: f32,
    pub high: f32,
    /// Whether the distance of the origin from the axis is at most the radius.
    pub within: bool,
}

impl CylinderForm {
    /// Returns the intervals in the infinite cylinder, and the square root of the discriminant.
    #[inline(always)]
    fn side<S: Simd>(&self, simd: S, d: &VectorLanes<S>) -> (FloatLanes<S>, FloatLanes<S>, FloatLanes<S>) {
        let [x, y, _] = self.origin;
        let a = d.x * d.x + d.y * d.y;
        let b = d.x * x + d.y * y;
        let cross = d.y * x - d.x * y;
        let root = (a * (self.radius * self.radius) - cross * cross).sqrt();
        let scale = splat(simd, 1.0) / a;
        // A ray parallel to the axis is inside either everywhere or nowhere.
        let along = a.simd_lt(splat(simd, 1e-12));
        let far = splat(simd, if self.within { 1e30 } else { f32::NAN });
        (along.select(-far, (-b - root) * scale), along.select(far, (root - b) * scale), root)
    }
}

impl<S: Simd> AnalyticForm<S> for CylinderForm {
    /// Interval in the infinite cylinder, and the square root of the discriminant.
    type SurfaceTerms = [FloatLanes<S>; 3];

    #[inline(always)]
    fn span(&self, simd: S, d: &VectorLanes<S>) -> (RaySpan<S>, [FloatLanes<S>; 3]) {
        let (s0, s1, root) = self.side(simd, d);
        let (z0, z1) = slab(simd, self.low, self.high, d.z);
        let (enter, leave) = (greatest(s0, z0), least(s1, z1));
        let valid = s0.simd_eq(s0) & enter.simd_le(leave);
        (RaySpan { enter, leave, valid }, [s0, s1, root])
    }

    #[inline(always)]
    fn surface(
        &self,
        simd: S,
        d: &VectorLanes<S>,
        span: &RaySpan<S>,
        more: &[FloatLanes<S>; 3],
        leaving: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>) {
        let [s0, s1, root] = *more;
        let t = leaving.select(span.leave, span.enter);
        let on_side = t.simd_eq(leaving.select(s1, s0));
        let size = on_side.select(root * self.inverse, d.z.abs());
        let upper = d.z.simd_gt(splat(simd, 0.0)).simd_eq(leaving);
        (
            signed(leaving, size),
            on_side
                .select(UintLanes::splat(simd, 0), upper.select(UintLanes::splat(simd, 1), UintLanes::splat(simd, 2))),
        )
    }
}

/// A cylinder with hemispheres at its ends.
pub(super) struct CapsuleForm {
    pub cylinder: CylinderForm,
    /// The balls at the upper and at the lower end.
    pub spheres: [SphereForm; 2],
}

impl<S: Simd> AnalyticForm<S> for CapsuleForm {
    /// Root of the side, half chords through the balls, and their intervals.
    type SurfaceTerms = ([FloatLanes<S>; 3], [FloatLanes<S>; 4]);

    #[inline(always)]
    fn span(&self, simd: S, d: &VectorLanes<S>) -> (RaySpan<S>, ([FloatLanes<S>; 3], [FloatLanes<S>; 4])) {
        let (drum, [_, _, root]) = AnalyticForm::<S>::span(&self.cylinder, simd, d);
        let (up, up_half) = AnalyticForm::<S>::span(&self.spheres[0], simd, d);
        let (down, down_half) = AnalyticForm::<S>::span(&self.spheres[1], simd, d);
        // The solid is convex, so the union of the intervals of its parts is a single interval.
        let (never, always) = (splat(simd, f32::INFINITY), splat(simd, f32::NEG_INFINITY));
        let (u0, u1) = (up.valid.select(up.enter, never), up.valid.select(up.leave, always));
        let (d0, d1) = (down.valid.select(down.enter, never), down.valid.select(down.leave, always));
        let (s0, s1) = (drum.valid.select(drum.enter, never), drum.valid.select(drum.leave, always));
        let span = RaySpan {
            enter: least(least(s0, u0), d0),
            leave: greatest(greatest(s1, u1), d1),
            valid: drum.valid | up.valid | down.valid,
        };
        (span, ([root, up_half, down_half], [u0, d0, u1, d1]))
    }

    #[inline(always)]
    fn surface(
        &self,
        simd: S,
        _: &VectorLanes<S>,
        span: &RaySpan<S>,
        more: &Self::SurfaceTerms,
        leaving: MaskLanes<S>,
    ) -> (FloatLanes<S>, UintLanes<S>) {
        let ([root, up_half, down_half], [u0, d0, u1, d1]) = *more;
        let t = leaving.select(span.leave, span.enter);
        let up = t.simd_eq(leaving.select(u1, u0));
        let down = t.simd_eq(leaving.select(d1, d0));
        let size = up.select(up_half, down.select(down_half, root)) * self.cylinder.inverse;
        (
            signed(leaving, size),
            up.select(UintLanes::splat(simd, 1), down.select(UintLanes::splat(simd, 2), UintLanes::splat(simd, 0))),
        )
    }
}
