//! The rooms of `bench/peers/scenes.py`. The same random generator and the same order of samples give equal values.

use std::{f64::consts::PI, sync::Arc};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_core::{
    beams::BeamTarget,
    geometry::{Form, Mesh},
};

/// The random generator SplitMix64; the field is its state.
pub struct Rng(pub u64);

impl Rng {
    /// Returns a random value from `low` to `high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-53)
    }
}

/// Returns a pose rotated by `yaw` (rad) about the vertical.
pub fn pose(x: f64, y: f64, z: f64, yaw: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw))
}

/// Returns a target with the id and group `number`.
pub fn target(number: usize, pose: Isometry3<f64>, form: Form) -> BeamTarget {
    BeamTarget {
        object: number as u64 + 1,
        group: number as u32 + 1,
        world_from_target: pose,
        form,
        color: [0.7; 3],
        opacity: 1.0,
        texture: None,
    }
}

fn box_target(number: usize, at: [f64; 3], half: [f64; 3], yaw: f64) -> BeamTarget {
    target(number, pose(at[0], at[1], at[2], yaw), Form::Box { half: half.into() })
}

/// Returns the targets of `room()`: a floor of 20 m x 20 m, 4 walls, and 100 boxes, none within 2 m of the origin.
pub fn room() -> Vec<BeamTarget> {
    let mut rng = Rng(42);
    let mut out = vec![target(0, Isometry3::identity(), Form::Plane)];
    while out.len() < 101 {
        let (x, y) = (rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0));
        let (hx, hy, hz) = (rng.uniform(0.15, 0.5), rng.uniform(0.15, 0.5), rng.uniform(0.3, 0.6));
        let yaw = rng.uniform(-PI, PI);
        if x.hypot(y) >= 2.0 {
            out.push(box_target(out.len(), [x, y, hz], [hx, hy, hz], yaw));
        }
    }
    let h = 10.0;
    for (at, half) in [
        ([h + 0.05, 0.0, 1.0], [0.05, h + 0.1, 1.0]),
        ([-h - 0.05, 0.0, 1.0], [0.05, h + 0.1, 1.0]),
        ([0.0, h + 0.05, 1.0], [h, 0.05, 1.0]),
        ([0.0, -h - 0.05, 1.0], [h, 0.05, 1.0]),
    ] {
        out.push(box_target(out.len(), at, half, 0.0));
    }
    out
}

/// Returns the target of `mesh()` at `MESH_CENTRE`: a closed bumpy torus with 100,000 triangles.
pub fn torus(number: usize) -> BeamTarget {
    let (nu, nv) = (250u32, 200u32);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..nu {
        let u = 2.0 * PI * f64::from(i) / f64::from(nu);
        for j in 0..nv {
            let v = 2.0 * PI * f64::from(j) / f64::from(nv);
            let r = 0.25 * (1.0 + 0.1 * (8.0 * u).sin() * (6.0 * v).sin());
            let q = 0.6 + r * v.cos();
            vertices.push(Point3::new(r * v.sin(), q * u.cos(), q * u.sin()));
        }
    }
    for i in 0..nu {
        for j in 0..nv {
            let [a, b] = [i * nv + j, (i + 1) % nu * nv + j];
            let [c, d] = [(i + 1) % nu * nv + (j + 1) % nv, i * nv + (j + 1) % nv];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let form = Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Default::default() }), convex: false };
    target(number, Isometry3::translation(3.0, 0.0, 1.0), form)
}

/// Returns `sensor_pose(k)`: x (m), y (m) and yaw (rad) of the sensor in frame `k`.
pub fn sensor_pose(k: u64) -> (f64, f64, f64) {
    let t = 0.1 * (k % 200) as f64;
    (0.8 * t.cos(), 0.8 * t.sin(), 0.3 * (0.7 * t).sin())
}

/// Returns the number of cells along a side of the arena, and the length of a side in m.
fn arena_side(robots: usize) -> (usize, f64) {
    let cells = ((robots.max(2) - 1).isqrt() + 1).max(5);
    (cells, 2.0 * cells as f64)
}

/// Returns `arena(n)`: the poses of the robots (x, y, yaw), and the static boxes and walls.
pub fn arena(robots: usize) -> (Vec<(f64, f64, f64)>, Vec<BeamTarget>) {
    let (cells, side) = arena_side(robots);
    let mut rng = Rng(1000 + robots as u64);
    let mut poses = Vec::new();
    for k in 0..robots {
        let c = k * cells * cells / robots;
        let x = ((c % cells) as f64 + 0.5) * 2.0 - side / 2.0;
        let y = ((c / cells) as f64 + 0.5) * 2.0 - side / 2.0;
        poses.push((x, y, rng.uniform(-PI, PI)));
    }
    // The groups 1..=robots belong to the robots. Each static object has a separate group.
    let mut still = Vec::new();
    for i in 1..cells {
        for j in 1..cells {
            let keep = rng.uniform(0.0, 1.0) < 0.5;
            let (hx, hy) = (rng.uniform(0.15, 0.40), rng.uniform(0.15, 0.40));
            let yaw = rng.uniform(-PI, PI);
            if keep {
                let at = [i as f64 * 2.0 - side / 2.0, j as f64 * 2.0 - side / 2.0, 0.25];
                still.push(box_target(robots + still.len(), at, [hx, hy, 0.25], yaw));
            }
        }
    }
    let h = side / 2.0;
    for (at, half) in [
        ([h + 0.05, 0.0, 0.25], [0.05, h + 0.1, 0.25]),
        ([-h - 0.05, 0.0, 0.25], [0.05, h + 0.1, 0.25]),
        ([0.0, h + 0.05, 0.25], [h, 0.05, 0.25]),
        ([0.0, -h - 0.05, 0.25], [h, 0.05, 0.25]),
    ] {
        still.push(box_target(robots + still.len(), at, half, 0.0));
    }
    (poses, still)
}
