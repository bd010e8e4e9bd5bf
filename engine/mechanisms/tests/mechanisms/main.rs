//! Tests of the public interface against reference values, closed-form solutions and invariants.

mod contacts;
mod drives;
mod energy;
mod gears;
mod joints;
mod limits;
mod properties;
mod random;
mod reference;
mod refusals;
mod robots;
mod saturation;
