//! Graphs: streams of numbers over time, and curves of one over another.
//!
//! - `spec`: descriptions of streams and curves; `values`: tables with a fixed set of keys;
//! - [`Stream`]: one number over time, with its transformation;
//! - [`Graph`]: streams that are recorded together, and their curves.

mod recording;
mod spec;
mod stream;
mod values;

pub use recording::{Curve, Graph};
pub use spec::{Axis, CurveSpec, GraphSpec, MOST_SAMPLES, StreamSpec, Transform, keys_of};
pub use stream::Stream;
pub use values::{Keys, map};
