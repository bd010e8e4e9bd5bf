//! Tests of the source tree: error codes, copies, features, imports, layers, names, paths in documents, regressions,
//! structs, lengths.

#[cfg(target_os = "linux")]
mod codes;
mod copies;
#[cfg(target_os = "linux")]
mod features;
mod imports;
mod layers;
#[cfg(target_os = "linux")]
mod names;
#[cfg(target_os = "linux")]
mod paths;
#[cfg(target_os = "linux")]
mod regressions;
#[cfg(target_os = "linux")]
mod structs;
#[cfg(target_os = "linux")]
mod tree;
