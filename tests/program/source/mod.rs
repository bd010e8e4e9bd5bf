//! Tests of the source tree: layers, names, lengths.

mod imports;
mod layers;
#[cfg(target_os = "linux")]
mod tree;
