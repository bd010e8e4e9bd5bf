//! Motion profiles, by handle.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::motion::profile::MotionProfile;

/// A profile that a script advances.
#[derive(Serialize, Deserialize)]
pub(crate) struct ScriptProfile {
    pub(crate) profile: MotionProfile,
    /// Steps are multiples of this time, s.
    pub(crate) cycle: f64,
    /// Whether the target consists of velocities, which last after they have been reached.
    pub(crate) velocities: bool,
}

/// All profiles of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Profiles {
    pub(crate) all: BTreeMap<i64, ScriptProfile>,
    pub(crate) made: i64,
}
