//! What is asked of a bundle, and where the answers go.

use nalgebra::Isometry3;

use super::pack::RayBundle;
use crate::Faces;

/// One question: what all rays of a bundle see.
///
/// A ray sees what a [`Beam`](crate::Beam) with [`Volume::Ray`](crate::Volume::Ray) and the same limits sees. Distances
/// differ from its by less than 1e-4 m up to 100 m, but for rays that pass an edge by less than that.
#[derive(Debug, Clone, Copy)]
pub struct BundleCast<'a> {
    /// The rays.
    pub bundle: &'a RayBundle,
    /// The sensor's place; the rays begin at its origin.
    pub world_from_sensor: Isometry3<f64>,
    /// Least distance, in metres.
    pub near: f64,
    /// Greatest distance, in metres.
    pub far: f64,
    /// Greatest angle between surface normal and ray, in radians; pi/2 or more is no limit.
    pub max_incidence: f64,
    /// Sides seen.
    pub faces: Faces,
    /// A group that is passed over.
    pub skip_group: Option<u32>,
    /// The one object that is looked for; the others neither count nor hide it.
    pub only_object: Option<u64>,
}

/// Where the answers go: one place per ray and array, in the order of the bundle's directions. An empty array asks for
/// nothing; without `point` and `normal` a cast is faster.
#[derive(Debug, Default)]
pub struct BundleHits<'a> {
    /// From the origin, in metres; infinity when nothing is seen.
    pub distance: &'a mut [f64],
    /// The tag of the target; 0 when nothing is seen.
    pub object: &'a mut [u64],
    /// The place on the form, as in [`Hit::primitive`](crate::Hit::primitive); 0 when nothing is seen.
    pub primitive: &'a mut [u32],
    /// The point in the sensor's frame; zero when nothing is seen.
    pub point: &'a mut [[f64; 3]],
    /// The surface normal on the side of the sensor, in its frame; zero when nothing is seen.
    pub normal: &'a mut [[f64; 3]],
}

impl<'a> BundleCast<'a> {
    /// All rays of a bundle to `far` metres, with both sides seen and no other limit.
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
    /// Panics unless each array is empty or has a place for each ray.
    pub(super) fn check(&self, rays: usize) {
        let lengths =
            [self.distance.len(), self.object.len(), self.primitive.len(), self.point.len(), self.normal.len()];
        assert!(lengths.iter().all(|n| *n == 0 || *n == rays), "each ray needs a place for its answer");
    }

    /// The answers of the first `rays` rays, and the others.
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
