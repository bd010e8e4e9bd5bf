//! The source tree itself: layers, names, lengths.

mod imports;
mod layers;
#[cfg(target_os = "linux")]
mod licences;
mod tree;
