//! Joints that follow another joint, their leader.

use serde::{Deserialize, Serialize};

/// The rule by which a joint follows another joint, its leader.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows of joints describes each property")]
pub struct FollowRule {
    /// Path of the leader; empty if the joint follows no other joint.
    pub master: String,
    pub factor: f64,
    pub offset: f64,
    pub curve: Vec<f64>,
    pub geared: bool,
}

impl Default for FollowRule {
    fn default() -> Self {
        FollowRule { master: String::new(), factor: 1.0, offset: 0.0, curve: Vec::new(), geared: false }
    }
}

impl FollowRule {
    /// Returns the follower's position for a position of the leader, from the curve if there is one.
    pub fn position(&self, position: f64) -> f64 {
        let (pairs, _) = self.curve.as_chunks::<2>();
        let (Some([x0, y0]), Some([_, y1])) = (pairs.first(), pairs.last()) else {
            return self.offset + self.factor * position;
        };
        if position <= *x0 {
            return *y0;
        }
        for pair in pairs.windows(2) {
            let ([xa, ya], [xb, yb]) = (pair[0], pair[1]);
            if position <= xb {
                return ya + (yb - ya) * (position - xa) / (xb - xa);
            }
        }
        *y1
    }
}

/// Returns whether values form a curve: at least two pairs, with strictly ascending first values. An empty list is
/// valid and means that there is no curve.
pub(crate) fn is_curve(v: &[f64]) -> bool {
    let (pairs, rest) = v.as_chunks::<2>();
    rest.is_empty() && pairs.len() != 1 && pairs.windows(2).all(|p| p[0][0] < p[1][0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follow_curve_is_linear_and_constant_beyond_its_ends() {
        let cam = FollowRule { curve: vec![0.0, 1.0, 1.0, 3.0, 2.0, 3.5], ..FollowRule::default() };
        let at = |x| cam.position(x);
        assert_eq!([at(-1.0), at(0.5), at(1.0), at(1.5), at(9.0)], [1.0, 2.0, 3.0, 3.25, 3.5]);
        let gear = FollowRule { factor: -2.0, offset: 0.5, ..FollowRule::default() };
        assert_eq!(gear.position(1.0), -1.5);
    }

    #[test]
    fn follow_curves_must_ascend() {
        assert!(is_curve(&[]) && is_curve(&[0.0, 5.0, 1.0, -5.0]));
        assert!(!is_curve(&[0.0, 1.0]) && !is_curve(&[0.0, 1.0, 0.0, 2.0]) && !is_curve(&[0.0, 1.0, 2.0]));
    }
}
