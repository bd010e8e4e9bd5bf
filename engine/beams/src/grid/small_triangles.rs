//! Small triangles of at most 8 x 8 pixels, rasterised in blocks of 4 x 4.

use fearless_simd::prelude::*;

use super::raster::{FloatLanes, LANES, Raster, SurfaceFragments, UintLanes};

/// Sub-pixel steps per pixel, to which corners are rounded.
pub(super) const STEPS_PER_PIXEL: f32 = 256.0;

/// 16 small triangles prepared for rasterisation, as a structure of arrays.
pub(super) struct SmallTriangles {
    /// For each edge function: its increments per column and per row, and its value at the first pixel; 0 or more is
    /// inside.
    borders: [[[f32; LANES]; 3]; 3],
    /// `w` at the first corner, and its increments per unit of the second and the third edge function.
    w: [[f32; LANES]; 3],
    /// First pixel of the bounding box.
    column: [f32; LANES],
    row: [f32; LANES],
    /// Number of pixels after the first that the bounding box covers.
    across: [f32; LANES],
    up: [f32; LANES],
    id: [u32; LANES],
}

/// 16 corners in the image: column and row in sub-pixel steps, and `w`. Values are NaN if a corner cannot be rounded.
#[derive(Clone, Copy)]
pub(super) struct ImageCorners<S: Simd> {
    pub x: FloatLanes<S>,
    pub y: FloatLanes<S>,
    pub w: FloatLanes<S>,
}

impl SmallTriangles {
    /// Prepares 16 triangles; `from` and `to` are columns and rows of the first and the last pixel.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        [a, b, c]: [ImageCorners<S>; 3],
        area: FloatLanes<S>,
        [from, to]: [(FloatLanes<S>, FloatLanes<S>); 2],
        id: UintLanes<S>,
    ) -> Self {
        // Triangles seen from behind have their corners swapped.
        let turned = area.simd_lt(0.0);
        let (b, c) = (
            ImageCorners { x: turned.select(c.x, b.x), y: turned.select(c.y, b.y), w: turned.select(c.w, b.w) },
            ImageCorners { x: turned.select(b.x, c.x), y: turned.select(b.y, c.y), w: turned.select(b.w, c.w) },
        );
        let area = area.abs();
        // Relative to the first pixel, all coordinates are small integers, so sums and products are exact.
        let (left, low) = (from.0 * STEPS_PER_PIXEL, from.1 * STEPS_PER_PIXEL);
        let (pa, pb, pc) = ((a.x - left, a.y - low), (b.x - left, b.y - low), (c.x - left, c.y - low));
        Self {
            borders: [edge_function(simd, pb, pc), edge_function(simd, pc, pa), edge_function(simd, pa, pb)],
            w: [to_array(a.w), to_array((b.w - a.w) / area), to_array((c.w - a.w) / area)],
            column: to_array(from.0),
            row: to_array(from.1),
            across: to_array(to.0 - from.0),
            up: to_array(to.1 - from.1),
            id: *id.as_array(),
        }
    }

    /// Rasterises the triangles whose bits are set.
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, mut bits: u64, raster: &mut Raster<'_, ID>) {
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize % LANES;
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
        let id = UintLanes::splat(simd, if ID { self.id[lane] } else { 0 });
        raster.offer_block(simd, place, SurfaceFragments { w, inside, id });
    }

    /// Evaluates an edge function at 4 x 4 pixels.
    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, border: usize, lane: usize, from: (f32, f32)) -> FloatLanes<S> {
        const X: [f32; LANES] = [0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.];
        const Y: [f32; LANES] = [0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.];
        let [u, v, c] = &self.borders[border];
        let (u, v) = (u[lane], v[lane]);
        let start = c[lane] + u * from.0 + v * from.1;
        FloatLanes::load_array_ref(simd, &X) * u + FloatLanes::load_array_ref(simd, &Y) * v + start
    }
}

/// Returns the edge function from one corner to another: its increments per column and per row, and its value at the
/// first pixel.
#[inline(always)]
fn edge_function<S: Simd>(
    simd: S,
    (x0, y0): (FloatLanes<S>, FloatLanes<S>),
    (x1, y1): (FloatLanes<S>, FloatLanes<S>),
) -> [[f32; LANES]; 3] {
    let (u, v) = (y0 - y1, x1 - x0);
    // A pixel exactly on an edge belongs to the area to the right of the edge or, for a horizontal edge, above it.
    let mine = u.simd_gt(0.0) | (u.simd_eq(0.0) & v.simd_gt(0.0));
    let off = mine.select(FloatLanes::splat(simd, 0.0), FloatLanes::splat(simd, 1.0));
    [to_array(u * STEPS_PER_PIXEL), to_array(v * STEPS_PER_PIXEL), to_array(-(u * x0 + v * y0) - off)]
}

#[inline(always)]
pub(super) fn to_array<S: Simd>(v: FloatLanes<S>) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    v.store_array(&mut out);
    out
}
