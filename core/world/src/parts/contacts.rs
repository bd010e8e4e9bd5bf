//! Contact hooks of parts: before each physics step, a part decides on the pairs of shapes that it has registered.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use tatu_physics::{BodyContact, PairRule};
use tatu_plugin_api::abi::*;
use tatu_scene::Scene;

use super::call::{self, Moment, PhysicsMoment};
use crate::cell::WorldCell;

/// A pair of shapes, by their slots, the lower one first.
type SlotPair = (u32, u32);

/// Returns whether any part has registered a pair.
pub(super) fn any(world: &WorldCell) -> bool {
    let Ok(mut actuators) = world.devices.actuators.try_borrow_mut() else { return false };
    let roster = actuators.parts();
    let registered = |i: &usize| {
        let d = &actuators.devices[*i];
        !d.off && d.part.as_deref().is_some_and(|p| !p.hooks.is_empty())
    };
    roster.iter().any(registered)
}

/// Asks all parts for the rules of their pairs in the next physics step, in the order in which parts are called, and for
/// each part in ascending order of the pairs. If two parts decide on a pair, the last one applies. No part of the world
/// may be borrowed.
pub(crate) fn ask(world: &WorldCell, at: PhysicsMoment) {
    let Ok(roster) = world.devices.actuators.try_borrow_mut().map(|mut a| a.parts()) else { return };
    if roster.is_empty() || !any(world) {
        return;
    }
    let touching: Vec<(u32, u32, BodyContact)> = {
        let scene = world.state.scene.borrow();
        world.state.dynamics.borrow().contacts(&scene).collect()
    };
    for part in &*roster {
        for pair in pairs_of(world, *part, &touching) {
            ask_part(world, *part, at, pair, &touching);
        }
    }
}

/// Returns the pairs on which a part decides: the registered ones and, for shapes that are registered with all others,
/// those that touch, or that the part has kept from touching.
fn pairs_of(world: &WorldCell, part: usize, touching: &[(u32, u32, BodyContact)]) -> BTreeSet<SlotPair> {
    let mut out = BTreeSet::new();
    let (Ok(mut actuators), Ok(scene)) = (world.devices.actuators.try_borrow_mut(), world.state.scene.try_borrow())
    else {
        return out;
    };
    let Some(d) = actuators.devices.get_mut(part).filter(|d| !d.off) else { return out };
    let Some(record) = d.part.as_deref_mut() else { return out };
    // Pairs of objects that have been removed are forgotten.
    record.hooks.retain(|(a, b)| scene.resolve(*a).is_ok() && (*b == 0 || scene.resolve(*b).is_ok()));
    record.rules.retain(|(a, b), _| scene.get(*a).is_some() && scene.get(*b).is_some());
    for (a, b) in &record.hooks {
        let Ok(a) = scene.resolve(*a) else { continue };
        if *b != 0 {
            out.extend(scene.resolve(*b).ok().map(|b| (a.min(b), a.max(b))));
            continue;
        }
        let of_a = |x: u32, y: u32| (x == a || y == a).then_some((x.min(y), x.max(y)));
        out.extend(touching.iter().filter_map(|(x, y, _)| of_a(*x, *y)));
        out.extend(record.rules.iter().filter(|(_, rule)| !rule.responds).filter_map(|((x, y), _)| of_a(*x, *y)));
    }
    out
}

/// Returns the strongest contact of a pair after the last physics step, with the normal from `a` to `b`.
fn strongest(scene: &Scene, (a, b): SlotPair, touching: &[(u32, u32, BodyContact)]) -> Option<tatu_contact> {
    let own = touching.iter().filter(|(x, y, _)| (*x.min(y), *x.max(y)) == (a, b));
    let (x, _, c) = own.reduce(|best, other| if other.2.force > best.2.force { other } else { best })?;
    let side = if *x == a { 1.0 } else { -1.0 };
    Some(tatu_contact {
        shape: [scene.id(a), scene.id(b)],
        point: c.point.coords.into(),
        normal: (side * c.normal).into(),
        force: c.force,
    })
}

fn ask_part(world: &WorldCell, part: usize, at: PhysicsMoment, pair: SlotPair, touching: &[(u32, u32, BodyContact)]) {
    let Some((mut asked, before)) = ({
        let (scene, actuators) = (world.state.scene.borrow(), world.devices.actuators.borrow());
        let record = actuators.devices.get(part).and_then(|d| d.part.as_deref());
        record.map(|record| {
            let before = record.rules.get(&pair).copied();
            let contact = strongest(&scene, pair, touching);
            let rule = before.unwrap_or_default();
            let nothing = tatu_contact { shape: [scene.id(pair.0), scene.id(pair.1)], ..NO_CONTACT };
            let asked = tatu_contact_pair {
                size: size_of::<tatu_contact_pair>() as u32,
                touching: contact.is_some().into(),
                contact: contact.unwrap_or(nothing),
                collide: rule.responds.into(),
                reserved: 0,
                friction: rule.friction.unwrap_or(-1.0),
                restitution: rule.restitution.unwrap_or(-1.0),
                surface: rule.slide.into(),
            };
            (asked, before)
        })
    }) else {
        return;
    };
    call::call_at(world, part, Moment::Contact(at, &raw mut asked));
    let mut actuators = world.devices.actuators.borrow_mut();
    let Some(d) = actuators.devices.get_mut(part) else { return };
    let numbers = [asked.friction, asked.restitution].into_iter().chain(asked.surface);
    let is_valid = asked.collide <= 1 && numbers.clone().all(f64::is_finite);
    if !d.off && !is_valid {
        d.off = true;
        let (slot, kind) = (d.slot, d.kind);
        drop(actuators);
        let text = "broke the contract: it decided on a contact with numbers that are not finite, or `collide` above 1";
        return call::report(world, (kind, slot), Moment::Contact(at, std::ptr::null_mut()), TATU_ERR, text);
    }
    if d.off {
        return;
    }
    let positive = |x: f64| (x >= 0.0).then_some(x);
    let rule = PairRule {
        responds: asked.collide != 0,
        friction: positive(asked.friction),
        restitution: positive(asked.restitution),
        slide: Vector3::from(asked.surface),
    };
    if before.unwrap_or_default() != rule {
        if let Some(record) = d.part.as_deref_mut() {
            record.rules.insert(pair, rule);
        }
        drop(actuators);
        apply_rule(world, pair, Some(rule));
    }
}

const NO_CONTACT: tatu_contact = tatu_contact { shape: [0; 2], point: [0.0; 3], normal: [0.0; 3], force: 0.0 };

/// Sets the rule of a pair of shapes from the next physics step on, or removes it. The velocity of the surface is that
/// of the first shape.
pub(crate) fn apply_rule(world: &WorldCell, (a, b): SlotPair, rule: Option<PairRule>) {
    let (scene, mut dynamics) = (world.state.scene.borrow(), world.state.dynamics.borrow_mut());
    if let (Some(a), Some(b)) = (scene.get(a).and_then(|o| o.shape()), scene.get(b).and_then(|o| o.shape())) {
        // The engine takes the velocity of the body with the lower id.
        let turned = a.body.0 > b.body.0;
        let rule = rule.map(|rule| PairRule { slide: if turned { -rule.slide } else { rule.slide }, ..rule });
        dynamics.set_pair(a, b, rule);
    }
}

/// Registers a pair for a part, or all contacts of `a` if `b` is 0; or ends this, which restores the contacts of its
/// pairs.
pub(crate) fn register(world: &WorldCell, part: usize, (a, b): (tatu_object, tatu_object), on: bool) {
    let dropped: Vec<SlotPair> = {
        let mut actuators = world.devices.actuators.borrow_mut();
        let Some(record) = actuators.devices.get_mut(part).and_then(|d| d.part.as_deref_mut()) else { return };
        if on {
            record.hooks.insert((a, b));
            return;
        }
        record.hooks.remove(&(a, b));
        let (a, b) = (tatu_slot(a), tatu_slot(b));
        let is_own = |pair: &SlotPair| if b == 0 { pair.0 == a || pair.1 == a } else { *pair == (a.min(b), a.max(b)) };
        let dropped: Vec<SlotPair> = record.rules.keys().copied().filter(is_own).collect();
        dropped.iter().for_each(|pair| _ = record.rules.remove(pair));
        dropped
    };
    dropped.into_iter().for_each(|pair| apply_rule(world, pair, None));
}
