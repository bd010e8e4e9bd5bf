//! Wireless data between objects that is in transit.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::tatu_object;

/// Data that was sent and has not expired yet.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct WirelessMessage {
    pub(crate) from: tatu_object,
    pub(crate) antenna: tatu_object,
    pub(crate) target: i64,
    pub(crate) header: i64,
    pub(crate) name: Vec<u8>,
    pub(crate) data: Vec<u8>,
    pub(crate) radius: f64,
    pub(crate) until: f64,
    pub(crate) read: BTreeSet<tatu_object>,
}

/// The wireless messages of a world, until they expire.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct PendingWireless {
    pub(crate) messages: Vec<WirelessMessage>,
}
