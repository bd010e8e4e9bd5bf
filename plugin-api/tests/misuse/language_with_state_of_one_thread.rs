//! Scripts that run in parallel are sent to other threads, so their state must be `Send`.
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
        offer.language_side_by_side::<Script>();
    }
}

struct Script(std::rc::Rc<()>);

impl Language for Script {
    type Plugin = Mine;
    const ID: &'static str = "mine";
    const TEXT: &'static str = "Does nothing.";
    const SUFFIXES: &'static [&'static str] = &[".mine"];
    fn create(_: &World<'_>, _: Instance) -> Result<Self> {
        Ok(Script(Default::default()))
    }
    fn load(&self, _: &[u8], _: &str, _: &str) -> Result<String> {
        Ok(String::new())
    }
    fn find(&self, _: u32, _: &[u8]) -> u32 {
        0
    }
    fn call(&self, _: u32, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Ok(Flow::Done)
    }
    fn resume(&self, _: u64, _: Option<Fail>, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Ok(Flow::Done)
    }
    fn keep_func(&self, _: u32) -> u32 {
        0
    }
    fn drop_func(&self, _: u32) {}
    fn call_func(&self, _: u32, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Ok(Flow::Done)
    }
}

fn main() {}
