//! Readings of sensors, drawings, and streams of graphs.

use std::collections::BTreeMap;

use serde::Serialize;

/// New readings by the handle of the sensor; `None` if the sensor has not measured since the last reset.
pub(crate) type ReadingMap = BTreeMap<u32, Option<Reading>>;

/// The last reading of a sensor. The variant depends on the schema of the reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
#[serde(tag = "schema", rename_all = "snake_case")]
pub(crate) enum Reading {
    Proximity {
        detected: bool,
        #[serde(skip_serializing_if = "Option::is_none")]
        distance: Option<f64>,
        /// The detected point in the sensor's frame, m.
        #[serde(skip_serializing_if = "Option::is_none")]
        point: Option<Vec<f64>>,
    },
    RangeScan {
        /// The distance measured along each beam, m; null if the beam hits nothing.
        #[cfg_attr(test, ts(as = "Vec<Option<f64>>"))]
        distance: Vec<Option<f64>>,
        /// The angle of each beam about the +y axis, measured from the +z axis, rad.
        angle: Vec<f64>,
        /// The elevation of each beam towards the +y axis, rad; omitted if all beams have elevation 0.
        #[serde(skip_serializing_if = "Option::is_none")]
        elevation: Option<Vec<f64>>,
        /// The maximum distance that the sensor measures, m; omitted if it is unlimited.
        #[serde(skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
    },
    Gps {
        /// Position in the world frame, m.
        position: Vec<f64>,
    },
    /// The fields of any other sensor that have at most 16 elements, by name.
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
    /// Size of each item: pixels for points and lines, m for solids.
    pub(crate) size: f64,
    pub(crate) color: Vec<f64>,
    /// The values of all items, consecutively; each item has `stride` values.
    pub(crate) items: Vec<f64>,
    pub(crate) stride: usize,
}

/// A stream of a graph with its newest samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct StreamSamples {
    pub(crate) name: String,
    pub(crate) unit: String,
    #[cfg_attr(test, ts(as = "Option<[f64; 3]>"))]
    pub(crate) color: Option<Vec<f64>>,
    /// The simulation times of the samples, s. Here and in `values`, non-finite values are null.
    pub(crate) times: Vec<Option<f64>>,
    pub(crate) values: Vec<Option<f64>>,
}

/// A curve that a graph declares, with its newest points: one stream over another.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct CurvePoints {
    pub(crate) name: String,
    pub(crate) unit: String,
    #[cfg_attr(test, ts(as = "Option<[f64; 3]>"))]
    pub(crate) color: Option<Vec<f64>>,
    /// The coordinates of the points. Here and in `y`, non-finite values are null.
    pub(crate) x: Vec<Option<f64>>,
    pub(crate) y: Vec<Option<f64>>,
}

/// The watched values at the end of a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct WatchSample {
    /// Simulation time, s.
    pub(crate) time: f64,
    /// The elements of each watched value, in the order of the request; empty if the value cannot be read. Non-finite
    /// elements are null.
    pub(crate) values: Vec<Vec<Option<f64>>>,
}

/// A contact in the last step.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ContactMark {
    /// The handles of the two shapes. If only one of them can move, it is the second.
    pub(crate) pair: [u32; 2],
    /// The contact point in the world frame, m.
    pub(crate) point: [f64; 3],
    /// The force on the second shape in the world frame, N.
    pub(crate) force: [f64; 3],
}

/// A dynamic shape, for overlays.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct BodyMark {
    pub(crate) id: u32,
    /// The centre of mass in the frame of the shape, m.
    pub(crate) com: [f64; 3],
    /// The mass, kg.
    pub(crate) mass: f64,
    /// The inertia matrix about the centre of mass, in the frame of the shape, in row-major order, kg m^2.
    pub(crate) inertia: [f64; 9],
    /// The linear velocity in the world frame, m/s.
    pub(crate) velocity: [f64; 3],
}
