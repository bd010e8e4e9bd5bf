//! Motions in minimum time within limits of velocity, acceleration and jerk.
//!
//! - [`State`], [`Limits`], [`Segment`]: one coordinate, its limits, and a time of constant jerk;
//! - [`Profile`]: the motion of one coordinate to a target, as fast as possible or in a given time;
//! - [`Trajectory`]: the motion of several coordinates that arrive together, on a straight line, or each by itself;
//! - [`Waypoints`]: states of a coordinate at given times;
//! - [`Spline`]: a smooth curve through points; [`PathTiming`]: its fastest traversal.
//!
//! Positions are in any unit, for instance m or rad, times in s. Results depend only on the arguments and are
//! bit-identical on all processors, since the crate uses no functions but the square root. Each file imports only from
//! those before it in this order: `state`, `velocity`, `profile`, `trajectory`, `waypoints`, `spline`,
//! `timing`.
//!
//! ```
//! use tatu_trajectories::{Limits, Profile, State};
//!
//! // One metre from rest to rest at 0.5 m/s, 1 m/s^2 and 10 m/s^3.
//! let limits = Limits::symmetric(0.5, 1.0, 10.0);
//! let profile = Profile::to_position(State::at(0.0), State::at(1.0), &limits).unwrap();
//! assert!((profile.duration() - 2.6).abs() < 1e-12);
//! assert!((profile.at(1.3).velocity - 0.5).abs() < 1e-12);
//! ```

mod profile;
mod spline;
mod state;
mod timing;
mod trajectory;
mod velocity;
mod waypoints;

pub use profile::Profile;
pub use spline::{Spline, SplinePoint};
pub use state::{Limits, MotionError, Segment, State};
pub use timing::{AxisBounds, PathTiming};
pub use trajectory::{Synchronization, Trajectory};
pub use waypoints::{Interpolation, Waypoints};
