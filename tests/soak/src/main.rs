//! Runs long tests: `cargo run --release -p soak`. Prints a table; the exit code is 1 if a bound is exceeded.
//!
//! Each run puts a Pioneer into an arena of 10 x 10 m with 8 boxes and gaps of at least 1 m. The boxes and the heading
//! at the start are drawn from the seed. The table shows, per seed, the shortest path in a minute, the longest contact,
//! and the largest tilt.

mod arena;
mod avoidance;

use std::{path::PathBuf, process::ExitCode, sync::Arc};

use clap::Parser;
use rayon::prelude::*;
use tatu_core::plugins::{Registry, SearchPath};

/// Long runs of Tatu.
#[derive(Parser)]
struct Args {
    /// Number of seeds to run, starting with seed 1.
    #[arg(long, default_value_t = 10)]
    seeds: u64,
    /// Simulated time per seed, in minutes.
    #[arg(long, default_value_t = 10)]
    minutes: u32,
    /// File of the controller to test.
    #[arg(long, default_value = "scenes/first/avoid_walls.lua")]
    script: PathBuf,
    /// Dialect of the controller; if empty, it is detected from the script's text.
    #[arg(long, default_value = "")]
    dialect: String,
    /// Parameters of the robot, as lines of TOML for its table in the scene.
    #[arg(long, default_value = "")]
    robot: String,
}

/// The libraries of the plugins listed in this program's manifest.
const PLUGINS: &[&str] =
    &["tatu_commands_vrep", "tatu_scripts_lua", "tatu_sensors_proximity", "tatu_models_folder", "tatu_importers_mesh"];

fn main() -> ExitCode {
    let args = Args::parse();
    let exe = std::env::current_exe().ok();
    let registry =
        Arc::new(Registry::load(SearchPath::standard(exe.as_deref(), None, PLUGINS), tatu_core::host_tables()));
    let runs: Vec<_> = (1..=args.seeds)
        .into_par_iter()
        .map(|seed| (seed, avoidance::run(&registry, seed, args.minutes, &args.script, &args.dialect, &args.robot)))
        .collect();
    println!("seed  least m/min  longest contact s  greatest tilt deg  faults");
    let mut good = true;
    for (seed, run) in runs {
        match run {
            Ok(r) => {
                let holds = r.least_path_m >= 3.0 && r.longest_contact_s <= 0.5 && r.greatest_tilt_deg < 3.0;
                good &= holds && r.faults == 0;
                println!(
                    "{seed:>4}  {:>11.2}  {:>17.2}  {:>17.3}  {:>6}{}",
                    r.least_path_m,
                    r.longest_contact_s,
                    r.greatest_tilt_deg,
                    r.faults,
                    if holds { "" } else { "  <- out of bounds" }
                );
            }
            Err(e) => {
                good = false;
                println!("{seed:>4}  {e}");
            }
        }
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
