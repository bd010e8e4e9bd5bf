//! The forms of shapes and parts by name.

use serde::{Deserialize, Serialize};

use crate::property::words;

/// The form of a shape or part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum Primitive {
    Box,
    Sphere,
    Cylinder,
    Capsule,
    Plane,
    Mesh,
    Compound,
}

words! {
    Primitive {
        Box "box",
        Sphere "sphere",
        Cylinder "cylinder",
        Capsule "capsule",
        Plane "plane",
        Mesh "mesh",
        Compound "compound",
    }
}
