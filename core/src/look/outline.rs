//! The edges of what a sensor sends out, for pictures.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

use crate::{
    beams::Volume,
    sense::{BeamPlan, View},
};

/// Two points, m, in the sensor's frame.
pub type Edge = [[f64; 3]; 2];

/// Pieces of a circle.
const PIECES: u32 = 36;
/// Rays that are shown.
const MOST_RAYS: usize = 60;
/// What reaches farther than this is shown up to here, m.
const FARTHEST: f64 = 20.0;

/// The edges; none for a sensor that sends nothing out.
pub(super) fn edges(plan: &BeamPlan) -> Vec<Edge> {
    let (near, far) = (plan.near, plan.far.min(FARTHEST));
    let mut out = Vec::new();
    let mut edge = |a: Vector3<f64>, b: Vector3<f64>| out.push([a, b].map(|p| Point3::from(p).coords.into()));
    if let Some(image) = plan.image {
        let aspect = f64::from(image.rows) / f64::from(image.columns);
        let corner = |z: f64, x: f64, y: f64| match image.view {
            View::Pinhole(angle) => Vector3::new(x * z * (angle / 2.0).tan(), y * z * (angle / 2.0).tan() * aspect, z),
            View::Parallel(width) => Vector3::new(x * width / 2.0, y * width / 2.0 * aspect, z),
        };
        let around = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        for (i, (x, y)) in around.into_iter().enumerate() {
            let (u, v) = around[(i + 1) % 4];
            edge(corner(near, x, y), corner(far, x, y));
            edge(corner(near, x, y), corner(near, u, v));
            edge(corner(far, x, y), corner(far, u, v));
        }
        return out;
    }
    match plan.volume {
        Volume::Ray => {
            let step = plan.directions.len().div_ceil(MOST_RAYS).max(1);
            plan.directions.iter().step_by(step).for_each(|d| edge(Vector3::from(*d) * near, Vector3::from(*d) * far));
        }
        Volume::Cone { half_angle } => {
            // A ball sector: the rim, and two arcs through its middle.
            let on = |r: f64, off: f64, turn: f64| {
                Vector3::new(off.sin() * turn.cos(), off.sin() * turn.sin(), off.cos()) * r
            };
            let piece = |i: u32| TAU * f64::from(i) / f64::from(PIECES);
            for i in 0..PIECES {
                edge(on(far, half_angle, piece(i)), on(far, half_angle, piece(i + 1)));
                edge(on(near, half_angle, piece(i)), on(near, half_angle, piece(i + 1)));
                let off = |k: u32| half_angle * (2.0 * f64::from(k) / f64::from(PIECES) - 1.0);
                edge(on(far, off(i), 0.0), on(far, off(i + 1), 0.0));
                edge(on(far, off(i), TAU / 4.0), on(far, off(i + 1), TAU / 4.0));
            }
            for i in 0..4 {
                let turn = TAU * f64::from(i) / 4.0;
                edge(on(near, half_angle, turn), on(far, half_angle, turn));
            }
        }
    }
    out
}
