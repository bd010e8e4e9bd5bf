//! Small triangles of at most 8 x 8 pixels, rasterised in blocks of 4 x 4.

use fearless_simd::prelude::*;

use super::raster::{F, Offer, Raster, U, WIDE};

/// Sub-pixel steps per pixel, to which corners are rounded.
pub(super) const PARTS: f32 = 256.0;

/// 16 small triangles prepared for rasterisation, as a structure of arrays.
pub(super) struct Small {
    /// For each edge function: its increments per column and per row, and its value at the first pixel; 0 or more is
    /// inside.
    borders: [[[f32; WIDE]; 3]; 3],
    /// `w` at the first corner, and its increments per unit of the second and the third edge function.
    w: [[f32; WIDE]; 3],
    /// First pixel of the bounding box.
    column: [f32; WIDE],
    row: [f32; WIDE],
    /// Number of pixels after the first that the bounding box covers.
    across: [f32; WIDE],
    up: [f32; WIDE],
    id: [u32; WIDE],
}

/// 16 corners in the image: column and row in sub-pixel steps, and `w`. Values are NaN if a corner cannot be rounded.
#[derive(Clone, Copy)]
pub(super) struct Placed<S: Simd> {
    pub x: F<S>,
    pub y: F<S>,
    pub w: F<S>,
}

impl Small {
    /// Prepares 16 triangles; `from` and `to` are columns and rows of the first and the last pixel.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        [a, b, c]: [Placed<S>; 3],
        area: F<S>,
        [from, to]: [(F<S>, F<S>); 2],
        id: U<S>,
    ) -> Self {
        // Triangles seen from behind have their corners swapped.
        let turned = area.simd_lt(0.0);
        let (b, c) = (
            Placed { x: turned.select(c.x, b.x), y: turned.select(c.y, b.y), w: turned.select(c.w, b.w) },
            Placed { x: turned.select(b.x, c.x), y: turned.select(b.y, c.y), w: turned.select(b.w, c.w) },
        );
        let area = area.abs();
        // Relative to the first pixel, all coordinates are small integers, so sums and products are exact.
        let (left, low) = (from.0 * PARTS, from.1 * PARTS);
        let (pa, pb, pc) = ((a.x - left, a.y - low), (b.x - left, b.y - low), (c.x - left, c.y - low));
        Self {
            borders: [border(simd, pb, pc), border(simd, pc, pa), border(simd, pa, pb)],
            w: [stored(a.w), stored((b.w - a.w) / area), stored((c.w - a.w) / area)],
            column: stored(from.0),
            row: stored(from.1),
            across: stored(to.0 - from.0),
            up: stored(to.1 - from.1),
            id: *id.as_array(),
        }
    }

    /// Rasterises the triangles whose bits are set.
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, mut bits: u64, raster: &mut Raster<'_, ID>) {
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % WIDE;
            bits &= bits - 1;
            let (column, row) = (self.column[lane] as usize, self.row[lane] as usize);
            let place = (row - raster.first) * raster.stride + column;
            let below = place + 4 * raster.stride;
            self.block(simd, lane, (0.0, 0.0), place, raster);
            let (wide, high) = (self.across[lane] > 3.5, self.up[lane] > 3.5);
            if wide {
                self.block(simd, lane, (4.0, 0.0), place + 4, raster);
            }
            if high {
                self.block(simd, lane, (0.0, 4.0), below, raster);
            }
            if wide & high {
                self.block(simd, lane, (4.0, 4.0), below + 4, raster);
            }
        }
    }

    /// Rasterises 4 x 4 pixels of one triangle, starting at an offset from its first pixel.
    #[inline(always)]
    fn block<S: Simd, const ID: bool>(
        &self,
        simd: S,
        lane: usize,
        from: (f32, f32),
        place: usize,
        raster: &mut Raster<'_, ID>,
    ) {
        let v0 = self.value(simd, 0, lane, from);
        let v1 = self.value(simd, 1, lane, from);
        let v2 = self.value(simd, 2, lane, from);
        let inside = v0.simd_ge(0.0) & v1.simd_ge(0.0) & v2.simd_ge(0.0);
        let w = (v1 * self.w[1][lane] + v2 * self.w[2][lane]) + self.w[0][lane];
        let id = U::splat(simd, if ID { self.id[lane] } else { 0 });
        raster.offer_block(simd, place, Offer { w, inside, id });
    }

    /// Evaluates an edge function at 4 x 4 pixels.
    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, border: usize, lane: usize, from: (f32, f32)) -> F<S> {
        const X: [f32; WIDE] = [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.];
        const Y: [f32; WIDE] = [0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.];
        let [u, v, c] = &self.borders[border];
        let (u, v) = (u[lane], v[lane]);
        let start = c[lane] + u * from.0 + v * from.1;
        F::load_array_ref(simd, &X) * u + F::load_array_ref(simd, &Y) * v + start
    }
}

/// Returns the edge function from one corner to another: its increments per column and per row, and its value at the
/// first pixel.
#[inline(always)]
fn border<S: Simd>(simd: S, (x0, y0): (F<S>, F<S>), (x1, y1): (F<S>, F<S>)) -> [[f32; WIDE]; 3] {
    let (u, v) = (y0 - y1, x1 - x0);
    // A pixel exactly on an edge belongs to the area on the right of the edge, or above it.
    let mine = u.simd_gt(0.0) | (u.simd_eq(0.0) & v.simd_gt(0.0));
    let off = mine.select(F::splat(simd, 0.0), F::splat(simd, 1.0));
    [stored(u * PARTS), stored(v * PARTS), stored(-(u * x0 + v * y0) - off)]
}

#[inline(always)]
pub(super) fn stored<S: Simd>(v: F<S>) -> [f32; WIDE] {
    let mut out = [0.0; WIDE];
    v.store_array(&mut out);
    out
}
