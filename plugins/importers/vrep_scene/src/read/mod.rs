//! The decoder: from bytes to what they say. It knows nothing of Tatu.
//!
//! - [`header`], [`huffman`], [`cursor`], [`section`]: how a file is put together;
//! - [`mod@file`]: the sections of a whole file;
//! - one module for each kind of object: [`common`] for what all have, [`shape`], [`joint`], [`sensor`], [`others`];
//! - what stands inside of these: [`mesh`], [`legacy_mesh`], [`pool`], [`color`], [`material`], [`texture`], [`volume`],
//!   [`pose`], [`data`];
//! - what stands beside them: [`script`], [`settings`], [`registered`];
//! - [`surface`]: the triangles of a mesh; [`unknown`]: what nobody understands; [`made`]: small files for tests.

pub mod color;
pub mod common;
pub mod cursor;
pub mod data;
pub mod file;
pub mod header;
pub mod huffman;
pub mod joint;
pub mod legacy_mesh;
pub mod made;
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
pub mod texture;
pub mod unknown;
pub mod volume;
