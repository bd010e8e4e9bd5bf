//! What a page draws over the scene on request: contacts with their forces, centres of mass and velocities; and warnings
//! of bodies that fly apart.

use std::collections::BTreeSet;

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};

use crate::{
    plugin::Props,
    protocol::{BodyMark, ContactMark, ToPage},
};

/// Most contacts, and most bodies, of a message.
const MOST_MARKS: usize = 500;
/// Speed, in m/s, and distance from the origin, in m, from which on a body is told of.
const FAST: f64 = 100.0;
const FAR: f64 = 1000.0;

/// What a client wants.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wanted {
    pub contacts: bool,
    pub bodies: bool,
}

impl Wanted {
    /// Returns whether anything is wanted.
    pub fn any(self) -> bool {
        self.contacts || self.bodies
    }
}

/// Returns the message of what is wanted.
pub fn message(turn: &Turn<'_>, p: &Props, ids: &[tatu_object], wanted: Wanted) -> Result<ToPage> {
    let mut contacts = Vec::new();
    if wanted.contacts {
        let (all, frictions) = (turn.contacts(0)?, turn.frictions(0)?);
        for (i, contact) in all.iter().take(MOST_MARKS).enumerate() {
            let friction = frictions.get(i).copied().unwrap_or_default();
            let force: [f64; 3] = std::array::from_fn(|k| contact.normal[k] * contact.force + friction[k]);
            // A floor bears what is shown of the body on it.
            let [a, b] = contact.shape;
            let turned = moves(turn, p, a) && !moves(turn, p, b);
            contacts.push(ContactMark {
                pair: if turned { [b, a] } else { [a, b] }.map(tatu_slot),
                point: contact.point,
                force: if turned { force.map(|x| -x) } else { force },
            });
        }
    }
    let mut bodies = Vec::new();
    if wanted.bodies {
        for id in dynamic(turn, p, ids).take(MOST_MARKS) {
            let com = turn.get(id, p.com)?.numbers().unwrap_or_default();
            let [x, y, z, ..] = turn.twist(id)?;
            bodies.push(BodyMark {
                id: tatu_slot(id),
                com: com.first_chunk().copied().unwrap_or_default(),
                mass: turn.f64(id, p.mass)?,
                velocity: [x, y, z],
            });
        }
    }
    Ok(ToPage::Overlays { contacts, bodies })
}

/// Returns whether an object is a shape that forces move.
fn moves(turn: &Turn<'_>, p: &Props, id: tatu_object) -> bool {
    let shape = turn.look(id).is_ok_and(|o| o.kind == TATU_KIND_SHAPE);
    shape && turn.get(id, p.dynamic).is_ok_and(|v| v.truthy())
}

fn dynamic<'a>(turn: &'a Turn<'_>, p: &'a Props, ids: &'a [tatu_object]) -> impl Iterator<Item = tatu_object> + 'a {
    ids.iter().copied().filter(move |id| moves(turn, p, *id))
}

/// Bodies of which a run was told already.
#[derive(Default)]
pub struct Warned(BTreeSet<tatu_object>);

impl Warned {
    /// Forgets them, at the end of a run.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Returns warnings of bodies that have become too fast or are too far away, each once a run.
    pub fn look(&mut self, turn: &Turn<'_>, p: &Props, ids: &[tatu_object]) -> Vec<(tatu_object, String)> {
        let mut out = Vec::new();
        for id in dynamic(turn, p, ids) {
            let Ok([vx, vy, vz, ..]) = turn.twist(id) else { continue };
            let Ok([x, y, z, ..]) = turn.pose(id, 0) else { continue };
            let length = |a: f64, b: f64, c: f64| (a * a + b * b + c * c).sqrt();
            let (speed, far) = (length(vx, vy, vz), length(x, y, z));
            // What is not a number is neither.
            if (speed <= FAST && far <= FAR) || !self.0.insert(id) {
                continue;
            }
            let alias = turn.get(id, p.alias).ok().and_then(|v| v.as_str().map(|s| s.into_owned())).unwrap_or_default();
            let what = if speed <= FAST {
                format!("is {far:.0} m away from the origin")
            } else {
                format!("moves at {speed:.0} m/s")
            };
            let text = format!(
                "`{alias}` {what}: look for overlapping shapes, a joint beyond its limits, or a force that is too large"
            );
            out.push((id, text));
        }
        out
    }
}
