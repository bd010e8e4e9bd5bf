//! Joints that follow others: gears, linkages and cams. The place of one is a function of another's place, or its speed
//! is a multiple of another's.
//!
//! Whoever follows is driven by its own motor, with its own limit of force, towards what the other did by the end of
//! the last step; nothing pushes back on the other one. A joint that is geared moves with the other one as one.

use serde::{Deserialize, Serialize};

use super::{Control, Data, Scene};

/// Whom a joint follows, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each is a property row with its sentence")]
pub struct Follow {
    /// Empty: nobody.
    pub master: String,
    pub factor: f64,
    pub offset: f64,
    pub curve: Vec<f64>,
    pub geared: bool,
}

impl Default for Follow {
    fn default() -> Self {
        Follow { master: String::new(), factor: 1.0, offset: 0.0, curve: Vec::new(), geared: false }
    }
}

impl Follow {
    /// Where it stands when the other stands at `position`.
    fn position(&self, position: f64) -> f64 {
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

/// Whether these numbers are pairs whose first numbers ascend; none at all is no curve.
pub(super) fn is_curve(v: &[f64]) -> bool {
    let (pairs, rest) = v.as_chunks::<2>();
    rest.is_empty() && pairs.len() != 1 && pairs.windows(2).all(|p| p[0][0] < p[1][0])
}

/// The joints that follow others, and whom, in order of slots.
pub(super) fn followers(scene: &Scene) -> Vec<(u32, u32)> {
    let named = scene.slots().filter_map(|(slot, o)| {
        let master = o.joint().map(|j| j.follow.master.as_str()).filter(|m| !m.is_empty())?;
        let found = scene.find(slot, master)?;
        (found != slot && scene.get(found)?.joint().is_some()).then_some((slot, found))
    });
    named.collect()
}

impl Scene {
    /// Joints that are to follow what is not there, or is no joint: their path, and what they were told.
    pub fn lost_followers(&self) -> Vec<(String, String)> {
        let found = followers(self);
        let lost = self.slots().filter_map(|(slot, o)| {
            let master = o.joint().map(|j| &j.follow.master).filter(|m| !m.is_empty())?;
            let is_lost = !found.iter().any(|(s, _)| *s == slot);
            is_lost.then(|| (self.path(slot), master.clone()))
        });
        lost.collect()
    }
}

/// Joints that are geared to the one that they follow, and those that they follow.
pub(super) fn geared(scene: &Scene) -> Vec<(u32, u32)> {
    let is_geared = |slot: u32| scene.get(slot).and_then(|o| o.joint()).is_some_and(|j| j.follow.geared && j.dynamic);
    followers(scene)
        .into_iter()
        .filter(|(slot, leader)| {
            is_geared(*slot) && scene.get(*leader).and_then(|o| o.joint()).is_some_and(|j| j.dynamic)
        })
        .collect()
}

/// Tells followers where to go: they find it in their targets, kinematic ones are put there. `drives` takes those
/// whose drive has changed.
pub(super) fn update(scene: &mut Scene, followers: &[(u32, u32)], drives: &mut Vec<u32>) {
    for (slot, master) in followers {
        let Some(m) = scene.get(*master).and_then(|o| o.joint()) else { continue };
        // One that moves no body has no speed of its own: then what it is told counts.
        let (position, velocity) = (m.position, if m.id.is_some() { m.velocity } else { m.target_velocity });
        let Some(Data::Joint(j)) = scene.get_mut(*slot).map(|o| &mut o.data) else { continue };
        // The engine moves both as one.
        if j.follow.geared && j.dynamic {
            continue;
        }
        let position = j.follow.position(position);
        if !j.dynamic {
            j.velocity = j.follow.factor * velocity;
            if j.position != position {
                j.position = position;
                scene.refresh(*slot);
            }
            continue;
        }
        let (place, wanted) = match j.control {
            Control::Position => (&mut j.target_position, position),
            Control::Velocity => (&mut j.target_velocity, j.follow.factor * velocity),
            Control::Free | Control::Force | Control::Callback | Control::Spring => continue,
        };
        if std::mem::replace(place, wanted) != wanted {
            drives.push(*slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_straight_between_its_points_and_holds_beyond() {
        let cam = Follow { curve: vec![0.0, 1.0, 1.0, 3.0, 2.0, 3.5], ..Follow::default() };
        let at = |x| cam.position(x);
        assert_eq!([at(-1.0), at(0.5), at(1.0), at(1.5), at(9.0)], [1.0, 2.0, 3.0, 3.25, 3.5]);
        let gear = Follow { factor: -2.0, offset: 0.5, ..Follow::default() };
        assert_eq!(gear.position(1.0), -1.5);
    }

    #[test]
    fn curves_ascend() {
        assert!(is_curve(&[]) && is_curve(&[0.0, 5.0, 1.0, -5.0]));
        assert!(!is_curve(&[0.0, 1.0]) && !is_curve(&[0.0, 1.0, 0.0, 2.0]) && !is_curve(&[0.0, 1.0, 2.0]));
    }
}
