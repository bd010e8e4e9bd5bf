//! The pixels of a band of rows during rasterisation.

use fearless_simd::{f32x4, f32x16, mask32x16, prelude::*, u32x4, u32x16};

use super::camera::GridCamera;

/// Number of pixels rasterised at once.
pub(super) const LANES: usize = 16;
/// Vectors of 16 values: `FloatLanes` of floats, `MaskLanes` of conditions, `UintLanes` of surface indices.
pub(super) type FloatLanes<S> = f32x16<S>;
pub(super) type MaskLanes<S> = mask32x16<S>;
pub(super) type UintLanes<S> = u32x16<S>;

/// Padding rows that blocks may overlap at the end; their contents are not used.
const PADDING_ROWS: usize = 8;

/// Surface index that stands for "no visible surface".
pub(super) const NO_SURFACE: u32 = u32::MAX;

/// Buffers of a band, reused from frame to frame.
#[derive(Debug, Default, Clone)]
pub(super) struct BandBuffer {
    w: Vec<f32>,
    id: Vec<u32>,
}

/// The rows of an image from `first` up to, but excluding, `end`. `ID` selects whether the index of the visible surface
/// is stored.
pub(super) struct Raster<'a, const ID: bool> {
    pub first: usize,
    pub end: usize,
    pub columns: usize,
    /// Number of elements per row; greater than the number of columns, so that whole blocks can be written.
    pub stride: usize,
    /// Maximum visible `w`.
    pub w_near: f32,
    pub w: &'a mut [f32],
    pub id: &'a mut [u32],
}

/// A surface that is offered to a set of pixels, each of which stores the nearest surface offered so far.
#[derive(Clone, Copy)]
pub(super) struct SurfaceFragments<S: Simd> {
    pub w: FloatLanes<S>,
    pub inside: MaskLanes<S>,
    pub id: UintLanes<S>,
}

impl<'a, const ID: bool> Raster<'a, ID> {
    /// Prepares the rows from `first` up to, but excluding, `end`, without any visible surface.
    pub fn new(buffer: &'a mut BandBuffer, camera: &GridCamera, (first, end): (usize, usize)) -> Self {
        let stride = camera.columns.next_multiple_of(LANES) + LANES;
        let (used, size) = ((end - first) * stride, (end - first + PADDING_ROWS) * stride);
        buffer.w.resize(size, camera.w_empty);
        buffer.w[..used].fill(camera.w_empty);
        if ID {
            buffer.id.resize(size, NO_SURFACE);
            buffer.id[..used].fill(NO_SURFACE);
        }
        let (w, id) = (&mut buffer.w[..], &mut buffer.id[..]);
        Self { first, end, columns: camera.columns, stride, w_near: camera.w_near, w, id }
    }

    /// Offers a surface to 16 neighbouring pixels of a row.
    #[inline(always)]
    pub fn offer<S: Simd>(&mut self, simd: S, place: usize, offer: SurfaceFragments<S>) {
        let Some(w) = self.w.get_mut(place..place + LANES) else { return };
        let old = FloatLanes::from_slice(simd, w);
        if ID {
            let Some(id) = self.id.get_mut(place..place + LANES) else { return };
            let old_id = UintLanes::from_slice(simd, id);
            let take = nearer(&offer, self.w_near, old, old_id);
            take.select(offer.w, old).store_slice(w);
            take.select(offer.id, old_id).store_slice(id);
        } else {
            let take = offer.inside & offer.w.simd_gt(old) & offer.w.simd_le(self.w_near);
            take.select(offer.w, old).store_slice(w);
        }
    }

    /// Offers a surface to 4 x 4 pixels, starting at `place`, row by row.
    #[inline(always)]
    pub fn offer_block<S: Simd>(&mut self, simd: S, place: usize, offer: SurfaceFragments<S>) {
        let stride = self.stride;
        let Some(w) = self.w.get_mut(place..place + 3 * stride + 4) else { return };
        let [a, b, c, d] = four_rows(w, stride);
        let old = f32x4::from_slice(simd, a).combine(f32x4::from_slice(simd, b));
        let old = old.combine(f32x4::from_slice(simd, c).combine(f32x4::from_slice(simd, d)));
        let take = if ID {
            let Some(id) = self.id.get_mut(place..place + 3 * stride + 4) else { return };
            let [a, b, c, d] = four_rows(id, stride);
            let old_id = u32x4::from_slice(simd, a).combine(u32x4::from_slice(simd, b));
            let old_id = old_id.combine(u32x4::from_slice(simd, c).combine(u32x4::from_slice(simd, d)));
            let take = nearer(&offer, self.w_near, old, old_id);
            let (low, high) = take.select(offer.id, old_id).split();
            let ((one, two), (three, four)) = (low.split(), high.split());
            one.store_slice(a);
            two.store_slice(b);
            three.store_slice(c);
            four.store_slice(d);
            take
        } else {
            offer.inside & offer.w.simd_gt(old) & offer.w.simd_le(self.w_near)
        };
        let (low, high) = take.select(offer.w, old).split();
        let ((one, two), (three, four)) = (low.split(), high.split());
        one.store_slice(a);
        two.store_slice(b);
        three.store_slice(c);
        four.store_slice(d);
    }
}

/// Returns the first four elements of four rows.
#[inline(always)]
fn four_rows<T>(from: &mut [T], stride: usize) -> [&mut [T]; 4] {
    let (a, rest) = from.split_at_mut(stride);
    let (b, rest) = rest.split_at_mut(stride);
    let (c, d) = rest.split_at_mut(stride);
    [&mut a[..4], &mut b[..4], &mut c[..4], &mut d[..4]]
}

/// Returns the pixels where a surface is nearer than the stored one, or equally near with a lower number.
#[inline(always)]
fn nearer<S: Simd>(offer: &SurfaceFragments<S>, w_near: f32, old: FloatLanes<S>, old_id: UintLanes<S>) -> MaskLanes<S> {
    let tie = offer.w.simd_eq(old) & offer.id.simd_lt(old_id);
    offer.inside & offer.w.simd_le(w_near) & (offer.w.simd_gt(old) | tie)
}

/// Returns 0, 1, 2, ... 15.
#[inline(always)]
pub(super) fn lane_numbers<S: Simd>(simd: S) -> FloatLanes<S> {
    FloatLanes::load_array_ref(
        simd,
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0],
    )
}
