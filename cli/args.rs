//! The command line: from raw to meaningful, in one place.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use tatu_core::{
    document::{Options, Override, ScriptOverride},
    error::Error,
};

/// Tatu, a robot simulator made of a small core and plugins.
#[derive(Parser)]
#[command(version, about)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Run a scene.
    Run(Run),
    /// Check that a scene would start.
    Check(Check),
    /// List what plugins offer.
    List(List),
}

/// What a scene is and what is changed in it.
#[derive(clap::Args)]
pub struct Scene {
    /// The scene file.
    pub scene: PathBuf,
    /// Seed of all that is random, instead of the scene's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Set a property or model parameter: `/Robot/leftMotor.max_force_nm=2`, `scene.dt_s=0.01`.
    #[arg(long = "set", value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// Put a script in place of an object's own: `/Robot=my_controller.lua`.
    #[arg(long = "script", value_name = "OBJECT=FILE")]
    pub scripts: Vec<String>,
}

#[derive(clap::Args)]
pub struct Run {
    #[command(flatten)]
    pub scene: Scene,
    /// Simulated seconds to run [default: 10].
    #[arg(long, value_name = "S", conflicts_with = "steps", allow_negative_numbers = true, value_parser = seconds)]
    pub seconds: Option<f64>,
    /// Steps to run.
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
    /// Threads; the results do not depend on them.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Write one JSON line a step to a file.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Put an object's pose and velocity, and a sensor's readings, into the trace.
    #[arg(long, value_name = "PATH")]
    pub watch: Vec<String>,
    /// Write the state of the run to a file once T simulated seconds are over, and go on; may be given several times.
    #[arg(long, value_names = ["T", "FILE"], num_args = 2, action = clap::ArgAction::Append)]
    pub snapshot_at: Vec<String>,
    /// Go on from a file that `--snapshot-at` of the same scene wrote; times still count from 0.
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// End with a summary in JSON on standard output; everything else goes to standard error.
    #[arg(long)]
    pub json: bool,
}

#[derive(clap::Args)]
pub struct Check {
    #[command(flatten)]
    pub scene: Scene,
}

#[derive(clap::Args)]
pub struct List {
    /// What to list.
    pub what: What,
    /// A scene whose plugin folders are searched too.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// As a JSON array.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum What {
    Plugins,
    Models,
    Sensors,
    Commands,
}

fn seconds(text: &str) -> Result<f64, String> {
    let s: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if s.is_finite() && s >= 0.0 { Ok(s) } else { Err("expected a number of seconds, at least 0".into()) }
}

impl Scene {
    /// What the run changes in the scene.
    pub fn options(&self) -> Result<Options, Error> {
        Ok(Options {
            seed: self.seed,
            set: self.set.iter().map(|s| Override::parse(s)).collect::<Result<_, _>>()?,
            scripts: self.scripts.iter().map(|s| ScriptOverride::parse(s)).collect::<Result<_, _>>()?,
        })
    }
}
