//! The shortest distance between two solids.

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::parry::query::{ClosestPoints, closest_points};
use tatu_geometry::SolidPart;

use crate::convert;

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
