//! Worlds on several threads call a command's function, so it must not capture state that belongs to one thread.
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
        let calls = std::rc::Rc::new(std::cell::Cell::new(0));
        offer.command(Command::new("mine.count", move |_| {
            calls.set(calls.get() + 1);
            Ok(())
        }));
    }
}

fn main() {}
