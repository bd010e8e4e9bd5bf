//! Noise of sensors as declared in a scene, by field name.
//!
//! - `spec`: declarations, and their TOML form; `wrong`: errors in declarations;
//! - `fields`: the fields that names refer to, and the values that mean "nothing".

mod fields;
mod spec;
mod wrong;

pub use fields::{Meant, meant};
pub use spec::{FieldNoise, NoiseSpec, Outliers, Walk};
pub use wrong::Wrong;
