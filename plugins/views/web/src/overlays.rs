//! Builds the data for overlays that clients have requested: contacts with their forces, and bodies with their masses,
//! inertias and velocities.

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};

use crate::{
    plugin::Props,
    protocol::{BodyMark, ContactMark, ToPage},
};

/// Maximum number of contacts in a message, and of bodies.
const MAX_MARKS: usize = 500;

/// The overlays that a client has requested.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OverlayRequest {
    /// Contact points and forces.
    pub contacts: bool,
    /// Centres of mass, inertias and velocities of dynamic shapes.
    pub bodies: bool,
}

impl OverlayRequest {
    /// Returns whether any overlay is requested.
    pub fn any(self) -> bool {
        self.contacts || self.bodies
    }
}

/// Returns the message with the requested data; `ids` are the objects of the scene.
pub fn message(turn: &Turn<'_>, p: &Props, ids: &[tatu_object], wanted: OverlayRequest) -> Result<ToPage> {
    let mut contacts = Vec::new();
    if wanted.contacts {
        let (all, frictions) = (turn.contacts(0)?, turn.frictions(0)?);
        for (i, contact) in all.iter().take(MAX_MARKS).enumerate() {
            let friction = frictions.get(i).copied().unwrap_or_default();
            let force: [f64; 3] = std::array::from_fn(|k| contact.normal[k] * contact.force + friction[k]);
            // The force is that on the second shape, so a single movable shape is made the second one.
            let [a, b] = contact.shape;
            let turned = is_dynamic_shape(turn, p, a) && !is_dynamic_shape(turn, p, b);
            contacts.push(ContactMark {
                pair: if turned { [b, a] } else { [a, b] }.map(tatu_slot),
                point: contact.point,
                force: if turned { force.map(|x| -x) } else { force },
            });
        }
    }
    let mut bodies = Vec::new();
    if wanted.bodies {
        for id in ids.iter().copied().filter(|id| is_dynamic_shape(turn, p, *id)).take(MAX_MARKS) {
            let com = turn.get(id, p.com)?.numbers().unwrap_or_default();
            let [x, y, z, ..] = turn.twist(id)?;
            bodies.push(BodyMark {
                id: tatu_slot(id),
                com: com.first_chunk().copied().unwrap_or_default(),
                mass: turn.f64(id, p.mass)?,
                inertia: inertia(&turn.get(id, p.inertia)?.numbers().unwrap_or_default()),
                velocity: [x, y, z],
            });
        }
    }
    Ok(ToPage::Overlays { contacts, bodies })
}

/// Returns an inertia as a 3 x 3 matrix in row-major order. `numbers` contains the three diagonal elements or all nine.
fn inertia(numbers: &[f64]) -> [f64; 9] {
    match *numbers {
        [x, y, z] => [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z],
        _ => numbers.first_chunk().copied().unwrap_or_default(),
    }
}

/// Returns whether an object is a dynamic shape, which can move.
fn is_dynamic_shape(turn: &Turn<'_>, p: &Props, id: tatu_object) -> bool {
    let shape = turn.look(id).is_ok_and(|o| o.kind == TATU_KIND_SHAPE);
    shape && turn.get(id, p.dynamic).is_ok_and(|v| v.truthy())
}
