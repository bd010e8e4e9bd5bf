//! Readings of sensors, drawings, and streams of graphs.

use std::collections::BTreeMap;

use serde::Serialize;

/// New readings by the handle of their sensor; `None`: nothing has been measured since the last reset.
pub(crate) type Readings = BTreeMap<u32, Option<Reading>>;

/// The reading of a sensor.
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
        /// The distance along each beam, m; null if it hits nothing.
        #[cfg_attr(test, ts(as = "Vec<Option<f64>>"))]
        distance: Vec<Option<f64>>,
        /// The angle of each beam about +y from +z, rad.
        angle: Vec<f64>,
        /// The elevation of each beam towards +y, rad; 0 if it is missing.
        #[serde(skip_serializing_if = "Option::is_none")]
        elevation: Option<Vec<f64>>,
        /// The maximum distance that the sensor measures, m; unlimited if it is missing.
        #[serde(skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
    },
    Gps {
        /// Position in the world frame, m.
        position: Vec<f64>,
    },
    /// The fields with few elements of any other sensor, by name.
    Fields {
        #[cfg_attr(test, ts(as = "BTreeMap<String, Vec<Option<f64>>>"))]
        fields: BTreeMap<String, Vec<Option<f64>>>,
    },
}

/// A drawing object of a script.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Drawing {
    pub(crate) form: String,
    /// Size of points and lines in pixels, or of solids in m.
    pub(crate) size: f64,
    pub(crate) color: Vec<f64>,
    /// The values of all items, consecutively, and the number of values per item.
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

/// The watched values after a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Sample {
    /// Simulation time, s.
    pub(crate) time: f64,
    /// The elements of each value, in the order of the request; empty if the value cannot be read. Elements that are
    /// not finite are null.
    pub(crate) values: Vec<Vec<Option<f64>>>,
}

/// A contact of the last step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ContactMark {
    /// The two shapes; the second one can move if one of them can.
    pub(crate) pair: [u32; 2],
    /// The contact point in the world frame, m.
    pub(crate) point: [f64; 3],
    /// The force on the second shape in the world frame, N.
    pub(crate) force: [f64; 3],
}

/// A dynamic body.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct BodyMark {
    pub(crate) id: u32,
    /// The centre of mass in the frame of the body, m.
    pub(crate) com: [f64; 3],
    /// The mass, kg.
    pub(crate) mass: f64,
    /// The inertia matrix about the centre of mass, in the frame of the body, by rows, kg m^2.
    pub(crate) inertia: [f64; 9],
    /// The velocity in the world frame, m/s.
    pub(crate) velocity: [f64; 3],
}
