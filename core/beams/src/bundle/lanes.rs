//! Vectors of 16 values, with operations whose results are bit-identical at all SIMD levels.

use fearless_simd::{f32x16, mask32x16, prelude::*, u32x16};
use nalgebra::{Matrix3, Vector3};

use super::pack::{Lanes, Packet};

pub(super) type F<S> = f32x16<S>;
pub(super) type M<S> = mask32x16<S>;
pub(super) type U<S> = u32x16<S>;

/// Minimum magnitude of the components of a direction; smaller ones are replaced, to avoid division by zero.
const TINY: f32 = 1e-20;

/// 16 vectors.
#[derive(Clone, Copy)]
pub(super) struct V<S: Simd> {
    pub x: F<S>,
    pub y: F<S>,
    pub z: F<S>,
}

impl Lanes {
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> F<S> {
        F::load_array_ref(simd, &self.0)
    }
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, value: F<S>) {
        value.store_array(&mut self.0);
    }
}

impl<S: Simd> V<S> {
    #[inline(always)]
    pub fn load(simd: S, packet: &Packet) -> Self {
        Self { x: packet.x.load(simd), y: packet.y.load(simd), z: packet.z.load(simd) }
    }

    #[inline(always)]
    pub fn dot(&self, v: &[f32; 3]) -> F<S> {
        self.x * v[0] + self.y * v[1] + self.z * v[2]
    }

    /// Rotates the vectors.
    #[inline(always)]
    pub fn turned(&self, turn: &[[f32; 3]; 3]) -> Self {
        Self { x: self.dot(&turn[0]), y: self.dot(&turn[1]), z: self.dot(&turn[2]) }
    }
}

/// Returns the rows of a matrix.
pub(super) fn rows(m: &Matrix3<f64>) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|i| [m[(i, 0)] as f32, m[(i, 1)] as f32, m[(i, 2)] as f32])
}

pub(super) fn short(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> F<S> {
    F::splat(simd, value)
}

/// Returns the reciprocals of the components. For components near zero they are finite, but large enough to act as
/// infinity.
#[inline(always)]
pub(super) fn inverse<S: Simd>(simd: S, d: F<S>) -> F<S> {
    let tiny = splat(simd, TINY);
    splat(simd, 1.0) / d.abs().simd_lt(tiny).select(tiny, d)
}
