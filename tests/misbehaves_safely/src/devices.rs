//! Devices and a model whose declarations change each time they are read, and a sensor that reads its rays while aiming
//! them.

use std::sync::atomic::AtomicUsize;

use tatu_plugin_api::{abi::*, safe::*};

use crate::{MisbehavesPlugin, one_more_per_call};

const FIELD_NAMES: [&str; 4] =
    ["misbehaves_safely.grown", "misbehaves_safely.b", "misbehaves_safely.c", "misbehaves_safely.d"];

/// A sensor that declares more and longer fields at each call, and requests an image that no host supports.
pub struct GrowingSensor {
    image: u32,
}

impl Sensor for GrowingSensor {
    type Plugin = MisbehavesPlugin;
    const ID: &'static str = "misbehaves_safely";
    const TEXT: &'static str = "For tests.";
    const SCHEMAS: &'static [&'static str] = &["misbehaves_safely/1"];
    const INPUTS: u32 = 0;

    fn params() -> Vec<Param> {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let mut all = vec![Param::int("image").default(2_i64).text("Pixels in a row.")];
        all.extend(one_more_per_call(&CALLS, |i| Param::int(&format!("more{i}")).default(0_i64).text("Another.")));
        all
    }
    fn fields() -> Vec<Field> {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        let mut all = one_more_per_call(&CALLS, |i| {
            Field::f64(FIELD_NAMES[i % 4]).dims([1 + 1000 * i as u32, 1, 1]).text("Numbers.")
        });
        all.push(Field::f32("misbehaves_safely.image").dims([TATU_DIM_ROWS, TATU_DIM_COLUMNS, 1]).text("An image."));
        all
    }
    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(GrowingSensor { image: params.i64("image")? as u32 })
    }
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        self.image = params.i64("image")? as u32;
        Ok(Change::Taken)
    }
    fn beams(&self) -> Result<Beams> {
        let form = Form::Image { columns: self.image, rows: self.image, horizontal_angle: 1.0 };
        Ok(Beams { form, far: 1.0, ..Beams::default() })
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        for k in 0..8 {
            out.f64(k).fill(1.0 + sample.time());
            out.f32(k).fill(3.0);
            out.u8(k).fill(1);
        }
        Ok(())
    }
}

/// A sensor that reads its rays while it aims them.
pub struct AimingSensor;

impl Sensor for AimingSensor {
    type Plugin = MisbehavesPlugin;
    const ID: &'static str = "misbehaves_safely_aim";
    const TEXT: &'static str = "For tests.";
    const SCHEMAS: &'static [&'static str] = &["misbehaves_safely_aim/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        vec![Field::i32("misbehaves_safely_aim.rays").text("Number of rays that `measure` can read.")]
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(AimingSensor)
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::Rays(vec![[0.0, 0.0, 1.0]; 3]), far: 1.0, aimed: true, ..Beams::default() })
    }
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let seen = sample.rays();
        rays[0][5] = 1.0;
        match (rays.len(), seen.len()) {
            (3, 0) => Ok(()),
            (n, seen) => Err(Fail::new(format!("{n} rays can be aimed, but {seen} can be read; expected 3 and 0"))),
        }
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        out.i32(0).fill(sample.rays().len() as i32);
        Ok(())
    }
}

/// An actuator that declares more commands at each call.
pub struct GrowingActuator;

impl Actuator for GrowingActuator {
    type Plugin = MisbehavesPlugin;
    const ID: &'static str = "misbehaves_safely";
    const TEXT: &'static str = "For tests.";
    const STATE: usize = 1;

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn commands() -> Vec<Param> {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        one_more_per_call(&CALLS, |i| Param::float(&format!("push{i}")).default(0.0).unit("N").text("A push."))
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(GrowingActuator)
    }
    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        match drive.commands().len() {
            1 => {
                out.state.fill(1.0);
                Ok(())
            }
            n => Err(Fail::new(format!("{n} commands"))),
        }
    }
}

/// A model that declares more parameters at each call.
pub struct GrowingModel;

impl Model for GrowingModel {
    type Plugin = MisbehavesPlugin;
    const ID: &'static str = "misbehaves_safely";
    const TEXT: &'static str = "For tests.";

    fn params() -> Vec<Param> {
        static CALLS: AtomicUsize = AtomicUsize::new(0);
        one_more_per_call(&CALLS, |i| Param::float(&format!("size{i}")).default(0.5).unit("m").text("A size."))
    }
    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        params.f64("size0")?;
        if params.get("size1").is_ok() {
            return Err(Fail::new("the model has the parameter `size1`, which its first declaration does not contain"));
        }
        builder.object("dummy", None, "built").map(drop)
    }
}
