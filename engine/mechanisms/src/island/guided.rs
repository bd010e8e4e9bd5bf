//! Friction of contacts between two bodies that are guided by a joint, such as a drawer on its rails.
//!
//! The joint constrains the bodies across its axis, so the share of the load that the contact carries is undetermined,
//! and contacts without response transmit no force (`MIN_RESPONSE` in `jacobian`). The friction of a drawer that rests
//! on its rails would then vanish. Such contacts are therefore assumed to carry the weight on the joint in equal
//! shares, and their friction acts like dry friction of the joint.

use super::Island;
use crate::{
    contact::{ContactPoint, ContactSide},
    island_tree::IslandTree,
    jacobian::HalfRow,
    vector::{Vec3, dot},
};

/// Maximum tangent of the angle between the motion that the joint allows and the surface, for contacts with other
/// bodies and between links of one tree. Contacts that are tilted more transmit forces of their own: these values are
/// the square roots of those of `MIN_RESPONSE`.
const MAX_TILT: [f64; 2] = [3e-5, 1e-2];
/// Maximum distance of a contact that carries weight, m; overlapping bodies that a joint holds are at 0.
const MAX_SUPPORT_DISTANCE: f64 = 1e-6;

impl Island {
    /// Adds the friction of guided contacts to that of their joints.
    pub(super) fn add_guided_friction(&self, members: &mut [IslandTree<'_>], contacts: &[ContactPoint], gravity: Vec3) {
        let mut supports: Vec<(usize, usize, f64)> = Vec::new();
        for (contact, point) in contacts.iter().zip(&self.rows.points) {
            if contact.friction == 0.0 || contact.distance > MAX_SUPPORT_DISTANCE {
                continue;
            }
            let Some((half, axis, sign)) = guiding_axis(members, contact, &point.halves) else { continue };
            let d = members[half.member].tree.axes[axis as usize].velocity;
            let Some(column) = (half.first..half.end).find(|k| self.rows.columns[*k] == d) else { continue };
            let [normal, first, second] = self.rows.jacobian(column);
            let along = (first * first + second * second).sqrt();
            let linked = contact.sides.iter().all(Option::is_some);
            if normal.abs() > MAX_TILT[usize::from(linked)] * along {
                continue;
            }
            let (d, IslandTree { tree, solver, .. }) = (d as usize, &members[half.member]);
            // The joint's own link and those that it carries press on the contact if gravity pulls them towards it.
            let link = tree.axes[axis as usize].node as usize;
            let weight = solver.step.mass.mass_below(link) * sign * dot(gravity, point.axes[0]);
            if weight > 0.0 {
                supports.push((half.member, d, contact.friction * weight * along));
            }
        }
        for (member, d, friction) in &supports {
            let count = supports.iter().filter(|s| (s.0, s.1) == (*member, *d)).count();
            members[*member].solver.step.contact_friction[*d] += friction / count as f64;
        }
    }
}

/// Returns the half of a contact whose bodies can only move about a single axis relative to each other, with that axis,
/// and 1 if it moves the first body or -1 if it moves the second.
fn guiding_axis(
    members: &[IslandTree<'_>],
    contact: &ContactPoint,
    halves: &[Option<HalfRow>; 2],
) -> Option<(HalfRow, u32, f64)> {
    let mut halves = halves.iter().flatten();
    // Two links of one tree share a half.
    let (half, None) = (*halves.next()?, halves.next()) else { return None };
    let own = |side: Option<ContactSide>| side.map_or(&[][..], |s| members[s.member].tree.axis_paths.of_link(s.link));
    let (a, b) = (own(contact.sides[0]), own(contact.sides[1]));
    let common = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    match (&a[common..], &b[common..]) {
        ([axis], []) => Some((half, *axis, 1.0)),
        ([], [axis]) => Some((half, *axis, -1.0)),
        _ => None,
    }
}
