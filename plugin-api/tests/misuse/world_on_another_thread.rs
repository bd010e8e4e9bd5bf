//! A world belongs to one thread, and cannot be sent to another.
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
        offer.command(Command::new("mine.look", |c| {
            let world = c.world();
            std::thread::scope(|s| {
                s.spawn(|| world.pose(1, 0));
            });
            Ok(())
        }));
    }
}

fn main() {}
