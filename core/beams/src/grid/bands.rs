//! How the rows of an image are cut into bands, each drawn by one task.

use std::ops::Range;

/// Bands for each thread: what is in sight is seldom spread evenly over the rows.
const BANDS: usize = 4;
/// Least rows of a band; what reaches over its border is drawn once more.
const LEAST_ROWS: usize = 16;

/// How an image is cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bands {
    /// Of the image.
    rows: usize,
    /// Of a band; the last of the image may have less.
    height: usize,
}

impl Bands {
    /// An image of so many rows, for so many threads.
    pub fn new(rows: usize, threads: usize) -> Self {
        let bands = if threads == 1 { 1 } else { BANDS * threads };
        Self::of_height(rows, rows.div_ceil(bands).max(LEAST_ROWS))
    }

    /// The same with bands of so many rows.
    pub fn of_height(rows: usize, height: usize) -> Self {
        Self { rows, height: height.clamp(1, rows) }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.rows.div_ceil(self.height)
    }

    /// First row of each, and the one after the last.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.rows).step_by(self.height).map(|row| (row, self.rows.min(row + self.height)))
    }

    /// Those that some rows of the image, at least one, reach into.
    pub fn reached(&self, rows: (u32, u32)) -> Range<usize> {
        rows.0 as usize / self.height..(rows.1 as usize).div_ceil(self.height)
    }
}
