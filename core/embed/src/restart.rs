//! Starting this program again, for parts that need a process of their own.

use std::{ffi::OsString, io, process::Command, sync::OnceLock};

/// Program and first arguments by which the command line is started in another program.
static STARTED_BY: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets how the command line is started where it is part of another program: an interpreter, for example, with the
/// arguments that precede those of the command line. Only the first call counts.
pub fn started_by(command: Vec<OsString>) {
    if !command.is_empty() {
        let _ = STARTED_BY.set(command);
    }
}

/// Returns a command that starts this program again; its arguments are to be added.
///
/// # Errors
/// The system does not tell where this program is.
pub fn restart_command() -> io::Result<Command> {
    match STARTED_BY.get().map(Vec::as_slice) {
        Some([program, args @ ..]) => {
            let mut command = Command::new(program);
            command.args(args);
            Ok(command)
        }
        _ => std::env::current_exe().map(Command::new),
    }
}
