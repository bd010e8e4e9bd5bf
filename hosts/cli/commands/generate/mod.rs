//! `tatu generate`: prints files that packages of the program contain besides the binary: the manual page, completions
//! for shells, and declarations of commands for Python.

mod stubs;

pub use stubs::type_of as python_type;

use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;
use tatu_core::{document::SourceFiles, errors::Error};
use tatu_terminal::{Watchdog, report};

use crate::args::{CliArgs, GenerateArgs, GeneratedFile, SceneChanges};

/// Prints the requested file. The exit code is 0, or 1 if the file could not be generated.
pub fn generate(args: &GenerateArgs) -> ExitCode {
    let mut command = CliArgs::command();
    let mut text = Vec::new();
    let shell = match args.what {
        GeneratedFile::Python => return python(),
        GeneratedFile::Man => None,
        GeneratedFile::Bash => Some(Shell::Bash),
        GeneratedFile::Zsh => Some(Shell::Zsh),
        GeneratedFile::Fish => Some(Shell::Fish),
    };
    let made = match shell {
        None => manual(command, &mut text),
        Some(shell) => {
            clap_complete::generate(shell, &mut command, "tatu", &mut text);
            Ok(())
        }
    };
    if let Err(e) = made {
        report::error(&Error::new("E105", format!("cannot generate the manual page: {e}")));
        return ExitCode::FAILURE;
    }
    report::out!("{}", String::from_utf8_lossy(&text).trim_end());
    ExitCode::SUCCESS
}

/// Prints the declarations of all commands.
fn python() -> ExitCode {
    let registry = match super::registry(None, &SourceFiles::default(), &SceneChanges::default(), &Watchdog::default())
    {
        Ok(registry) => registry,
        Err(e) => {
            report::error(&e);
            return ExitCode::FAILURE;
        }
    };
    report::out!("{}", stubs::write(&registry).trim_end());
    match super::end_plugins(registry) {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

/// Writes a single manual page for the program and all its commands.
fn manual(command: clap::Command, out: &mut Vec<u8>) -> std::io::Result<()> {
    let commands: Vec<clap::Command> = command.get_subcommands().filter(|c| !c.is_hide_set()).cloned().collect();
    let page = clap_mangen::Man::new(command);
    page.render_title(out)?;
    page.render_name_section(out)?;
    page.render_synopsis_section(out)?;
    page.render_description_section(out)?;
    page.render_options_section(out)?;
    for command in commands {
        let title = format!("tatu {}", command.get_name());
        // Each command becomes one section of the page, with the command as its heading.
        let mut part = Vec::new();
        let page = clap_mangen::Man::new(command.display_name(title.clone()));
        page.render_synopsis_section(&mut part)?;
        page.render_description_section(&mut part)?;
        page.render_options_section(&mut part)?;
        let part = String::from_utf8_lossy(&part).replace(".SH ", ".SS ");
        out.extend_from_slice(format!(".SH {}\n{part}", title.to_uppercase()).as_bytes());
    }
    Ok(())
}
