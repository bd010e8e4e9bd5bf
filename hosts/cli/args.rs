//! The command line: declares and validates all arguments.

use std::{ffi::OsString, path::PathBuf};

use clap::{Parser, Subcommand, ValueEnum};
use tatu_core::{document::LoadOptions, errors::Error};
use tatu_embed::{SceneSource, WorldSetup};
use tatu_plugin_tools::PluginCommand;

use crate::{
    test_args::{GradeArgs, TestArgs},
    values::{WorldPoint, angle, length, permission, point, scene, seconds, shard, size, speed},
};

/// Tatu, a robot simulator made of a small core and plugins.
#[derive(Parser)]
#[command(version, about)]
pub struct CliArgs {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
#[allow(clippy::large_enum_variant, reason = "a process creates one value")]
pub enum Command {
    /// Run a scene.
    Run(RunArgs),
    /// Serve a scene to remote clients and views, which start, stop and change it while the program keeps running.
    Serve(ServeArgs),
    /// Open a scene in the browser: view it, control it, change its scripts.
    Open(OpenArgs),
    /// Check whether a scene can run, and report its problems.
    Check(CheckArgs),
    /// Convert a scene of any format to a scene file, with its meshes and scripts in files next to it.
    Convert(ConvertArgs),
    /// Pack a scene with its models, meshes and scripts into one file, which runs the same on other computers.
    Pack(PackArgs),
    /// Unpack a packed scene into a folder.
    Unpack(UnpackArgs),
    /// Run scenes as tests: report which have errors, or goals that are not reached.
    Test(TestArgs),
    /// Run many scripts in one scene, and award points for the goals that each reaches.
    Grade(GradeArgs),
    /// Repeat a recorded run: report whether it is the same, or where it differs.
    Verify(VerifyArgs),
    /// Import a robot or scene of another format: report what was taken, assumed and left out, and write it as a model.
    Import(ImportArgs),
    /// Export a robot or a scene to a URDF or MJCF file, with its meshes in files next to it: report what it cannot hold.
    Export(ExportArgs),
    /// List what plugins provide.
    List(ListArgs),
    /// Describe a plugin, kind of sensor, actuator or part, model, importer, script language, service, schema, object kind or
    /// command.
    Describe(DescribeArgs),
    /// Measure the behaviour of a model, and compare it with its data sheet.
    Measure(MeasureArgs),
    /// Render a picture of a scene, or of what one of its sensors measures; no display is needed.
    Look(LookArgs),
    /// Compare two traces: report the first step, and the first object in it, that differ.
    Diff(DiffArgs),
    /// Create a folder to start with: a plugin, an add-on, a scene, a robot or a course.
    New(tatu_plugin_tools::new::NewArgs),
    /// Run a scene many times, with seeds and parameters from a file, and write a row for each run.
    Sweep(SweepArgs),
    /// Record which plugins and models are loaded for a scene, with versions and hashes, or compare them.
    Lock(LockArgs),
    /// Build, run, test, check and install plugins.
    #[command(subcommand)]
    Plugin(PluginCommand),
    /// A subcommand of a plugin.
    #[command(external_subcommand)]
    Of(Vec<OsString>),
    /// Print the manual page, completions for a shell, or declarations of commands for Python.
    #[command(hide = true)]
    Generate(GenerateArgs),
}

/// Changes to a scene.
#[derive(Clone, Default, clap::Args)]
pub struct SceneChanges {
    /// Seed of all random numbers, instead of the scene's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Set a property or model parameter: `/Robot/leftMotor.max_force_nm=2`, `scene.dt_s=0.01`.
    #[arg(long = "set", value_name = "PATH=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
    /// Grant permissions: `exec` lets scripts start programs, and `native` lets them load libraries; such a run cannot
    /// be repeated. `net=HOST:PORT` lets scripts open sockets; `*` stands for any host or port. `plugins` loads plugins
    /// from the folders that the scene names. Some script languages need a permission of their own, such as `python`.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = permission)]
    pub allow: Vec<String>,
    /// Set parameters of a script language: `ID:KEY=VALUE,KEY=VALUE`, such as `python:interpreter=PATH`.
    #[arg(long = "language", value_name = "ID:KEY=VALUE")]
    pub languages: Vec<String>,
    /// A folder that contains ROS packages, or is one, to which `package://` in files of robots refers.
    #[arg(long, value_name = "DIR")]
    pub package_path: Vec<PathBuf>,
    /// Replace an object's script: `/Robot=my_controller.lua`. With `--stand-ins`: the script to run.
    #[arg(long = "script", value_name = "[OBJECT=]FILE")]
    pub scripts: Vec<String>,
}

/// Options of every subcommand of a plugin.
#[derive(Clone, Default, clap::Args)]
pub struct ExternalArgs {
    /// The scene to act on, or the name of a scene that comes with the program [default: an empty scene].
    #[arg(long, value_name = "FILE", value_parser = scene())]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub changes: SceneChanges,
}

#[derive(clap::Args)]
pub struct RunArgs {
    /// The scene file, or the name of a scene that comes with the program.
    #[arg(value_parser = scene())]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub changes: SceneChanges,
    #[command(flatten)]
    pub stand_in_script: StandInArgs,
    /// Start a service: `ID`, or `ID:KEY=VALUE,KEY=VALUE`.
    #[arg(long = "service", value_name = "ID")]
    pub services: Vec<String>,
    #[command(flatten)]
    pub addons: crate::addons::AddonFlags,
    /// The folder in which scripts open files [default: the working folder].
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    #[command(flatten)]
    pub input_log: InputLogArgs,
    #[command(flatten)]
    pub length: LengthArgs,
    /// Number of threads; the results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    #[command(flatten)]
    pub pace: PaceArgs,
    #[command(flatten)]
    pub records: RecordArgs,
    /// Seconds of real time after which a plugin call that has not returned ends the run; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
    /// Add the hash of each object to the trace, so that `tatu diff` can name the one that differs.
    #[arg(long)]
    pub hashes: bool,
    #[command(flatten)]
    pub snapshots: SnapshotArgs,
    /// Reload scripts, models and plugins that change during the run at the next step; such a run cannot be replayed.
    #[arg(long, conflicts_with_all = ["log", "replay", "snapshot_at", "from"])]
    pub reload: bool,
    #[command(flatten)]
    pub ending: EndingArgs,
}

/// A script that is run without its scene.
#[derive(clap::Args)]
pub struct StandInArgs {
    /// Run the script given by `--script FILE` without its scene; the objects that it looks up are created, with
    /// kinds that fit its calls.
    #[arg(long, conflicts_with_all = ["scene", "replay", "from", "reload"], requires = "scripts")]
    pub stand_ins: bool,
    /// Kind of the script, instead of the kind inferred from its source: main, child, threaded, customization, add-on
    /// or module.
    #[arg(long = "as", value_name = "KIND", requires = "stand_ins")]
    pub kind: Option<ScriptKind>,
}

/// The record of inputs.
#[derive(clap::Args)]
pub struct InputLogArgs {
    /// Record all outside input in a file, with everything needed for a replay.
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Record the run in a file that `tatu verify` repeats and that can be opened like a scene: the packed scene, all
    /// outside input, and the hash of every step. Its name must end with `.tatu`.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["log", "replay", "from", "reload", "stand_ins"])]
    pub capsule: Option<PathBuf>,
    /// Put this file into the record too, which must be below the folder of the scene: data that scripts read.
    #[arg(long = "capsule-file", value_name = "FILE", requires = "capsule")]
    pub capsule_files: Vec<PathBuf>,
    /// Replay an input log; no scene is needed, and no service is started.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "seed", "set", "scripts", "services", "addons", "no_addons", "without"])]
    pub replay: Option<PathBuf>,
}

/// The length of a run.
#[derive(clap::Args)]
pub struct LengthArgs {
    /// Seconds of simulation time to run, `inf`: until it is stopped [default: the scene's `duration_s`, or 10; with a
    /// service or `--interactive`: until it is stopped].
    #[arg(long, value_name = "S", conflicts_with = "steps", allow_negative_numbers = true, value_parser = length)]
    pub seconds: Option<f64>,
    /// Number of steps to run.
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
}

/// The pace of a run, and its keys.
#[derive(clap::Args)]
pub struct PaceArgs {
    /// Read key presses from a file with lines `TIME KEY`; KEY is a character, a name such as `up`, or the API's code.
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    pub keys: Option<PathBuf>,
    /// Run in real time; scripts then read the real clock.
    #[arg(long, conflicts_with = "replay")]
    pub realtime: bool,
    /// Run at this multiple of real time.
    #[arg(long, value_name = "F", conflicts_with = "replay", value_parser = speed)]
    pub speed: Option<f64>,
    /// Read keys from the terminal: F5 play or pause, F6 one step, F7 stop, + and - change the speed; all other keys
    /// are passed to scripts.
    #[arg(long, conflicts_with = "replay")]
    pub interactive: bool,
}

/// What is recorded.
#[derive(clap::Args)]
pub struct RecordArgs {
    /// Write one JSON line per step to a file.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Add an object's pose and velocity, and a sensor's readings, to the trace.
    #[arg(long, value_name = "PATH", requires = "trace")]
    pub watch: Vec<String>,
    /// Write the recorded data of graphs into a folder at the end of the run: `<graph>.csv` and `<graph>.png`.
    #[arg(long, value_name = "DIR")]
    pub graphs: Option<PathBuf>,
    /// Write the run as a film: a page that any browser can play from disk.
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    pub html: Option<PathBuf>,
}

/// Snapshots that are written, or continued.
#[derive(clap::Args)]
pub struct SnapshotArgs {
    /// Write the state of the run to a file at T seconds of simulation time, and continue; may be given several times.
    #[arg(long, value_names = ["T", "FILE"], num_args = 2, action = clap::ArgAction::Append)]
    pub snapshot_at: Vec<String>,
    /// Continue from a file written by `--snapshot-at` with the same scene; times are still counted from 0.
    #[arg(long, value_name = "FILE", conflicts_with = "addons")]
    pub from: Option<PathBuf>,
}

/// The end of a run.
#[derive(clap::Args)]
pub struct EndingArgs {
    /// Save the scene at the end of the run, before scripts clean up, as a scene file with meshes and scripts next to
    /// it.
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Judge the run by a script, which checks goals and which the scripts of the scene can neither see nor affect. The
    /// exit code is 3 if a goal fails.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["log", "replay", "capsule", "from", "reload", "stand_ins"])]
    pub criteria: Option<PathBuf>,
    /// Treat warnings as errors: one before the start prevents the run, one during the run makes the exit code 1.
    #[arg(long)]
    pub strict: bool,
    /// Print a summary in JSON on standard output at the end; everything else goes to standard error.
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, clap::Args)]
pub struct ServeArgs {
    /// The scene file, or a file that an importer reads; if omitted, a client must open a scene.
    #[arg(value_parser = scene())]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Start a service: `ID`, or `ID:KEY=VALUE,KEY=VALUE`. Services that the scene names are not started.
    #[arg(long = "service", value_name = "ID")]
    pub services: Vec<String>,
    #[command(flatten)]
    pub addons: crate::addons::AddonFlags,
    /// The folder in which scripts open files [default: the working folder].
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Number of threads; the results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Run in real time; a page sets its own pace.
    #[arg(long)]
    pub realtime: bool,
    /// Record the actions of clients on the first scene, up to its first stop, for `tatu run --replay`.
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Record the first scene, up to its first stop, in a file that `tatu verify` repeats and that can be opened like a
    /// scene. Its name must end with `.tatu`.
    #[arg(long, value_name = "FILE", conflicts_with = "log")]
    pub capsule: Option<PathBuf>,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct OpenArgs {
    #[command(flatten)]
    pub serve: ServeArgs,
    /// Port on which the page is served, on this machine only; 0: any free port.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Do not start a browser: only print the address of the page.
    #[arg(long)]
    pub no_browser: bool,
}

#[derive(clap::Args)]
pub struct ConvertArgs {
    /// The scene file, or a file that an importer reads.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// The scene file to write; its name must end with `.toml`.
    pub output: PathBuf,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct PackArgs {
    /// The scene file, or a file that an importer reads.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// The file to write; its name must end with `.tatu`.
    pub output: PathBuf,
    /// Pack this file too, which must be below the folder of the scene: data that scripts read.
    #[arg(long = "file", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct UnpackArgs {
    /// The packed scene.
    pub file: PathBuf,
    /// The folder to write, which must be empty or absent [default: the name of the file without its suffix].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

#[derive(clap::Args)]
pub struct VerifyArgs {
    /// The recorded run, which `--capsule` of `tatu run`, `tatu serve` or `tatu open` has written.
    pub file: PathBuf,
    /// Grant permissions that the scene requests: see `tatu run --help`.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = permission)]
    pub allow: Vec<String>,
    /// Set parameters of a script language: `ID:KEY=VALUE,KEY=VALUE`.
    #[arg(long = "language", value_name = "ID:KEY=VALUE")]
    pub languages: Vec<String>,
    /// Number of threads; the results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Print the result in JSON.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

impl VerifyArgs {
    /// The changes to the scene that do not change its run.
    pub fn changes(&self) -> SceneChanges {
        SceneChanges { allow: self.allow.clone(), languages: self.languages.clone(), ..SceneChanges::default() }
    }
}

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  tatu import robot.urdf\n  tatu import robot.xml -o models/my_robot --strict")]
pub struct ImportArgs {
    /// The file, which an importer reads: `tatu list importers`.
    pub file: PathBuf,
    /// The folder to write: `model.toml`, its meshes, and a README with the report [default: only report].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Fail, and write nothing, if a part of the file was changed or left out.
    #[arg(long)]
    pub strict: bool,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  tatu export pioneer_p3dx -o pioneer.urdf\n  tatu export scene.toml -o scene.xml\n  tatu \
                  export scene.toml --object /arm -o out/arm.urdf --strict"
)]
pub struct ExportArgs {
    /// The scene file, the file of a robot, or the id of a model.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// The file to write, whose suffix chooses the format: `.urdf`, or `.xml` for MJCF.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Export only this object, with all that is below it [default: the whole scene].
    #[arg(long, value_name = "PATH")]
    pub object: Option<String>,
    /// Fail, and write nothing, if a part of the scene was changed or left out.
    #[arg(long)]
    pub strict: bool,
    /// Replace existing files.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct SweepArgs {
    /// The sweep file: scene, seconds, seeds, a grid of parameters, and metrics.
    pub file: PathBuf,
    /// Run only every N-th job, starting with job I, counted from 0: splits a sweep over N machines or tasks.
    #[arg(long, value_name = "I/N", default_value = "0/1", value_parser = shard)]
    pub shard: (usize, usize),
    /// The file of rows, in JSON lines; jobs whose rows it already contains are not run again [default: standard
    /// output].
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Number of jobs that are run at the same time [default: the number of cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

#[derive(clap::Args)]
pub struct GenerateArgs {
    pub what: GeneratedFile,
}

/// Files that packages of the program contain besides the binary.
#[derive(Clone, Copy, ValueEnum)]
pub enum GeneratedFile {
    Man,
    Bash,
    Zsh,
    Fish,
    /// Declarations of all commands for Python's type checkers.
    Python,
}

#[derive(clap::Args)]
pub struct LockArgs {
    /// The scene file; the record is a file beside it, with the suffix `.lock` instead of its own.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// Compare with the record instead of writing it; exit code 1 if anything differs.
    #[arg(long)]
    pub check: bool,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct CheckArgs {
    /// The scene file.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// Print in JSON what the file contains, as far as its importer can describe it, and all reports about it.
    #[arg(long)]
    pub json: bool,
    /// Print in JSON the masses, joints, and poses at three configurations, for comparison with other programs; SI units.
    #[arg(long, conflicts_with = "json")]
    pub numbers: bool,
    #[command(flatten)]
    pub changes: SceneChanges,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
#[command(after_help = LOOK_EXAMPLES)]
pub struct LookArgs {
    /// The scene file.
    #[arg(value_parser = scene())]
    pub scene: PathBuf,
    /// Position of the camera: X,Y,Z in the world frame, m [default: the scene's first camera, or a position from which
    /// everything is visible].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point, requires = "to")]
    pub from: Option<WorldPoint>,
    /// Point at the centre of the picture: X,Y,Z in the world frame, m.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = point, requires = "from")]
    pub to: Option<WorldPoint>,
    /// Show the last reading of this sensor instead, by path or unique name.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["from", "to", "fov"])]
    pub sensor: Option<String>,
    /// Seconds of simulation time to run first; 0: show the scene as loaded, or a sensor's reading after one step.
    #[arg(long, value_name = "T", default_value_t = 0.0, allow_negative_numbers = true, value_parser = seconds)]
    pub at: f64,
    /// Size of a picture of the scene in pixels: COLUMNSxROWS.
    #[arg(long, value_name = "CxR", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// Horizontal field of view, degrees [default: 50, or that of the scene's camera].
    #[arg(long, value_name = "DEG", value_parser = angle)]
    pub fov: Option<f64>,
    /// Do not add a floor below a scene that has none.
    #[arg(long, conflicts_with = "sensor")]
    pub no_ground: bool,
    /// The PNG file to write.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub changes: SceneChanges,
    #[command(flatten)]
    pub addons: crate::addons::AddonFlags,
    /// The folder in which scripts open files [default: the working folder].
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Number of threads; the picture does not depend on it [default: one for each core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seconds of real time after which a plugin call that has not returned ends the run; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

const LOOK_EXAMPLES: &str = "Examples:
  tatu look scenes/first/pioneer_avoids_walls.toml -o scene.png
  tatu look scenes/first/pioneer_avoids_walls.toml --from -3,-4,3 --to 0,0,0.2 -o scene.png
  tatu look scenes/first/pioneer_avoids_walls.toml --sensor Pioneer_p3dx_ultrasonicSensor5 --at 3 -o sonar.png";

#[derive(clap::Args)]
pub struct DiffArgs {
    /// A trace, as `tatu run --trace` writes it.
    pub a: PathBuf,
    /// The trace to compare it with.
    pub b: PathBuf,
}

#[derive(clap::Args)]
pub struct ListArgs {
    /// What to list.
    pub what: ListedKind,
    /// A scene whose plugin folders are searched too.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// `plugins`: load plugins from the folders that the scene names.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = ["plugins"])]
    pub allow: Vec<String>,
    /// Print a JSON array.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
pub struct DescribeArgs {
    /// One or more ids; a command may be given by any of its names.
    #[arg(value_name = "ID", required_unless_present = "all")]
    pub ids: Vec<String>,
    /// Describe all commands, as pages.
    #[arg(long, requires = "markdown")]
    pub all: bool,
    /// Folder to which the pages are written, one for each subject of commands.
    #[arg(long, value_name = "DIR", requires = "all")]
    pub markdown: Option<PathBuf>,
    /// Write a PNG picture of a model that is stored in a folder, or a sheet of several such models.
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// A scene whose plugin folders are searched too.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// `plugins`: load plugins from the folders that the scene names.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = ["plugins"])]
    pub allow: Vec<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  tatu measure bubblerob\n  tatu measure models/my_robot --write")]
pub struct MeasureArgs {
    /// The model: its id, its folder or its file.
    pub model: String,
    /// Run only these measures.
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write the measured values into the card.
    #[arg(long)]
    pub write: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin call that has not returned ends the program; 0: never.
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds)]
    pub watchdog: f64,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum ListedKind {
    Plugins,
    Models,
    Sensors,
    Actuators,
    Parts,
    Importers,
    Commands,
    Services,
    Events,
    Addons,
}

/// Kind of a script that is run without a scene.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ScriptKind {
    Main,
    Child,
    Threaded,
    Customization,
    AddOn,
    Module,
}

impl SceneChanges {
    /// Returns the changes to the scene as the core's loading options.
    pub fn options(&self, services: &[String]) -> Result<LoadOptions, Error> {
        let changes = WorldSetup {
            seed: self.seed,
            set: self.set.clone(),
            scripts: self.scripts.clone(),
            allow: self.allow.clone(),
            services: services.to_vec(),
            languages: self.languages.clone(),
            ..WorldSetup::new(SceneSource::File(PathBuf::new()))
        };
        changes.options()
    }
}
