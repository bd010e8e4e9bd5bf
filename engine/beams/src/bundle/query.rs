//! Queries with bundles, and their results.

use nalgebra::Isometry3;

use super::pack::RayBundle;
use crate::Faces;

/// A query that casts all rays of a bundle.
///
/// A ray hits the same surfaces as a [`Beam`](crate::Beam) with [`Volume::Ray`](crate::Volume::Ray) and the same
/// limits. Up to 100 m, distances differ by less than 1e-4 m, except for rays that pass within that distance of an
/// edge.
#[derive(Debug, Clone, Copy)]
pub struct BundleCast<'a> {
    /// The rays.
    pub bundle: &'a RayBundle,
    /// Pose of the sensor; the rays start at its origin.
    pub world_from_sensor: Isometry3<f64>,
    /// Minimum distance, m.
    pub near: f64,
    /// Maximum distance, m.
    pub far: f64,
    /// Maximum angle between surface normal and ray, rad; pi/2 or more means no limit.
    pub max_incidence: f64,
    /// Sides of surfaces that are detected.
    pub faces: Faces,
    /// Group of targets to ignore, such as the model that carries the sensor.
    pub skip_group: Option<u32>,
    /// If set, only this object is considered; other objects are neither detected nor occlude it.
    pub only_object: Option<u64>,
}

/// Result arrays, with one element per ray in the order of the bundle's directions. Empty arrays are not filled;
/// without `point` and `normal` a cast is faster.
#[derive(Debug, Default)]
pub struct BundleHits<'a> {
    /// Distance from the origin, m; infinity if there is no hit.
    pub distance: &'a mut [f64],
    /// Tag of the target; 0 if there is no hit.
    pub object: &'a mut [u64],
    /// Primitive of the form, as in [`Hit::primitive`](crate::Hit::primitive); 0 if there is no hit.
    pub primitive: &'a mut [u32],
    /// Point in the sensor's frame, m; zero if there is no hit.
    pub point: &'a mut [[f64; 3]],
    /// Surface normal on the sensor's side, in the sensor's frame; zero if there is no hit.
    pub normal: &'a mut [[f64; 3]],
}

impl<'a> BundleCast<'a> {
    /// Creates a query for all rays of a bundle with a range of `far` m, which detects both sides of surfaces at any
    /// incidence.
    pub fn new(bundle: &'a RayBundle, world_from_sensor: Isometry3<f64>, far: f64) -> Self {
        Self {
            bundle,
            world_from_sensor,
            near: 0.0,
            far,
            max_incidence: std::f64::consts::FRAC_PI_2,
            faces: Faces::BOTH,
            skip_group: None,
            only_object: None,
        }
    }
}

impl BundleHits<'_> {
    /// Panics unless each array is empty or has an element per ray.
    pub(super) fn check(&self, rays: usize) {
        let lengths =
            [self.distance.len(), self.object.len(), self.primitive.len(), self.point.len(), self.normal.len()];
        assert!(lengths.iter().all(|n| *n == 0 || *n == rays), "arrays must be empty or have one element per ray");
    }

    /// Splits off the results of the first `rays` rays.
    pub(super) fn split(self, rays: usize) -> (Self, Self) {
        fn cut<T>(all: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            all.split_at_mut(at.min(all.len()))
        }
        let (distance, object, primitive) =
            (cut(self.distance, rays), cut(self.object, rays), cut(self.primitive, rays));
        let (point, normal) = (cut(self.point, rays), cut(self.normal, rays));
        (
            BundleHits {
                distance: distance.0,
                object: object.0,
                primitive: primitive.0,
                point: point.0,
                normal: normal.0,
            },
            BundleHits {
                distance: distance.1,
                object: object.1,
                primitive: primitive.1,
                point: point.1,
                normal: normal.1,
            },
        )
    }
}
