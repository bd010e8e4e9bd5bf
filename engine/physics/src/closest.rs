//! The shortest distance between two solids.

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::{
    geometry::SharedShape,
    math::Pose,
    parry::query::{ClosestPoints, closest_points, intersection_test},
};
use tatu_geometry::SolidPart;

use crate::convert;

/// The forms of a solid, prepared for tests against others.
#[derive(Clone)]
pub struct PreparedSolid(Vec<(SharedShape, Pose)>);

impl PreparedSolid {
    /// Prepares the parts of a solid; degenerate ones are left out.
    pub fn new(parts: &[SolidPart]) -> Self {
        let prepared = |part: &SolidPart| {
            let (shape, own) = convert::shape(&part.form)?;
            Some((shape, convert::pose(&part.pose) * own))
        };
        PreparedSolid(parts.iter().filter_map(prepared).collect())
    }

    /// Returns whether this solid at a pose is at most `margin`, m, from another one; a margin of 0 is a contact.
    pub fn is_within(
        &self,
        margin: f64,
        pose: &Isometry3<f64>,
        other: &PreparedSolid,
        other_pose: &Isometry3<f64>,
    ) -> bool {
        if margin <= 0.0 {
            return self.is_touching(pose, other, other_pose);
        }
        let (a, b) = (convert::pose(pose), convert::pose(other_pose));
        self.0.iter().any(|(sa, pa)| {
            let wa = a * *pa;
            other.0.iter().any(|(sb, pb)| {
                let found = closest_points(&wa, sa.as_ref(), &(b * *pb), sb.as_ref(), margin);
                found.is_ok_and(|points| points != ClosestPoints::Disjoint)
            })
        })
    }

    /// Returns whether this solid at a pose touches or overlaps another one, as those at a distance of 0 from each other
    /// do. Meshes that are not convex are surfaces.
    pub fn is_touching(&self, pose: &Isometry3<f64>, other: &PreparedSolid, other_pose: &Isometry3<f64>) -> bool {
        let (a, b) = (convert::pose(pose), convert::pose(other_pose));
        self.0.iter().any(|(sa, pa)| {
            let wa = a * *pa;
            other.0.iter().any(|(sb, pb)| {
                // Two planes cannot be tested, and count as apart.
                intersection_test(&wa, sa.as_ref(), &(b * *pb), sb.as_ref()).is_ok_and(|found| found.intersecting)
            })
        })
    }
}

/// Returns the ends of the shortest segment from one solid to the other, in the world frame, or `None` if the solids
/// are farther apart than `limit`, m. If they overlap, both ends are the origin of an overlapping part of the first
/// solid.
pub fn closest(
    a: (&Isometry3<f64>, &[SolidPart]),
    b: (&Isometry3<f64>, &[SolidPart]),
    limit: f64,
) -> Option<(Point3<f64>, Point3<f64>)> {
    let mut best: Option<(Point3<f64>, Point3<f64>)> = None;
    let mut reach = limit;
    for pa in a.1 {
        let Some((sa, la)) = convert::shape(&pa.form) else { continue };
        let wa = convert::pose(&(a.0 * pa.pose)) * la;
        for pb in b.1 {
            let Some((sb, lb)) = convert::shape(&pb.form) else { continue };
            let wb = convert::pose(&(b.0 * pb.pose)) * lb;
            let overlap = || {
                let p = Point3::from(convert::vector_back(wa.translation));
                Some((p, p))
            };
            match closest_points(&wa, sa.as_ref(), &wb, sb.as_ref(), reach) {
                Ok(ClosestPoints::Intersecting) => return overlap(),
                Ok(ClosestPoints::WithinMargin(p, q)) => {
                    let (p, q): (Vector3<f64>, Vector3<f64>) = (convert::vector_back(p), convert::vector_back(q));
                    let d = (p - q).norm();
                    if best.is_none() || d < reach {
                        reach = d;
                        best = Some((Point3::from(p), Point3::from(q)));
                    }
                }
                Ok(ClosestPoints::Disjoint) => {}
                // The distance between two planes is undefined.
                Err(_) => {}
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use tatu_geometry::Form;

    fn ball(radius: f64) -> Vec<SolidPart> {
        vec![SolidPart::from(Form::Sphere { radius })]
    }

    #[test]
    fn prepared_solids_touch_where_their_distance_is_zero() {
        let (a, b) = (PreparedSolid::new(&ball(0.2)), PreparedSolid::new(&ball(0.3)));
        let at = |x| Isometry3::translation(x, 0.0, 0.0);
        assert!(a.is_touching(&at(0.0), &b, &at(0.499)) && !a.is_touching(&at(0.0), &b, &at(0.501)));
        assert!(a.is_within(0.1, &at(0.0), &b, &at(0.599)) && !a.is_within(0.1, &at(0.0), &b, &at(0.601)));
    }

    #[test]
    fn distance_of_balls_is_that_of_centres_less_the_radii() {
        let (here, there) = (Isometry3::identity(), Isometry3::translation(1.0, 0.0, 0.0));
        let (p, q) = closest((&here, &ball(0.2)), (&there, &ball(0.3)), f64::INFINITY).unwrap();
        assert!(((p - q).norm() - 0.5).abs() < 1e-9);
        assert!((p.x - 0.2).abs() < 1e-9 && (q.x - 0.7).abs() < 1e-9);
        assert_eq!(closest((&here, &ball(0.2)), (&there, &ball(0.3)), 0.4), None);
        let (p, q) = closest((&here, &ball(0.6)), (&there, &ball(0.6)), 1.0).unwrap();
        assert_eq!(p, q);
    }
}
