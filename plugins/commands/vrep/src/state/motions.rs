//! Motions that are under way.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::{tatu_func, tatu_object};

use crate::{kit::algebra::Pose, motion::profile::Profile};

/// What a motion moves.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) enum Mover {
    Joints(Vec<tatu_object>),
    /// An object, from pose to pose in a frame (0: the world); 0: only the callback is called.
    Pose {
        object: tatu_object,
        frame: tatu_object,
        from: Pose,
        to: Pose,
    },
    Nothing,
}

/// Who is notified of each step.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) enum Listener {
    Nobody,
    Function(tatu_func),
    Named(String),
}

/// What a command gives in the end.
#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
pub(crate) enum Answer {
    /// A table with keys.
    Map,
    /// The values one by one, as before 4.7.
    List,
    /// A result, the values, and the time left over, as in 3.x.
    Old,
    /// The time left over.
    Left,
}

/// A motion.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct Motion {
    pub(crate) profile: Profile,
    pub(crate) mover: Mover,
    pub(crate) listener: Listener,
    pub(crate) answer: Answer,
    /// What the callback gets as its last argument, packed.
    pub(crate) data: Vec<u8>,
}
