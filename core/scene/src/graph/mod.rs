//! Graphs: streams of numbers over time and curves of one over another.
//!
//! - `spec`: streams and curves as scene files and plugins describe them; `values`: tables with a few keys;
//! - [`Stream`]: one number over time, and what is made of it;
//! - [`Graph`]: streams recorded together, and their curves.

mod recording;
mod spec;
mod stream;
mod values;

pub use recording::{Curve, Graph};
pub use spec::{Axis, CurveSpec, GraphSpec, MOST_SAMPLES, StreamSpec, Transform, keys_of};
pub use stream::Stream;
pub use values::{Keys, map};
