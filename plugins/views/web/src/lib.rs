//! A web page that shows a world and controls it. `docs/reference/web-stream.md` describes the protocol.
//!
//! - `service`: the service and its work at each barrier; `show`: messages to clients; `requests`: requests from
//!   clients; `drop`: files dropped on the page;
//! - `scene`: the complete scene; `copies`: equal models in it; `frames`: motion of its objects; `changes`: all other
//!   changes of objects; `readings`: data of sensors, drawings and graphs;
//! - `sent`: what a client has received last;
//! - `protocol`: the types of all text messages;
//! - `edits`: the state of undo and redo, and backup copies of unsaved edits;
//! - `gallery`: the scenes that the page offers; `recent`: recently shown scenes, stored for later runs;
//! - `lists`: lists shared by all clients, and the rate limit of requests; `browser`: passes the address to a browser;
//! - `plugin`: the plugin, and interned property keys; `windows`: windows of scripts; `pace`: the speed relative to
//!   real time; `files`: the embedded files of the page;
//! - `overlays`: contacts, centres of mass and velocities; `watch`: values that clients request for each step;
//! - `recorder`: records a run; `film`: the service that writes a recording to a file; `film_page`: the page that plays
//!   it.

mod browser;
mod changes;
mod copies;
mod drop;
mod edits;
mod files;
mod film;
mod film_page;
mod frames;
mod gallery;
mod lists;
mod overlays;
mod pace;
mod plugin;
mod protocol;
mod readings;
mod recent;
mod recorder;
mod requests;
mod scene;
mod sent;
mod service;
mod show;
mod watch;
mod windows;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use film::FilmService;
pub use plugin::WebPage;
pub use service::WebService;

impl Plugin for WebPage {
    fn start(host: &Host) -> Result<Self> {
        Ok(WebPage { p: plugin::Props::new(host) })
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<WebService>();
        offer.service::<FilmService>();
    }
}

tatu_plugin! {
    plugin: WebPage,
    id: "tatu.view.web",
    name: "A page in the browser",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
