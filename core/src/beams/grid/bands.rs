//! How the rows of an image are cut for threads to draw side by side, and which triangles belong where.
//!
//! Two threads share a segment: one begins with its first rows, the other with its last, band after band until they meet. So
//! neither waits for the other, though what a band costs is but estimated. What a mesh has in sight is drawn once, in
//! the band where it begins, however far it reaches into the following ones: moving corners costs more than pixels.

use super::camera::Camera;

/// Least rows of a band.
pub(super) const LEAST_ROWS: usize = 4;
/// The least bands are one part in so many of a segment.
const LEAST_PART: usize = 128;
/// What 16 triangles cost, in pixels with nothing but depth; measured.
const SIXTEEN: usize = 220;
/// What a pixel costs of which more than the depth is asked for.
const SHADED: usize = 40;
/// What reaches over more than one in so many rows of the image is drawn anew by each band. Whether it does is looked
/// at closely: the ball around a group is often much higher than what it holds.
pub(super) const TALL: usize = 4;

/// Some triangles of a mesh that is ready.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Piece {
    /// Place of the mesh.
    pub mesh: u32,
    /// First vector, and the one after the last.
    pub sixteens: (u32, u32),
    /// First row, and the one after the last.
    pub rows: (u32, u32),
}

/// Some rows of a segment.
#[derive(Debug, Clone)]
pub(super) struct Band {
    /// First row, and the one after the last.
    pub rows: (usize, usize),
    /// The row after the last that triangles reach which begin in it or in bands before it; at least its end.
    pub reach: usize,
    /// Triangles that begin in it: from one to before another of the segment's.
    pub own: (usize, usize),
}

/// Rows that one or two threads draw.
#[derive(Debug, Default)]
pub(super) struct Segment {
    /// First row, and the one after the last.
    pub rows: (usize, usize),
    pub bands: Vec<Band>,
    /// Triangles, by the band in which they begin.
    pub own: Vec<Piece>,
    /// Those that each band draws as far as its rows go.
    pub tall: Vec<Piece>,
}

/// Which bands a segment gets.
#[derive(Debug, Clone, Copy)]
pub(super) enum Cut {
    /// Of so many rows each.
    Even(usize),
    /// Large ones first and last, ever smaller ones where two threads meet.
    Balanced { shaded: bool },
}

impl Cut {
    /// Whether so many rows stay in one band.
    pub fn is_one_band(self, rows: usize) -> bool {
        matches!(self, Self::Even(band) if band >= rows)
    }
}

/// Cuts an image into so many segments.
pub(super) fn segments(pieces: Vec<Piece>, camera: &Camera, (count, cut): (usize, Cut)) -> Vec<Segment> {
    let rows = camera.rows;
    let count = count.clamp(1, rows);
    if count == 1 && cut.is_one_band(rows) {
        return vec![Segment::whole(pieces, rows)];
    }
    (0..count).map(|i| Segment::new(&pieces, camera, (i * rows / count, (i + 1) * rows / count), cut)).collect()
}

impl Segment {
    /// One band: nothing has to be put in order.
    fn whole(own: Vec<Piece>, rows: usize) -> Self {
        let band = Band { rows: (0, rows), reach: rows, own: (0, own.len()) };
        Self { rows: (0, rows), bands: vec![band], own, tall: Vec::new() }
    }

    fn new(all: &[Piece], camera: &Camera, rows: (usize, usize), cut: Cut) -> Self {
        let mut out = Self { rows, ..Self::default() };
        let high = rows.1 - rows.0;
        let shaded = matches!(cut, Cut::Balanced { shaded: true });
        let mut costs = vec![camera.columns * if shaded { SHADED } else { 1 }; high];
        let mut pieces = Vec::with_capacity(all.len());
        for mut piece in all.iter().copied() {
            piece.rows = (piece.rows.0.max(rows.0 as u32), piece.rows.1.min(rows.1 as u32));
            if piece.rows.0 >= piece.rows.1 {
                continue;
            }
            if (piece.rows.1 - piece.rows.0) as usize * TALL > camera.rows {
                out.tall.push(piece);
                continue;
            }
            costs[piece.rows.0 as usize - rows.0] += (piece.sixteens.1 - piece.sixteens.0) as usize * SIXTEEN;
            pieces.push(piece);
        }
        let cuts: Vec<usize> = match cut {
            Cut::Even(band) => (0..high).step_by(band.max(1)).skip(1).collect(),
            Cut::Balanced { .. } => balanced(&costs),
        };
        // The band of each row.
        let mut band_of = vec![0u32; high];
        let mut first = 0;
        for (number, end) in cuts.into_iter().chain([high]).enumerate() {
            band_of[first..end].fill(number as u32);
            out.bands.push(Band { rows: (rows.0 + first, rows.0 + end), reach: rows.0 + end, own: (0, 0) });
            first = end;
        }
        // Within a band they stay in the order of the mesh, which is the order in memory.
        let band_of = |piece: &Piece| band_of[piece.rows.0 as usize - rows.0] as usize;
        for piece in &pieces {
            let band = &mut out.bands[band_of(piece)];
            band.own.1 += 1;
            band.reach = band.reach.max(piece.rows.1 as usize);
        }
        let (mut begun, mut reach) = (0, 0);
        for band in &mut out.bands {
            begun += band.own.1;
            band.own = (begun - band.own.1, begun - band.own.1);
            reach = band.reach.max(reach);
            band.reach = reach;
        }
        out.own.resize(pieces.len(), Piece::default());
        for piece in &pieces {
            let end = &mut out.bands[band_of(piece)].own.1;
            out.own[*end] = *piece;
            *end += 1;
        }
        out
    }
}

/// Where bands begin, but for the first, from what rows cost.
fn balanced(costs: &[usize]) -> Vec<usize> {
    let whole: usize = costs.iter().sum();
    let (mut low, mut high, mut rest) = (0, costs.len(), whole);
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    while low < high {
        let share = (rest / 4).max(whole / LEAST_PART);
        let (first, mut cost) = (low, 0);
        while low < high && (cost < share || low - first < LEAST_ROWS) {
            cost += costs[low];
            low += 1;
        }
        lower.push(low);
        rest -= cost;
        let (end, mut cost) = (high, 0);
        while low < high && (cost < share || end - high < LEAST_ROWS) {
            high -= 1;
            cost += costs[high];
        }
        upper.push(high);
        rest -= cost;
    }
    upper.reverse();
    lower.extend(upper);
    lower.retain(|row| *row < costs.len());
    lower.dedup();
    lower
}
