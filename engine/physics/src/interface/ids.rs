//! Ids of bodies and joints. They are dense, start at 0 and are never reused.

use serde::{Deserialize, Serialize};

/// The id of a body, from 0, in order of creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyId(pub u32);

/// The id of a joint, from 0, in order of creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JointId(pub u32);
