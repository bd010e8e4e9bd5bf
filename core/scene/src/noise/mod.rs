//! Noise of sensors, as a scene declares it: by the names of fields.
//!
//! - `spec`: what is declared, as TOML and back;
//! - `fields`: which field a name means, and which of its values mean nothing.

mod fields;
mod spec;
mod wrong;

pub use fields::{Meant, meant};
pub use spec::{FieldNoise, NoiseSpec, Outliers, Walk};
pub use wrong::Wrong;
