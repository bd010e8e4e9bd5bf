//! `tatu serve` and `tatu open`: run scenes that clients control through services. The scene is initially stopped.
//! Clients start and stop it, and open other scenes; only a request to quit, or Ctrl-C, ends the program.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use tatu_core::{
    NextScene, Phase, Session, World,
    document::{Document, SourceFiles},
    errors::Error,
    plugins::Registry,
    session::file::{InputLogHeader, InputLogWriter},
};
use tatu_plugin_api::abi::*;

use super::{
    capsule::{Capsule, refuse_addons, without_folders},
    run::{InputLogFile, write_log},
};
use tatu_terminal::{Watchdog, report};

use crate::{
    addons,
    args::{OpenArgs, ServeArgs},
};

/// Exit code after a second Ctrl-C, by the convention of shells.
const INTERRUPTED_EXIT_CODE: i32 = 130;
/// Name of the scene that is used if none was given.
const EMPTY_SCENE_FILE: &str = "nothing.toml";
/// The scene of `tatu open` if none was given: the page offers scenes instead, among them a new one with a floor.
const EMPTY_SCENE_TEXT: &str = "format = 1\n";
/// The scene of `tatu serve` if none was given: clients load models into it, which need a floor and a picture.
const FLOOR_SCENE_TEXT: &str = "\
format = 1

[[object]]
kind = \"shape\"
alias = \"floor\"
primitive = \"plane\"
respondable = true
detectable = true

[[object]]
kind = \"light\"
alias = \"light\"
position_m = [-2.0, -2.0, 5.0]

[[object]]
kind = \"camera\"
alias = \"camera\"
position_m = [2.0, -2.5, 1.6]
quaternion = [-0.27701, 0.78968, 0.51656, -0.1812]
";
/// Longest wait without checking for input.
const MAX_WAIT: Duration = Duration::from_millis(20);

/// Runs `tatu open`: serves the page, and starts a browser.
pub fn open(args: OpenArgs) -> ExitCode {
    let mut web = format!("web:port={}", args.port);
    web += if args.no_browser { ",browser=false" } else { ",browser=true" };
    let mut serve = args.serve;
    serve.services.insert(0, web);
    serve_or(&serve, EMPTY_SCENE_TEXT)
}

/// Runs `tatu serve`. The exit code is 0 on success, 1 if an error occurred, and 2 if no scene could be opened.
pub fn serve(args: &ServeArgs) -> ExitCode {
    serve_or(args, FLOOR_SCENE_TEXT)
}

/// Serves the scene of the arguments, or the text of one if none was given.
fn serve_or(args: &ServeArgs, text: &'static str) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    match start(args, text, &watchdog) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn start(args: &ServeArgs, text: &'static str, watchdog: &Watchdog) -> Result<ExitCode, Error> {
    let options = args.changes.options(&args.services)?;
    let registry = super::registry(args.scene.as_deref(), &options.sources, &args.changes, watchdog)?;
    let mut document = read(args, text, args.scene.as_deref(), None, &registry)?;
    if document.requests.services.is_empty() {
        return Err(Error::new("E404", "no service was given, so no client could start this scene").help(
            "add a service, such as `tatu serve SCENE --service jsonl`, or use `tatu open`, which serves a page",
        ));
    }
    let session = Session::new(registry.clone(), &document.requests.services)?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            tatu_terminal::stuck_run::leave(INTERRUPTED_EXIT_CODE);
        }
    });
    session.set_interrupt_flag(interrupted.clone());
    let mut failed = false;
    let mut log = None;
    let (mut scene, mut starts) = (args.scene.clone(), false);
    let mut before = None;
    // Services tell worlds apart by their addresses, so a world is dropped only when the next one has its own.
    let mut ended_world = None;
    loop {
        let world = match create_world(args, &document, &registry) {
            Ok(world) => world,
            // The new scene was read but could not be created: reopen the previous one.
            Err(e) => match before.take() {
                Some(earlier) => {
                    report::error(&e);
                    failed = true;
                    ((document, scene), starts) = (earlier, false);
                    continue;
                }
                None => {
                    session.end().iter().for_each(report::error);
                    return Err(e);
                }
            },
        };
        drop(ended_world.take());
        watchdog.world(&world, false);
        watchdog.begin(None);
        world.set_scene_reader(scene_reader(args, text, scene.clone(), &registry));
        world.set_interactive(true);
        session.join(&world);
        if log.is_none() {
            log = SessionLog::create(args, scene.as_deref(), &world)?;
        }
        let next = run_scene(args, &world, &session, (&interrupted, &mut log), starts);
        log.iter_mut().for_each(|log| log.end(&world));
        failed |= !world.faults().is_empty();
        world.stop();
        world.end();
        print_log(&world);
        ended_world = Some(world);
        match next {
            Some(next) => {
                before = Some((document, scene.clone()));
                (document, starts) = (next.document, next.starts);
                if !next.file.as_os_str().is_empty() {
                    scene = Some(next.file);
                }
            }
            None => break,
        }
    }
    drop(ended_world);
    let badly_ended = session.end();
    badly_ended.iter().for_each(report::error);
    watchdog.set_summary_printed();
    let good = super::end_plugins(registry) && !failed && badly_ended.is_empty();
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Reads a scene, or `text` without one, and applies the changes and the services of the command line; services that the
/// scene names are ignored. Files in `sources` are not read from disk.
fn read(
    args: &ServeArgs,
    text: &str,
    scene: Option<&Path>,
    sources: Option<SourceFiles>,
    registry: &Registry,
) -> Result<Arc<Document>, Error> {
    let mut options = args.changes.options(&args.services)?;
    let nothing = PathBuf::from(EMPTY_SCENE_FILE);
    if let Some(sources) = sources {
        options.sources = sources;
    } else if scene.is_none() {
        options.sources = SourceFiles::of(vec![(nothing.clone(), text.as_bytes().to_vec())]);
    }
    let document = super::load(scene.unwrap_or(&nothing), &options, registry)?;
    let named = |id: &str| args.services.iter().any(|s| s.split(':').next() == Some(id));
    if document.requests.services.iter().all(|s| named(&registry.services[s.kind].id)) {
        return Ok(document);
    }
    let mut own = Document::clone(&document);
    own.requests.services.retain(|s| named(&registry.services[s.kind].id));
    Ok(Arc::new(own))
}

/// Creates the world of a document, with the add-ons and the folder chosen on the command line.
fn create_world(args: &ServeArgs, document: &Arc<Document>, registry: &Arc<Registry>) -> Result<World, Error> {
    let world = World::with_threads(document.clone(), registry.clone(), args.threads.into())?;
    let addons = addons::choose_addons(&args.addons, document, registry)?;
    if args.capsule.is_some() {
        refuse_addons(&addons.entries())?;
    }
    addons.attach(&world)?;
    if let Some(folder) = &args.files {
        world.set_file_folder(folder)?;
    }
    Ok(world)
}

/// Returns a function that reads the scene that a client opens; if its path is empty, `scene` or `text`, which is open
/// now, is read again.
fn scene_reader(
    args: &ServeArgs,
    text: &'static str,
    scene: Option<PathBuf>,
    registry: &Arc<Registry>,
) -> impl Fn(&Path, Option<SourceFiles>) -> Result<Arc<Document>, Error> + 'static {
    let (args, registry) = (args.clone(), registry.clone());
    move |file, sources| {
        let file = if file.as_os_str().is_empty() { scene.as_deref() } else { Some(file) };
        read(&args, text, file, sources, &registry)
    }
}

/// Runs one world until another scene is opened or the program ends. If `starts` is set, the simulation starts
/// immediately.
fn run_scene(
    args: &ServeArgs,
    world: &World,
    session: &Session,
    (interrupted, log): (&AtomicBool, &mut Option<SessionLog>),
    mut starts: bool,
) -> Option<NextScene> {
    // Nobody reads this input log, and it would grow without bound.
    world.input_log_mut().store_records(false);
    loop {
        let started = std::mem::take(&mut starts) || session.wait_for_start(world);
        print_log(world);
        if interrupted.load(Ordering::Relaxed) {
            return None;
        }
        if started {
            run(args, world, (interrupted, log));
        }
        if let Some(next) = world.next_scene() {
            return Some(next);
        }
        if !started {
            return None;
        }
        print_log(world);
    }
}

/// Runs the simulation from a start to the next stop.
fn run(args: &ServeArgs, world: &World, (interrupted, log): (&AtomicBool, &mut Option<SessionLog>)) {
    world.start();
    log.iter_mut().for_each(|log| log.step(world));
    let began = Instant::now();
    while world.phase() != Phase::Stopped {
        if interrupted.load(Ordering::Relaxed) {
            world.request_stop();
        }
        if args.realtime && world.phase() != Phase::Paused {
            while let Some(left) = Duration::try_from_secs_f64(world.time() - began.elapsed().as_secs_f64()).ok()
                && !left.is_zero()
                && !interrupted.load(Ordering::Relaxed)
            {
                std::thread::sleep(left.min(MAX_WAIT));
            }
        }
        let before = world.steps();
        world.step();
        if world.steps() > before {
            log.iter_mut().for_each(|log| log.step(world));
        }
        if world.stop_requested() {
            log.iter_mut().for_each(|log| log.end(world));
        }
        print_log(world);
    }
}

/// The input log of the first scene, until its first stop.
struct SessionLog {
    inputs: InputLogFile,
    /// The record of the run, of which the log is a part.
    capsule: Option<Capsule>,
}

impl SessionLog {
    /// Begins the log that the arguments request, if they do.
    fn create(args: &ServeArgs, scene: Option<&Path>, world: &World) -> Result<Option<Self>, Error> {
        let (document, registry) = (world.document(), world.registry());
        let (writer, capsule) = match (&args.log, &args.capsule) {
            (Some(file), _) => {
                let c = &args.changes;
                let mut header = InputLogHeader::new(&document, &registry, c.seed, c.set.clone(), c.scripts.clone());
                header.session = true;
                (InputLogWriter::create(file, &header)?, None)
            }
            (None, Some(output)) => {
                let scene = scene.unwrap_or(Path::new(EMPTY_SCENE_FILE));
                let (capsule, writer) = Capsule::begin(output, scene, (&document, &registry), &[], true)?;
                (writer, Some(capsule))
            }
            (None, None) => return Ok(None),
        };
        let inputs = write_log(world, writer);
        world.input_log_mut().include_session();
        Ok(Some(SessionLog { inputs, capsule }))
    }
    /// Records the hashes after a step, or after the start.
    fn step(&mut self, world: &World) {
        self.capsule.iter_mut().for_each(|capsule| capsule.step(world));
    }
    /// Writes the end of the log; further calls do nothing.
    fn end(&mut self, world: &World) {
        let Some(log) = self.inputs.borrow_mut().take() else { return };
        let mut opened = world.files_opened();
        if self.capsule.is_some() {
            opened = without_folders(&opened);
        }
        let written = log.end(world.steps(), true, &opened, world.hash().total);
        if let Err(e) = written.and_then(|()| self.capsule.take().map_or(Ok(()), Capsule::write)) {
            report::report_lost_output(&e);
        }
    }
}

/// Prints log lines to standard error.
fn print_log(world: &World) {
    for line in world.take_lines() {
        match line.level {
            TATU_LOG_ERROR => {
                report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text)
            }
            TATU_LOG_WARNING => report::warn_text(&line.text),
            TATU_LOG_DEBUG => tracing::debug!("{}", line.text),
            TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {}
            _ => report::err!("{}", line.text),
        }
    }
}
