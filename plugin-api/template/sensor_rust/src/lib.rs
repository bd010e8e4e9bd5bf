//! my_plugin: a kind of sensor in Rust. A fan of beams in the plane of its z and x axes measures the clearance ahead.
//!
//! - `my_plugin.distance`: for each beam, m; the range if nothing is hit
//! - `my_plugin.nearest`: the smallest of them, m; `my_plugin.bearing`: its direction, rad, from +z towards +x
//!
//! The scene sets noise, rate and latency: see the preset below, and `[noise.distance]` in a scene.
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use std::f64::consts::PI;

use tatu_plugin_api::{abi::TATU_IN_DISTANCE, fields, safe::*, tatu_plugin};

/// The plugin. Data shared by all its sensors would be stored here.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Fan>();
    }
}

/// One sensor of a scene. Its parameters fully determine its state, so there is nothing to save in a snapshot.
struct Fan {
    range: f64,
    angle: f64,
    beams: usize,
}

impl Fan {
    fn bearing(&self, beam: usize) -> f64 {
        let part = if self.beams > 1 { beam as f64 / (self.beams - 1) as f64 - 0.5 } else { 0.0 };
        self.angle * part
    }
}

// The fields of a reading, which `measure` writes by these names.
fields! {
    Fan {
        DISTANCE: f64 = Field::new("my_plugin.distance").per_beam().unit("m").text("Distance along each beam.");
        NEAREST: f64 = Field::new("my_plugin.nearest").unit("m").text("The least distance.");
        BEARING: f64 = Field::new("my_plugin.bearing").unit("rad").text("Direction of that beam, from +z towards +x.");
    }
}

impl Sensor for Fan {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Measures the clearance ahead with a fan of beams.";
    const SCHEMAS: &'static [&'static str] = &["my_plugin/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE;
    const PRESETS: &'static [Preset] = &[Preset {
        id: "cheap",
        text: "A low-cost sensor with an error of 2 cm; the values are examples.",
        settings: "range_m = 4.0\n\n[noise.nearest]\nsigma = 0.02\n",
    }];

    fn params() -> Vec<Param> {
        vec![
            Param::float("range").unit("m").range(0.01, 1000.0).default(5.0).text("Maximum range."),
            Param::float("angle").unit("rad").range(0.0, PI).default(1.0).text("Angle from first to last beam."),
            Param::int("beams").range(1.0, 1000.0).default(21).rebuilds().text("Number of beams."),
        ]
    }
    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Fan { range: params.f64("range")?, angle: params.f64("angle")?, beams: params.i64("beams")? as usize })
    }
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        (self.range, self.angle) = (params.f64("range")?, params.f64("angle")?);
        Ok(Change::Taken)
    }
    fn beams(&self) -> Result<Beams> {
        let ahead = (0..self.beams).map(|k| [self.bearing(k).sin(), 0.0, self.bearing(k).cos()]);
        Ok(Beams { form: Form::Rays(ahead.collect()), far: self.range, ..Beams::default() })
    }

    /// May be called on any thread, so it uses only the sensor and the sample.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let distances: Vec<f64> = sample.distances().iter().map(|d| d.min(self.range)).collect();
        let nearest = (0..distances.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b])).unwrap_or(0);
        out.slice(Self::DISTANCE).copy_from_slice(&distances);
        out.set(Self::NEAREST, distances[nearest]);
        out.set(Self::BEARING, if distances[nearest] < self.range { self.bearing(nearest) } else { 0.0 });
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
