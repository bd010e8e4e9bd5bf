//! The serialized parts of a world in a snapshot.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tatu_devices::sense::NoiseState;
use tatu_errors::{Fault, FaultKind};
use tatu_physics::PairRule;
use tatu_plugin_api::safe::Value;
use tatu_scene::{Scene, document::WorldSettings};

use crate::cell::{InstanceImage, WaitingCommand};

/// A value in a snapshot, such as that of a signal or a parameter.
#[derive(Serialize, Deserialize)]
pub enum ValueImage {
    Nil,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Vec<u8>),
    Bytes(Vec<u8>),
    Floats(Vec<f64>),
    Ints(Vec<i64>),
    List(Vec<ValueImage>),
    Map(Vec<(ValueImage, ValueImage)>),
    Func(u64),
    Object(u64),
}

impl From<&Value> for ValueImage {
    fn from(v: &Value) -> Self {
        match v {
            Value::Nil => Self::Nil,
            Value::Bool(x) => Self::Bool(*x),
            Value::Int(x) => Self::Int(*x),
            Value::Float(x) => Self::Float(*x),
            Value::Text(x) => Self::Text(x.clone()),
            Value::Bytes(x) => Self::Bytes(x.clone()),
            Value::Floats(x) => Self::Floats(x.clone()),
            Value::Ints(x) => Self::Ints(x.clone()),
            Value::List(x) => Self::List(x.iter().map(Self::from).collect()),
            Value::Map(x) => Self::Map(x.iter().map(|(k, v)| (Self::from(k), Self::from(v))).collect()),
            Value::Func(x) => Self::Func(*x),
            Value::Object(x) => Self::Object(*x),
        }
    }
}

impl From<ValueImage> for Value {
    fn from(v: ValueImage) -> Self {
        match v {
            ValueImage::Nil => Self::Nil,
            ValueImage::Bool(x) => Self::Bool(x),
            ValueImage::Int(x) => Self::Int(x),
            ValueImage::Float(x) => Self::Float(x),
            ValueImage::Text(x) => Self::Text(x),
            ValueImage::Bytes(x) => Self::Bytes(x),
            ValueImage::Floats(x) => Self::Floats(x),
            ValueImage::Ints(x) => Self::Ints(x),
            ValueImage::List(x) => Self::List(x.into_iter().map(Self::from).collect()),
            ValueImage::Map(x) => Self::Map(x.into_iter().map(|(k, v)| (k.into(), v.into())).collect()),
            ValueImage::Func(x) => Self::Func(x),
            ValueImage::Object(x) => Self::Object(x),
        }
    }
}

/// The state of the core itself: scene, engine, clock, signals, commands that wait, and faults.
#[derive(Serialize, Deserialize)]
pub struct CoreImage {
    pub scene: Scene,
    /// For each shape with a mesh, its slot and the index of the mesh in the document.
    pub meshes: Vec<(u32, u32)>,
    pub settings: WorldSettings,
    pub dynamics: Vec<u8>,
    pub phase: crate::cell::Phase,
    /// Time (s), number of steps, duration of a step (s), number of passes.
    pub clock: (f64, u64, f64, u64),
    pub requests: u32,
    pub next_instance: u64,
    /// The last number assigned to a result of a plugin's thread.
    pub last_wake: u64,
    /// For each signal, its kind, name and value, and whether it is removed when the run ends.
    pub signals: Vec<(u32, Vec<u8>, ValueImage, bool)>,
    pub waits: Vec<WaitingCommand>,
    pub faults: Vec<FaultImage>,
    /// Events that have not been delivered yet.
    pub events: Vec<(String, ValueImage)>,
    /// Pairs of slots that touched after the last physics stage, for events of contacts.
    pub touching: BTreeSet<(u32, u32)>,
}

/// A sensor's state.
#[derive(Serialize, Deserialize)]
pub struct DeviceImage {
    pub slot: u32,
    pub kind: u32,
    pub id: u64,
    pub params: Vec<ValueImage>,
    pub instance: InstanceImage,
    pub fields: Vec<u64>,
    pub sequence: u64,
    pub time: f64,
    pub drawn: u64,
    pub period: Option<u64>,
    /// The state of the sensor's noise.
    pub noise: Option<NoiseState>,
    pub off: bool,
}

/// The state of an actuator or a part, without its commands, which are in the scene.
#[derive(Serialize, Deserialize)]
pub struct ActuatorImage {
    pub slot: u32,
    pub kind: u32,
    /// Handle of the object, which consists of a generation and a slot.
    pub object: u64,
    pub params: Vec<ValueImage>,
    pub instance: InstanceImage,
    pub off: bool,
    pub idle_told: bool,
    /// Number of calls of a part; 0 for an actuator.
    pub calls: u64,
    /// The pairs of shapes on whose contact a part decides, and its decisions.
    pub hooks: BTreeSet<(u64, u64)>,
    pub rules: BTreeMap<(u32, u32), PairRule>,
}

/// A fault reported before the snapshot.
#[derive(Serialize, Deserialize)]
pub struct FaultImage {
    kind: FaultKind,
    plugin: Option<String>,
    script: Option<String>,
    object: Option<String>,
    file: Option<String>,
    line: Option<u64>,
    message: String,
    help: Option<String>,
    traceback: Option<String>,
    count: u64,
}

impl From<&Fault> for FaultImage {
    fn from(f: &Fault) -> Self {
        let Fault { code: _, kind, plugin, script, object, file, line, message, help, traceback, count } = f.clone();
        FaultImage { kind, plugin, script, object, file, line, message, help, traceback, count }
    }
}

impl From<FaultImage> for Fault {
    fn from(f: FaultImage) -> Self {
        let FaultImage { kind, plugin, script, object, file, line, message, help, traceback, count } = f;
        Fault { code: kind.code(), kind, plugin, script, object, file, line, message, help, traceback, count }
    }
}
