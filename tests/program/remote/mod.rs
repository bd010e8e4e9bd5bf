//! Tests of the services, with the real clients of each protocol where they are available.

pub mod jsonl;
mod jsonl_clients;
pub mod legacy_remote;
mod masters;
mod next_scene;
pub mod rosbridge;
mod rosbridge_inertial;
mod rosbridge_scripts;
mod silence;
pub mod zmq_remote;
