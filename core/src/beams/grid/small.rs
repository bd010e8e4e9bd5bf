//! Small triangles: at most 8 x 8 pixels, drawn by blocks of 4 x 4.

use fearless_simd::prelude::*;

use super::raster::{F, Offer, Raster, U, WIDE};
use super::triangles::Placed;

/// Parts of a pixel to which corners are rounded.
pub(super) const PARTS: f32 = 256.0;

/// 16 small triangles made ready: numbers of one kind side by side.
pub(super) struct Small {
    /// Of each border: what a column and a row add, and the value at the first pixel; 0 or more is inside.
    borders: [[[f32; WIDE]; 3]; 3],
    /// `w` at the first corner, and what one unit of the second and third border adds.
    w: [[f32; WIDE]; 3],
    /// First pixel.
    column: [f32; WIDE],
    row: [f32; WIDE],
    /// Pixels after the first that the box around the triangle reaches.
    across: [f32; WIDE],
    up: [f32; WIDE],
}

impl Small {
    /// `from` and `to` are columns and rows of the first and the last pixel.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, [a, b, c]: [Placed<S>; 3], area: F<S>, from: (F<S>, F<S>), to: (F<S>, F<S>)) -> Self {
        // Seen from behind, corners are taken the other way round.
        let turned = area.simd_lt(0.0);
        let (b, c) = (
            Placed { x: turned.select(c.x, b.x), y: turned.select(c.y, b.y), w: turned.select(c.w, b.w) },
            Placed { x: turned.select(b.x, c.x), y: turned.select(b.y, c.y), w: turned.select(b.w, c.w) },
        );
        let area = area.abs();
        // Relative to the first pixel all numbers are whole and small: sums and products are exact.
        let (left, low) = (from.0 * PARTS, from.1 * PARTS);
        let near = |p: Placed<S>| (p.x - left, p.y - low);
        let (pa, pb, pc) = (near(a), near(b), near(c));
        let border = |(x0, y0): (F<S>, F<S>), (x1, y1): (F<S>, F<S>)| {
            let (u, v) = (y0 - y1, x1 - x0);
            // A pixel on a border belongs to the area on its right, or above.
            let mine = u.simd_gt(0.0) | (u.simd_eq(0.0) & v.simd_gt(0.0));
            let off = mine.select(F::splat(simd, 0.0), F::splat(simd, 1.0));
            [u * PARTS, v * PARTS, -(u * x0 + v * y0) - off].map(stored)
        };
        Self {
            borders: [border(pb, pc), border(pc, pa), border(pa, pb)],
            w: [a.w, (b.w - a.w) / area, (c.w - a.w) / area].map(stored),
            column: stored(from.0),
            row: stored(from.1),
            across: stored(to.0 - from.0),
            up: stored(to.1 - from.1),
        }
    }

    /// Draws those whose bits are set.
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(
        &self,
        simd: S,
        mut bits: u64,
        id: impl Fn(usize) -> u32,
        raster: &mut Raster<'_, ID>,
    ) {
        const X: [f32; WIDE] = [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.];
        const Y: [f32; WIDE] = [0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.];
        let (x, y) = (F::load_array_ref(simd, &X), F::load_array_ref(simd, &Y));
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % WIDE;
            bits &= bits - 1;
            let [e0, e1, e2] = self.borders.each_ref().map(|b| b.each_ref().map(|v| v[lane]));
            let [w0, w1, w2] = self.w.each_ref().map(|v| v[lane]);
            let (column, row) = (self.column[lane] as usize, self.row[lane] as usize);
            let (across, up) = (self.across[lane], self.up[lane]);
            let stride = raster.stride;
            let place = (row - raster.first) * raster.stride + column;
            let id = U::splat(simd, if ID { id(lane) } else { 0 });
            let mut block = |right: f32, above: f32, place: usize| {
                let border = |e: [f32; 3]| x * e[0] + y * e[1] + (e[2] + e[0] * right + e[1] * above);
                let (v0, v1, v2) = (border(e0), border(e1), border(e2));
                let inside = v0.simd_ge(0.0) & v1.simd_ge(0.0) & v2.simd_ge(0.0);
                let w = (v1 * w1 + v2 * w2) + w0;
                raster.offer_block(simd, place, Offer { w, inside, id });
            };
            block(0.0, 0.0, place);
            let (wide, high) = (across > 3.5, up > 3.5);
            if wide | high {
                if wide {
                    block(4.0, 0.0, place + 4);
                }
                if high {
                    block(0.0, 4.0, place + 4 * stride);
                }
                if wide & high {
                    block(4.0, 4.0, place + 4 * stride + 4);
                }
            }
        }
    }
}

/// The numbers of a vector.
#[inline(always)]
fn stored<S: Simd>(v: F<S>) -> [f32; WIDE] {
    let mut out = [0.0; WIDE];
    v.store_array(&mut out);
    out
}
