//! What packets have met so far, and the limits of a cast.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;

use super::{
    lanes::{F, M, splat},
    pack::{GROUPS, LANES, Lanes, PacketGroup},
    query::BundleCast,
};

/// No target.
pub(super) const NONE: u32 = u32::MAX;

/// What the rays of a packet have met so far.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Best {
    pub t: Lanes,
    /// Below zero: to be computed again.
    pub margin: Lanes,
    pub target: [u32; LANES],
    pub primitive: [u32; LANES],
}

/// What a part has met so far.
pub(super) struct Seen {
    pub best: ArrayVec<Best, { GROUPS * LANES }>,
    /// Of each packet, the farthest of its rays' nearest distances; below zero where there is no packet.
    pub far: [Lanes; GROUPS],
    /// The same of each group.
    pub group_far: Lanes,
}

impl Seen {
    pub fn new(part: &PacketGroup, far: f32) -> Self {
        let nothing =
            Best { t: Lanes([far; LANES]), margin: Lanes([0.0; LANES]), target: [NONE; LANES], primitive: [0; LANES] };
        let nothing_yet = Lanes([-1.0; LANES]);
        let mut seen = Self { best: ArrayVec::new(), far: [nothing_yet; GROUPS], group_far: nothing_yet };
        for packet in 0..part.packets.len() {
            seen.best.push(nothing);
            seen.far[packet / LANES].0[packet % LANES] = far;
            seen.group_far.0[packet / LANES] = far;
        }
        seen
    }
}

/// The limits of a cast.
pub(super) struct Limits {
    pub near: f32,
    pub far: f32,
    pub cos: f32,
    pub front: bool,
    pub back: bool,
    /// Both sides are seen at any incidence.
    pub all: bool,
}

impl Limits {
    pub fn new(cast: &BundleCast<'_>) -> Option<Self> {
        let near = cast.near.max(0.0);
        let cos =
            if cast.max_incidence < std::f64::consts::FRAC_PI_2 { libm::cos(cast.max_incidence.max(0.0)) } else { 0.0 };
        let (front, back) = (cast.faces.front, cast.faces.back);
        let ordered = near <= cast.far && (front || back);
        ordered.then(|| Self {
            near: near as f32,
            // So far away nothing is, and no product of it overflows.
            far: cast.far.min(1e15) as f32,
            cos: cos as f32,
            front,
            back,
            all: front && back && cos <= 0.0,
        })
    }

    /// Crossings that count, of which the slope is known: the cosine between ray and outward normal.
    #[inline(always)]
    pub fn shows<S: Simd>(&self, simd: S, slope: F<S>) -> M<S> {
        let zero = splat(simd, 0.0);
        let front = slope.simd_le(zero) & M::splat(simd, self.front);
        let back = slope.simd_ge(zero) & M::splat(simd, self.back);
        (front | back) & slope.abs().simd_ge(splat(simd, self.cos))
    }
}
