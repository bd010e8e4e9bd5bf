//! Tests that the same scene and seed give the same bits: on every run, after a snapshot, in a replay, with other
//! worlds in the process.

mod address_space;
mod damaged;
mod determinism;
mod processors;
mod replay;
pub mod restart;
mod snapshot;
mod worlds;
