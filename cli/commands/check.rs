//! `tatu check`: would the scene start?

use std::process::ExitCode;

use tatu_core::World;

use crate::{args::Check, report};

/// Exit code 0 if it would, else 2.
pub fn check(args: &Check) -> ExitCode {
    let world = super::registry(Some(&args.scene.scene))
        .and_then(|registry| World::new(super::load(&args.scene, &registry)?, registry));
    match world {
        Ok(_) => {
            println!("{}: would start", args.scene.scene.display());
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}
