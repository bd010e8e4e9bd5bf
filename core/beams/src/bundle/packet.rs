//! Intermediate results of packets, and the limits of a cast.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;

use super::{
    lanes::{F, M, splat},
    pack::{GROUPS, LANES, Lanes, PacketGroup},
    query::BundleCast,
};

/// Index that stands for "no target".
pub(super) const NONE: u32 = u32::MAX;

/// The nearest hits of a packet so far.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Best {
    pub t: Lanes,
    /// Difference between the cosine of the incidence and the lowest cosine at which 32 bits suffice; negative if the
    /// distance must be recomputed in 64 bits.
    pub margin: Lanes,
    pub target: [u32; LANES],
    pub primitive: [u32; LANES],
}

/// The nearest hits of a part so far.
pub(super) struct Seen {
    pub best: ArrayVec<Best, { GROUPS * LANES }>,
    /// For each packet, the maximum of its rays' nearest distances; negative if there is no packet.
    pub far: [Lanes; GROUPS],
    /// The same maximum for each group.
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
    /// Whether both sides of surfaces are detected at any incidence.
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
            // 1e15 m exceeds all relevant distances, and products with it do not overflow.
            far: cast.far.min(1e15) as f32,
            cos: cos as f32,
            front,
            back,
            all: front && back && cos <= 0.0,
        })
    }

    /// Returns the lanes whose hits are admissible; `slope` is the cosine between ray and outward normal.
    #[inline(always)]
    pub fn shows<S: Simd>(&self, simd: S, slope: F<S>) -> M<S> {
        let zero = splat(simd, 0.0);
        let front = slope.simd_le(zero) & M::splat(simd, self.front);
        let back = slope.simd_ge(zero) & M::splat(simd, self.back);
        (front | back) & slope.abs().simd_ge(splat(simd, self.cos))
    }
}
