//! A template for a sensor: a single beam along +z measures the distance to the nearest object, rounded to steps.
//!
//! Change the parts marked (1) to (6); README.md describes how to build the sensor and where to put the library.

use tatu_plugin_api::{abi::*, fields, safe::*, tatu_plugin};

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

/// One sensor of a scene: (1) its parameters and other data.
struct ExampleRange {
    range: f64,
    step: f64,
}

// (4) The fields of a reading: all fields of a schema, which defines their meaning, or your own fields. `measure`
// writes them by these names.
fields! {
    ExampleRange {
        DETECTED: i32 = Field::new("proximity.detected");
        DISTANCE: f64 = Field::new("proximity.distance").unit("m");
        POINT: f64 = Field::new("proximity.point").elements(3).unit("m");
        OBJECT: tatu_object = Field::new("proximity.object");
        NORMAL: f64 = Field::new("proximity.normal").elements(3).unit("1");
    }
}

impl Sensor for ExampleRange {
    type Plugin = ExamplePlugin;

    // (2) Its name in scenes, a description of one sentence, and the schema that it fills (see plugin-api/schemas).
    const ID: &'static str = "example_range";
    const TEXT: &'static str = "Measures the distance to the nearest object straight ahead.";
    const SCHEMAS: &'static [&'static str] = &["proximity/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_POINT | TATU_IN_NORMAL | TATU_IN_OBJECT;

    // (3) The parameters, with unit, range and default; `range` in metres is written `range_m` in scenes.
    fn params() -> Vec<Param> {
        let metres = |key| Param::float(key).unit("m").range(0.0, 1e6);
        vec![
            metres("range").default(2.0).text("Maximum range."),
            metres("step").default(0.001).text("Step to which the distance is rounded; 0: not rounded."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(ExampleRange { range: params.f64("range")?, step: params.f64("step")? })
    }

    // Both parameters may change during a run. Without this, or with `.rebuilds()` in (3), a change recreates the
    // sensor.
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        (self.range, self.step) = (params.f64("range")?, params.f64("step")?);
        Ok(Change::Taken)
    }

    // (5) The beams: rays along unit vectors in the sensor's frame, or a volume such as a cone; +z points ahead.
    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::Rays(vec![[0.0, 0.0, 1.0]]), far: self.range, ..Beams::default() })
    }

    // (6) Computes the fields from the results of the beams. All fields are 0 initially.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let distance = sample.distances()[0];
        if distance.is_finite() {
            out.set(Self::DETECTED, 1);
            out.set(Self::DISTANCE, in_steps(distance, self.step));
            out.slice(Self::POINT).copy_from_slice(&sample.points()[0]);
            out.set(Self::OBJECT, sample.objects()[0]);
            out.slice(Self::NORMAL).copy_from_slice(&sample.normals()[0]);
        }
        Ok(())
    }
}

/// Rounds `x` to the nearest multiple of `step`; returns `x` if `step` is 0.
fn in_steps(x: f64, step: f64) -> f64 {
    let steps = (x / step).round();
    if step > 0.0 { steps * step } else { x }
}

tatu_plugin! {
    plugin: ExamplePlugin, id: "org.example.range", name: "Example range sensor", version: "0.1.0", licence: "MIT",
}

#[test]
fn distances_are_multiples_of_the_step() {
    assert!((in_steps(1.2345, 0.01) - 1.23).abs() < 1e-12);
    assert_eq!(in_steps(1.2345, 0.0), 1.2345);
}
