//! The crate as its users see it, against stored values, closed forms and itself.

mod contacts;
mod drives;
mod energy;
mod joints;
mod limits;
mod properties;
mod random;
mod reference;
mod refusals;
mod robots;
mod saturation;
