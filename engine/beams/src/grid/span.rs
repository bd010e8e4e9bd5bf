//! Rasterisation of convex areas row by row, from the left edges to the right ones.

use fearless_simd::prelude::*;

use super::{
    camera::LinearFunction,
    raster::{FloatLanes, LANES, Raster, SurfaceFragments, UintLanes, lane_numbers},
};
use crate::simd::{greatest, least};

/// An edge; the area lies where the line is greater than 0.
///
/// A pixel exactly on a line belongs to the area to the right of the line or, for a horizontal line, above it. Both
/// areas that share an edge compute the same quotients, so each pixel belongs to exactly one of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpanEdge(pub LinearFunction);

impl SpanEdge {
    /// Narrows a range of columns in a row to the inside of the edge; columns are whole numbers.
    #[inline(always)]
    fn narrow(&self, row: f64, low: &mut f64, high: &mut f64) {
        let LinearFunction { a, b, c } = self.0;
        let rest = b * row + c;
        let place = (-rest / a).ceil();
        if a > 0.0 {
            *low = if place > *low { place } else { *low };
        } else if a < 0.0 {
            *high = if place < *high { place } else { *high };
        } else if !(rest > 0.0 || (rest == 0.0 && b > 0.0)) {
            *high = -1.0;
        }
    }
}

/// A part of a plane to rasterise.
pub(super) struct SpanFace<'a> {
    pub edges: &'a [SpanEdge],
    /// `w` as a function of column and row.
    pub w: LinearFunction,
    /// Range that `w` is clamped to.
    pub limits: (f32, f32),
    pub id: u32,
}

impl SpanFace<'_> {
    /// Rasterises the rows from `rows.0` up to, but excluding, `rows.1`.
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, raster: &mut Raster<'_, ID>, rows: (usize, usize)) {
        for row in rows.0.max(raster.first)..rows.1.min(raster.end) {
            let (mut low, mut high) = (0.0, raster.columns as f64);
            for edge in self.edges {
                edge.narrow(row as f64, &mut low, &mut high);
            }
            if low < high {
                self.draw_row(simd, raster, row, low as usize, high as usize);
            }
        }
    }

    #[inline(always)]
    fn draw_row<S: Simd, const ID: bool>(
        &self,
        simd: S,
        raster: &mut Raster<'_, ID>,
        row: usize,
        low: usize,
        high: usize,
    ) {
        let base = self.w.b * row as f64 + self.w.c;
        let place = (row - raster.first) * raster.stride;
        let lanes = lane_numbers(simd);
        let climb = lanes * self.w.a as f32;
        let (least_w, most_w) = (FloatLanes::splat(simd, self.limits.0), FloatLanes::splat(simd, self.limits.1));
        let id = UintLanes::splat(simd, self.id);
        let mut column = low;
        while column < high {
            // The value is recomputed in double precision every 16 pixels.
            let w = climb + (base + self.w.a * column as f64) as f32;
            let w = least(greatest(w, least_w), most_w);
            let inside = lanes.simd_lt((high - column) as f32);
            raster.offer(simd, place + column, SurfaceFragments { w, inside, id });
            column += LANES;
        }
    }
}
