//! Active motions.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::{
    abi::{TATU_ERR_SPACE, tatu_func, tatu_object},
    safe::{Fail, Result},
};

use crate::{
    kit::{Ctx, algebra::Pose},
    motion::profile::MotionProfile,
};

/// The object or joints moved by a motion.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) enum MovedObjects {
    Joints(Vec<tatu_object>),
    /// An object that moves from one pose to another in a frame. `object` is 0 if only the callback is called, and
    /// `frame` is 0 for the world frame. The coordinates are x, y, z and the angle, or the way covered of a `length`.
    Pose {
        object: tatu_object,
        frame: tatu_object,
        from: Pose,
        to: Pose,
        length: Option<f64>,
    },
    Nothing,
}

/// The function that a motion calls after each step.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) enum MotionCallback {
    Nobody,
    Function(tatu_func),
    Named(String),
}

/// The form in which a command returns its result.
#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
pub(crate) enum ResultForm {
    /// A table with named fields.
    Map,
    /// Separate values, as before 4.7.
    List,
    /// A result code, the values, and the remaining time, as in 3.x.
    Old,
    /// The remaining time only.
    Left,
}

/// Most motions and profiles of a world, each.
const MAX_MOTIONS: usize = 10_000;
/// Most memory of the data that scripts pass to the callbacks of motions, in all, and of the coordinates of profiles,
/// bytes.
const MAX_MOTION_BYTES: usize = 64 << 20;

/// Returns an error if a motion or profile of `bytes` cannot be added to those of these sizes.
pub(crate) fn check_room(sizes: impl ExactSizeIterator<Item = usize>, bytes: usize) -> Result<()> {
    if sizes.len() >= MAX_MOTIONS {
        return Err(Fail::with_code(TATU_ERR_SPACE, format!("there are already {MAX_MOTIONS} motions or profiles"))
            .help("end those that are no longer needed with `_cleanup`, sim.ruckigRemove or sim.rmlRemove"));
    }
    let sum = sizes.fold(bytes, usize::saturating_add);
    if sum > MAX_MOTION_BYTES {
        return Err(Fail::with_code(
            TATU_ERR_SPACE,
            format!("motions and profiles would need {sum} bytes; the maximum is {MAX_MOTION_BYTES}"),
        )
        .help("end those that are no longer needed, or pass less data to their callbacks"));
    }
    Ok(())
}

/// An active motion: its profile, the objects that it moves, the callback that it calls after each step, and the form
/// in which its command returns the result.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct ActiveMotion {
    /// The script that started the motion; 0 for a client.
    pub(crate) script: tatu_object,
    pub(crate) profile: MotionProfile,
    pub(crate) mover: MovedObjects,
    pub(crate) listener: MotionCallback,
    pub(crate) answer: ResultForm,
    /// The last argument of the callback, packed.
    pub(crate) data: Vec<u8>,
    /// Duration of a step, s; 0: that of the simulation.
    pub(crate) time_step: f64,
    /// Whether the target has been reached or the callback has ended the motion, and only the thread waits on.
    pub(crate) has_ended: bool,
}

impl ActiveMotion {
    /// Returns the approximate size in memory, bytes.
    pub(crate) fn size(&self) -> usize {
        self.profile.size() + self.data.len()
    }
}

/// Returns those of these scripts that no longer exist, whose motions and profiles can be removed. A client is script 0.
pub(crate) fn removed_scripts(c: &Ctx<'_>, scripts: BTreeSet<tatu_object>) -> BTreeSet<tatu_object> {
    scripts.into_iter().filter(|script| *script != 0 && c.world().look(*script).is_err()).collect()
}
