//! `tatu check`: would the scene start?

use std::process::ExitCode;

use tatu_core::{World, document::Sources};

use crate::{args::Check, report};

/// Exit code 0 if it would, else 2.
pub fn check(args: &Check) -> ExitCode {
    let options = args.changes.options(&[]);
    let world = super::registry(Some(&args.scene), &Sources::default())
        .and_then(|registry| World::new(super::load(&args.scene, &options?, &registry)?, registry));
    match world {
        Ok(world) => {
            // A text that is no program does not keep a scene from starting; better told now than then.
            world.start();
            world.mechanics().iter().for_each(|text| crate::report::err!("warning: {text}"));
            world.take_lines().iter().for_each(|l| crate::report::err!("warning: {}", l.text));
            crate::report::out!("{}: would start", args.scene.display());
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}
