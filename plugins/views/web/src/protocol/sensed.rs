//! Readings of sensors, drawings, and streams of graphs.

use std::collections::BTreeMap;

use serde::Serialize;

/// New readings by the handle of their sensor; none: nothing has been measured since the last reset.
pub(crate) type Readings = BTreeMap<u32, Option<Reading>>;

/// A reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
#[serde(tag = "schema", rename_all = "snake_case")]
pub(crate) enum Reading {
    Proximity {
        detected: bool,
        #[serde(skip_serializing_if = "Option::is_none")]
        distance: Option<f64>,
        /// The detected point, in the sensor's frame.
        #[serde(skip_serializing_if = "Option::is_none")]
        point: Option<Vec<f64>>,
    },
    RangeScan {
        /// The distance of each beam, m; null: it meets nothing.
        #[cfg_attr(test, ts(as = "Vec<Option<f64>>"))]
        distance: Vec<Option<f64>>,
        /// The angle of each beam about +y from +z, rad.
        angle: Vec<f64>,
        /// The elevation of each beam towards +y, rad; missing: 0.
        #[serde(skip_serializing_if = "Option::is_none")]
        elevation: Option<Vec<f64>>,
        /// The greatest distance that the sensor can tell, m; missing: there is none.
        #[serde(skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
    },
    Gps {
        /// In the frame of the world.
        position: Vec<f64>,
    },
    /// Of any other sensor: the fields that have few numbers, by name.
    Fields {
        #[cfg_attr(test, ts(as = "BTreeMap<String, Vec<Option<f64>>>"))]
        fields: BTreeMap<String, Vec<Option<f64>>>,
    },
}

/// What a script draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Drawing {
    pub(crate) form: String,
    /// The size of points and lines in pixels, of bodies in m.
    pub(crate) size: f64,
    pub(crate) color: Vec<f64>,
    /// The numbers of all items, and how many each has.
    pub(crate) items: Vec<f64>,
    pub(crate) stride: usize,
}

/// A stream of a graph, with its newest samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Stream {
    pub(crate) name: String,
    pub(crate) unit: String,
    #[cfg_attr(test, ts(as = "Option<[f64; 3]>"))]
    pub(crate) color: Option<Vec<f64>>,
    /// Samples that are not finite are null.
    pub(crate) times: Vec<Option<f64>>,
    pub(crate) values: Vec<Option<f64>>,
}

/// What is watched, after a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Sample {
    /// Simulation time, s.
    pub(crate) time: f64,
    /// The numbers of each value in the order of the request; empty if it cannot be read. Numbers that are not finite
    /// are null.
    pub(crate) values: Vec<Vec<Option<f64>>>,
}

/// A contact of the last step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ContactMark {
    /// The two shapes; the second one can move if one of them can.
    pub(crate) pair: [u32; 2],
    /// Where they touch, in the world, m.
    pub(crate) point: [f64; 3],
    /// The force on the second shape, N.
    pub(crate) force: [f64; 3],
}

/// A body that forces move.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct BodyMark {
    pub(crate) id: u32,
    /// Its centre of mass, in its frame, m.
    pub(crate) com: [f64; 3],
    /// kg.
    pub(crate) mass: f64,
    /// Its inertia about the centre of mass, in its frame, by rows, kg m^2.
    pub(crate) inertia: [f64; 9],
    /// In the world, m/s.
    pub(crate) velocity: [f64; 3],
}
