//! Sensors are measured on several threads, so their state must be `Sync`.
use tatu_plugin_api::safe::*;

struct Mine;

impl PerWorld for Mine {
    type World = std::cell::RefCell<Vec<f64>>;
    fn world(&self, _: &World<'_>) -> Result<Self::World> {
        Ok(Default::default())
    }
}
impl Plugin for Mine {
    fn start(_: &Host) -> Result<Self> { Ok(Mine) }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Eye>();
    }
}

struct Eye {
    seen: std::rc::Rc<std::cell::Cell<u32>>,
}

impl Sensor for Eye {
    type Plugin = Mine;
    const ID: &'static str = "eye";
    const TEXT: &'static str = "Counts.";
    const SCHEMAS: &'static [&'static str] = &["eye/1"];
    const INPUTS: u32 = 0;
    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        Vec::new()
    }
    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Eye { seen: Default::default() })
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }
    fn measure(&self, _: &Sample<'_>, _: &mut Readout<'_>) -> Result {
        self.seen.set(self.seen.get() + 1);
        Ok(())
    }
}

fn main() {}
