//! Builds the command that starts this program again, for tasks that need a separate process.

use std::{ffi::OsString, io, process::Command, sync::OnceLock};

/// Program and leading arguments of the command that starts the command-line interface, if it is embedded in another
/// program.
static RESTART_COMMAND: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the command that starts the command-line interface if it is embedded in another program, such as an interpreter
/// with the arguments that precede those of the command-line interface. Empty commands are ignored, and only the first
/// other call has an effect.
pub fn set_restart_command(command: Vec<OsString>) {
    if !command.is_empty() {
        let _ = RESTART_COMMAND.set(command);
    }
}

/// Returns a command that starts this program again, to which the caller adds arguments.
///
/// # Errors
/// The path of this program cannot be determined.
pub fn restart_command() -> io::Result<Command> {
    match RESTART_COMMAND.get().map(Vec::as_slice) {
        Some([program, args @ ..]) => {
            let mut command = Command::new(program);
            command.args(args);
            Ok(command)
        }
        _ => std::env::current_exe().map(Command::new),
    }
}
