//! Motion profiles, by handle.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::motion::profile::MotionProfile;

/// All profiles of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Profiles {
    pub(crate) all: BTreeMap<i64, MotionProfile>,
    pub(crate) made: i64,
}
