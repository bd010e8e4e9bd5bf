//! The command line: what it prints, writes, draws and describes.

mod command_line;
mod demos;
mod describe;
#[cfg(unix)]
mod interactive;
pub mod keys;
mod look;
mod outputs;
mod written;
