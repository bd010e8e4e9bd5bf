//! Results of filters and scripts for the image of a sensor.

use std::{borrow::Cow, collections::BTreeMap};

use serde::{Deserialize, Serialize};

use super::view::VisionView;
use crate::kit::*;

/// Results of filters and scripts for one image.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct VisionResult {
    /// Identifies the image: the sensor's measurement count and time.
    pub stamp: (u64, u64),
    /// Colours that replace the measured ones.
    pub rgb: Option<Vec<u8>>,
    /// Depths that replace the measured ones.
    pub depth: Option<Vec<f32>>,
    /// Whether something was detected.
    pub trigger: bool,
    /// Packets of filters and callbacks, in addition to the standard packet.
    pub packets: Vec<Vec<f64>>,
}

/// The results of the sensors of a world, by the sensor's handle.
pub(crate) type VisionResults = BTreeMap<tatu_object, VisionResult>;

impl VisionResult {
    /// Creates an empty result for a sensor's current image.
    pub fn of(view: &VisionView) -> Self {
        VisionResult { stamp: stamp(view), ..VisionResult::default() }
    }
    /// Creates a result whose image was set by a script.
    pub fn with_image(rgb: Vec<u8>, depth: Option<Vec<f32>>) -> Self {
        VisionResult { rgb: Some(rgb), depth, ..VisionResult::default() }
    }
    pub fn rgb<'a>(&'a self, c: &Ctx<'a>, view: &VisionView) -> Cow<'a, [u8]> {
        match &self.rgb {
            Some(rgb) if rgb.len() == 3 * view.pixels() => Cow::Borrowed(rgb),
            _ => Cow::Owned(view.rgb(c)),
        }
    }
    pub fn depth<'a>(&'a self, c: &Ctx<'a>, view: &VisionView) -> Cow<'a, [f32]> {
        match &self.depth {
            Some(depth) if depth.len() == view.pixels() => Cow::Borrowed(depth),
            _ => Cow::Owned(view.depth(c)),
        }
    }
    /// Returns whether the depths are the measured ones.
    pub fn is_depth_measured(&self) -> bool {
        self.depth.is_none()
    }
}

/// Returns the measurement count and time of a sensor's current image, which identify it.
pub(super) fn stamp(view: &VisionView) -> (u64, u64) {
    (view.sequence, view.time.to_bits())
}
