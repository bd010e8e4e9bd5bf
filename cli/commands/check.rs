//! `tatu check`: would the scene start?

use std::process::ExitCode;

use serde_json::{Value as Json, json};
use tatu_core::{
    World,
    document::{Document, Options, Sources},
};

use super::describe::facts::to_json;
use crate::{args::Check, report, watchdog::Watchdog};

/// Exit code 0 if it would, else 2.
pub fn check(args: &Check) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    let options = args.changes.options(&[]).map(|o| Options { describe: args.json, ..o });
    let world =
        super::registry(Some(&args.scene), &Sources::default(), &args.changes.allow, &watchdog).and_then(|registry| {
            let document = super::load(&args.scene, &options?, &registry)?;
            let described = args.json.then(|| described(args, &document));
            let world = World::new(document, registry)?;
            // Told only of a scene that would start.
            if let Some(json) = described {
                report::out!("{json}");
            }
            Ok(world)
        });
    match world {
        Ok(world) => {
            // A text that is no program does not keep a scene from starting; better reported now than then.
            watchdog.world(&world, false);
            world.start();
            world.mechanics().iter().for_each(|text| crate::report::err!("warning: {text}"));
            world.take_lines().iter().for_each(|l| crate::report::err!("warning: {}", l.text));
            if !args.json {
                crate::report::out!("{}: would start", args.scene.display());
            }
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// What the file holds: its importer's description, if it gives one, with the file's name and a report.
fn described(args: &Check, document: &Document) -> Json {
    let mut out = document.description.as_ref().map(to_json).filter(Json::is_object).unwrap_or_else(|| json!({}));
    if let Some(map) = out.as_object_mut() {
        let name = args.scene.file_name().map(|n| n.to_string_lossy().into_owned());
        map.insert("file".into(), json!(name.unwrap_or_default()));
        map.entry("report").or_insert_with(|| json!(document.reports));
    }
    out
}
