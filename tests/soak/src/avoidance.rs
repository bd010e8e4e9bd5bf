//! Runs one robot in one arena for many minutes.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use tatu_core::{World, document, plugins::Registry};

use crate::arena;

/// The measurements of one run in the arena.
pub struct AvoidanceRun {
    /// Shortest path of the base in any full minute, m.
    pub least_path_m: f64,
    /// Longest uninterrupted contact with a single obstacle, s.
    pub longest_contact_s: f64,
    /// Largest tilt of the base's z axis from the vertical, degrees.
    pub greatest_tilt_deg: f64,
    /// Number of errors that the run reported.
    pub faults: usize,
}

/// Runs one robot in the arena of a seed, and returns the measurements.
pub fn run(
    registry: &Arc<Registry>,
    seed: u64,
    minutes: u32,
    script: &Path,
    dialect: &str,
    robot: &str,
) -> Result<AvoidanceRun, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let script = std::fs::canonicalize(script).map_err(|e| format!("{}: {e}", script.display()))?;
    let file = folder.path().join("arena.toml");
    std::fs::write(&file, arena::scene(seed, &script.display().to_string(), dialect, robot))
        .map_err(|e| e.to_string())?;
    let scene = document::load(&file, registry, &document::LoadOptions::default()).map_err(|e| e.to_string())?;
    let world = World::new(Arc::new(scene), registry.clone()).map_err(|e| e.to_string())?;
    world.start();
    let dt = world.dt();
    let steps = (60.0 / dt).round() as u32;
    let mut out =
        AvoidanceRun { least_path_m: f64::INFINITY, longest_contact_s: 0.0, greatest_tilt_deg: 0.0, faults: 0 };
    let mut touching: BTreeMap<String, f64> = BTreeMap::new();
    let mut last = position(&world)?;
    for _ in 0..minutes {
        let mut path = 0.0;
        for _ in 0..steps {
            world.step();
            let now = position(&world)?;
            path += f64::hypot(now[0] - last[0], now[1] - last[1]);
            last = now;
            // The angle between the base's z axis and the vertical: cos = 1 - 2 (x^2 + y^2) of its quaternion.
            let tilt = (1.0 - 2.0 * (now[3] * now[3] + now[4] * now[4])).clamp(-1.0, 1.0).acos().to_degrees();
            out.greatest_tilt_deg = out.greatest_tilt_deg.max(tilt);
            let obstacles: Vec<String> = world
                .contacts()
                .into_iter()
                .filter_map(|(a, b, _)| match (is_obstacle(&a), is_obstacle(&b)) {
                    (true, false) => Some(a),
                    (false, true) => Some(b),
                    _ => None,
                })
                .collect();
            touching.retain(|o, _| obstacles.contains(o));
            for o in obstacles {
                touching.entry(o).or_insert(0.0);
            }
            for time in touching.values_mut() {
                *time += dt;
                out.longest_contact_s = out.longest_contact_s.max(*time);
            }
        }
        out.least_path_m = out.least_path_m.min(path);
    }
    world.stop();
    out.faults = world.faults().len();
    Ok(out)
}

fn is_obstacle(path: &str) -> bool {
    path.starts_with("/wall_") || path.starts_with("/box_")
}

fn position(world: &World) -> Result<[f64; 7], String> {
    world.observe("/Pioneer_p3dx").map(|o| o.pose).ok_or_else(|| "the robot is gone".into())
}
