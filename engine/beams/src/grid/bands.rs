//! The division of an image into bands of rows, each rasterised by one task.

use std::ops::Range;

/// Number of bands per thread. Several bands balance the load, since visible surfaces are seldom spread evenly over the
/// rows.
const BANDS_PER_THREAD: usize = 4;
/// Minimum number of rows per band, since surfaces that cross a boundary between bands are processed once per band.
const MIN_BAND_ROWS: usize = 16;

/// The division of an image into bands.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowBands {
    /// Number of rows of the image.
    rows: usize,
    /// Number of rows of a band; the last band of the image may have fewer.
    height: usize,
}

impl RowBands {
    /// Divides an image of `rows` rows for `threads` threads.
    pub fn new(rows: usize, threads: usize) -> Self {
        let bands = if threads == 1 { 1 } else { BANDS_PER_THREAD * threads };
        Self::of_height(rows, rows.div_ceil(bands).max(MIN_BAND_ROWS))
    }

    /// Divides an image into bands of `height` rows.
    pub fn of_height(rows: usize, height: usize) -> Self {
        Self { rows, height: height.clamp(1, rows) }
    }

    /// Returns the number of bands.
    pub fn count(&self) -> usize {
        self.rows.div_ceil(self.height)
    }

    /// Returns the first row of each band and the row after its last one.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.rows).step_by(self.height).map(|row| (row, self.rows.min(row + self.height)))
    }

    /// Returns the indices of the bands that overlap a range of rows, which must not be empty.
    pub fn overlapping(&self, rows: (u32, u32)) -> Range<usize> {
        rows.0 as usize / self.height..(rows.1 as usize).div_ceil(self.height)
    }
}
