//! Arguments, values and texts must not outlive the call to which they were passed.
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
            *LAST.lock().unwrap() = c.bytes(0)?;
            Ok(())
        }));
    }
}

fn main() {}
