//! Sensors: the times at which they measure, their beams and their readings.
//!
//! - `sensing`: the world's sensors; `device`: a sensor's instance and last reading;
//! - `roster`, `due`: which sensors measure in a step;
//! - `plan`: the beams of a sensor, as its plugin declares them; `aim`: rays that plugins aim before each cast;
//! - `targets`: the scene in which beams and images are cast; `outline`: outlines for pictures;
//! - `cast`, `image`: beams and images of a batch; `measure`: casts the beams of a batch and passes it to the plugin in
//!   one call; `batch`: calls into a kind; `scratch`: the buffers of a batch;
//! - `physics_step`: sensors that measure after each physics step, such as accelerations, loads and contacts;
//! - `noise`: the noise that a scene declares for the fields of a sensor, applied after each measurement;
//! - `random`: random numbers that depend only on the seed, the sensor and the measurement count; `normal`: the inverse
//!   of the normal distribution function;
//! - `numbers`: the words of a field as numbers.

mod aim;
mod batch;
mod cast;
mod device;
mod due;
mod image;
mod measure;
mod noise;
mod normal;
mod numbers;
mod outline;
mod physics_step;
mod plan;
mod random;
mod roster;
mod scratch;
mod sensing;
mod targets;

pub use batch::MeasureFailure;
pub use cast::HitLimits;
pub use device::{FieldLayout, SensorDevice};
pub use measure::{MeasureContext, MeasureOptions, MeasureRequest, measure};
pub use noise::{NoiseState, SensorNoise};
pub use outline::{OutlineEdge, edges};
pub use physics_step::{StepContext, StepSensing};
pub use plan::BeamPlan;
pub use roster::{DueSensors, SensorRoster};
pub use scratch::MeasureTime;
pub use sensing::Sensing;
pub use targets::{TargetFilter, Targets};
pub use tatu_plugins::reading_arena::ReadingBuffer;
