//! Computes outlines of the beams of a sensor, for pictures.

use std::f64::consts::TAU;

use ::tatu_beams::{ImageProjection, Volume};
use nalgebra::Vector3;

use super::BeamPlan;

/// The two ends of a line in the sensor's frame, m.
pub type OutlineEdge = [[f64; 3]; 2];

const CIRCLE_SEGMENTS: u32 = 36;
/// Approximate maximum number of rays shown.
const MAX_SHOWN_RAYS: usize = 60;
/// Maximum range shown, m.
const MAX_SHOWN_RANGE: f64 = 20.0;

/// Returns the edges of the beams or image of a plan. The result is empty for a sensor without beams.
pub fn edges(plan: &BeamPlan) -> Vec<OutlineEdge> {
    let (near, far) = (plan.range.near, plan.range.far.min(MAX_SHOWN_RANGE));
    let mut out = Vec::new();
    let mut edge = |a: Vector3<f64>, b: Vector3<f64>| out.push([a.into(), b.into()]);
    if let Some(image) = plan.image {
        let aspect = f64::from(image.rows) / f64::from(image.columns);
        let corner = |z: f64, x: f64, y: f64| match image.projection {
            ImageProjection::Perspective { angle } => {
                Vector3::new(x * z * libm::tan(angle / 2.0), y * z * libm::tan(angle / 2.0) * aspect, z)
            }
            ImageProjection::Orthographic { width } => Vector3::new(x * width / 2.0, y * width / 2.0 * aspect, z),
        };
        for (i, (x, y)) in SQUARE_CORNERS.into_iter().enumerate() {
            let (u, v) = SQUARE_CORNERS[(i + 1) % 4];
            edge(corner(near, x, y), corner(far, x, y));
            edge(corner(near, x, y), corner(near, u, v));
            edge(corner(far, x, y), corner(far, u, v));
        }
        return out;
    }
    match plan.volume {
        Volume::Ray => {
            let step = plan.directions.len().div_ceil(MAX_SHOWN_RAYS).max(1);
            plan.directions.iter().step_by(step).for_each(|d| edge(Vector3::from(*d) * near, Vector3::from(*d) * far));
        }
        Volume::Cone { half_angle } => {
            // A spherical sector: both rims, and two arcs through the middle of the far end.
            let on = |r: f64, off: f64, turn: f64| {
                Vector3::new(libm::sin(off) * libm::cos(turn), libm::sin(off) * libm::sin(turn), libm::cos(off)) * r
            };
            for (a, b) in pieces(TAU) {
                edge(on(far, half_angle, a), on(far, half_angle, b));
                edge(on(near, half_angle, a), on(near, half_angle, b));
            }
            for (a, b) in pieces(2.0 * half_angle) {
                let (a, b) = (a - half_angle, b - half_angle);
                edge(on(far, a, 0.0), on(far, b, 0.0));
                edge(on(far, a, TAU / 4.0), on(far, b, TAU / 4.0));
            }
            (0..4)
                .map(|i| TAU / 4.0 * f64::from(i))
                .for_each(|t| edge(on(near, half_angle, t), on(far, half_angle, t)));
        }
        Volume::Pyramid { x_near, y_near, x_far, y_far } => {
            let ends = [(near, x_near, y_near), (far, x_far, y_far)];
            let corner = |(z, x, y): (f64, f64, f64), (u, v): (f64, f64)| Vector3::new(x * u / 2.0, y * v / 2.0, z);
            for (i, at) in SQUARE_CORNERS.into_iter().enumerate() {
                ends.into_iter().for_each(|e| edge(corner(e, at), corner(e, SQUARE_CORNERS[(i + 1) % 4])));
                edge(corner(ends[0], at), corner(ends[1], at));
            }
        }
        Volume::Cylinder { radius_near, radius_far } => {
            let on = |z: f64, r: f64, turn: f64| Vector3::new(r * libm::cos(turn), r * libm::sin(turn), z);
            for (a, b) in pieces(TAU) {
                edge(on(near, radius_near, a), on(near, radius_near, b));
                edge(on(far, radius_far, a), on(far, radius_far, b));
            }
            (0..4)
                .map(|i| TAU / 4.0 * f64::from(i))
                .for_each(|t| edge(on(near, radius_near, t), on(far, radius_far, t)));
        }
        Volume::Disc { angle, height, gap } => {
            let on = |r: f64, y: f64, turn: f64| Vector3::new(r * libm::sin(turn), y, r * libm::cos(turn));
            for y in [-height / 2.0, height / 2.0] {
                for side in [1.0, -1.0] {
                    for (a, b) in pieces((angle - gap).max(0.0) / 2.0) {
                        let (a, b) = (side * (a + gap / 2.0), side * (b + gap / 2.0));
                        edge(on(far, y, a), on(far, y, b));
                        edge(on(near, y, a), on(near, y, b));
                    }
                    edge(on(near, y, side * angle / 2.0), on(far, y, side * angle / 2.0));
                    if gap > 0.0 {
                        edge(on(near, y, side * gap / 2.0), on(far, y, side * gap / 2.0));
                    }
                }
            }
            for r in [near, far] {
                for t in [angle / 2.0, -angle / 2.0] {
                    edge(on(r, -height / 2.0, t), on(r, height / 2.0, t));
                }
            }
        }
    }
    out
}

/// The corners of a square from -1 to 1, in counterclockwise order.
const SQUARE_CORNERS: [(f64, f64); 4] = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];

/// Divides an angle into equal pieces; returns the start and the end of each.
fn pieces(angle: f64) -> impl Iterator<Item = (f64, f64)> {
    let at = move |i: u32| angle * f64::from(i) / f64::from(CIRCLE_SEGMENTS);
    (0..CIRCLE_SEGMENTS).map(move |i| (at(i), at(i + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sense::plan::BeamRange;

    fn plan(volume: Volume, near: f64, far: f64) -> BeamPlan {
        let range = BeamRange { near, far, ..BeamPlan::NONE.range };
        BeamPlan { volume, range, directions: vec![[0.0, 0.0, 1.0]], ..BeamPlan::NONE }
    }
    fn bounds(edges: &[OutlineEdge]) -> [[f64; 2]; 3] {
        let along = |i: usize| edges.iter().flatten().map(move |p| p[i]);
        [0, 1, 2].map(|i| [along(i).fold(f64::MAX, f64::min), along(i).fold(f64::MIN, f64::max)])
    }
    fn same(a: [[f64; 2]; 3], b: [[f64; 2]; 3]) {
        assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(x, y)| (x - y).abs() < 1e-9), "{a:?} {b:?}");
    }

    #[test]
    fn edges_reach_as_far_as_the_volume() {
        let cone = plan(Volume::Cone { half_angle: TAU / 12.0 }, 0.0, 2.0);
        same(bounds(&edges(&cone)), [[-1.0, 1.0], [-1.0, 1.0], [0.0, 2.0]]);
        let pyramid = plan(Volume::Pyramid { x_near: 0.2, y_near: 0.1, x_far: 2.0, y_far: 1.0 }, 0.5, 3.0);
        same(bounds(&edges(&pyramid)), [[-1.0, 1.0], [-0.5, 0.5], [0.5, 3.0]]);
        let cylinder = plan(Volume::Cylinder { radius_near: 0.1, radius_far: 0.4 }, 0.0, 1.0);
        same(bounds(&edges(&cylinder)), [[-0.4, 0.4], [-0.4, 0.4], [0.0, 1.0]]);
        let disc = plan(Volume::Disc { angle: TAU / 2.0, height: 0.2, gap: 0.0 }, 0.0, 1.0);
        same(bounds(&edges(&disc)), [[-1.0, 1.0], [-0.1, 0.1], [0.0, 1.0]]);
        assert!(edges(&BeamPlan { directions: Vec::new(), ..plan(Volume::Ray, 0.0, 1.0) }).is_empty());
    }
}
