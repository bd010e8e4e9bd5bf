//! Tests of sensors against closed-form geometry, of their noise, and that reading them has no side effects.

mod depth_camera;
mod floor;
mod gps;
mod laser;
mod load;
mod motion;
mod noise;
mod pioneer_sonar;
mod proximity;
mod scans;
mod sensor_models;
mod sensor_state;
mod vision;
mod watchers;
