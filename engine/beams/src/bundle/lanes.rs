//! Vectors of 16 values, with operations whose results are bit-identical at all SIMD levels.

use fearless_simd::{f32x16, mask32x16, prelude::*, u32x16};
use nalgebra::{Matrix3, Vector3};

use super::pack::{LaneArray, RayPacket};

pub(super) type FloatLanes<S> = f32x16<S>;
pub(super) type MaskLanes<S> = mask32x16<S>;
pub(super) type UintLanes<S> = u32x16<S>;

/// Minimum magnitude of the components of a direction; smaller ones are replaced, to avoid division by zero.
const MIN_COMPONENT: f32 = 1e-20;

/// 16 vectors.
#[derive(Clone, Copy)]
pub(super) struct VectorLanes<S: Simd> {
    pub x: FloatLanes<S>,
    pub y: FloatLanes<S>,
    pub z: FloatLanes<S>,
}

impl LaneArray {
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> FloatLanes<S> {
        FloatLanes::load_array_ref(simd, &self.0)
    }
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, value: FloatLanes<S>) {
        value.store_array(&mut self.0);
    }
}

impl<S: Simd> VectorLanes<S> {
    #[inline(always)]
    pub fn load(simd: S, packet: &RayPacket) -> Self {
        Self { x: packet.x.load(simd), y: packet.y.load(simd), z: packet.z.load(simd) }
    }

    #[inline(always)]
    pub fn dot(&self, v: &[f32; 3]) -> FloatLanes<S> {
        self.x * v[0] + self.y * v[1] + self.z * v[2]
    }

    /// Rotates the vectors.
    #[inline(always)]
    pub fn rotated(&self, turn: &[[f32; 3]; 3]) -> Self {
        Self { x: self.dot(&turn[0]), y: self.dot(&turn[1]), z: self.dot(&turn[2]) }
    }
}

/// Converts the rows of a matrix to 32 bits.
pub(super) fn rows(m: &Matrix3<f64>) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|i| [m[(i, 0)] as f32, m[(i, 1)] as f32, m[(i, 2)] as f32])
}

pub(super) fn to_f32(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> FloatLanes<S> {
    FloatLanes::splat(simd, value)
}

/// Returns the reciprocals of the components. For components near zero they are finite, but large enough to act as
/// infinity.
#[inline(always)]
pub(super) fn inverse<S: Simd>(simd: S, d: FloatLanes<S>) -> FloatLanes<S> {
    let tiny = splat(simd, MIN_COMPONENT);
    splat(simd, 1.0) / d.abs().simd_lt(tiny).select(tiny, d)
}
