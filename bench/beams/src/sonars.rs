//! Times the beams of 1000 robots with 16 sonar cones each, without physics, as `mujoco_arena.py` times its rays.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;
use serde_json::{Value, json};
use tatu_core::{
    beams::{Beam, BeamScene, BeamTarget, Hit},
    geometry::Form,
};

use crate::{
    BenchOptions,
    clock::{LoopTimes, loop_for},
    scenes::{arena, pose},
};

/// Directions of the sensors in degrees: `SENSOR_ANGLES` in `bench/peers/scenes.py`.
const ANGLES: [f64; 16] =
    [90., 50., 30., 10., -10., -30., -50., -90., -90., -130., -150., -170., 170., 150., 130., 90.];
/// `chassis_z` of `ROBOT`, m. The next two constants are its `sensor_z` and `sensor_range`, m.
const CHASSIS_Z: f64 = 0.16;
const SENSOR_Z: f64 = 0.06;
const RANGE: f64 = 1.0;
/// Half the opening angle of the Pioneer's sonars (30 degrees), rad.
const HALF_ANGLE: f64 = 15.0 * PI / 180.0;

/// Returns the forms of one robot (`ROBOT`) with their poses in the frame of the chassis.
fn parts() -> [(Isometry3<f64>, Form); 4] {
    let flat = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -PI / 2.0);
    let wheel = Form::Cylinder { radius: 0.0975, half_length: 0.02 };
    let at = |y| Isometry3::from_parts(Translation3::new(0.06, y, -0.0625), flat);
    [
        (Isometry3::identity(), Form::Box { half: Vector3::new(0.19, 0.16, 0.10) }),
        (Isometry3::translation(-0.15, 0.0, -0.11), Form::Sphere { radius: 0.05 }),
        (at(0.165), wheel.clone()),
        (at(-0.165), wheel),
    ]
}

/// Returns the poses of the sensors in the frame of the chassis.
fn mounts() -> Vec<Isometry3<f64>> {
    let mount = |degrees: f64| {
        let a = degrees.to_radians();
        let off = (0.195 / a.cos().abs().max(1e-9)).min(0.19 / a.sin().abs().max(1e-9));
        let ahead = Vector3::new(a.cos(), a.sin(), 0.0);
        let turn = UnitQuaternion::face_towards(&ahead, &Vector3::z());
        Isometry3::from_parts(Translation3::from(ahead * off + Vector3::z() * SENSOR_Z), turn)
    };
    ANGLES.into_iter().map(mount).collect()
}

/// Times the sonars, and returns the result as a JSON object.
pub fn run(asked: &BenchOptions) -> Value {
    let robots: usize = asked.number("robots", 1000);
    let threads: usize = asked.number("threads", 1);
    let (poses, still) = arena(robots);
    let (parts, mounts) = (parts(), mounts());
    let mut targets: Vec<BeamTarget> = Vec::new();
    for (k, _) in poses.iter().enumerate() {
        for (_, form) in &parts {
            let (object, group) = (k as u64 + 1, k as u32 + 1);
            targets.push(BeamTarget {
                object,
                group,
                world_from_target: Isometry3::identity(),
                form: form.clone(),
                color: [0.7; 3],
                opacity: 1.0,
                texture: None,
            });
        }
    }
    targets.extend(still);
    let mut scene = BeamScene::default();
    scene.set(targets);

    // Robots drive in small circles, so every pose changes in every frame.
    let place = |k: usize, frame: u64| {
        let (x, y, yaw) = poses[k];
        let t = 0.1 * frame as f64 + k as f64;
        pose(x + 0.2 * t.cos(), y + 0.2 * t.sin(), CHASSIS_Z, yaw + t)
    };
    let mut beams = vec![Beam::cone(Isometry3::identity(), HALF_ANGLE, RANGE); robots * mounts.len()];
    let mut hits = vec![Hit::NONE; robots * mounts.len()];
    let mut moved = vec![(0, Isometry3::identity()); robots * parts.len()];
    // As in a world, the calling thread is one of the pool's threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread();
    let pool = pool.build().expect("the thread pool can be created");
    let mut seen = 0usize;
    let prepare = |frame: u64| (0..robots).map(|k| place(k, frame)).collect::<Vec<_>>();
    let LoopTimes { frames, clock, median } = loop_for(asked.number("seconds", 3.0), prepare, |chassis| {
        pool.install(|| {
            moved.par_chunks_mut(parts.len()).zip(chassis.par_iter()).enumerate().with_min_len(64).for_each(
                |(k, (moved, at))| {
                    for (i, (place, (part, _))) in moved.iter_mut().zip(&parts).enumerate() {
                        *place = (k * parts.len() + i, at * part);
                    }
                },
            );
            scene.update_poses(&moved);
            // The poses of the sensors are computed on all threads.
            beams.par_chunks_mut(mounts.len()).zip(chassis.par_iter()).enumerate().with_min_len(64).for_each(
                |(k, (beams, at))| {
                    for (beam, mount) in beams.iter_mut().zip(&mounts) {
                        *beam = Beam { skip_group: Some(k as u32 + 1), ..Beam::cone(at * mount, HALF_ANGLE, RANGE) };
                    }
                },
            );
            scene.cast(&beams, &mut hits);
        });
        seen += hits.iter().filter(|hit| hit.is_some()).count();
    });
    let steps = (robots as u64 * frames) as f64;
    json!({
        "bench": "B1_sonars", "robots": robots, "cones": mounts.len(), "threads": threads,
        "robot_steps_per_s": steps / clock.wall, "robot_steps_per_cpu_s": steps / clock.cpu,
        "median_s": median, "seen": seen as f64 / (frames + 1) as f64,
    })
}
