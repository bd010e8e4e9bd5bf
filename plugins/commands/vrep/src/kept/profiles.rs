//! Motion profiles that scripts step themselves.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::profile::Profile;

/// All profiles of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Profiles {
    pub(crate) all: BTreeMap<i64, Profile>,
    pub(crate) made: i64,
}
