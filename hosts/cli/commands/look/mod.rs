//! `tatu look`: renders a picture of a scene, or of a sensor's reading.
//!
//! `sensor` chooses the type of picture by the schemas of a reading; `scan`, `frame`, `proximity` and `numbers` draw
//! it; `canvas` contains drawing primitives; `file` writes PNG files.

pub mod canvas;
pub mod file;
mod frame;
mod numbers;
mod proximity;
mod scan;
mod sensor;

use std::process::ExitCode;

use nalgebra::Point3;
use tatu_core::{LogLine, World, errors::Error};
use tatu_render::Camera;
use tatu_terminal::{Watchdog, report};

use crate::{addons, args::LookArgs};

/// Renders a picture. The exit code is 0 on success, 1 if an error occurred while the scene ran, and 2 if no picture
/// was written.
pub fn look(args: &LookArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    match take_picture(args, &watchdog) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// Renders the picture; returns whether the scene ran without errors.
fn take_picture(args: &LookArgs, watchdog: &Watchdog) -> Result<bool, Error> {
    let camera = camera(args)?;
    let options = args.changes.options(&[])?;
    let registry = super::registry(Some(&args.scene), &options.sources, &args.changes, watchdog)?;
    let document = super::load(&args.scene, &options, &registry)?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.map_or(all, usize::from);
    let world = World::with_threads(document.clone(), registry.clone(), threads)?;
    addons::choose_addons(&args.addons, &document, &registry)?.attach(&world)?;
    if let Some(folder) = &args.files {
        world.set_file_folder(folder)?;
    }
    if let Some(path) = &args.sensor {
        sensor::find(&world, path)?;
    }
    if !document.requests.services.is_empty() {
        report::note("services are not started by `tatu look`");
    }
    run(&world, args, watchdog);
    let picture = match &args.sensor {
        Some(path) => sensor::picture(&world, path)?,
        None => {
            let camera = camera.unwrap_or_else(|| own_camera(&world, args));
            tatu_render::picture(&world, &camera, &[], !args.no_ground)
        }
    };
    file::write(&args.output, &picture)?;
    world.end();
    print_log(&world);
    watchdog.set_summary_printed();
    let good = world.faults().is_empty();
    drop(world);
    Ok(super::end_plugins(registry) && good)
}

/// Default field of view of a camera, degrees.
const DEFAULT_FOV_DEG: f64 = 50.0;

/// Returns the scene's camera or, if the scene has none or it sees less than half of the scene, a camera that shows
/// everything.
fn own_camera(world: &World, args: &LookArgs) -> Camera {
    let fov = args.fov.map(f64::to_radians);
    let of_scene = tatu_render::scene_camera(world, fov, args.size);
    if let Some((camera, path)) = &of_scene
        && !tatu_render::shows_most(world, camera)
    {
        report::note(&format!(
            "the camera {path} sees less than half of the scene, so the picture shows everything; `--from` and `--to` \
             choose another viewpoint"
        ));
        return tatu_render::framing_camera(world, fov.unwrap_or(DEFAULT_FOV_DEG.to_radians()), args.size);
    }
    match of_scene {
        Some((camera, path)) => {
            report::note(&format!(
                "the picture shows the view of the camera {path}; `--from` and `--to` choose another viewpoint"
            ));
            camera
        }
        None => tatu_render::framing_camera(world, fov.unwrap_or(DEFAULT_FOV_DEG.to_radians()), args.size),
    }
}

/// Returns the camera described on the command line, if any.
fn camera(args: &LookArgs) -> Result<Option<Camera>, Error> {
    let (Some(from), Some(to)) = (args.from, args.to) else { return Ok(None) };
    if from == to {
        let error = Error::new("E102", "--from and --to are the same point: the camera has no direction");
        return Err(error.expected("two different points"));
    }
    let [columns, rows] = args.size;
    let fov = args.fov.unwrap_or(DEFAULT_FOV_DEG).to_radians();
    Ok(Some(Camera { from: Point3::from(from.0), to: Point3::from(to.0), fov, columns, rows }))
}

/// Runs the scene up to the time of the picture.
fn run(world: &World, args: &LookArgs, watchdog: &Watchdog) {
    let least = u64::from(args.sensor.is_some());
    if args.at == 0.0 && least == 0 {
        return;
    }
    watchdog.world(world, false);
    watchdog.begin(None);
    world.start();
    let to_do = |world: &World| world.steps() < least || world.time() < args.at - 1e-9;
    while to_do(world) && !world.stop_requested() {
        let before = world.steps();
        world.step();
        watchdog.step(world.steps(), world.time(), None);
        print_log(world);
        if world.steps() == before {
            break;
        }
    }
    if to_do(world) {
        report::note(&format!("the run ended at {} s; the picture shows that time", world.time()));
    }
}

/// Prints the log of scripts and the host to standard error; only `tatu run` prints it to standard output.
fn print_log(world: &World) {
    world.take_lines().iter().filter_map(LogLine::formatted).for_each(|line| report::err!("{line}"));
}
