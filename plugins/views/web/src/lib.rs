//! A page in the browser that shows a world and steers it. What it shows and takes: `docs/reference/web-stream.md`.
//!
//! - `service`: what is done at the barrier; `show`: what clients are to see; `acts`: what clients ask for; `drop`: files that are dropped;
//! - `scene`: the scene as a whole; `frames`: what changed since; `readings`: what sensors, drawings and graphs show;
//! - `lists`: what is made once for all clients, and how often they may ask; `opened`: how a browser is told the address;
//! - `windows`: what scripts opened; `pace`: how fast time passes; `files`: the page itself;
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
mod readings;
mod scene;
mod service;
mod show;
mod windows;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Prop, Result, World},
    tatu_plugin,
};

pub use film::Film;
pub use service::Web;

macro_rules! props {
    ($($name:ident: $key:literal,)*) => {
        /// Keys that are read often.
        #[derive(Clone, Copy)]
        pub struct Props { $($name: Prop,)* }
        impl Props {
            fn new(host: &Host) -> Self {
                Props { $($name: host.prop($key),)* }
            }
        }
    };
}
props! {
    alias: "object.alias",
    kind: "object.kind",
    parent: "object.parent",
    pose: "object.pose",
    visible: "object.visible",
    layer: "object.layer",
    model_base: "object.model_base",
    joint_type: "joint.type",
    joint_position: "joint.position",
    joint_rotation: "joint.rotation",
    joint_lead: "joint.lead",
    sensor_kind: "sensor.kind",
    script_name: "script.name",
    script_kind: "script.kind",
    script_language: "script.language",
    points: "path.points",
    closed: "path.closed",
    time: "scene.time",
    dt: "scene.dt",
    file: "scene.file",
    detected: "proximity.detected",
    distance: "proximity.distance",
    point: "proximity.point",
    scan_distance: "range_scan.distance",
    scan_angle: "range_scan.angle",
    depth: "depth_image.depth",
    rgb: "color_image.rgb",
    gps: "gps.position",
}

/// The plugin.
pub struct WebPage {
    p: Props,
}

impl Plugin for WebPage {
    type World = ();

    fn start(host: &Host) -> Result<Self> {
        Ok(WebPage { p: Props::new(host) })
    }
    fn world(&self, _: &World<'_>) -> Result<()> {
        Ok(())
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
