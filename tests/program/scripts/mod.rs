//! Tests of scripts: when each is called, what is preserved for scripts of old versions of V-REP, what commands return,
//! what windows contain, how scripts are isolated from each other.

mod addons;
mod cascades;
mod catalogue;
mod driver;
mod endless;
mod eras;
mod events;
mod folders;
mod graphs;
mod grasp;
mod ik;
mod isolation;
mod joints;
mod kin;
mod lives;
mod luasocket;
mod modules;
mod nesting;
mod options;
pub mod order;
mod planning;
mod python;
mod python_course;
mod python_hostile;
mod returns;
pub mod ros_actions;
mod script_errors;
mod side_by_side;
mod stand_ins;
mod stores;
mod talk;
mod threads;
mod velocities;
mod versions;
mod windows;
mod zmq;
