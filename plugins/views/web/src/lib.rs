//! A page in the browser that shows a world and steers it. What it shows and takes: `docs/reference/web-stream.md`.
//!
//! - `service`: what is done at the barrier; `show`: what clients are to see; `acts`: what clients ask for; `drop`:
//!   files that are dropped;
//! - `scene`: the scene as a whole; `frames`: what changed since; `readings`: what sensors, drawings and graphs show;
//! - `lists`: what is made once for all clients, and how often they may ask; `opened`: how a browser gets the address;
//! - `plugin`: the plugin, and keys that are read often; `windows`: what scripts opened; `pace`: how fast time passes;
//!   `files`: the page itself;
//! - `film`: a run is recorded; `film_page`: the page that shows it from a file.

mod acts;
mod drop;
mod files;
mod film;
mod film_page;
mod frames;
mod lists;
mod opened;
mod pace;
mod plugin;
mod readings;
mod scene;
mod service;
mod show;
mod windows;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use film::Film;
pub use plugin::WebPage;
pub use service::Web;

impl Plugin for WebPage {
    fn start(host: &Host) -> Result<Self> {
        Ok(WebPage { p: plugin::Props::new(host) })
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Web>();
        offer.service::<Film>();
    }
}

tatu_plugin! {
    plugin: WebPage,
    id: "tatu.view.web",
    name: "A page in the browser",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
