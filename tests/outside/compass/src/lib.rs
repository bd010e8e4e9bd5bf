//! A compass that measures the heading of its x axis in the world's x-y plane, counter-clockwise from the world's x
//! axis.
#![forbid(unsafe_code)]

use std::f64::consts::{PI, TAU};

use tatu_plugin_api::{abi::TATU_IN_POSE, fields, safe::*, tatu_plugin};

struct CompassPlugin;

impl Plugin for CompassPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(CompassPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Compass>();
        offer.sensor::<Turns>();
    }
}

/// A compass in a scene.
struct Compass {
    /// Added to each heading, rad.
    offset: f64,
    /// The minimum length of the x axis projected onto the x-y plane; below it, there is no heading.
    least: f64,
}

fields! {
    Compass {
        VALID: i32 = Field::new("compass.valid").text("Whether there is a heading: 1 or 0.");
        HEADING: f64 = Field::new("compass.heading").unit("rad").valid("compass.valid").nothing("0").text(
            "From the world's x axis to the sensor's, counter-clockwise, above -pi to pi; 0 where there is none.",
        );
    }
}

impl Sensor for Compass {
    type Plugin = CompassPlugin;

    const ID: &'static str = "needle";
    const TEXT: &'static str = "Measures the heading of its x axis in the world's x-y plane.";
    const SCHEMAS: &'static [&'static str] = &["compass/1"];
    const INPUTS: u32 = TATU_IN_POSE;
    const PRESETS: &'static [Preset] = &[Preset {
        id: "magnetic_munich",
        text: "A compass that shows magnetic north: 4.1 degrees of declination, ten times a second.",
        settings: "offset_rad = 0.0716\nrate_hz = 10.0\n",
    }];

    fn params() -> Vec<Param> {
        vec![
            Param::float("offset").unit("rad").range(-PI, PI).default(0.0).text("Added to each heading."),
            Param::float("dead_angle")
                .unit("rad")
                .range(0.0, PI / 2.0)
                .default(0.05)
                .rebuilds()
                .text("Angle between the x axis and the vertical, below which there is no heading."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Compass { offset: params.f64("offset")?, least: params.f64("dead_angle")?.sin() })
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        self.offset = params.f64("offset")?;
        Ok(Change::Taken)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let pose = sample.pose().ok_or_else(|| Fail::new("the host passed no pose"))?;
        if let Some(heading) = heading(&pose, self.least) {
            out.set(Self::VALID, 1);
            out.set(Self::HEADING, wrapped(heading + self.offset));
        }
        Ok(())
    }
}

/// A sensor that measures the heading continuously, with full turns counted since the start.
struct Turns;

/// Indices into the state: the last heading, the turns so far, and whether a heading has been measured.
const LAST: usize = 0;
const SUM: usize = 1;
const BEGUN: usize = 2;

fields! {
    Turns {
        TURNS: f64 = Field::new("turns.turns")
            .unit("1")
            .text("Turns since the start, counter-clockwise, with their fraction.");
    }
}

impl Sensor for Turns {
    type Plugin = CompassPlugin;

    const ID: &'static str = "turn_counter";
    const TEXT: &'static str = "Counts the turns of its x axis in the world's x-y plane.";
    const SCHEMAS: &'static [&'static str] = &["turns/1"];
    const INPUTS: u32 = TATU_IN_POSE;
    const STATE: usize = 3;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Turns)
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let pose = sample.pose().ok_or_else(|| Fail::new("the host passed no pose"))?;
        let kept = out.state();
        if let Some(heading) = heading(&pose, 0.05) {
            if kept[BEGUN] != 0.0 {
                kept[SUM] += wrapped(heading - kept[LAST]) / TAU;
            }
            (kept[LAST], kept[BEGUN]) = (heading, 1.0);
        }
        let turns = kept[SUM];
        out.set(Self::TURNS, turns);
        Ok(())
    }
}

/// Returns the heading of the x axis of `pose`, or `None` if its projection is shorter than `least`.
fn heading(pose: &[f64; 7], least: f64) -> Option<f64> {
    let [_, _, _, x, y, z, w] = *pose;
    let (east, north) = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w));
    (east.hypot(north) > least).then(|| north.atan2(east))
}

/// Wraps `angle` to the interval (-pi, pi].
fn wrapped(angle: f64) -> f64 {
    let a = angle.rem_euclid(TAU);
    if a > PI { a - TAU } else { a }
}

tatu_plugin! {
    plugin: CompassPlugin, id: "org.example.compass", name: "Compass", version: "1.0.0", licence: "MIT",
}

#[test]
fn headings() {
    let turned = |z: f64| [0.0, 0.0, 0.0, 0.0, 0.0, (z / 2.0).sin(), (z / 2.0).cos()];
    assert!((heading(&turned(1.0), 0.05).unwrap() - 1.0).abs() < 1e-12);
    assert!((heading(&turned(-2.5), 0.05).unwrap() + 2.5).abs() < 1e-12);
    let up = [0.0, 0.0, 0.0, 0.0, -(PI / 4.0).sin(), 0.0, (PI / 4.0).cos()];
    assert_eq!(heading(&up, 0.05), None);
    assert!((wrapped(3.0 + 1.0) - (4.0 - TAU)).abs() < 1e-12);
}
