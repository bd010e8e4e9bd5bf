//! Motion profiles, by handle.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::tatu_object;

use crate::motion::profile::MotionProfile;

/// A profile that a script advances.
#[derive(Serialize, Deserialize)]
pub(crate) struct ScriptProfile {
    /// The script that created the profile; 0 for a client.
    pub(crate) script: tatu_object,
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
