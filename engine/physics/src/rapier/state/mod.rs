//! The state of the engine, and its snapshots.

mod engine_state;
pub(crate) mod snapshot;

pub(crate) use engine_state::EngineState;
