//! `tatu serve` and `tatu open`: a program that services steer. It begins stopped; a start, a stop and another scene come
//! from outside, and only a request to quit, or Ctrl-C, ends it.

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
    document::{Document, Sources},
    errors::Error,
    plugins::Registry,
};
use tatu_plugin_api::abi::*;

use crate::{
    addons,
    args::{Open, Serve},
    report,
    watchdog::Watchdog,
};

/// Exit code after a second Ctrl-C, as shells know it.
const INTERRUPTED: i32 = 130;
/// The name of the scene that is there where none was given.
const NOTHING: &str = "nothing.toml";
const NOTHING_TEXT: &str = "format = 1\n";
/// How long a wait lasts before anything else is looked at.
const SLICE: Duration = Duration::from_millis(20);

/// `tatu open`: the page, and a browser.
pub fn open(args: Open) -> ExitCode {
    let mut web = format!("web:port={}", args.port);
    web += if args.no_browser { ",browser=false" } else { ",browser=true" };
    let mut serve = args.serve;
    serve.services.insert(0, web);
    self::serve(&serve)
}

/// Exit code 0; 1 if something went wrong while it ran; 2 if nothing could be started.
pub fn serve(args: &Serve) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    match start(args, &watchdog) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn start(args: &Serve, watchdog: &Watchdog) -> Result<ExitCode, Error> {
    let options = args.changes.options(&args.services)?;
    let registry = super::registry(args.scene.as_deref(), &options.sources, &args.changes.allow, watchdog)?;
    let mut document = read(args, args.scene.as_deref(), &registry)?;
    if document.services.is_empty() {
        return Err(Error::new("E404", "nothing could start this scene: no service was given")
            .help("name one: `tatu serve SCENE --service jsonl`; `tatu open` serves a page"));
    }
    let session = Session::new(registry.clone(), &document.services)?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            crate::watchdog::leave(INTERRUPTED);
        }
    });
    session.interrupt_by(interrupted.clone());
    let mut failed = false;
    let (mut scene, mut starts) = (args.scene.clone(), false);
    let mut before = None;
    loop {
        let world = match make(args, &document, &registry) {
            Ok(world) => world,
            // What was read could not be made: the scene before it is opened again.
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
        watchdog.world(&world, false);
        watchdog.begin(None);
        world.take_scenes(reader(args, scene.clone(), &registry));
        world.set_interactive(true);
        session.join(&world);
        let next = live(args, &world, &session, &interrupted, starts);
        failed |= !world.faults().is_empty();
        world.stop();
        world.end();
        tell(&world);
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
    let badly_ended = session.end();
    badly_ended.iter().for_each(report::error);
    watchdog.told();
    let good = super::end(registry) && !failed && badly_ended.is_empty();
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A scene as the command line changes it, with the services of the command line and no others.
fn read(args: &Serve, scene: Option<&Path>, registry: &Registry) -> Result<Arc<Document>, Error> {
    let mut options = args.changes.options(&args.services)?;
    let nothing = PathBuf::from(NOTHING);
    if scene.is_none() {
        options.sources = Sources::of(vec![(nothing.clone(), NOTHING_TEXT.as_bytes().to_vec())]);
    }
    let document = super::load(scene.unwrap_or(&nothing), &options, registry)?;
    let named = |id: &str| args.services.iter().any(|s| s.split(':').next() == Some(id));
    if document.services.iter().all(|s| named(&registry.services[s.kind].id)) {
        return Ok(document);
    }
    let mut own = Document::clone(&document);
    own.services.retain(|s| named(&registry.services[s.kind].id));
    Ok(Arc::new(own))
}

/// The world of a document, with the add-ons and the folder that the command line chooses.
fn make(args: &Serve, document: &Arc<Document>, registry: &Arc<Registry>) -> Result<World, Error> {
    let world = World::with_threads(document.clone(), registry.clone(), args.threads.into())?;
    addons::choose(&args.addons, document, registry)?.attach(&world)?;
    if let Some(folder) = &args.files {
        world.open_files_in(folder)?;
    }
    Ok(world)
}

/// What reads the scene that somebody asks for while `scene` is there.
fn reader(
    args: &Serve,
    scene: Option<PathBuf>,
    registry: &Arc<Registry>,
) -> impl Fn(&Path) -> Result<Arc<Document>, Error> + 'static {
    let (args, registry) = (args.clone(), registry.clone());
    move |file| {
        let file = if file.as_os_str().is_empty() { scene.as_deref() } else { Some(file) };
        read(&args, file, &registry)
    }
}

/// The life of one world: until another scene is asked for, or the end. `starts`: it begins with a start.
fn live(
    args: &Serve,
    world: &World,
    session: &Session,
    interrupted: &AtomicBool,
    mut starts: bool,
) -> Option<NextScene> {
    // Nobody can ask for what came in, and clients send without end.
    world.input_log_mut().keep(false);
    loop {
        let started = std::mem::take(&mut starts) || session.wait_for_start(world);
        tell(world);
        if interrupted.load(Ordering::Relaxed) {
            return None;
        }
        if started {
            run(args, world, interrupted);
        }
        if let Some(next) = world.next_scene() {
            return Some(next);
        }
        if !started {
            return None;
        }
        tell(world);
    }
}

/// From a start to a stop.
fn run(args: &Serve, world: &World, interrupted: &AtomicBool) {
    world.start();
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
                std::thread::sleep(left.min(SLICE));
            }
        }
        world.step();
        tell(world);
    }
}

/// Log lines go on: those of the status bar to standard output, all else to standard error.
fn tell(world: &World) {
    for line in world.take_lines() {
        match line.level {
            TATU_LOG_ERROR => {
                report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text)
            }
            TATU_LOG_WARNING => report::warned(&line.text),
            TATU_LOG_DEBUG => tracing::debug!("{}", line.text),
            TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {}
            _ => report::err!("{}", line.text),
        }
    }
}
