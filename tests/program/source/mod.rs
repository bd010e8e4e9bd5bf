//! Tests of the source tree: layers, names, lengths, features.

#[cfg(target_os = "linux")]
mod features;
mod imports;
mod layers;
#[cfg(target_os = "linux")]
mod tree;
