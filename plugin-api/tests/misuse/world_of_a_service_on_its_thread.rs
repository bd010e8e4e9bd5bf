//! Threads of a service must not access a world: they queue requests and wake the session.
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
        offer.service::<Listener>();
    }
}

struct Listener;

impl Service for Listener {
    type Plugin = Mine;
    const ID: &'static str = "listener";
    const TEXT: &'static str = "Listens.";
    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn start(_: &Mine, _: &Host, _: Session, _: &Params<'_>) -> Result<Self> {
        Ok(Listener)
    }
    fn barrier(&self, turn: &Turn<'_>, _: u64) -> Result<Answer> {
        std::thread::scope(|s| {
            s.spawn(|| turn.call("sim.getSimulationTime", &[], 0));
        });
        Ok(Answer::Go)
    }
}

fn main() {}
