//! Image buffers.

use super::{GridCast, camera::MAX_SIDE_PIXELS, raster::BandBuffer};

/// An image, with one value per pixel, row by row from the bottom, each row from left to right. Channels that were not
/// requested are empty.
///
/// An image can be reused from frame to frame: memory is allocated only when the image or its number of bands grows.
#[derive(Debug, Default, Clone)]
pub struct GridImage {
    /// Distance from the sensor along its axis, in metres; infinity where no surface is visible.
    pub depth: Vec<f32>,
    /// Tag of the target; 0 where no surface is visible.
    pub object: Vec<u64>,
    /// Part of the form, as in [`Hit::primitive`](crate::Hit::primitive); 0 where no surface is visible.
    pub primitive: Vec<u32>,
    /// Red, green and blue, each 0 to 255.
    pub color: Vec<[u8; 3]>,
    /// Cosine of the angle between the surface normal and the ray, 0 to 1; 0 where no surface is visible.
    pub cosine: Vec<f32>,
    /// Unit surface normal on the side of the camera, in the frame of the sensor; zero where no surface is visible.
    pub normal: Vec<[f32; 3]>,
    buffers: Vec<BandBuffer>,
}

/// Consecutive rows of an image.
#[derive(Default)]
pub(super) struct ImageBand<'a> {
    pub depth: &'a mut [f32],
    pub object: &'a mut [u64],
    pub primitive: &'a mut [u32],
    pub color: &'a mut [[u8; 3]],
    pub cosine: &'a mut [f32],
    pub normal: &'a mut [[f32; 3]],
}

impl GridImage {
    /// Resizes the requested channels, which still contain the values of the previous image.
    pub(super) fn prepare(&mut self, cast: &GridCast<'_>) {
        let (grid, want) = (cast.grid, cast.outputs);
        let pixels = grid.columns.min(MAX_SIDE_PIXELS) as usize * grid.rows.min(MAX_SIDE_PIXELS) as usize;
        let room = |wanted: bool| if wanted { pixels } else { 0 };
        self.depth.resize(pixels, f32::INFINITY);
        self.object.resize(room(want.object), 0);
        self.primitive.resize(room(want.primitive), 0);
        self.color.resize(room(want.color), [0; 3]);
        self.cosine.resize(room(want.cosine), 0.0);
        self.normal.resize(room(want.normal), [0.0; 3]);
    }

    /// Returns all pixels, and a buffer for each band.
    pub(super) fn parts(&mut self, bands: usize) -> (ImageBand<'_>, &mut [BandBuffer]) {
        let Self { depth, object, primitive, color, cosine, normal, buffers } = self;
        buffers.resize_with(bands, Default::default);
        (ImageBand { depth, object, primitive, color, cosine, normal }, buffers)
    }
}

impl ImageBand<'_> {
    /// Splits off the first `pixels` pixels.
    pub fn split(self, pixels: usize) -> (Self, Self) {
        fn halves<T>(all: &mut [T], pixels: usize) -> (&mut [T], &mut [T]) {
            all.split_at_mut(pixels.min(all.len()))
        }
        let (depth, object) = (halves(self.depth, pixels), halves(self.object, pixels));
        let (primitive, color) = (halves(self.primitive, pixels), halves(self.color, pixels));
        let (cosine, normal) = (halves(self.cosine, pixels), halves(self.normal, pixels));
        let first = Self {
            depth: depth.0,
            object: object.0,
            primitive: primitive.0,
            color: color.0,
            cosine: cosine.0,
            normal: normal.0,
        };
        let rest = Self {
            depth: depth.1,
            object: object.1,
            primitive: primitive.1,
            color: color.1,
            cosine: cosine.1,
            normal: normal.1,
        };
        (first, rest)
    }

    /// Sets all channels except the depth to their values for pixels without a visible surface.
    pub fn clear(&mut self, sky: [u8; 3]) {
        self.object.fill(0);
        self.primitive.fill(0);
        self.color.fill(sky);
        self.cosine.fill(0.0);
        self.normal.fill([0.0; 3]);
    }
}
