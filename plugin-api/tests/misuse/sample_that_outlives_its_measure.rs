//! A sample must not outlive the call of `measure`, and the world must not outlive the call of `create`.
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
    world: SharedWorld<'static>,
    last: std::sync::Mutex<&'static [f64]>,
}

impl Sensor for Eye {
    type Plugin = Mine;
    const ID: &'static str = "eye";
    const TEXT: &'static str = "Keeps.";
    const SCHEMAS: &'static [&'static str] = &["eye/1"];
    const INPUTS: u32 = 0;
    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn fields() -> Vec<Field> {
        Vec::new()
    }
    fn create(world: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Eye { world: *world, last: Default::default() })
    }
    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }
    fn measure(&self, sample: &Sample<'_>, _: &mut Readout<'_>) -> Result {
        *self.last.lock().unwrap() = sample.distances();
        self.world.log(1, b"seen");
        Ok(())
    }
}

fn main() {}
