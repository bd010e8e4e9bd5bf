//! Graphs: streams of values over time, and curves of one stream over another.
//!
//! - `spec`: descriptions of streams and curves; `values`: tables with a fixed set of keys;
//! - [`Stream`]: one value over time, with its transformation;
//! - [`Graph`]: streams that are recorded together, and their curves.

mod recording;
pub(crate) mod spec;
mod stream;
mod values;

pub use recording::{Curve, Graph};
pub use spec::{Axis, CurveSpec, GraphSpec, StreamSpec, Transform, keys_of};
pub use stream::Stream;
pub use values::{Keys, map};
