//! Tests of the source tree: error codes, features, imports, layers, names, lengths.

#[cfg(target_os = "linux")]
mod codes;
#[cfg(target_os = "linux")]
mod features;
mod imports;
mod layers;
#[cfg(target_os = "linux")]
mod names;
#[cfg(target_os = "linux")]
mod tree;
