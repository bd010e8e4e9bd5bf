//! Intermediate results of packets, and the limits of a cast.

use arrayvec::ArrayVec;
use fearless_simd::prelude::*;

use super::{
    lanes::{FloatLanes, MaskLanes, splat},
    pack::{BundlePart, GROUPS, LANES, LaneArray},
    query::BundleCast,
};

/// Index that stands for "no target".
pub(super) const NO_TARGET: u32 = u32::MAX;

/// The nearest hits of a packet so far.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct PacketHits {
    pub t: LaneArray,
    /// Difference between the cosine of the incidence and the lowest cosine at which 32 bits suffice; negative if the
    /// distance must be recomputed in 64 bits.
    pub margin: LaneArray,
    pub target: [u32; LANES],
    pub primitive: [u32; LANES],
}

/// The nearest hits of a part so far.
pub(super) struct PartHits {
    pub best: ArrayVec<PacketHits, { GROUPS * LANES }>,
    /// For each packet, the maximum of its rays' nearest distances; negative if there is no packet.
    pub far: [LaneArray; GROUPS],
    /// The same maximum for each group.
    pub group_far: LaneArray,
}

impl PartHits {
    pub fn new(part: &BundlePart, far: f32) -> Self {
        let nothing = PacketHits {
            t: LaneArray([far; LANES]),
            margin: LaneArray([0.0; LANES]),
            target: [NO_TARGET; LANES],
            primitive: [0; LANES],
        };
        let nothing_yet = LaneArray([-1.0; LANES]);
        let mut seen = Self { best: ArrayVec::new(), far: [nothing_yet; GROUPS], group_far: nothing_yet };
        for packet in 0..part.packets.len() {
            seen.best.push(nothing);
            seen.far[packet / LANES].0[packet % LANES] = far;
            seen.group_far.0[packet / LANES] = far;
        }
        seen
    }
}

pub(super) struct CastLimits {
    pub near: f32,
    pub far: f32,
    pub cos: f32,
    pub front: bool,
    pub back: bool,
    /// Whether both sides of surfaces are detected at any incidence.
    pub any_surface: bool,
}

impl CastLimits {
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
            any_surface: front && back && cos <= 0.0,
        })
    }

    /// Returns the lanes whose hits are admissible; `slope` is the cosine between ray and outward normal.
    #[inline(always)]
    pub fn admits<S: Simd>(&self, simd: S, slope: FloatLanes<S>) -> MaskLanes<S> {
        let zero = splat(simd, 0.0);
        let front = slope.simd_le(zero) & MaskLanes::splat(simd, self.front);
        let back = slope.simd_ge(zero) & MaskLanes::splat(simd, self.back);
        (front | back) & slope.abs().simd_ge(splat(simd, self.cos))
    }
}
