//! rosbridge: clients of ROS on a WebSocket read the sensors of a scene as topics, and steer its robots.
//!
//! - `types`: what messages are made of; `convert`: messages as JSON, CBOR and values;
//! - `robots`: what a scene holds, and how far wheels have driven; `poses`: frames;
//! - `topics`: which topics there are by themselves; `messages`: what they tell;
//! - `protocol`: what clients ask; `peers`: what each has asked for; `relay`: what clients offer each other;
//! - `acts`: what is done for clients; `rosapi`: what there is; `service`: the barrier;
//! - `scripts`: `simROS` and `simROS2`, by which scripts take part; `times`, `images`, `params`: more of them; `node`: what they have open.

mod acts;
mod convert;
mod images;
mod messages;
mod node;
mod params;
mod peers;
mod poses;
mod protocol;
mod relay;
mod robots;
mod rosapi;
mod scripts;
mod service;
mod times;
mod topics;
mod types;

use tatu_plugin_api::{
    safe::{Call, Fail, Host, Offer, Plugin, Prop, Result, World},
    tatu_plugin,
};

pub use service::Rosbridge;

macro_rules! props {
    ($($name:ident: $key:literal,)*) => {
        /// Keys that are read often.
        #[derive(Clone, Copy)]
        pub(crate) struct Props { wheels: tatu_robots_drivetrain::Props, $($name: Prop,)* }
        impl Props {
            fn new(host: &Host) -> Self {
                Props { wheels: tatu_robots_drivetrain::Props::new(host), $($name: host.prop($key),)* }
            }
        }
    };
}
props! {
    alias: "object.alias",
    name: "object.name",
    parent: "object.parent",
    model_base: "object.model_base",
    joint_type: "joint.type",
    effort: "joint.effort",
    sensor_kind: "sensor.kind",
    rate: "sensor.rate",
    time: "scene.time",
    dt: "scene.dt",
    scan_distance: "range_scan.distance",
    scan_angle: "range_scan.angle",
    scan_limits: "range_scan.limits",
    scan_elevation: "range_scan.elevation",
    scan_intensity: "range_scan.intensity",
    detected: "proximity.detected",
    distance: "proximity.distance",
    fix_valid: "gps.valid",
    latitude: "gps.latitude",
    longitude: "gps.longitude",
    altitude: "gps.altitude",
    rgb: "color_image.rgb",
    depth: "depth_image.depth",
    intrinsics: "depth_image.intrinsics",
    parallel: "depth_image.parallel",
}

/// A running command of this plugin.
type Ctx<'a> = Call<'a, Ros>;

/// The plugin.
pub struct Ros {
    p: Props,
}

impl Plugin for Ros {
    type World = node::Node;

    fn start(host: &Host) -> Result<Self> {
        Ok(Ros { p: Props::new(host) })
    }
    fn world(&self, _: &World<'_>) -> Result<node::Node> {
        Ok(node::Node::default())
    }

    const STATE_VERSION: u32 = 1;
    fn save(node: &node::Node) -> Result<Vec<u8>> {
        node.write()
    }
    fn load(node: &node::Node, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            let text = format!("its state has version {version}, and it reads {}", Self::STATE_VERSION);
            return Err(Fail::unsupported(text));
        }
        *node.all()? =
            serde_json::from_slice(bytes).map_err(|e| Fail::new(format!("its state cannot be read: {e}")))?;
        Ok(())
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Rosbridge>();
        scripts::offer(offer);
    }
}

tatu_plugin! {
    plugin: Ros,
    id: "tatu.service.rosbridge",
    name: "rosbridge",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
