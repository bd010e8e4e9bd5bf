//! Graphs: streams of values over time, and curves of one stream over another.
//!
//! - `spec`: descriptions of streams and curves; `values`: tables with a fixed set of keys;
//! - [`RecordedStream`]: one value over time, with its transformation;
//! - [`Graph`]: streams that are recorded together, and their curves.

mod recording;
pub(crate) mod spec;
mod stream;
mod values;

pub use recording::{Graph, RecordedCurve};
pub use spec::{CurveAxis, CurveSpec, GraphSpec, StreamSpec, StreamTransform, parse_static_copy};
pub use stream::RecordedStream;
pub use values::{CheckedMap, map};
