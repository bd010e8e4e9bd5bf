//! A property that the host returns must not outlive the call in which it was read.
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
        static LAST: std::sync::Mutex<&[u8]> = std::sync::Mutex::new(&[]);
        offer.command(Command::new("mine.keep", |c| {
            let world = c.world();
            let alias = world.get(c.caller_object(), world.host().prop("object.alias"))?;
            *LAST.lock().unwrap() = alias.as_bytes().unwrap_or_default();
            Ok(())
        }));
    }
}

fn main() {}
