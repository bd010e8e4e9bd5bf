//! A plugin as it was built with this revision of the contract: a command, what it keeps per world, and a sensor.
//! A frozen copy of this file lies beside the sources of its crate; see `tests/compat/README.md`.

#![allow(missing_docs, reason = "a plugin for tests")]

use std::cell::Cell;

use tatu_plugin_api::{abi::*, safe::*, tatu_plugin};

struct OfOld;

impl Plugin for OfOld {
    type World = Cell<i64>;

    fn start(_: &Host) -> Result<Self> {
        Ok(OfOld)
    }
    fn world(&self, _: &World<'_>) -> Result<Cell<i64>> {
        Ok(Cell::new(0))
    }
    fn offer(offer: &mut Offer<Self>) {
        let twice = Command::<OfOld>::new("oldrust.twice", |c| {
            let x = c.f64(0)?;
            c.instance().set(c.instance().get() + 1);
            c.ret(2.0 * x);
            Ok(())
        });
        offer.command(twice.param(Param::float("number").text("Any.")).text("Doubles."));
        let count = Command::<OfOld>::new("oldrust.count", |c| {
            let n = c.instance().get();
            c.ret(n);
            Ok(())
        });
        offer.command(count.text("How often twice was called."));
        offer.sensor::<Eye>();
    }
}

struct Eye {
    range: f64,
}

impl Sensor for Eye {
    type Plugin = OfOld;
    const ID: &'static str = "oldrust_eye";
    const TEXT: &'static str = "One ray ahead.";
    const SCHEMAS: &'static [&'static str] = &["oldrust/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE;

    fn params() -> Vec<Param> {
        vec![Param::float("range").unit("m").range(0.0, 100.0).default(2.0).text("How far it sees.").rebuilds()]
    }
    fn fields() -> Vec<Field> {
        vec![Field::f64("oldrust.distance").unit("m")]
    }
    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Eye { range: params.f64("range")? })
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::Rays(vec![[0.0, 0.0, 1.0]]), far: self.range, ..Beams::default() })
    }
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let distance = sample.distances()[0];
        out.f64(0)[0] = if distance.is_finite() { distance } else { 0.0 };
        Ok(())
    }
}

tatu_plugin! {
    plugin: OfOld, id: "org.tatu.compat.rust", name: "Of old", version: "1", licence: "MIT",
}
