//! Watches the functions of the C library that the plugin under test calls.
//!
//! The loader has written the addresses of these functions into tables of the plugin's library. `redirect` replaces
//! them with the functions of this folder, which report calls that the rules forbid, and then call the originals. Only
//! the plugin and the libraries that were loaded because of it are affected, not the host.
//!
//! - `rules`: the calls that are forbidden; `clocks`: clocks that run differently; `allocations`: memory in use;
//!   `redirect`: finds and replaces addresses in loaded libraries; `watch`: the functions.

#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod allocations;
#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod clocks;
#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod redirect;
#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod rules;
#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod watch;

#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
pub use self::{
    allocations::{allocated_bytes, record_allocations},
    clocks::use_other_clocks,
    watch::{LoadedBefore, watch},
};

#[cfg(not(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64")))]
pub use elsewhere::*;

/// On other systems, calls are not watched.
#[cfg(not(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64")))]
mod elsewhere {
    pub struct LoadedBefore;
    impl LoadedBefore {
        pub fn now() -> Self {
            LoadedBefore
        }
    }
    pub fn watch(_: usize, _: &str, _: &LoadedBefore, _: &std::path::Path) {}
    pub fn use_other_clocks() {}
    pub fn record_allocations() {}
    pub fn allocated_bytes() -> i64 {
        0
    }
}
