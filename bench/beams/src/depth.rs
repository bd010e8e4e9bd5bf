//! Times a depth camera with 640 x 480 pixels in a room with 100 boxes.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use tatu_core::beams::{BeamScene, Faces, Grid, GridCast, GridImage, ImageLighting, ImageOutputs, ImageProjection};

use crate::{
    BenchOptions,
    clock::{LoopTimes, loop_for},
    scenes::{room, sensor_pose, torus},
};

/// The camera's parameters, in pixels, degrees and m, equal to those of `DEPTH` in `bench/peers/scenes.py`.
const COLUMNS: u32 = 640;
const ROWS: u32 = 480;
const ANGLE: f64 = 57.0;
const NEAR: f64 = 0.2;
const FAR: f64 = 10.0;
const HEIGHT: f64 = 0.8;
const PITCH_DOWN_DEG: f64 = 10.0;

/// Returns the pose of the camera in frame `k`. Its +z axis points forward, +y up, and +x to the left.
fn camera(k: u64) -> Isometry3<f64> {
    let (x, y, yaw) = sensor_pose(k);
    let down = PITCH_DOWN_DEG.to_radians();
    let ahead = Vector3::new(yaw.cos() * down.cos(), yaw.sin() * down.cos(), -down.sin());
    let left = Vector3::new(-yaw.sin(), yaw.cos(), 0.0);
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[left, ahead.cross(&left), ahead]));
    Isometry3::from_parts(Translation3::new(x, y, HEIGHT), UnitQuaternion::from_rotation_matrix(&turn))
}

/// Times the camera, and returns the result as a JSON object.
pub fn run(asked: &BenchOptions) -> Value {
    let threads: usize = asked.number("threads", 1);
    let mut targets = room();
    if asked.flag("mesh") {
        targets.push(torus(targets.len()));
    }
    let mut scene = BeamScene::default();
    scene.set(targets);
    let grid = Grid {
        columns: COLUMNS,
        rows: ROWS,
        projection: ImageProjection::Perspective { angle: ANGLE.to_radians() },
        near: NEAR,
        far: FAR,
    };
    let (light, want) =
        (ImageLighting::default(), if asked.flag("all") { ImageOutputs::ALL } else { ImageOutputs::DEPTH });
    let (faces, skip_group, only_object) = (Faces::BOTH, None, None);
    // As in a world, the calling thread is one of the pool's threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread();
    let pool = pool.build().expect("the thread pool can be created");
    let mut image = GridImage::default();
    let mut first = 0.0;
    let took = loop_for(asked.number("seconds", 3.0), camera, |world_from_sensor| {
        let cast =
            GridCast { grid: &grid, world_from_sensor, faces, skip_group, only_object, outputs: want, light: &light };
        pool.install(|| scene.render(&cast, &mut image));
        if first == 0.0 {
            let sum: f64 = image.depth.iter().map(|z| f64::from(*z).min(FAR)).sum();
            first = sum / image.depth.len() as f64;
        }
    });
    let LoopTimes { frames, clock, median } = took;
    json!({
        "bench": "B3_depth", "mesh": asked.flag("mesh"), "threads": threads, "frames_per_s": frames as f64 / clock.wall,
        "frames_per_cpu_s": frames as f64 / clock.cpu, "median_s": median, "mean_depth_frame0": first,
    })
}
