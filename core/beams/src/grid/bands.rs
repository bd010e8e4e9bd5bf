//! How the rows of an image are cut for threads to draw side by side, and which groups of triangles belong where.
//!
//! Two threads share a segment: one begins with its first rows, the other with its last, band after band until they meet. So
//! it need not be known what a band costs. What a mesh has in sight is drawn once, in the band where it begins, however
//! far it reaches into the following ones: moving corners costs more than pixels.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Bands of a segment.
const BANDS: usize = 12;
/// Least rows of a band.
pub(super) const LEAST_ROWS: usize = 4;
/// What reaches over more than one in so many rows of the image is drawn anew by each band: one thread alone would take too
/// long.
const TALL: usize = 4;

/// How an image is cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    /// Of the image.
    rows: usize,
    /// Of a band; the last of the image may have less.
    height: usize,
    /// Bands of a segment; the last of the image may have less.
    bands: usize,
}

/// A group of triangles that may be seen, and the rows that it may be in.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    /// First vector, and the one after the last.
    pub sixteens: (u32, u32),
    /// First row, and the one after the last.
    pub rows: (u32, u32),
}

/// Groups of a mesh that may be seen.
pub(super) struct Found {
    /// Those drawn once, by the band in which they begin; of each band in the order in memory.
    own: Vec<Seen>,
    /// Where those of each band begin in `own`, and the end.
    starts: Vec<usize>,
    /// Those that each band draws as far as its rows go.
    pub tall: Vec<Seen>,
}

/// For each band of an image how far it reaches: the row after the last of what begins in it.
pub(super) struct Reaches(Vec<AtomicUsize>);

/// Some rows of a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    /// First row, and the one after the last.
    pub rows: (usize, usize),
    /// Groups that begin in these bands of the image are drawn with it: its own, and for the first of a segment those before.
    begin: (usize, usize),
    /// The row after the last that groups reach which are drawn with it or with bands before it; at least its end.
    pub reach: usize,
}

/// Rows that one or two threads draw.
pub(super) struct Segment {
    /// First row, and the one after the last.
    pub rows: (usize, usize),
    pub bands: Vec<Band>,
}

impl Cut {
    /// An image of so many rows, for so many threads.
    pub fn new(rows: usize, threads: usize) -> Self {
        let bands = if threads == 1 { 1 } else { BANDS * threads.div_ceil(2) };
        Self::into_bands(rows, threads, rows.div_ceil(bands).max(LEAST_ROWS))
    }

    /// The same with bands of so many rows.
    pub fn into_bands(rows: usize, threads: usize, height: usize) -> Self {
        let height = height.clamp(1, rows);
        Self { rows, height, bands: rows.div_ceil(height).div_ceil(threads.div_ceil(2)) }
    }

    /// Whether the image stays whole.
    pub fn is_whole(&self) -> bool {
        self.height == self.rows
    }

    /// How many segments there are.
    pub fn segments(&self) -> usize {
        self.rows.div_ceil(self.height * self.bands)
    }

    /// Whether what is in such rows is drawn anew by each band.
    pub fn is_tall(&self, rows: (u32, u32)) -> bool {
        !self.is_whole() && (rows.1 - rows.0) as usize * TALL > self.rows
    }

    /// Room for how far bands reach.
    pub fn reaches(&self) -> Reaches {
        Reaches((0..self.rows.div_ceil(self.height)).map(|_| AtomicUsize::new(0)).collect())
    }

    /// Puts groups in order, and notes how far they reach.
    pub fn sort(&self, seen: Vec<Seen>, tall: Vec<Seen>, reaches: &Reaches) -> Found {
        let band_of = |seen: &Seen| seen.rows.0 as usize / self.height;
        let (mut ends, mut starts) = (vec![0; reaches.0.len()], vec![0; reaches.0.len() + 1]);
        for seen in &seen {
            let band = band_of(seen);
            ends[band] = (seen.rows.1 as usize).max(ends[band]);
            starts[band + 1] += 1;
        }
        for (band, (reach, end)) in reaches.0.iter().zip(ends).enumerate() {
            reach.fetch_max(end, Ordering::Relaxed);
            starts[band + 1] += starts[band];
        }
        let (mut own, mut next) = (vec![Seen::default(); seen.len()], starts.clone());
        for seen in seen {
            let place = &mut next[band_of(&seen)];
            own[*place] = seen;
            *place += 1;
        }
        Found { own, starts, tall }
    }

    /// Segments with their bands, from how far these reach.
    pub fn cut(&self, reaches: &Reaches) -> Vec<Segment> {
        let mut reach = 0;
        let bands: Vec<Band> = (0..self.rows.div_ceil(self.height))
            .map(|number| {
                let rows = (number * self.height, self.rows.min((number + 1) * self.height));
                let begin = if number % self.bands == 0 { 0 } else { number };
                reach = reaches.0[number].load(Ordering::Relaxed).max(rows.1).max(reach);
                Band { rows, begin: (begin, number + 1), reach }
            })
            .collect();
        let segment = |bands: &[Band]| {
            let (first, end) = (bands[0].rows.0, bands[bands.len() - 1].rows.1);
            let bands = bands.iter().map(|band| Band { reach: band.reach.min(end), ..*band }).collect();
            Segment { rows: (first, end), bands }
        };
        bands.chunks(self.bands).map(segment).collect()
    }
}

impl Found {
    /// Those that are drawn once, with a band.
    pub fn of_band(&self, band: &Band) -> impl Iterator<Item = &Seen> {
        let (from, to) = band.begin;
        let first = band.rows.0 as u32;
        self.own[self.starts[from]..self.starts[to]].iter().filter(move |seen| seen.rows.1 > first)
    }
}
