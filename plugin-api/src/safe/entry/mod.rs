//! Entry points for the host: start, instances, and the guard around every function.

pub(crate) mod guard;
pub(crate) mod life;
pub(crate) mod sensor_table;
pub(crate) mod start;
