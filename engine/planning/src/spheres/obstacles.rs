//! Forms that stay where they are, and spheres of eight states that may touch them.

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;

use super::{
    fit::{Sphere, around},
    lanes::{LANES, Lane, LanePoint},
};

/// A form that stays, in the world.
#[derive(Debug, Clone)]
pub(super) enum Obstacle {
    Sphere(Sphere),
    /// A box, whose axes are the rows.
    Box {
        axes: [[f64; 3]; 3],
        center: [f64; 3],
        half: [f64; 3],
    },
    /// A cylinder along the last of the axes.
    Cylinder {
        axes: [[f64; 3]; 3],
        center: [f64; 3],
        radius: f64,
        half_length: f64,
    },
    /// The points that are nearer to a segment than a radius.
    Capsule {
        from: [f64; 3],
        along: [f64; 3],
        radius: f64,
    },
    /// Points below a plane.
    Plane {
        normal: [f64; 3],
        height: f64,
    },
    /// Spheres within a box.
    Spheres {
        bound: Box<Obstacle>,
        spheres: Vec<Sphere>,
    },
}

/// Which of eight states are meant.
pub(super) type Mask = [bool; LANES];
pub(super) const NO_LANE: Mask = [false; LANES];

pub(super) fn any(mask: &Mask) -> bool {
    mask.iter().any(|m| *m)
}

impl Obstacle {
    /// Returns a form at a pose, or `None` for a mesh without triangles. `spheres` cover it, in its own frame.
    pub fn new(form: &Form, pose: &Isometry3<f64>, spheres: &[Sphere]) -> Option<Self> {
        let r = pose.rotation.to_rotation_matrix();
        let axes = std::array::from_fn(|axis| std::array::from_fn(|i| r.matrix()[(i, axis)]));
        let center = [pose.translation.x, pose.translation.y, pose.translation.z];
        Some(match form {
            Form::Sphere { radius } => Obstacle::Sphere(Sphere { center: Point3::from(center), radius: *radius }),
            Form::Box { half } => Obstacle::Box { axes, center, half: [half.x, half.y, half.z] },
            Form::Cylinder { radius, half_length } => {
                Obstacle::Cylinder { axes, center, radius: *radius, half_length: *half_length }
            }
            Form::Capsule { radius, half_length } => {
                let half = axes[2].map(|x: f64| x * half_length);
                let from = std::array::from_fn(|i| center[i] - half[i]);
                Obstacle::Capsule { from, along: half.map(|x| 2.0 * x), radius: *radius }
            }
            Form::Plane => {
                let normal = axes[2];
                Obstacle::Plane { normal, height: (0..3).map(|i| normal[i] * center[i]).sum() }
            }
            Form::Mesh { .. } => {
                around(spheres)?;
                let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
                for s in spheres {
                    low = low.inf(&s.center.coords.add_scalar(-s.radius));
                    high = high.sup(&s.center.coords.add_scalar(s.radius));
                }
                let middle = pose * Point3::from(0.5 * (low + high));
                let half = 0.5 * (high - low);
                let bound =
                    Obstacle::Box { axes, center: [middle.x, middle.y, middle.z], half: [half.x, half.y, half.z] };
                let spheres = spheres.iter().map(|s| Sphere { center: pose * s.center, radius: s.radius }).collect();
                Obstacle::Spheres { bound: Box::new(bound), spheres }
            }
        })
    }

    /// Returns which of eight spheres touch or overlap the form.
    #[inline(always)]
    pub fn touches(&self, center: &LanePoint, radius: f64) -> Mask {
        match self {
            Obstacle::Spheres { bound, spheres } => {
                if !any(&bound.touches_simple(center, radius)) {
                    return NO_LANE;
                }
                let mut mask = NO_LANE;
                for s in spheres {
                    let hit = touches_sphere(s, center, radius);
                    for l in 0..LANES {
                        mask[l] |= hit[l];
                    }
                }
                mask
            }
            simple => simple.touches_simple(center, radius),
        }
    }

    #[inline(always)]
    fn touches_simple(&self, p: &LanePoint, radius: f64) -> Mask {
        let mut squares: Lane = [0.0; LANES];
        let mut reach = radius;
        match self {
            Obstacle::Sphere(s) => return touches_sphere(s, p, radius),
            Obstacle::Box { axes, center, half } => {
                for (axis, half) in axes.iter().zip(half) {
                    let along = component(axis, center, p);
                    for l in 0..LANES {
                        let beyond = larger(along[l].abs() - half, 0.0);
                        squares[l] += beyond * beyond;
                    }
                }
            }
            Obstacle::Cylinder { axes, center, radius: own, half_length } => {
                let [x, y, z] =
                    [component(&axes[0], center, p), component(&axes[1], center, p), component(&axes[2], center, p)];
                for l in 0..LANES {
                    let beside = larger((x[l] * x[l] + y[l] * y[l]).sqrt() - own, 0.0);
                    let beyond = larger(z[l].abs() - half_length, 0.0);
                    squares[l] = beside * beside + beyond * beyond;
                }
            }
            Obstacle::Capsule { from, along, radius: own } => {
                let square = along.iter().map(|x| x * x).sum::<f64>().max(1e-300);
                let share = component(along, from, p);
                for l in 0..LANES {
                    let t = larger(smaller(share[l] / square, 1.0), 0.0);
                    for i in 0..3 {
                        let d = p[i][l] - (from[i] + along[i] * t);
                        squares[l] += d * d;
                    }
                }
                reach += own;
            }
            Obstacle::Plane { normal, height } => {
                let heights = component(normal, &[0.0; 3], p);
                let mut mask = NO_LANE;
                for l in 0..LANES {
                    mask[l] = heights[l] - height <= radius;
                }
                return mask;
            }
            Obstacle::Spheres { .. } => return [true; LANES],
        }
        let mut mask = NO_LANE;
        for l in 0..LANES {
            mask[l] = squares[l] <= reach * reach;
        }
        mask
    }
}

// `f64::max` must also handle NaN, which takes several instructions.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the extent of points along an axis, from a centre.
#[inline(always)]
fn component(axis: &[f64; 3], center: &[f64; 3], p: &LanePoint) -> Lane {
    let mut out = [0.0; LANES];
    for l in 0..LANES {
        out[l] = (axis[0] * (p[0][l] - center[0]) + axis[1] * (p[1][l] - center[1])) + axis[2] * (p[2][l] - center[2]);
    }
    out
}

#[inline(always)]
fn touches_sphere(s: &Sphere, p: &LanePoint, radius: f64) -> Mask {
    let (c, reach) = (&s.center, s.radius + radius);
    let mut mask = NO_LANE;
    for l in 0..LANES {
        let (x, y, z) = (p[0][l] - c.x, p[1][l] - c.y, p[2][l] - c.z);
        mask[l] = (x * x + y * y) + z * z <= reach * reach;
    }
    mask
}

/// Returns which of eight pairs of spheres touch.
#[inline(always)]
pub(super) fn touch_each_other(a: &LanePoint, b: &LanePoint, reach: f64) -> Mask {
    let mut mask = NO_LANE;
    for l in 0..LANES {
        let (x, y, z) = (a[0][l] - b[0][l], a[1][l] - b[1][l], a[2][l] - b[2][l]);
        mask[l] = (x * x + y * y) + z * z <= reach * reach;
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances that are known from the formulas of the forms.
    #[test]
    fn spheres_touch_forms_at_their_distance() {
        let pose = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.4, -0.3, 0.8));
        let cases: [(Form, [f64; 3], f64); 8] = [
            (Form::Sphere { radius: 0.5 }, [0.0, 0.0, 2.0], 1.5),
            (Form::Box { half: Vector3::new(1.0, 2.0, 3.0) }, [2.0, 3.0, 3.5], (1.0f64 + 1.0 + 0.25).sqrt()),
            (Form::Box { half: Vector3::new(1.0, 2.0, 3.0) }, [0.5, -4.0, 1.0], 2.0),
            (Form::Cylinder { radius: 1.0, half_length: 2.0 }, [3.0, 4.0, 1.0], 4.0),
            (Form::Cylinder { radius: 1.0, half_length: 2.0 }, [3.0, 4.0, -5.0], 5.0),
            (Form::Capsule { radius: 0.5, half_length: 2.0 }, [0.0, 3.0, 6.0], 4.5),
            (Form::Capsule { radius: 0.5, half_length: 2.0 }, [2.0, 0.0, 1.0], 1.5),
            (Form::Plane, [5.0, -7.0, 0.75], 0.75),
        ];
        for (form, place, distance) in cases {
            let obstacle = Obstacle::new(&form, &pose, &[]).unwrap();
            let p = pose * Point3::from(place);
            let lanes = [[p.x; LANES], [p.y; LANES], [p.z; LANES]];
            assert!(any(&obstacle.touches(&lanes, distance + 1e-9)), "{form:?}");
            assert!(!any(&obstacle.touches(&lanes, distance - 1e-9)), "{form:?}");
        }
    }
}
