//! Times a planar laser scanner in a room with 100 boxes.

use nalgebra::Isometry3;
use serde_json::{Value, json};
use tatu_core::beams::{BeamScene, BundleCast, BundleHits, RayBundle};

use crate::{
    BenchOptions,
    clock::{LoopTimes, loop_for},
    scenes::{pose, room, sensor_pose, torus},
};

/// `LIDAR_Z` in `bench/peers/scenes.py`, m. The next constant is its `LIDAR_RANGE`, m.
const HEIGHT: f64 = 0.3;
const RANGE: f64 = 30.0;

/// Returns the field of view, in degrees, of the scanner with this number of beams in `LIDARS` of
/// `bench/peers/scenes.py`.
fn field_of_view(beams: usize) -> f64 {
    match beams {
        180 => 180.0,
        685 => 240.0,
        _ => 270.0,
    }
}

/// Times the scanner, and returns the result as a JSON object.
pub fn run(asked: &BenchOptions) -> Value {
    let beams: usize = asked.number("beams", 1080);
    let fov = field_of_view(beams).to_radians();
    let mut targets = room();
    if asked.flag("mesh") {
        targets.push(torus(targets.len()));
    }
    let mut scene = BeamScene::default();
    scene.set(targets);
    let directions: Vec<[f64; 3]> = (0..beams)
        .map(|i| {
            let a = -fov / 2.0 + fov * i as f64 / (beams - 1) as f64;
            [a.cos(), a.sin(), 0.0]
        })
        .collect();
    let bundle = RayBundle::new(&directions);
    let mut distance = vec![0.0; beams];
    let mut first = 0.0;
    let prepare = |k: u64| {
        let (x, y, yaw) = sensor_pose(k);
        pose(x, y, HEIGHT, yaw)
    };
    let LoopTimes { frames, clock, .. } = loop_for(asked.number("seconds", 3.0), prepare, |sensor: Isometry3<f64>| {
        let cast = BundleCast::new(&bundle, sensor, RANGE);
        scene.cast_bundle(&cast, BundleHits { distance: &mut distance, ..BundleHits::default() });
        if first == 0.0 {
            first = distance.iter().map(|d| d.min(RANGE)).sum::<f64>() / beams as f64;
        }
    });
    let rays = (frames * beams as u64) as f64;
    json!({
        "bench": "B2_lidar", "beams": beams, "mesh": asked.flag("mesh"),
        "rays_per_s": rays / clock.wall, "rays_per_cpu_s": rays / clock.cpu, "mean_range_frame0": first,
    })
}
