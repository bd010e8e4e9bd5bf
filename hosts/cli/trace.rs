//! Writes the trace of a run: one JSON line per step.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use serde_json::{Map, Value as Json, json};
use tatu_core::{LogLine, World, errors::Error};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_terminal::stuck_run::SharedFile;

/// The trace file, if one is requested.
pub struct Trace {
    file: Option<(SharedFile, PathBuf)>,
    watched: Vec<String>,
    hashes: bool,
}

impl Trace {
    /// Opens the file. Fails with E110 if an object to watch does not exist.
    pub fn open(path: Option<&Path>, watch: &[String], hashes: bool, world: &World) -> Result<Self, Error> {
        for w in watch {
            if world.observe(w).is_none() {
                let error = Error::new("E110", format!("--watch: there is no object `{w}`"));
                return Err(match world.nearest(w) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error,
                });
            }
        }
        for (option, given) in [("--watch", !watch.is_empty()), ("--hashes", hashes)] {
            if given && path.is_none() {
                let error = Error::new("E114", format!("{option} has no effect without --trace"));
                tatu_terminal::report::warning(&error.help("add `--trace FILE`"));
            }
        }
        let file = match path {
            None => None,
            Some(p) => {
                let file = File::create(p)
                    .map_err(|e| Error::new("E105", format!("cannot write the trace {}: {e}", p.display())))?;
                Some((Arc::new(Mutex::new(BufWriter::new(file))), p.to_owned()))
            }
        };
        Ok(Trace { file, watched: watch.to_vec(), hashes })
    }

    /// Returns the file, for the watchdog.
    pub fn shared(&self) -> Option<SharedFile> {
        self.file.as_ref().map(|(file, _)| file.clone())
    }

    /// Writes the line of the step that was just run. `stopping` is set if a stop was requested before the step.
    pub fn step(&mut self, world: &World, lines: &[LogLine], stopping: bool) -> Result<(), Error> {
        if self.file.is_none() {
            return Ok(());
        }
        let mut objects = Map::new();
        let mut readings = Map::new();
        for seen in self.watched.iter().filter_map(|w| world.observe(w)) {
            let mut o = json!({
                "position": seen.pose[..3],
                "quaternion": seen.pose[3..],
                "linear_velocity": seen.twist[..3],
                "angular_velocity": seen.twist[3..],
            });
            if let Some([position, velocity, effort]) = seen.joint {
                o["joint"] = json!({ "position": position, "velocity": velocity, "effort": effort });
            }
            if let Some(fields) = seen.reading {
                readings.insert(seen.path.clone(), fields.into_iter().map(|(k, v)| (k, to_json(v))).collect());
            }
            objects.insert(seen.path, o);
        }
        let statusbar: Vec<&str> =
            lines.iter().filter(|l| l.level == TATU_LOG_STATUS).map(|l| l.text.as_str()).collect();
        let hash = world.hash();
        let mut line = json!({
            "step": world.steps(),
            "time": world.time(),
            "hash": format!("{:016x}", hash.total),
            "objects": objects,
            "statusbar": statusbar,
            "console": consoles(lines),
            "readings": readings,
        });
        if stopping {
            line["stopping"] = json!(true);
        }
        if self.hashes {
            let of = |(path, hash): (String, u64)| (path, json!(format!("{hash:016x}")));
            line["hashes"] = Json::Object(hash.objects.into_iter().map(of).collect());
        }
        self.write(&line)
    }

    fn write(&mut self, line: &Json) -> Result<(), Error> {
        let Some((file, path)) = &mut self.file else { return Ok(()) };
        let written = writeln!(file.lock().unwrap_or_else(PoisonError::into_inner), "{line}");
        if let Err(e) = written {
            let what = format!("cannot write the trace {}: {e}; the run continues without it", path.display());
            let error = Error::new("E105", what);
            // The error is reported once.
            self.file = None;
            return Err(error);
        }
        Ok(())
    }

    /// Flushes and closes the file, if a trace is written.
    pub fn close(self) -> Result<(), Error> {
        let Some((file, path)) = self.file else { return Ok(()) };
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.flush().map_err(|e| Error::new("E105", format!("the trace {} is incomplete: {e}", path.display())))
    }
}

/// Returns the text that these lines print on each console, keyed by the title of the console. If a console is cleared,
/// only the text after the last clear is returned, or null if there is none.
fn consoles(lines: &[LogLine]) -> Map<String, Json> {
    let mut all = Map::new();
    for line in lines {
        match line.level {
            TATU_LOG_CONSOLE_CLEAR => drop(all.insert(line.text.clone(), Json::Null)),
            TATU_LOG_CONSOLE => {
                let (title, text) = line.text.split_once('\0').unwrap_or((&line.text, ""));
                let so_far = all.get(title).and_then(Json::as_str).unwrap_or_default();
                let so_far = json!(format!("{so_far}{text}"));
                all.insert(title.to_owned(), so_far);
            }
            _ => {}
        }
    }
    all
}

fn to_json(v: Value) -> Json {
    match v {
        // A field with a single element is written as a number, not as an array.
        Value::Floats(f) if f.len() == 1 => json!(f[0]),
        Value::Ints(f) if f.len() == 1 => json!(f[0]),
        Value::Floats(f) => json!(f),
        Value::Ints(i) => json!(i),
        Value::Bytes(b) => json!(b),
        other => json!(format!("{other:?}")),
    }
}
