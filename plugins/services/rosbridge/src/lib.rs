//! The rosbridge service: ROS clients connect by WebSocket, read sensors of a scene as topics, and drive its robots.
//!
//! - `plugin`: the state of the plugin; `types`: definitions of message types; `convert`: converts messages between
//!   values, JSON and CBOR;
//! - `robots`: robots and sensors of a scene, and wheel odometry; `poses`: calculations with poses;
//! - `topics`: topics that the scene provides; `messages`, `simple_readings`: their messages; `declared_messages`: those
//!   that other plugins build; `covariance`: covariances of readings; `description`: robots as URDF;
//! - `protocol`: parses requests from clients; `peers`: clients and their subscriptions; `relay`: forwards calls and
//!   goals between clients and scripts;
//! - `requests`: executes requests from clients; `rosapi`: introspection; `service`: the service and its work at each
//!   barrier;
//! - `joint_trajectories`: joints that follow trajectories of clients;
//! - `scripts`: `simROS` and `simROS2`, the commands for scripts; `times`, `images`, `pixels`, `bytes`, `params`:
//!   further commands; `node`: endpoints that scripts have opened;
//! - `goals`: goals of actions; `actions`: commands for actions; `service_commands`: commands that only the service
//!   calls; `script_goals`, `client_goals`: handling of goals on the side of scripts and of the service.

mod actions;
mod bytes;
mod client_goals;
mod convert;
mod covariance;
mod declared_messages;
mod description;
mod goals;
mod images;
mod joint_trajectories;
mod messages;
mod node;
mod params;
mod peers;
mod pixels;
mod plugin;
mod poses;
mod protocol;
mod relay;
mod requests;
mod robots;
mod rosapi;
mod script_goals;
mod scripts;
mod service;
mod service_commands;
mod simple_readings;
mod times;
mod topics;
mod types;

use tatu_plugin_api::{
    safe::{Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

pub use plugin::RosPlugin;
pub(crate) use plugin::{Props, RosCall};
pub use service::RosbridgeService;

impl Plugin for RosPlugin {
    fn start(host: &Host) -> Result<Self> {
        Ok(RosPlugin { p: Props::new(host) })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.service::<RosbridgeService>();
        offer.subject("ros2", |offer| {
            scripts::offer(offer);
            actions::offer(offer);
            bytes::offer(offer);
            images::images(offer);
            params::params(offer);
            times::times(offer);
        });
        offer.subject("rosbridge", |offer| {
            scripts::offer_service_commands(offer);
            service_commands::offer(offer);
        });
    }
}

impl PerWorld for RosPlugin {
    type World = node::RosNode;

    fn world(&self, _: &World<'_>) -> Result<node::RosNode> {
        Ok(node::RosNode::default())
    }

    const OUTLIVES_RUNS: bool = true;
    fn end_run(&self, node: &node::RosNode, world: &World<'_>) -> Result<()> {
        node.end_run(world)
    }

    const STATE_VERSION: u32 = 2;
    fn save(node: &node::RosNode) -> Result<Vec<u8>> {
        node.write()
    }
    fn load(node: &node::RosNode, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            let text = format!(
                "the ROS state was saved in format version {version}, but this plugin reads only version {}",
                Self::STATE_VERSION
            );
            return Err(Fail::unsupported(text));
        }
        *node.state()? =
            serde_json::from_slice(bytes).map_err(|e| Fail::new(format!("the saved ROS state is damaged: {e}")))?;
        Ok(())
    }
}

tatu_plugin! {
    plugin: RosPlugin,
    id: "tatu.service.rosbridge",
    name: "rosbridge",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
