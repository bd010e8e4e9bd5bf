//! Origins and directions of the rays of a floor sensor.

use std::f64::consts::TAU;

/// Spots of one size, and the rays of each.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotLayout {
    /// Centres in the sensor's xy plane, m.
    pub centres: Vec<[f64; 2]>,
    /// Rays per spot.
    pub rays: usize,
    /// Diameter of the area from which the rays of a spot start, m.
    pub diameter: f64,
    /// Full opening angle of the rays of a spot, rad.
    pub view: f64,
}

/// Angle between consecutive rays as a fraction of a turn. It follows from the golden ratio, which distributes any
/// number of rays evenly over a disc.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105_1;

impl SpotLayout {
    /// Returns `count` centres along x, in ascending order, `pitch` metres apart and centred on the origin.
    pub fn in_a_row(count: usize, pitch: f64) -> Vec<[f64; 2]> {
        let middle = 0.5 * (count as f64 - 1.0);
        (0..count).map(|i| [(i as f64 - middle) * pitch, 0.0]).collect()
    }

    /// Returns the origins and the directions of all rays, spot after spot.
    pub fn rays(&self) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
        let spread = libm::tan(0.5 * self.view);
        let offsets: Vec<[f64; 2]> = (0..self.rays)
            .map(|i| {
                // Each ray represents an equal part of the disc; a single ray is at the centre.
                let radius = if self.rays == 1 { 0.0 } else { ((i as f64 + 0.5) / self.rays as f64).sqrt() };
                let (s, c) = libm::sincos(TAU * GOLDEN_TURN * i as f64);
                [radius * c, radius * s]
            })
            .collect();
        let each = self.centres.iter().flat_map(|c| offsets.iter().map(move |o| (c, o)));
        each.map(|([x, y], [dx, dy])| {
            let radius = 0.5 * self.diameter;
            let (a, b) = (spread * dx, spread * dy);
            let length = (a * a + b * b + 1.0).sqrt();
            ([x + radius * dx, y + radius * dy, 0.0], [a / length, b / length, 1.0 / length])
        })
        .unzip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_centred_on_the_sensor() {
        let xs = |n, pitch| SpotLayout::in_a_row(n, pitch).into_iter().map(|c| c[0]).collect::<Vec<_>>();
        assert_eq!(xs(3, 0.01), [-0.01, 0.0, 0.01]);
        assert_eq!(xs(2, 1.0), [-0.5, 0.5]);
        assert_eq!(xs(1, 1.0), [0.0]);
    }

    #[test]
    fn a_single_ray_is_the_middle_of_its_spot() {
        let spots = SpotLayout { centres: vec![[0.1, 0.2]], rays: 1, diameter: 0.01, view: 0.5 };
        assert_eq!(spots.rays(), (vec![[0.1, 0.2, 0.0]], vec![[0.0, 0.0, 1.0]]));
    }

    #[test]
    fn rays_cover_their_disc_evenly() {
        let spots = SpotLayout { centres: vec![[0.0, 0.0]], rays: 400, diameter: 2.0, view: 0.6 };
        let (origins, directions) = spots.rays();
        let within = |r: f64| origins.iter().filter(|o| o[0].hypot(o[1]) < r).count();
        // The fraction of rays within a radius equals that of the area.
        for (r, share) in [(0.25, 0.0625), (0.5, 0.25), (0.75, 0.5625), (1.0, 1.0)] {
            assert!((within(r) as f64 / 400.0 - share).abs() < 0.006, "{r}: {}", within(r));
        }
        let left = origins.iter().filter(|o| o[0] < 0.0).count();
        assert!((190..=210).contains(&left), "{left}");
        let widest = directions.iter().map(|d| (d[0].hypot(d[1]) / d[2]).atan()).fold(0.0, f64::max);
        assert!(widest < 0.3 && widest > 0.299, "{widest}");
        assert!(directions.iter().all(|d| (d.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12));
    }
}
