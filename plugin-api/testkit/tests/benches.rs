//! Sensors and actuators without a host: images, aimed rays, state, random numbers, and inputs that do not fit.

#![allow(missing_docs)]

use tatu_plugin_api::{abi::*, fields, safe::*};
use tatu_plugin_testkit::{Inputs, Random, SensorBench, measure, measure_all};

struct EmptyPlugin;

impl Plugin for EmptyPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(EmptyPlugin)
    }
    fn offer(_: &mut Offer<Self>) {}
}

/// An image of `columns` by 2 pixels. Its fields are the depths, the mean of each row, `own` zeros, and the objects.
struct ImageSensor {
    columns: u32,
    own: u32,
}

fields! {
    ImageSensor {
        DEPTH: f32 = Field::new("eye.depth").dims([TATU_DIM_ROWS, TATU_DIM_COLUMNS, 1]);
        MEAN: f64 = Field::new("eye.mean").dims([TATU_DIM_ROWS, 1, 1]);
        OWN: u8 = Field::new("eye.own").dims([TATU_DIM_OWN, 1, 1]);
        SEEN: tatu_object = Field::new("eye.seen").per_beam();
    }
}

impl Sensor for ImageSensor {
    type Plugin = EmptyPlugin;
    const ID: &'static str = "eye";
    const TEXT: &'static str = "Depths.";
    const SCHEMAS: &'static [&'static str] = &["eye/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_OBJECT | TATU_IN_POSE;

    fn params() -> Vec<Param> {
        vec![Param::int("columns").range(1.0, 100.0).default(3).rebuilds(), Param::int("own").default(0)]
    }
    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }
    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(ImageSensor { columns: params.i64("columns")? as u32, own: params.i64("own")? as u32 })
    }
    fn beams(&self) -> Result<Beams> {
        let form = Form::Image { columns: self.columns, rows: 2, horizontal_angle: 1.0 };
        Ok(Beams { form, far: 10.0, own: [self.own, 0, 0, 0], ..Beams::default() })
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        assert!(sample.pose().is_some() && sample.twist().is_none() && sample.distances().is_empty());
        out.slice(Self::DEPTH).copy_from_slice(sample.depths());
        out.slice(Self::SEEN).copy_from_slice(sample.pixel_objects());
        let rows = sample.depths().chunks(self.columns as usize);
        let mean = |row: &[f32]| row.iter().map(|d| f64::from(*d)).sum::<f64>() / f64::from(self.columns);
        out.slice(Self::MEAN).iter_mut().zip(rows).for_each(|(m, row)| *m = mean(row));
        Ok(())
    }
}

#[test]
fn images_have_rows_and_columns() {
    let inputs = Inputs { depth: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], ..Inputs::default() };
    let reading = measure::<ImageSensor>(&[("own", 5.into())], inputs.clone()).unwrap();
    assert_eq!(reading.f64s("eye.depth").unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(reading.f64s("eye.mean").unwrap(), [2.0, 5.0]);
    assert_eq!(reading.f64s("eye.own").unwrap(), [0.0; 5]);
    assert_eq!(reading.objects("eye.seen").unwrap(), [1; 6]);
    // A batch of two sensors, one of which has no hits.
    let both = measure_all::<ImageSensor>(&[], vec![Inputs::default(), inputs]).unwrap();
    assert_eq!(both[0].objects("eye.seen").unwrap(), [0; 6]);
    assert_eq!(both[1].f64s("eye.mean").unwrap(), [2.0, 5.0]);
}

#[test]
fn inputs_of_wrong_size_are_refused() {
    let told =
        |params: &[(&str, Value)], inputs: Inputs| measure::<ImageSensor>(params, inputs).unwrap_err().to_string();
    let short = Inputs { depth: vec![1.0], ..Inputs::default() };
    assert!(told(&[], short).contains("`depth` has 1 elements, but must have 6"));
    let foreign = Inputs { twist: [0.0; 6], distance: vec![1.0], ..Inputs::default() };
    assert!(told(&[], foreign).contains("`distance` has 1 elements, but the sensor does not receive it"));
    assert!(told(&[("colums", 2.into())], Inputs::default()).contains("declared parameters are: columns, own"));
    assert!(told(&[("columns", 200.into())], Inputs::default()).contains("200 is not within 1 to 100"));
    assert!(told(&[("columns", "x".into())], Inputs::default()).contains("expected an integer, found a text"));
    let endless = Inputs { depth: vec![f32::NAN; 6], ..Inputs::default() };
    assert!(told(&[], endless).contains("`eye.depth` contains NaN"));
    let reading = measure::<ImageSensor>(&[], Inputs::default()).unwrap();
    assert!(reading.f64("eye.depth").unwrap_err().to_string().contains("6 elements, but `f64` needs 1"));
    assert!(reading.f64("eye.dept").unwrap_err().to_string().contains("expected: one of eye.depth"));
}

#[test]
fn rebuilding_parameter_creates_a_new_sensor() {
    let mut eye = SensorBench::<ImageSensor>::new(&[]).unwrap();
    eye.set("columns", 1).unwrap();
    assert_eq!(eye.measure(Inputs::default()).unwrap().f64s("eye.depth").unwrap().len(), 2);
}

/// A sensor with a ray that is turned by a random angle, and a counter of measurements.
struct JitterSensor;

fields! {
    JitterSensor {
        POINT: f64 = Field::new("jitter.point").elements(3);
        COUNT: i32 = Field::new("jitter.count");
    }
}

impl Sensor for JitterSensor {
    type Plugin = EmptyPlugin;
    const ID: &'static str = "jitter";
    const TEXT: &'static str = "Looks aside.";
    const SCHEMAS: &'static [&'static str] = &["jitter/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_POINT;
    const STATE: usize = 1;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }
    fn create(world: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        // Without a host, functions of the world fail.
        assert!(world.pose(1, 0).is_err());
        Ok(JitterSensor)
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::Rays(vec![[0.0, 0.0, 1.0]]), far: 5.0, aimed: true, ..Beams::default() })
    }
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let mut turn = [0.0];
        sample.normal(0, &mut turn);
        rays[0] = [0.0, 0.0, 0.0, turn[0].sin(), 0.0, turn[0].cos()];
        Ok(())
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        assert_eq!(sample.rays().len(), 1);
        out.slice(Self::POINT).copy_from_slice(&sample.points()[0]);
        out.state()[0] += 1.0;
        let count = out.state()[0] as i32;
        out.set(Self::COUNT, count);
        Ok(())
    }
}

#[test]
fn rays_are_aimed_and_state_persists() {
    let mut jitter = SensorBench::<JitterSensor>::new(&[]).unwrap();
    let ahead = Inputs { distance: vec![2.0], ..Inputs::default() };
    assert_eq!(jitter.measure(ahead.clone()).unwrap().f64s("jitter.point").unwrap(), [0.0, 0.0, 2.0]);
    let aside = Inputs { random: Random::Fixed(vec![std::f64::consts::FRAC_PI_6]), ..ahead };
    let reading = jitter.measure(aside).unwrap();
    let point = reading.f64s("jitter.point").unwrap();
    // The components are the sine and the cosine of 30 degrees, times the distance.
    assert!((point[0] - 1.0).abs() < 1e-12 && (point[2] - f64::sqrt(3.0)).abs() < 1e-12, "{point:?}");
    assert_eq!((reading.f64("jitter.count").unwrap(), reading.state.as_slice()), (2.0, [2.0].as_slice()));
}
