//! Tests of plugins in Rust, for `cargo test` in the plugin's own crate.
//!
//! There are two kinds of tests:
//!
//! - *Does the plugin work in a scene?* [`Host`] opens scenes with the plugin's library, which is loaded as the program
//!   loads it. This requires a built Tatu; see [`Host::find`].
//! - *Does a device compute the correct values?* [`measure`] passes inputs to one [`Sensor`], and [`act`] calls one
//!   [`Actuator`], without a host, a library or a scene, so that all code can be debugged in one process.
//!
//! ```no_run
//! use tatu_plugin_testkit::{Host, plugin};
//!
//! #[test]
//! fn sees_the_wall() -> tatu_plugin_testkit::Result {
//!     let host = Host::find()?.with_plugin(plugin!()?);
//!     let world = host.scene(include_str!("wall.toml"))?;
//!     world.step(1)?;
//!     assert_eq!(world.reading("/lamp")?.f64("lamp.level")?, 0.5);
//!     world.close()
//! }
//! ```
//!
//! - `library`: paths of the host's and the plugin's library; `host`: [`Host`]; `world`: [`World`] and [`Reading`];
//! - `measuring`: sensors without a host, with `inputs` and `readings`; `acting`: actuators; `targets`: their targets; `random`: random
//!   numbers;
//! - `error`: [`Error`].
//!
//! [`Sensor`]: tatu_plugin_api::safe::Sensor
//! [`Actuator`]: tatu_plugin_api::safe::Actuator

mod acting;
mod error;
mod host;
mod inputs;
mod library;
mod measuring;
mod random;
mod readings;
mod targets;
mod world;

pub use acting::{ActuatorBench, Motion, Push, Surroundings, act};
pub use error::{Error, Result};
pub use host::Host;
pub use inputs::Inputs;
pub use library::plugin_library;
pub use measuring::{SensorBench, measure, measure_all};
pub use random::Random;
pub use readings::Readings;
pub use tatu_plugin_api::safe::{Target, Value};
pub use world::{Reading, World};

/// Returns the path of the library of the plugin under test, as a [`Result`]. This is the `cdylib` of the package,
/// which cargo builds for tests in the folder `tests`, or that of a library whose name is given:
/// `plugin!("tatu_lamp")`.
#[macro_export]
macro_rules! plugin {
    () => {
        $crate::plugin_library(::core::env!("CARGO_PKG_NAME"))
    };
    ($name:expr) => {
        $crate::plugin_library($name)
    };
}
