//! The functions that the host calls: start, life cycle and tables, and the guard that catches their panics.

pub(crate) mod life;
pub(crate) mod panics;
pub(crate) mod sensor_table;
pub(crate) mod start;
