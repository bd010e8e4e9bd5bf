//! The arguments of `tatu test` and `tatu grade`.

use std::path::PathBuf;

use crate::values::{length, permission, scene, seconds};

#[derive(clap::Args)]
pub struct TestArgs {
    /// Scene files, and folders with scenes that state `duration_s` in `[scene]` or have goals.
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// Number of scenes that are run at the same time [default: the number of cores].
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Write the results to a file in JUnit's format, which programs for continuous integration show.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Folder for the records of failed runs, which is created.
    #[arg(long, value_name = "DIR", default_value = "failed")]
    pub failed: PathBuf,
    /// Seconds of real time after which a run is ended and counts as failed.
    #[arg(long, value_name = "S", default_value_t = 600.0, value_parser = seconds)]
    pub timeout: f64,
    /// Seed of all random numbers, instead of the scenes'.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Set a property or model parameter in all scenes, as for `tatu run`.
    #[arg(long, value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// Grant permissions, as for `tatu run`.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = permission)]
    pub allow: Vec<String>,
    /// Print the results in JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(clap::Args)]
pub struct GradeArgs {
    /// The scene that all scripts are run in.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// The script that checks the goals.
    pub criteria: PathBuf,
    /// A folder with one script, folder or handed-in zip file for each student, or one of them.
    pub submissions: PathBuf,
    /// The object whose script is replaced [default: the only object at the top of the scene with a
    /// script].
    #[arg(long, value_name = "PATH")]
    pub object: Option<String>,
    /// Seconds of simulation time [default: the scene's `duration_s`, or 10].
    #[arg(long, value_name = "S", value_parser = length)]
    pub seconds: Option<f64>,
    /// Seeds of the random numbers, the same for all; the points are the mean of the runs [default: the scene's].
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub seeds: Vec<u64>,
    /// Number of scripts that are run at the same time [default: the number of cores].
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Seconds of real time after which a run is ended, without points.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub timeout: f64,
    /// Address space of a run, MB.
    #[arg(long, value_name = "MB", default_value_t = 4096, value_parser = clap::value_parser!(u64).range(256..))]
    pub memory: u64,
    /// Write the results as comma-separated values, for spreadsheets.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with the results and a film of each run into a folder, which is created.
    #[arg(long, value_name = "DIR")]
    pub html: Option<PathBuf>,
    /// Write a file in the format of Gradescope's autograder for each submission into a folder, which is created.
    #[arg(long, value_name = "DIR")]
    pub gradescope: Option<PathBuf>,
    /// Print goals that are not reached as annotations for GitHub Actions.
    #[arg(long)]
    pub github: bool,
    /// Check a grade slip: the line that an earlier grading of the same script has printed.
    #[arg(long, value_name = "SLIP")]
    pub check: Option<String>,
}
