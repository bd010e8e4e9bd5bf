//! Intersection of sensor beams with the detectable surfaces of a scene, independent of the physics engine.
//!
//! The crate contains the intersection of rays and volume beams with every [`Form`](tatu_geometry::Form), and the trees
//! that accelerate casting. Other crates decide what a sensor derives from a hit, and which objects are detectable.
//! Start with [`BeamScene`]; the geometry of a cone and a flat face is in `planar`.
//!
//! ```
//! use nalgebra::Isometry3;
//! use tatu_beams::{Beam, BeamScene, BeamTarget};
//! use tatu_geometry::Form;
//!
//! let mut scene = BeamScene::default();
//! scene.set([BeamTarget {
//!     object: 7,
//!     group: 0,
//!     world_from_target: Isometry3::translation(0.0, 0.0, 1.0),
//!     form: Form::Sphere { radius: 0.25 },
//!     color: [0.7; 3],
//!     opacity: 1.0,
//!     texture: None,
//! }]);
//! let hit = scene.cast_one(&Beam::cone(Isometry3::identity(), 0.26, 2.0));
//! assert!((hit.distance - 0.75).abs() < 1e-12);
//! assert_eq!(hit.object, 7);
//!
//! scene.update_poses(&[(0, Isometry3::translation(0.0, 0.0, 3.0))]);
//! assert!(!scene.cast_one(&Beam::ray(Isometry3::identity(), 2.0)).is_some());
//! ```

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod aabb;
mod beam;
mod binary;
mod bundle;
mod candidates;
mod convex;
mod cylinder;
mod disc;
mod grid;
mod layers;
mod mesh;
mod planar;
mod probe;
mod ray;
mod scene;
mod sight;
mod simd;
mod solid;
mod sphere;
mod tree;
mod triangle;

pub use aabb::bounds;
pub use beam::{Beam, Faces, Hit, Volume};
pub use bundle::{BundleCast, BundleHits, RayBundle};
pub use grid::{Grid, GridCast, GridImage, ImageLighting, ImageOutputs, ImageProjection, shaded_color};
pub use layers::{MAX_TRANSLUCENT_LAYERS, SurfaceLayer, composite};
pub use scene::{BeamScene, BeamTarget};

/// Returns the length of a two-dimensional vector. Unlike the C library's `hypot`, it does not guard against overflow
/// of the squares, and is ten times as fast.
pub(crate) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

// Named after the crate, so that the filter `cargo test --workspace --lib beams` finds them.
#[cfg(test)]
pub(crate) mod beams_tests;
