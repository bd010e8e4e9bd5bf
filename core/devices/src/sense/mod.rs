//! Sensors: which are due, their beams, their readings.
//!
//! - `sensing`: the world's sensors; `device`: one sensor's instance and its last reading;
//! - `turn`, `due`: which sensors measure by themselves in a step;
//! - `plan`: what a device sends out, as its plugin declared; `aim`: rays that plugins move before they are cast;
//! - `targets`: the scene as beams and images find it; `outline`: edges for pictures;
//! - `cast`, `image`: beams and images of a batch; `measure`: a batch of one kind, cast together, then one call of the
//!   plugin; `scratch`: its buffers;
//! - `noise`: what a scene declares for the fields of a sensor, applied after each measure;
//! - `random`: random numbers that depend on nothing but seed, sensor and count; `normal`: those of the normal
//!   distribution;
//! - `reading_arena`: the memory of readings.

mod aim;
mod cast;
mod device;
mod due;
mod image;
mod measure;
mod noise;
mod normal;
mod outline;
mod plan;
mod random;
mod reading_arena;
mod scratch;
mod sensing;
mod targets;
mod turn;

pub use cast::Limits;
pub use device::{Device, Layout};
pub use measure::{Around, Job, MeasureOptions, Moment, measure};
pub use noise::{Memory, Noise};
pub use outline::{Edge, edges};
pub use plan::BeamPlan;
pub use reading_arena::ReadingBuffer;
pub use sensing::Sensing;
pub use targets::{Sees, Targets};
pub use turn::{Roll, Turn};
