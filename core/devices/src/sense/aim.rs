//! Aimed rays: a plugin sets their origins and directions before each cast.

use nalgebra::{Isometry3, Vector3};
use tatu_plugins::guarded_array::GuardedArray;

use super::plan::{BeamPlan, look_along};

/// The aimed rays of a batch.
#[derive(Default)]
pub(super) struct AimedRays {
    /// Origin and direction of each ray in its sensor's frame, sensor by sensor.
    rays: GuardedArray<[f64; 6]>,
    /// For each sensor of the batch, the pointer to its first ray that is passed to the plugin, or null if its rays are
    /// not aimed. Empty if no sensor of the batch has aimed rays.
    pub places: Vec<*mut f64>,
    /// Poses of the rays returned so far by [`AimedRays::next_rays`], in their sensor's frame.
    turned: Vec<Isometry3<f64>>,
}

impl AimedRays {
    pub fn clear(&mut self) {
        self.places.clear();
        self.turned.clear();
    }

    /// Initialises the rays of aimed sensors with their planned directions; returns whether there are any aimed
    /// sensors.
    pub fn set_planned_rays<'a>(&mut self, plans: impl Iterator<Item = &'a BeamPlan> + Clone) -> bool {
        if !plans.clone().any(|p| p.aimed) {
            return false;
        }
        let directions = plans.clone().filter(|p| p.aimed).flat_map(|p| &p.directions);
        self.rays.fill(directions.clone().count(), [0.0; 6]);
        for (ray, d) in self.rays.iter_mut().zip(directions) {
            *ray = [0.0, 0.0, 0.0, d[0], d[1], d[2]];
        }
        let mut rest = &mut *self.rays;
        for plan in plans {
            if !plan.aimed {
                self.places.push(std::ptr::null_mut());
                continue;
            }
            let (own, after) = std::mem::take(&mut rest).split_at_mut(plan.directions.len());
            self.places.push(own.as_mut_ptr().cast());
            rest = after;
        }
        true
    }

    /// Returns whether the guards around the rays are intact.
    pub fn are_whole(&self) -> bool {
        self.rays.guards_intact()
    }

    /// Returns the next `n` rays as they are currently aimed, or `None` if an origin is not finite or a direction is
    /// not a unit vector.
    pub fn next_rays(&mut self, n: usize) -> Option<&[Isometry3<f64>]> {
        let begin = self.turned.len();
        let own = &self.rays[begin..begin + n];
        let bad = !own.iter().all(is_ray);
        let place = |r: &[f64; 6]| match bad {
            true => Isometry3::identity(),
            false => Isometry3::from_parts(Vector3::new(r[0], r[1], r[2]).into(), look_along([r[3], r[4], r[5]])),
        };
        self.turned.extend(own.iter().map(place));
        (!bad).then(|| &self.turned[begin..])
    }
}

fn is_ray(r: &[f64; 6]) -> bool {
    let length = r[3] * r[3] + r[4] * r[4] + r[5] * r[5];
    r.iter().all(|x| x.is_finite()) && (length - 1.0).abs() < 1e-6
}
