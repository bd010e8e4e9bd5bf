//! Hydrostatics of a box in water with a flat surface.

/// Number of columns along x and along y. In each of these directions, a column has two points of the Gauss-Legendre
/// rule, which integrates the submerged volume and its moment exactly unless the water surface crosses the top or the
/// bottom of the box within the column.
const COLUMNS: [usize; 2] = [6, 4];
/// Distance of the two points from the centre of a column of half width 1.
const GAUSS_POINT: f64 = 0.577_350_269_189_625_8;

/// A box centred on the origin of its mount, with a given displacement.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Full extents along the axes of the mount, m.
    pub size: [f64; 3],
    /// Volume of water that the fully submerged hull displaces, m^3.
    pub volume: f64,
}

/// The size of the submerged part of a hull, and the point at which its buoyancy acts.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SubmergedPart {
    /// Submerged fraction of the volume, 0 to 1.
    pub share: f64,
    /// Centre of the submerged part relative to the mount's origin, world frame, m; the origin if nothing is under
    /// water.
    pub centre: [f64; 3],
}

impl Hull {
    /// Returns the submerged part. `axes` are the mount's axes in the world frame, and `depth` is the depth of the
    /// mount's origin below the surface, m.
    pub fn submerged(&self, axes: [[f64; 3]; 3], depth: f64) -> SubmergedPart {
        let half = self.size.map(|s| s / 2.0);
        let (mut share, mut moment) = (0.0, [0.0; 3]);
        for x in gauss_points(COLUMNS[0]) {
            for y in gauss_points(COLUMNS[1]) {
                let (x, y) = (x * half[0], y * half[1]);
                let middle: [f64; 3] = std::array::from_fn(|k| axes[0][k] * x + axes[1][k] * y);
                // The column is submerged from `low` to `high` along its axis.
                let (low, high) = submerged_range(middle[2] - depth, axes[2][2], half[2]);
                let along = (low + high) / 2.0;
                let length = high - low;
                share += length;
                for k in 0..3 {
                    moment[k] += length * (middle[k] + axes[2][k] * along);
                }
            }
        }
        if share <= 0.0 {
            return SubmergedPart::default();
        }
        let all = 2.0 * half[2] * (4 * COLUMNS[0] * COLUMNS[1]) as f64;
        SubmergedPart { share: share / all, centre: moment.map(|m| m / share) }
    }
}

/// Returns the ends of the submerged part of a column, as positions along its axis from its centre. The centre is at
/// height `z` above the surface, the axis rises by `up` per unit of length, and the half length is `half`.
fn submerged_range(z: f64, up: f64, half: f64) -> (f64, f64) {
    // A horizontal column is treated as slightly tilted, so that the transition is continuous.
    let up = if up.abs() < 1e-6 { f64::copysign(1e-6, up) } else { up };
    let surface = (-z / up).clamp(-half, half);
    if up > 0.0 { (-half, surface) } else { (surface, half) }
}

/// Returns the integration points of `n` columns in the range -1 to 1.
fn gauss_points(n: usize) -> impl Iterator<Item = f64> + Clone {
    let width = 2.0 / n as f64;
    (0..n).flat_map(move |i| {
        let middle = -1.0 + (i as f64 + 0.5) * width;
        [middle - GAUSS_POINT * width / 2.0, middle + GAUSS_POINT * width / 2.0]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn hull() -> Hull {
        Hull { size: [2.0, 1.0, 0.4], volume: 0.8 }
    }

    fn rolled(angle: f64) -> [[f64; 3]; 3] {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        [[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]
    }

    #[test]
    fn level_box_displaces_its_volume_below_the_surface() {
        for (depth, share, z) in [(0.0, 0.5, -0.1), (0.1, 0.75, -0.05), (-0.2, 0.0, 0.0), (5.0, 1.0, 0.0)] {
            let got = hull().submerged(LEVEL, depth);
            assert!((got.share - share).abs() < 1e-12 && (got.centre[2] - z).abs() < 1e-12, "{depth}: {got:?}");
            assert!(got.centre[0].abs() + got.centre[1].abs() < 1e-12);
        }
    }

    #[test]
    fn a_rolled_box_rights_itself_by_the_metacentre() {
        // Half submerged: the centre of buoyancy moves sideways by BM times the tangent of the roll, where BM is the
        // second moment of the waterline divided by the displaced volume: l b^3 / 12 / (l b d).
        let angle: f64 = 0.05;
        let got = hull().submerged(rolled(angle), 0.0);
        assert!((got.share - 0.5).abs() < 1e-12, "{got:?}");
        // Sideways displacement of the centre, in the hull's frame.
        let [_, y_axis, _] = rolled(angle);
        let aside = got.centre[1] * y_axis[1] + got.centre[2] * y_axis[2];
        let bm = 1.0 / 12.0 / 0.2;
        assert!((aside + bm * libm::tan(angle)).abs() < 1e-12, "{aside} against {}", -bm * libm::tan(angle));
    }

    #[test]
    fn inverted_and_tilted_boxes_displace_the_same_volume() {
        let over = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let got = hull().submerged(over, 0.1);
        assert!((got.share - 0.75).abs() < 1e-12 && (got.centre[2] + 0.05).abs() < 1e-12, "{got:?}");
        let side = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
        let got = hull().submerged(side, 0.0);
        assert!((got.share - 0.5).abs() < 1e-6 && (got.centre[2] + 0.25).abs() < 0.01, "{got:?}");
    }
}
