//! Colliders of bodies, and the hooks that they require.

use nalgebra::Vector3;
use rapier3d::{dynamics::CoefficientCombineRule, geometry::ColliderBuilder, pipeline::ActiveHooks};

use super::{
    masks::{self, ColliderTag},
    refresh,
    table::{Contacts, MAX_FRICTION},
};
use crate::{
    BodyDesc, BodyId, ContactSurface, FrictionRule, PairRule,
    rapier::bodies::{Bodies, BodyRecord, ShapeCache, is_valid_surface},
};

impl Contacts {
    /// Adds the colliders of a new body, unless it collides with nothing.
    pub fn add_body(&mut self, bodies: &mut Bodies, shapes: &mut ShapeCache, id: BodyId, desc: &BodyDesc) {
        if desc.collision_mask.mask == 0 {
            return;
        }
        self.add_colliders(bodies, shapes, id, desc);
        self.join_collision_tree(bodies, id);
        self.fresh.push(id);
        if needs_contact_hook(bodies, id) {
            enable_contact_hook(bodies, id);
        }
        if desc.surface != ContactSurface::default() {
            self.surfaces.insert(id, desc.surface);
            enable_pair_hooks(bodies, id);
        }
    }

    fn add_colliders(&self, bodies: &mut Bodies, shapes: &mut ShapeCache, id: BodyId, desc: &BodyDesc) {
        let Some(&record) = bodies.record(id) else {
            return;
        };
        for part in &desc.parts {
            let Some((shape, in_part)) = shapes.shape(&part.form) else {
                continue;
            };
            let collider = ColliderBuilder::new(shape)
                .position(record.local_pose(&part.pose) * in_part)
                // The mass is set on the body directly.
                .density(0.0)
                .friction(part.friction.unwrap_or(desc.friction))
                .friction_combine_rule(match self.friction_rule {
                    FrictionRule::Product => CoefficientCombineRule::Multiply,
                    FrictionRule::Mean => CoefficientCombineRule::Average,
                    FrictionRule::Least => CoefficientCombineRule::Min,
                    FrictionRule::Greatest => CoefficientCombineRule::Max,
                })
                .restitution(desc.restitution)
                .restitution_combine_rule(CoefficientCombineRule::Multiply)
                .active_hooks(refresh::required_hooks(&part.form))
                .collision_groups(masks::collision_groups(desc.collision_mask.mask, false))
                .user_data(ColliderTag { body: id.0, collision_mask: desc.collision_mask }.pack());
            bodies.world.insert_collider(collider, Some(record.handle));
        }
    }

    /// Adds a body to its collision tree, and enables the mask filter where collision groups are not sufficient.
    fn join_collision_tree(&mut self, bodies: &mut Bodies, id: BodyId) {
        let Some(&BodyRecord { respond: new, .. }) = bodies.record(id) else {
            return;
        };
        let mut tree = self.collision_trees.remove(&new.tree).unwrap_or_default();
        for &other in &tree.members {
            let Some(&BodyRecord { respond: old, .. }) = bodies.record(other) else {
                continue;
            };
            match (masks::masks_collide(old, new), masks::high_bytes_collide(old, new)) {
                // The collision groups would let the two bodies collide, so one of them needs the filter. It is enabled
                // for the older one, which is usually the base of a robot. The robot's wheels then touch the floor
                // without a filter.
                (false, true) => enable_mask_filter(bodies, other, false),
                (true, false) => tree.wide = true,
                _ => {}
            }
        }
        tree.members.push(id);
        if tree.wide {
            for &member in &tree.members {
                enable_mask_filter(bodies, member, true);
            }
        }
        self.collision_trees.insert(new.tree, tree);
    }

    /// Removes a body that is about to be destroyed from the table, with its friction constraints.
    pub fn remove_body(&mut self, bodies: &mut Bodies, body: BodyId) {
        let Some(tree) = bodies.record(body).map(|r| r.respond.tree) else { return };
        self.surfaces.remove(&body);
        self.friction_constraints.retain(|(a, b), constraint| {
            let kept = *a != body && *b != body;
            if !kept {
                bodies.world.remove_impulse_joint(constraint.handle);
            }
            kept
        });
        self.pairs.retain(|(a, b), _| *a != body && *b != body);
        self.separations.retain(|(a, b), _| *a != body && *b != body);
        self.fresh.retain(|id| *id != body);
        if let Some(members) = self.collision_trees.get_mut(&tree).map(|tree| &mut tree.members) {
            members.retain(|id| *id != body);
            if members.is_empty() {
                self.collision_trees.remove(&tree);
            }
        }
    }

    /// Sets the contact properties of a body's surface.
    pub fn set_surface(&mut self, bodies: &mut Bodies, body: BodyId, surface: ContactSurface) {
        let Some(handle) = bodies.record(body).map(|r| r.handle).filter(|_| is_valid_surface(&surface)) else {
            return;
        };
        if surface == ContactSurface::default() {
            self.surfaces.remove(&body);
        } else if self.surfaces.insert(body, surface) != Some(surface) {
            enable_pair_hooks(bodies, body);
            // Bodies that rest on a belt must wake when it starts.
            bodies.wake_touching(handle);
        }
    }

    /// Sets the contact parameters of a pair, or removes them.
    pub fn set_pair(&mut self, bodies: &mut Bodies, a: BodyId, b: BodyId, rule: Option<PairRule>) {
        let pair = (a.min(b), a.max(b));
        let Some(rule) = rule else {
            self.pairs.remove(&pair);
            return;
        };
        let before = self.pairs.insert(pair, rule);
        if before == Some(rule) {
            return;
        }
        for body in [a, b] {
            // The filter must be enabled for bodies with a rule.
            enable_pair_hooks(bodies, body);
            // Bodies that rest on a surface must wake when it starts to move.
            if before.map_or(Vector3::zeros(), |r| r.slide) != rule.slide
                && let Some(handle) = bodies.record(body).map(|r| r.handle)
            {
                bodies.wake_touching(handle);
            }
        }
    }

    /// Disables the hook that modifies the contacts of a body, unless it is still needed.
    pub fn disable_contact_hook(&self, bodies: &mut Bodies, id: BodyId) {
        let in_pair = |(a, b): &(BodyId, BodyId)| *a == id || *b == id;
        if !needs_contact_hook(bodies, id)
            && !self.surfaces.contains_key(&id)
            && !self.pairs.keys().any(in_pair)
            && !self.separations.keys().any(in_pair)
        {
            set_hooks(bodies, id, |h| h & !ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
    }
}

/// Enables the mask filter for a body. If `low_too` is set, the groups also pass pairs that share only low bits.
fn enable_mask_filter(bodies: &mut Bodies, id: BodyId, low_too: bool) {
    let Some(&BodyRecord { handle, respond, .. }) = bodies.record(id) else {
        return;
    };
    let colliders = &mut bodies.world.colliders;
    for &collider in bodies.world.bodies[handle].colliders() {
        let Some(collider) = colliders.get_mut(collider) else {
            continue;
        };
        collider.set_active_hooks(collider.active_hooks() | ActiveHooks::FILTER_CONTACT_PAIRS);
        if low_too {
            collider.set_collision_groups(masks::collision_groups(respond.mask, true));
        }
    }
}

/// Enables the hooks that decide which bodies a body collides with and that modify its contacts.
fn enable_pair_hooks(bodies: &mut Bodies, id: BodyId) {
    set_hooks(bodies, id, |h| h | ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS);
}

/// Enables the hook that modifies the contacts of a body.
pub(crate) fn enable_contact_hook(bodies: &mut Bodies, id: BodyId) {
    set_hooks(bodies, id, |h| h | ActiveHooks::MODIFY_SOLVER_CONTACTS);
}

/// Returns whether one of the body's colliders bounces, or has a friction coefficient with which that of a pair, the
/// product, may exceed its maximum: the hook then modifies its contacts.
fn needs_contact_hook(bodies: &Bodies, id: BodyId) -> bool {
    let colliders = bodies.record(id).map(|r| bodies.world.bodies[r.handle].colliders());
    let mut colliders = colliders.into_iter().flatten().filter_map(|c| bodies.world.colliders.get(*c));
    colliders.any(|c| c.friction() > MAX_FRICTION.sqrt() || c.restitution() > 0.0)
}

fn set_hooks(bodies: &mut Bodies, id: BodyId, change: impl Fn(ActiveHooks) -> ActiveHooks) {
    let Some(handle) = bodies.record(id).map(|r| r.handle) else { return };
    for &collider in bodies.world.bodies[handle].colliders() {
        if let Some(collider) = bodies.world.colliders.get_mut(collider) {
            collider.set_active_hooks(change(collider.active_hooks()));
        }
    }
}
