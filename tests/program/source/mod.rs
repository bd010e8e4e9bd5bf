//! The source tree itself: layers, names, lengths.

mod imports;
mod layers;
mod tree;
