//! The pixels of a band of rows while they are drawn.

use super::camera::Camera;

/// Pixels drawn at once.
pub(super) const WIDE: usize = 16;

/// Rows below a band that blocks may reach into; what is there is not used.
pub(super) const SPARE_ROWS: usize = 8;

/// The number of no surface.
pub(super) const NOBODY: u32 = u32::MAX;

/// Buffers of a band, used again from frame to frame.
#[derive(Debug, Default, Clone)]
pub(super) struct Buffer {
    w: Vec<f32>,
    id: Vec<u32>,
}

/// The rows from `first` to `end` of an image. With `ID` it is noted what is seen.
pub(super) struct Raster<'a, const ID: bool> {
    pub first: usize,
    pub end: usize,
    pub columns: usize,
    /// Places from row to row: some more than columns, so that whole blocks can be written.
    pub stride: usize,
    /// Greatest `w` that is seen.
    pub w_near: f32,
    pub w: &'a mut [f32],
    pub id: &'a mut [u32],
}

impl<'a, const ID: bool> Raster<'a, ID> {
    /// An empty band.
    pub fn new(buffer: &'a mut Buffer, camera: &Camera, first: usize, end: usize) -> Self {
        let stride = camera.columns.next_multiple_of(WIDE) + WIDE;
        let size = (end - first + SPARE_ROWS) * stride;
        buffer.w.clear();
        buffer.w.resize(size, camera.w_nothing);
        if ID {
            buffer.id.clear();
            buffer.id.resize(size, NOBODY);
        }
        Self {
            first,
            end,
            columns: camera.columns,
            stride,
            w_near: camera.w_near,
            w: &mut buffer.w,
            id: &mut buffer.id,
        }
    }

    /// Offers 16 neighbouring pixels of a row a surface: `w` where `inside`, seen as `id`.
    ///
    /// Taken where it is nearer than what is there, or as near with a lower number.
    #[inline(always)]
    pub fn offer(&mut self, place: usize, w: &[f32; WIDE], inside: &[bool; WIDE], id: &[u32; WIDE]) {
        let Some(old) = self.w[place..].first_chunk_mut::<WIDE>() else { return };
        let w_near = self.w_near;
        if ID {
            let Some(old_id) = self.id[place..].first_chunk_mut::<WIDE>() else { return };
            for i in 0..WIDE {
                let nearer = (w[i] > old[i]) | ((w[i] == old[i]) & (id[i] < old_id[i]));
                let take = inside[i] & nearer & (w[i] <= w_near);
                old[i] = if take { w[i] } else { old[i] };
                old_id[i] = if take { id[i] } else { old_id[i] };
            }
        } else {
            for i in 0..WIDE {
                let take = inside[i] & (w[i] > old[i]) & (w[i] <= w_near);
                old[i] = if take { w[i] } else { old[i] };
            }
        }
    }

    /// The same for 4 x 4 pixels from a place on, row by row.
    #[inline(always)]
    pub fn offer_block(&mut self, place: usize, w: &[f32; WIDE], inside: &[bool; WIDE], id: u32) {
        let w_near = self.w_near;
        for row in 0..4 {
            let place = place + row * self.stride;
            let Some(old) = self.w[place..].first_chunk_mut::<4>() else { return };
            if ID {
                let Some(old_id) = self.id[place..].first_chunk_mut::<4>() else { return };
                for i in 0..4 {
                    let (w, inside) = (w[4 * row + i], inside[4 * row + i]);
                    let nearer = (w > old[i]) | ((w == old[i]) & (id < old_id[i]));
                    let take = inside & nearer & (w <= w_near);
                    old[i] = if take { w } else { old[i] };
                    old_id[i] = if take { id } else { old_id[i] };
                }
            } else {
                for i in 0..4 {
                    let (w, inside) = (w[4 * row + i], inside[4 * row + i]);
                    let take = inside & (w > old[i]) & (w <= w_near);
                    old[i] = if take { w } else { old[i] };
                }
            }
        }
    }
}
