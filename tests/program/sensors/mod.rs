//! Sensors against geometry written out, their noise, and what reading them may change: nothing.

mod depth_camera;
mod gps;
mod laser;
mod noise;
mod pioneer_sonar;
mod proximity;
mod scans;
mod sensor_models;
mod vision;
mod watchers;
