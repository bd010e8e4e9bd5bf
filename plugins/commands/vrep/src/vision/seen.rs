//! What was made of the image of a sensor.

use std::{borrow::Cow, collections::BTreeMap};

use serde::{Deserialize, Serialize};

use super::view::View;
use crate::kit::*;

/// What was made of the image of a sensor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Which image: how often the sensor had measured, and when.
    pub stamp: (u64, u64),
    /// What stands in place of the colours and depths that were taken.
    pub rgb: Option<Vec<u8>>,
    pub depth: Option<Vec<f32>>,
    /// Something was detected.
    pub trigger: bool,
    /// What was found, beside the packet that every sensor has.
    pub packets: Vec<Vec<f64>>,
}

/// What was made of the images of each sensor.
pub(crate) type AllSeen = BTreeMap<tatu_object, Seen>;

impl Seen {
    /// Before anything is made of an image.
    pub fn of(view: &View) -> Self {
        Seen { stamp: stamp(view), ..Seen::default() }
    }
    /// An image from elsewhere.
    pub fn given(rgb: Vec<u8>, depth: Option<Vec<f32>>) -> Self {
        Seen { rgb: Some(rgb), depth, ..Seen::default() }
    }
    pub fn rgb<'a>(&'a self, c: &Ctx<'a>, view: &View) -> Cow<'a, [u8]> {
        match &self.rgb {
            Some(rgb) if rgb.len() == 3 * view.pixels() => Cow::Borrowed(rgb),
            _ => Cow::Owned(view.rgb(c)),
        }
    }
    pub fn depth<'a>(&'a self, c: &Ctx<'a>, view: &View) -> Cow<'a, [f32]> {
        match &self.depth {
            Some(depth) if depth.len() == view.pixels() => Cow::Borrowed(depth),
            _ => Cow::Owned(view.depth(c)),
        }
    }
    /// Whether the depths are those that were taken.
    pub fn depth_as_taken(&self) -> bool {
        self.depth.is_none()
    }
}

/// Which image a sensor has.
pub(super) fn stamp(view: &View) -> (u64, u64) {
    (view.sequence, view.time.to_bits())
}
