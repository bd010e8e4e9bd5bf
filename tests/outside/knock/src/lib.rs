//! A sensor that detects and counts impacts, with its own schema, knock/1.

use tatu_plugin_api::{
    abi::TATU_IN_ACCELERATION,
    fields,
    safe::{
        Beams, Fail, Field, Host, Instance, Offer, Param, Params, Plugin, Readout, Result, Sample, Sensor, SharedWorld,
    },
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct Knocks;

impl Plugin for Knocks {
    fn start(_: &Host) -> Result<Self> {
        Ok(Knocks)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Knock>();
    }
}

/// A sensor in a scene.
pub struct Knock {
    /// Specific force above which an impact is counted, m/s^2.
    threshold: f64,
}

fields! {
    Knock {
        STRENGTH: f64 = Field::new("knock.strength").unit("m/s^2").text("Specific force in the last physics step.");
        COUNT: i32 = Field::new("knock.count").text("How many times it has risen above the threshold.");
    }
}

impl Sensor for Knock {
    type Plugin = Knocks;
    const ID: &'static str = "knock";
    const TEXT: &'static str = "Feels blows, and counts them.";
    const SCHEMAS: &'static [&'static str] = &["knock/1"];
    const INPUTS: u32 = TATU_IN_ACCELERATION;
    const EVERY_PHYSICS_STEP: bool = true;
    /// Two values: the count, and whether the force is above the threshold.
    const STATE: usize = 2;

    fn params() -> Vec<Param> {
        vec![
            Param::float("threshold")
                .unit("m/s^2")
                .range(10.0, 1e6)
                .default(50.0)
                .text("Specific force that counts as a blow.")
                .rebuilds(),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Knock { threshold: params.f64("threshold")? })
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let Some(acceleration) = sample.acceleration() else {
            return Err(Fail::unsupported("this host does not provide the acceleration of sensors"));
        };
        let force = sample.gravity().iter().zip(acceleration).map(|(g, a)| (a - g) * (a - g)).sum::<f64>().sqrt();
        let above = f64::from(u8::from(force > self.threshold));
        if let [count, was_above] = out.state() {
            *count += (above - *was_above).max(0.0);
            *was_above = above;
        }
        let count = out.state().first().copied().unwrap_or(0.0);
        out.set(Self::STRENGTH, force);
        out.set(Self::COUNT, count as i32);
        Ok(())
    }
}

tatu_plugin! {
    plugin: Knocks, id: "org.example.knock", name: "Knock", version: "1.0.0", licence: "MIT",
}
