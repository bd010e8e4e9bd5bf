//! Tests of plugins in Rust, for `cargo test` in the plugin's own crate.
//!
//! Two ways, for two questions:
//!
//! - *Does the plugin do in a scene what it should?* [`Host`] opens worlds: scenes with the plugin's library, just as
//!   the program opens it. It needs a built Tatu; see [`Host::find`].
//! - *Does my sensor compute the right numbers?* [`measure`] feeds a sample to one [`Sensor`], and [`act`] drives one
//!   [`Actuator`]: no host, no library, no scene, and a debugger sees it all.
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
//! - `library`: the host's library and that of the plugin; `host`: [`Host`]; `world`: [`World`] and [`Reading`];
//! - `measuring`: sensors without a host, with `inputs` and `readings`; `acting`: actuators; `random`: numbers for them;
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
mod world;

pub use acting::{ActuatorBench, Motion, Push, act};
pub use error::{Error, Result};
pub use host::Host;
pub use inputs::Inputs;
pub use library::plugin_library;
pub use measuring::{SensorBench, measure, measure_all};
pub use random::Random;
pub use readings::Readings;
pub use tatu_plugin_api::safe::Value;
pub use world::{Reading, World};

/// The library of the plugin whose tests these are, as a [`Result`] of its path: the `cdylib` of the package, which cargo
/// has built for its tests in the folder `tests`. A name in brackets is that of another library: `plugin!("tatu_lamp")`.
#[macro_export]
macro_rules! plugin {
    () => {
        $crate::plugin_library(::core::env!("CARGO_PKG_NAME"))
    };
    ($name:expr) => {
        $crate::plugin_library($name)
    };
}
