//! Tests of the command line: printed and written output, pictures, descriptions.

mod command_line;
mod demos;
mod describe;
mod export;
mod grade;
mod import;
#[cfg(unix)]
mod interactive;
pub mod keys;
mod library;
mod lock;
mod look;
mod output_files;
mod outputs;
mod subcommand;
mod sweep;
mod test_command;
