//! The forms of shapes and parts by name.

use serde::{Deserialize, Serialize};

/// The form of a shape or part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum Primitive {
    Box,
    Sphere,
    Cylinder,
    Capsule,
    Plane,
    Mesh,
    Compound,
}

/// Names of the primitives, in the order of [`Primitive`].
pub const PRIMITIVES: &[&str] = &["box", "sphere", "cylinder", "capsule", "plane", "mesh", "compound"];

impl Primitive {
    /// Returns the primitive with a name in `PRIMITIVES`.
    pub fn parse(name: &str) -> Option<Self> {
        use Primitive::*;
        let all = [Box, Sphere, Cylinder, Capsule, Plane, Mesh, Compound];
        PRIMITIVES.iter().position(|p| *p == name).map(|i| all[i])
    }
    /// Returns the primitive's name.
    pub fn name(self) -> &'static str {
        PRIMITIVES[self as usize]
    }
}
