//! Masses, centres of mass and inertia tensors.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Vector3};

/// Mass (kg), centre of mass (m) and inertia about the centre of mass (kg m^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// Volume (m^3), centre (m) and inertia about the centre for a density of 1 kg/m^3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Volume, m^3.
    pub volume: f64,
    /// Centre of the volume, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre for a density of 1 kg/m^3.
    pub inertia: Matrix3<f64>,
}

impl Mass {
    /// The mass of nothing.
    pub const ZERO: Mass = Mass {
        mass: 0.0,
        com: Vector3::new(0.0, 0.0, 0.0),
        inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Returns the mass in the frame in which its own frame has this pose.
    pub fn moved(&self, pose: &Isometry3<f64>) -> Mass {
        let turn = pose.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * self.inertia * turn.matrix().transpose();
        Mass { mass: self.mass, com: pose.transform_point(&self.com.into()).coords, inertia }
    }

    /// Returns the combined mass of several rigidly connected parts in the same frame.
    pub fn sum(parts: &[Mass]) -> Mass {
        let mass: f64 = parts.iter().map(|m| m.mass).sum();
        if mass <= 0.0 {
            let inertia = parts.iter().map(|m| m.inertia).sum();
            return Mass { inertia, ..Mass::ZERO };
        }
        let com = parts.iter().map(|m| m.com * m.mass).sum::<Vector3<f64>>() / mass;
        let inertia = parts.iter().map(|m| m.inertia_about(com)).sum();
        Mass { mass, com, inertia }
    }

    /// Returns the combined mass of two rigidly connected parts in the same frame; without a mass, it has no inertia.
    pub fn combined_with(&self, other: &Mass) -> Mass {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Mass::ZERO;
        }
        // A part without mass can have an inertia, which counts.
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        Mass { mass, com, inertia: self.inertia_about(com) + other.inertia_about(com) }
    }

    /// Returns whether the inertia is positive definite, as that of a rigid body is. The triangle inequality of the
    /// principal moments is not checked.
    pub fn is_possible(&self) -> bool {
        let least = self.inertia.symmetric_eigenvalues().min();
        least.is_finite() && least > 1e-12 * self.inertia.norm()
    }

    /// Returns the inertia about a point.
    pub fn inertia_about(&self, point: Vector3<f64>) -> Matrix3<f64> {
        let d = self.com - point;
        self.inertia + self.mass * (Matrix3::identity() * d.norm_squared() - d * d.transpose())
    }

    /// Returns the mass multiplied by a factor, with the same centre and shape.
    pub fn scaled(&self, factor: f64) -> Mass {
        Mass { mass: self.mass * factor, com: self.com, inertia: self.inertia * factor }
    }

    /// Returns the mass with its principal moments changed by `change`.
    pub fn with_moments(&self, change: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Mass {
        let eigen = self.inertia.symmetric_eigen();
        let changed = change(eigen.eigenvalues);
        if changed == eigen.eigenvalues {
            return *self;
        }
        let axes = eigen.eigenvectors;
        Mass { inertia: axes * Matrix3::from_diagonal(&changed) * axes.transpose(), ..*self }
    }
}

impl Solid {
    fn centred(volume: f64, moments: [f64; 3]) -> Solid {
        let inertia = Matrix3::from_diagonal(&Vector3::from(moments)) * volume;
        Solid { volume, centre: Vector3::zeros(), inertia }
    }

    /// Returns an ellipsoid with these half extents.
    pub fn ellipsoid([a, b, c]: [f64; 3]) -> Solid {
        let [a2, b2, c2] = [a * a, b * b, c * c];
        Solid::centred(4.0 / 3.0 * PI * a * b * c, [(b2 + c2) / 5.0, (a2 + c2) / 5.0, (a2 + b2) / 5.0])
    }

    /// Returns a box with these half extents.
    pub fn cuboid([a, b, c]: [f64; 3]) -> Solid {
        let [a2, b2, c2] = [a * a, b * b, c * c];
        Solid::centred(8.0 * a * b * c, [(b2 + c2) / 3.0, (a2 + c2) / 3.0, (a2 + b2) / 3.0])
    }

    /// Returns a cylinder about z with this half length.
    pub fn cylinder(radius: f64, half: f64) -> Solid {
        let (r2, h2) = (radius * radius, half * half);
        let across = r2 / 4.0 + h2 / 3.0;
        Solid::centred(2.0 * PI * r2 * half, [across, across, r2 / 2.0])
    }

    /// Returns a cylinder about z with this half length, and half balls at its ends.
    pub fn capsule(radius: f64, half: f64) -> Solid {
        let middle = Solid::cylinder(radius, half);
        let ball = Solid::ellipsoid([radius; 3]);
        // The centre of each half ball is at 3/8 of the radius from its flat side.
        let shift = ball.volume * (half * half + 0.75 * radius * half);
        let inertia = middle.inertia + ball.inertia + Matrix3::from_diagonal(&Vector3::new(shift, shift, 0.0));
        Solid { volume: middle.volume + ball.volume, centre: Vector3::zeros(), inertia }
    }

    /// Returns the mass of the solid with a density, or with a total mass instead.
    pub fn mass(&self, mass: Option<f64>, density: f64) -> Mass {
        let density = match mass {
            Some(mass) if self.volume.abs() > 0.0 => mass / self.volume,
            Some(_) => 0.0,
            None => density,
        };
        Mass { mass: self.volume * density, com: self.centre, inertia: self.inertia * density }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns mass and moments of a body of revolution about z, summed over thin discs.
    fn by_discs(radius_at: impl Fn(f64) -> f64, half: f64) -> (f64, f64, f64) {
        let n = 40_000;
        let step = 2.0 * half / f64::from(n);
        (0..n).map(|i| -half + step * (f64::from(i) + 0.5)).fold((0.0, 0.0, 0.0), |(m, x, z), at| {
            let r2 = radius_at(at) * radius_at(at);
            let disc = PI * r2 * step;
            (m + disc, x + disc * (r2 / 4.0 + at * at), z + disc * r2 / 2.0)
        })
    }

    #[test]
    fn moments_of_solids_equal_sums_over_discs() {
        let (r, h) = (0.2, 0.35);
        let cap = |z: f64| if z.abs() < h { r } else { (r * r - (z.abs() - h) * (z.abs() - h)).max(0.0).sqrt() };
        for (solid, (m, x, z)) in [
            (Solid::capsule(r, h), by_discs(cap, h + r)),
            (Solid::cylinder(r, h), by_discs(|_| r, h)),
            (Solid::ellipsoid([r, r, h]), by_discs(|z| r * (1.0 - z * z / (h * h)).sqrt(), h)),
        ] {
            for (own, wanted) in [(solid.volume, m), (solid.inertia[(0, 0)], x), (solid.inertia[(2, 2)], z)] {
                assert!((own / wanted - 1.0).abs() < 1e-6, "{own} {wanted}");
            }
        }
    }
}
