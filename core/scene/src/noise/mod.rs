//! Noise of sensors as declared in a scene, by field name.
//!
//! - `spec`: declarations, and their TOML form; `error`: errors in declarations;
//! - `fields`: the fields that names refer to, and the values that mean "nothing".

mod error;
mod fields;
mod spec;

pub use error::NoiseError;
pub use fields::{NamedField, find_field};
pub use spec::{FieldNoise, GaussMarkovProcess, NoiseSpec, OutlierNoise};
