//! A sensor to copy: one straight beam that measures the distance to the nearest object, in whole steps.
//!
//! Change the parts marked (1) to (6). README.md describes how to build the plugin and where to put the library.

use tatu_plugin_api::{abi::*, safe::*, tatu_plugin};

/// The plugin. Data shared by all its sensors would be stored here.
struct ExamplePlugin;

impl Plugin for ExamplePlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ExamplePlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<ExampleRange>();
    }
}

/// (1) The data of one sensor in a scene.
struct ExampleRange {
    range: f64,
    step: f64,
}

impl Sensor for ExampleRange {
    type Plugin = ExamplePlugin;

    // (2) The kind's name in scene files, one sentence that describes it, and its schema (see plugin-api/schemas).
    const ID: &'static str = "example_range";
    const TEXT: &'static str = "Tells how far the next thing straight ahead is.";
    const SCHEMAS: &'static [&'static str] = &["proximity/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_POINT | TATU_IN_NORMAL | TATU_IN_OBJECT;

    // (3) The parameters, with unit, range and default. The parameter `range`, in metres, is `range_m` in scene files.
    fn params() -> Vec<Param> {
        let metres = |key| Param::float(key).unit("m").range(0.0, 1e6);
        vec![
            metres("range").default(2.0).text("How far it sees."),
            metres("step").default(0.001).text("Smallest step of its distance."),
        ]
    }

    // (4) The fields of its readings: all fields of the schema, which defines their meaning, or your own fields.
    fn fields() -> Vec<Field> {
        vec![
            Field::i32("proximity.detected"),
            Field::f64("proximity.distance").unit("m"),
            Field::f64("proximity.point").dims([3, 1, 1]).unit("m"),
            Field::object("proximity.object"),
            Field::f64("proximity.normal").dims([3, 1, 1]).unit("1"),
        ]
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(ExampleRange { range: params.f64("range")?, step: params.f64("step")? })
    }

    // Both parameters can change during a run. Without this function, or for a parameter with `.rebuilds()` in (3), a
    // change creates the sensor anew.
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        (self.range, self.step) = (params.f64("range")?, params.f64("step")?);
        Ok(Change::Taken)
    }

    // (5) The beams: rays along unit vectors in the sensor's frame, or a cone; +z points forward.
    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::Rays(vec![[0.0, 0.0, 1.0]]), far: self.range, ..Beams::default() })
    }

    // (6) Computes the reading from the results of the beams. Fields are indexed from 0 in the order of (4); the host
    // has set them to 0.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let distance = sample.distances()[0];
        if distance.is_finite() {
            out.i32(0)[0] = 1;
            out.f64(1)[0] = in_steps(distance, self.step);
            out.f64(2).copy_from_slice(&sample.points()[0]);
            out.object(3)[0] = sample.objects()[0];
            out.f64(4).copy_from_slice(&sample.normals()[0]);
        }
        Ok(())
    }
}

/// Rounds `x` to the nearest multiple of `step`; returns `x` itself if `step` is 0.
fn in_steps(x: f64, step: f64) -> f64 {
    let steps = (x / step).round();
    if step > 0.0 { steps * step } else { x }
}

tatu_plugin! {
    plugin: ExamplePlugin, id: "org.example.range", name: "Example range sensor", version: "0.1.0", licence: "MIT",
}

#[test]
fn distances_come_in_steps() {
    assert!((in_steps(1.2345, 0.01) - 1.23).abs() < 1e-12);
    assert_eq!(in_steps(1.2345, 0.0), 1.2345);
}
