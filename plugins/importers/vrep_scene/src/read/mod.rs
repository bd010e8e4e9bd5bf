//! Decoder of the file format. It is independent of Tatu.
//!
//! - [`header`], [`huffman`], [`cursor`], [`section`]: the structure of a file;
//! - [`mod@file`]: the sections of a whole file;
//! - one module for each kind of object: [`common`] for the common part, [`shape`], [`joint`], [`sensor`], [`others`];
//! - parts of these: [`mesh`], [`legacy_mesh`], [`pool`], [`color`], [`material`], [`texture`], [`volume`], [`pose`],
//!   [`data`];
//! - sections other than objects: [`script`], [`settings`], [`registered`];
//! - [`surface`]: the triangles of a mesh; [`unknown`]: elements that are unknown to the reader; [`test_files`]: small
//!   files for tests.

pub mod color;
pub mod common;
pub mod cursor;
pub mod data;
pub mod file;
pub mod header;
pub mod huffman;
pub mod joint;
pub mod legacy_mesh;
pub mod material;
pub mod mesh;
pub mod others;
pub mod pool;
pub mod pose;
pub mod registered;
pub mod script;
pub mod section;
pub mod sensor;
pub mod settings;
pub mod shape;
pub mod surface;
pub mod test_files;
pub mod texture;
pub mod unknown;
pub mod volume;
