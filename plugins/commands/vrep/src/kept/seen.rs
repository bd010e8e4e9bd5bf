//! What was made of the images of vision sensors, and their working images.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::tatu_object;

use crate::vision::work::Work;

/// What was made of the image of a sensor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Which image: how often the sensor had measured, and when.
    pub(crate) stamp: (u64, u64),
    /// What stands in place of the colours and depths that were taken.
    pub(crate) rgb: Option<Vec<u8>>,
    pub(crate) depth: Option<Vec<f32>>,
    /// Something was detected.
    pub(crate) trigger: bool,
    /// What was found, beside the packet that every sensor has.
    pub(crate) packets: Vec<Vec<f64>>,
}

/// What was made of the images of each sensor.
pub(crate) type AllSeen = BTreeMap<tatu_object, Seen>;

/// The working images of sensors.
pub(crate) type AllWork = BTreeMap<tatu_object, Work>;
