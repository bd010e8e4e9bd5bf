//! Times calls of parts: `bench-parts PLUGIN_HEADERS`, where the argument is the folder `plugin-api/include`.
//!
//! Compiles a plugin with two kinds of parts that do nothing, and prints, as JSON, what 1000 of each add to a step, per
//! part: as a time, and as a ratio to the bound that docs/plugin-authors/parts.md states.

use std::{error::Error, path::Path, process::Command, sync::Arc, time::Instant};

use serde_json::json;
use tatu_core::{
    World, document, host_tables,
    plugins::{Registry, SearchPath},
};

const PLUGIN: &str = r#"
#include "tatu/part.h"
static tatu_status TATU_CALL nothing(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)data, (void)error;
  *(double *)call->state += call->dt;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = 8};
static const tatu_part stages = {.size = sizeof(tatu_part), .id = "stages", .text = "Acts and senses.", .life = &life,
  .actuate = nothing, .sense = nothing};
static const tatu_part physics = {.size = sizeof(tatu_part), .id = "physics", .text = "Acts in physics.", .life = &life,
  .physics_step = nothing};
TATU_PLUGIN(TATU_PARTS(&stages, &physics), .id = "org.tatu.bench-parts", .name = "Parts", .version = "1", .licence = "MIT");
"#;

/// Number of parts, and of physics steps in a step.
const COUNT: usize = 1000;
const PHYSICS_STEPS: usize = 10;
/// Each case is measured this often; the median counts.
const REPEATS: usize = 9;
const STEPS: usize = 40;
/// Bounds of the time that the host adds, us: per part in a step with `actuate` and `sense`, and in a physics step.
const STAGES_BOUND_US: f64 = 1.0;
const PHYSICS_BOUND_US: f64 = 0.3;

fn scene(kind: &str, count: usize) -> String {
    let mut text = "format = 1\n[scene]\ntext = \"Parts\"\ndt_s = 0.05\nphysics_dt_s = 0.005\n".to_owned();
    for i in 0..count {
        text += &format!("[[object]]\nkind = \"part\"\npart = \"{kind}\"\nalias = \"p{i}\"\n");
    }
    text
}

/// Returns the median duration of a step, us.
fn step_us(folder: &Path, registry: &Arc<Registry>, kind: &str, count: usize) -> Result<f64, Box<dyn Error>> {
    let file = folder.join("scene.toml");
    std::fs::write(&file, scene(kind, count))?;
    let document = document::load(&file, registry, &document::LoadOptions::default()).map_err(|e| e.text)?;
    let world = World::new(Arc::new(document), registry.clone()).map_err(|e| e.text)?;
    world.start();
    (0..STEPS).for_each(|_| _ = world.step());
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let begun = Instant::now();
            (0..STEPS).for_each(|_| _ = world.step());
            begun.elapsed().as_secs_f64() * 1e6 / STEPS as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    Ok(times[REPEATS / 2])
}

fn main() -> Result<(), Box<dyn Error>> {
    let headers = std::env::args().nth(1).ok_or("usage: bench-parts plugin-api/include")?;
    let folder = std::env::temp_dir().join(format!("tatu-bench-parts-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let source = folder.join("parts.c");
    std::fs::write(&source, PLUGIN)?;
    let library = folder.join(format!("libtatu_parts{}", std::env::consts::DLL_SUFFIX));
    let built = Command::new("cc")
        .args(["-std=c11", "-O2", "-shared", "-fPIC", "-I", &headers, "-o"])
        .args([&library, &source])
        .status()?;
    if !built.success() {
        return Err("the plugin cannot be compiled".into());
    }
    let registry = Arc::new(Registry::load(SearchPath::standard(None, Some(folder.as_os_str()), &[]), host_tables()));
    let of = |kind: &str, count| step_us(&folder, &registry, kind, count);
    let empty = of("stages", 0)?;
    let stages = (of("stages", COUNT)? - empty) / COUNT as f64;
    let physics = (of("physics", COUNT)? - empty) / (COUNT * PHYSICS_STEPS) as f64;
    let row = |us: f64, bound: f64| json!({ "us": us, "bound_us": bound, "ratio": us / bound });
    println!(
        "{}",
        json!({ "parts": COUNT, "step_us": empty, "actuate_and_sense": row(stages, STAGES_BOUND_US),
                "physics_step": row(physics, PHYSICS_BOUND_US) })
    );
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
