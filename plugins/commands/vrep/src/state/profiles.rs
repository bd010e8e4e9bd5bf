//! Motion profiles, by handle.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::motion::profile::Profile;

/// All profiles of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Profiles {
    pub(crate) all: BTreeMap<i64, Profile>,
    pub(crate) made: i64,
}
