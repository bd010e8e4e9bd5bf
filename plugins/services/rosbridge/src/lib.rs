//! The rosbridge service: ROS clients connect by WebSocket, read sensors of a scene as topics, and drive its robots.
//!
//! - `plugin`: the state of the plugin; `types`: definitions of message types; `convert`: converts messages between
//!   values, JSON and CBOR;
//! - `robots`: robots and sensors of a scene, and wheel odometry; `poses`: calculations with poses;
//! - `topics`: topics that the scene provides; `messages`, `felt`: their messages; `covariance`: covariances of
//!   readings; `description`: robots as URDF;
//! - `protocol`: parses requests from clients; `peers`: clients and their subscriptions; `relay`: forwards calls and
//!   goals between clients and scripts;
//! - `acts`: executes requests from clients; `rosapi`: introspection; `service`: the service and its work at each
//!   barrier;
//! - `scripts`: `simROS` and `simROS2`, the commands for scripts; `times`, `images`, `pixels`, `bytes`, `params`:
//!   further commands; `node`: endpoints that scripts have opened;
//! - `goals`: goals of actions; `actions`: commands for actions; `between`: commands that only the service calls;
//!   `goals_of_scripts`, `goals_of_clients`: handling of goals on the side of scripts and of the service.

mod actions;
mod acts;
mod between;
mod bytes;
mod convert;
mod covariance;
mod description;
mod felt;
mod goals;
mod goals_of_clients;
mod goals_of_scripts;
mod images;
mod messages;
mod node;
mod params;
mod peers;
mod pixels;
mod plugin;
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
    safe::{Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

pub use plugin::Ros;
pub(crate) use plugin::{Ctx, Props};
pub use service::Rosbridge;

impl Plugin for Ros {
    fn start(host: &Host) -> Result<Self> {
        Ok(Ros { p: Props::new(host) })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.service::<Rosbridge>();
        offer.subject("ros2", |offer| {
            scripts::offer(offer);
            actions::offer(offer);
            bytes::offer(offer);
            images::images(offer);
            params::params(offer);
            times::times(offer);
        });
        offer.subject("rosbridge", |offer| {
            scripts::between(offer);
            between::offer(offer);
        });
    }
}

impl PerWorld for Ros {
    type World = node::Node;

    fn world(&self, _: &World<'_>) -> Result<node::Node> {
        Ok(node::Node::default())
    }

    const OUTLIVES_RUNS: bool = true;
    fn end_run(&self, node: &node::Node, world: &World<'_>) -> Result<()> {
        node.end_run(world)
    }

    const STATE_VERSION: u32 = 2;
    fn save(node: &node::Node) -> Result<Vec<u8>> {
        node.write()
    }
    fn load(node: &node::Node, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            let text = format!(
                "its state was saved in format version {version}, but this program reads only version {}",
                Self::STATE_VERSION
            );
            return Err(Fail::unsupported(text));
        }
        *node.all()? =
            serde_json::from_slice(bytes).map_err(|e| Fail::new(format!("its saved state is damaged: {e}")))?;
        Ok(())
    }
}

tatu_plugin! {
    plugin: Ros,
    id: "tatu.service.rosbridge",
    name: "rosbridge",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
