//! Limitations of real depth cameras: slanted surfaces, areas that the projector does not light, and edges of objects.
//!
//! Noise along the line of sight, quantization and limits are declared by scenes and presets instead.

/// How the depth of pixels at depth discontinuities is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeMode {
    /// Such pixels have the depth of the surface at their centre.
    Exact,
    /// Such pixels have no depth, because a pattern that is split between two surfaces is not recognized.
    Lost,
    /// Such pixels have a depth between those of the two surfaces, because the sensor combines light from both.
    Mixed,
}

/// How a camera differs from an ideal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Minimum cosine of the angle between line of sight and normal of a surface that can be measured.
    pub least_cosine: f32,
    /// Position of the projector on the x axis, m, positive to the left; 0: no projector.
    pub projector: f64,
    /// How pixels at depth discontinuities are measured.
    pub edges: EdgeMode,
    /// Standard deviation of the position of edges, pixels.
    pub lateral_sigma: f64,
}

/// The image of an ideal camera.
#[derive(Debug, Clone, Copy)]
pub struct IdealImage<'a> {
    /// Pixels per row.
    pub columns: usize,
    /// Focal length, pixels.
    pub focal: f64,
    /// Depths, m; infinity if there is no surface.
    pub depth: &'a [f32],
    /// Cosines of the angle between line of sight and surface normal; empty if the host did not compute them.
    pub cosine: &'a [f32],
}

/// A reproducible sequence of random numbers that can be read from any index.
pub trait RandomSource {
    /// Fills `out` with the numbers from index `first` on, uniformly distributed in [0, 1).
    fn uniform(&self, first: u64, out: &mut [f64]);
    /// Fills `out` with the numbers from index `first` on, with a standard normal distribution.
    fn normal(&self, first: u64, out: &mut [f64]);
}

/// Difference between the depths of neighbouring pixels, as a fraction of the smaller depth, above which there is a
/// discontinuity between them. On a plane, the fraction is tan(incidence) / focal length: 1 % at 80 degrees and 571
/// pixels.
const DISCONTINUITY_RATIO: f32 = 0.03;
/// Difference of disparity, pixels, that separates a shadow from a slanted surface: a pixel is in shadow if the surface
/// that blocks the projector's light is nearer by more than this.
const SHADOW_DISPARITY_PX: f64 = 1.0;

impl Optics {
    /// An ideal camera.
    pub const NONE: Optics = Optics { least_cosine: 0.0, projector: 0.0, edges: EdgeMode::Exact, lateral_sigma: 0.0 };

    /// Returns whether measured depths equal the ideal ones.
    pub fn is_ideal(&self) -> bool {
        *self == Optics::NONE
    }

    /// Writes the measured depth of each pixel: 0 if the measurement fails, infinity if there is no surface.
    pub fn measure(&self, frame: &IdealImage<'_>, random: &impl RandomSource, out: &mut [f32]) {
        for (i, z) in out.iter_mut().enumerate() {
            *z = self.pixel(frame, random, i);
        }
        if self.projector != 0.0 {
            let mut shade = ProjectorShadow::new(frame.columns, frame.focal * self.projector);
            for (seen, out) in frame.depth.chunks(frame.columns).zip(out.chunks_mut(frame.columns)) {
                shade.row(seen, out);
            }
        }
    }

    fn pixel(&self, frame: &IdealImage<'_>, random: &impl RandomSource, i: usize) -> f32 {
        let mut at = i;
        if self.lateral_sigma > 0.0 && frame.has_discontinuity(i, 3) {
            let mut shift = [0.0; 2];
            random.normal(2 * i as u64, &mut shift);
            at = frame.neighbour(i, shift.map(|s| (s * self.lateral_sigma).round() as isize));
        }
        let mut z = frame.depth[at];
        if self.edges != EdgeMode::Exact
            && let Some(other) = frame.depth_across_edge(at)
        {
            if self.edges == EdgeMode::Lost {
                return 0.0;
            }
            if z.is_finite() && other.is_finite() {
                let mut part = [0.0];
                random.uniform(i as u64, &mut part);
                z += (other - z) * part[0] as f32;
            }
        }
        if z.is_infinite() {
            return z;
        }
        let slanted = frame.cosine.get(at).is_some_and(|c| *c < self.least_cosine);
        if slanted { 0.0 } else { z }
    }
}

fn is_discontinuity(a: f32, b: f32) -> bool {
    (a - b).abs() > DISCONTINUITY_RATIO * a.min(b) || a.is_infinite() != b.is_infinite()
}

impl IdealImage<'_> {
    /// Returns the pixel at an offset of columns and rows, or the same pixel if that is outside the image.
    fn neighbour(&self, i: usize, [columns, rows]: [isize; 2]) -> usize {
        let (column, row) = (i % self.columns, i / self.columns);
        match (column.checked_add_signed(columns), row.checked_add_signed(rows)) {
            (Some(c), Some(r)) if c < self.columns && r < self.depth.len() / self.columns => r * self.columns + c,
            _ => i,
        }
    }
    fn four_neighbours(&self, i: usize, far: isize) -> [f32; 4] {
        [[far, 0], [-far, 0], [0, far], [0, -far]].map(|by| self.depth[self.neighbour(i, by)])
    }
    /// Returns whether there is a discontinuity between a pixel and any pixel up to `within` pixels away, in any of
    /// four directions.
    fn has_discontinuity(&self, i: usize, within: isize) -> bool {
        let z = self.depth[i];
        (1..=within).any(|far| self.four_neighbours(i, far).into_iter().any(|n| is_discontinuity(z, n)))
    }
    /// Returns the depth on the other side of a discontinuity beside a pixel, or `None` if there is no discontinuity.
    fn depth_across_edge(&self, i: usize) -> Option<f32> {
        let z = self.depth[i];
        self.four_neighbours(i, 1).into_iter().find(|n| is_discontinuity(z, *n))
    }
}

/// The surfaces that the projector lights in a row of pixels.
///
/// In the projector's image, a point is displaced from its position in the camera's image by the focal length times the
/// projector's offset, divided by the depth. Of the surfaces at one position of that image, the nearest is lit and the
/// others are in shadow.
struct ProjectorShadow {
    /// Focal length times the projector's x, pixels times m.
    shift: f64,
    /// The greatest inverse depth at each position of the projector's image.
    nearest: Vec<f64>,
    /// Number of positions before the first column.
    margin: isize,
}

impl ProjectorShadow {
    fn new(columns: usize, shift: f64) -> Self {
        ProjectorShadow { shift, nearest: vec![0.0; 3 * columns], margin: columns as isize }
    }

    /// Returns the position of a pixel in the projector's image. In the image of a projector to the left (+x), near
    /// objects appear farther to the right.
    fn place(&self, column: usize, inverse: f64) -> isize {
        column as isize + (self.shift * inverse).round() as isize + self.margin
    }

    fn row(&mut self, seen: &[f32], out: &mut [f32]) {
        self.nearest.fill(0.0);
        let inverse = |z: f32| if z > 0.0 && z.is_finite() { Some(1.0 / f64::from(z)) } else { None };
        let mut last: Option<isize> = None;
        for (c, z) in seen.iter().enumerate() {
            let Some(w) = inverse(*z) else {
                last = None;
                continue;
            };
            let at = self.place(c, w);
            // A slanted surface is stretched in the projector's image: fill the positions between its pixels.
            let from = last.filter(|l| (at - l).abs() <= 3).map_or(at, |l| if at > l { l + 1 } else { at });
            for place in from..=at {
                if let Some(n) = usize::try_from(place).ok().and_then(|p| self.nearest.get_mut(p)) {
                    *n = n.max(w);
                }
            }
            last = Some(at);
        }
        for (c, (z, out)) in seen.iter().zip(out).enumerate() {
            let Some(w) = inverse(*z) else { continue };
            let lit = usize::try_from(self.place(c, w)).ok().and_then(|p| self.nearest.get(p));
            if lit.is_some_and(|n| (n - w) * self.shift.abs() > SHADOW_DISPARITY_PX) {
                *out = 0.0;
            }
        }
    }
}

#[cfg(test)]
#[path = "optics_tests.rs"]
mod tests;
