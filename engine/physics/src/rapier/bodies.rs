//! Bodies and their colliders, and the freezing of bodies whose state has become NaN or infinite.

use nalgebra::{Isometry3, Matrix3, Point3};
use rapier3d::{
    dynamics::{CoefficientCombineRule, RigidBodyBuilder, RigidBodyHandle},
    geometry::ColliderBuilder,
    math::Vector,
    pipeline::ActiveHooks,
};

use super::{
    collision_filter::{self, ColliderTag},
    contact_refresh,
    records::{BodyRecord, JointRecord},
    sleep,
    state::{EngineState, Rapier, is_finite},
};
use crate::{BodyDesc, BodyId, ContactSurface, Engine, FrictionRule, JointId, MassProps, MotionType, convert};

impl Rapier {
    pub(super) fn record(&self, body: BodyId) -> Option<&BodyRecord> {
        self.state.bodies.get(body.0 as usize)?.as_ref()
    }

    pub(super) fn insert_body(&mut self, desc: &BodyDesc) -> BodyId {
        let id = BodyId(self.state.bodies.len() as u32);
        let sound = is_valid(desc);
        let builder = match desc.motion {
            MotionType::Static => RigidBodyBuilder::fixed(),
            MotionType::Kinematic => RigidBodyBuilder::kinematic_position_based(),
            MotionType::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let dynamic = sound && desc.motion == MotionType::Dynamic;
        let com = if dynamic { convert::vector(&desc.mass.com.coords) } else { Vector::ZERO };
        let mut record = BodyRecord {
            handle: RigidBodyHandle::invalid(),
            motion: desc.motion,
            respond: desc.collision_mask,
            com,
            joints: 0,
            uneven: false,
            in_tree: false,
        };
        let mut builder =
            builder.user_data(u128::from(id.0)).allow_fast_rotation(true).gyroscopic_forces_enabled(false);
        if sound {
            builder = builder.pose(record.rapier_pose(&desc.pose));
        }
        if dynamic {
            let mass = MassProps { com: Point3::origin(), ..desc.mass };
            record.uneven = is_uneven(&mass.inertia);
            builder = builder
                .linvel(convert::vector(&desc.linear_velocity))
                .angvel(convert::vector(&desc.angular_velocity))
                .linear_damping(desc.damping[0])
                .angular_damping(desc.damping[1])
                .ccd_enabled(desc.bullet)
                .additional_mass_properties(convert::mass(&mass));
        }
        let handle = self.world.insert_body(builder);
        record.handle = handle;
        sleep::set_may_sleep(&mut self.world.bodies[handle], self.state.sleep);
        self.state.bodies.push(Some(record));
        if desc.collision_mask.mask != 0 {
            self.add_colliders(id, desc);
            self.join_collision_tree(id);
            self.state.fresh.push(id);
            if self.needs_contact_hook(id) {
                self.enable_contact_hook(id);
            }
            if desc.surface != ContactSurface::default() {
                self.state.surfaces.insert(id, desc.surface);
                self.enable_pair_hooks(id);
            }
        }
        // Rapier would do this in the next step, but drives need the centre of mass before that.
        self.world.bodies[handle].recompute_mass_properties_from_colliders(&self.world.colliders);
        if !sound {
            self.freeze(id);
        }
        id
    }

    fn add_colliders(&mut self, id: BodyId, desc: &BodyDesc) {
        let Some(&record) = self.record(id) else {
            return;
        };
        for part in &desc.parts {
            let Some((shape, in_part)) = self.shapes.shape(&part.form) else {
                continue;
            };
            let collider = ColliderBuilder::new(shape)
                .position(record.local_pose(&part.pose) * in_part)
                // The mass is set on the body directly.
                .density(0.0)
                .friction(part.friction.unwrap_or(desc.friction))
                .friction_combine_rule(match self.state.friction_rule {
                    FrictionRule::Product => CoefficientCombineRule::Multiply,
                    FrictionRule::Mean => CoefficientCombineRule::Average,
                    FrictionRule::Least => CoefficientCombineRule::Min,
                    FrictionRule::Greatest => CoefficientCombineRule::Max,
                })
                .restitution(desc.restitution)
                .restitution_combine_rule(CoefficientCombineRule::Multiply)
                .active_hooks(contact_refresh::required_hooks(&part.form))
                .collision_groups(collision_filter::collision_groups(desc.collision_mask.mask, false))
                .user_data(ColliderTag { body: id.0, collision_mask: desc.collision_mask }.pack());
            self.world.insert_collider(collider, Some(record.handle));
        }
    }

    /// Adds a body to its collision tree, and enables the mask filter where collision groups are not sufficient.
    fn join_collision_tree(&mut self, id: BodyId) {
        let Some(&BodyRecord { respond: new, .. }) = self.record(id) else {
            return;
        };
        let mut tree = self.state.trees.remove(&new.tree).unwrap_or_default();
        for &other in &tree.members {
            let Some(&BodyRecord { respond: old, .. }) = self.record(other) else {
                continue;
            };
            match (collision_filter::masks_collide(old, new), collision_filter::high_bytes_collide(old, new)) {
                // The collision groups would let the two bodies collide, so one of them needs the filter. It is enabled
                // for the older one, which is usually the base of a robot. The robot's wheels then touch the floor
                // without a filter.
                (false, true) => self.enable_mask_filter(other, false),
                (true, false) => tree.wide = true,
                _ => {}
            }
        }
        tree.members.push(id);
        if tree.wide {
            for &member in &tree.members {
                self.enable_mask_filter(member, true);
            }
        }
        self.state.trees.insert(new.tree, tree);
    }

    /// Enables the mask filter for a body. If `low_too` is set, the groups also pass pairs that share only low bits.
    fn enable_mask_filter(&mut self, id: BodyId, low_too: bool) {
        let Some(&BodyRecord { handle, respond, .. }) = self.record(id) else {
            return;
        };
        let colliders = &mut self.world.colliders;
        for &collider in self.world.bodies[handle].colliders() {
            let Some(collider) = colliders.get_mut(collider) else {
                continue;
            };
            collider.set_active_hooks(collider.active_hooks() | ActiveHooks::FILTER_CONTACT_PAIRS);
            if low_too {
                collider.set_collision_groups(collision_filter::collision_groups(respond.mask, true));
            }
        }
    }

    /// Enables the hooks that decide which bodies a body collides with and that modify its contacts.
    pub(super) fn enable_pair_hooks(&mut self, id: BodyId) {
        self.set_hooks(id, |h| h | ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS);
    }

    /// Enables the hook that modifies the contacts of a body.
    pub(super) fn enable_contact_hook(&mut self, id: BodyId) {
        self.set_hooks(id, |h| h | ActiveHooks::MODIFY_SOLVER_CONTACTS);
    }

    /// Disables the hook that modifies the contacts of a body, unless it is still needed.
    pub(super) fn disable_contact_hook(&mut self, id: BodyId) {
        let EngineState { surfaces, pairs, partings, .. } = &self.state;
        let in_pair = |(a, b): &(BodyId, BodyId)| *a == id || *b == id;
        if !self.needs_contact_hook(id)
            && !surfaces.contains_key(&id)
            && !pairs.keys().any(in_pair)
            && !partings.keys().any(in_pair)
        {
            self.set_hooks(id, |h| h & !ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
    }

    /// Returns whether one of the body's colliders bounces, or has a friction coefficient that exceeds the maximum for
    /// a pair: the hook then modifies its contacts.
    fn needs_contact_hook(&self, id: BodyId) -> bool {
        let colliders = self.record(id).map(|r| self.world.bodies[r.handle].colliders());
        let mut colliders = colliders.into_iter().flatten().filter_map(|c| self.world.colliders.get(*c));
        colliders.any(|c| c.friction() > collision_filter::MAX_FRICTION || c.restitution() > 0.0)
    }

    fn set_hooks(&mut self, id: BodyId, change: impl Fn(ActiveHooks) -> ActiveHooks) {
        let Some(handle) = self.record(id).map(|r| r.handle) else { return };
        for &collider in self.world.bodies[handle].colliders() {
            if let Some(collider) = self.world.colliders.get_mut(collider) {
                collider.set_active_hooks(change(collider.active_hooks()));
            }
        }
    }

    pub(super) fn delete_body(&mut self, body: BodyId) {
        let Some(record) = self.record(body).copied() else {
            return;
        };
        let on_it = |j: &Option<_>| j.as_ref().is_some_and(|j: &JointRecord| j.bodies.0 == body || j.bodies.1 == body);
        let gone: Vec<_> = (0..).zip(&self.state.joints).filter(|(_, j)| on_it(j)).map(|(i, _)| JointId(i)).collect();
        for joint in gone {
            self.remove_joint(joint);
        }
        self.release_adopted_body(body);
        self.state.loads.remove(&body);
        self.discard_contacts(body);
        self.remove_surface(body);
        self.world.remove_body(record.handle);
        self.state.bodies[body.0 as usize] = None;
        self.discard_velocity(body);
        self.state.moving.remove(&body);
        self.state.pairs.retain(|(a, b), _| *a != body && *b != body);
        self.state.partings.retain(|(a, b), _| *a != body && *b != body);
        self.state.fresh.retain(|id| *id != body);
        if let Some(tree) = self.state.trees.get_mut(&record.respond.tree) {
            tree.members.retain(|id| *id != body);
            if tree.members.is_empty() {
                self.state.trees.remove(&record.respond.tree);
            }
        }
    }

    pub(super) fn set_body_pose(&mut self, body: BodyId, pose: &Isometry3<f64>) {
        let Some(&record) = self.record(body) else {
            return;
        };
        if !is_valid_pose(pose) {
            return self.freeze(body);
        }
        let (handle, pose) = (record.handle, record.rapier_pose(pose));
        if record.motion != MotionType::Kinematic {
            self.world.bodies[handle].set_position(pose, true);
            self.state.moved.push(body);
            self.discard_velocity(body);
            if record.motion == MotionType::Static && record.joints > 0 {
                self.schedule_rebuild(body);
                self.move_anchors(body, &pose);
            }
            return;
        }
        let from = *self.world.bodies[handle].position();
        self.state.moving.entry(body).or_insert((from, pose)).1 = pose;
    }

    /// Prepares a body for a joint. The body remains awake unless its mechanism is parked, because a wheel that creeps
    /// along under its motor can be slower than any threshold. If the joint connects bodies of very different mass, an
    /// iteration is added for the body's contacts and joints in each sub-step, because the solution converges slowly:
    /// without it, a 16 kg chassis on a 0.25 kg caster tilts by 0.4 degrees instead of 0.3.
    pub(super) fn prepare_for_joint(&mut self, body: BodyId, uneven: bool) {
        let Some(Some(record)) = self.state.bodies.get_mut(body.0 as usize) else {
            return;
        };
        record.joints += 1;
        let handle = record.handle;
        self.world.wake_up(handle, true);
        let body = &mut self.world.bodies[handle];
        sleep::set_may_sleep(body, false);
        // Gyroscopic forces are applied in each sub-step, not in each step as for free bodies.
        body.enable_gyroscopic_forces(true);
        if uneven && body.additional_pgs_iterations() == 0 {
            body.set_additional_pgs_iterations(1);
        }
    }

    /// Records that a joint of a body was removed. A body without joints can sleep again, and its gyroscopic forces are
    /// those of a free body.
    pub(super) fn free_from_joint(&mut self, body: BodyId) {
        let may_sleep = self.state.sleep;
        let Some(Some(record)) = self.state.bodies.get_mut(body.0 as usize) else {
            return;
        };
        record.joints = record.joints.saturating_sub(1);
        if record.joints == 0 {
            let body = &mut self.world.bodies[record.handle];
            sleep::set_may_sleep(body, may_sleep);
            body.enable_gyroscopic_forces(false);
        }
    }

    /// Freezes a body at its current pose; [`Engine::quarantined`] reports it.
    pub(super) fn freeze(&mut self, body: BodyId) {
        let Some(&BodyRecord { handle, .. }) = self.record(body) else {
            return;
        };
        if self.world.bodies[handle].is_enabled() {
            self.world.bodies[handle].set_enabled(false);
            self.state.frozen.push(body);
        }
    }

    /// Records the bodies that rapier has just frozen.
    pub(super) fn collect_frozen(&mut self) {
        if self.world.quarantine().is_empty() {
            return;
        }
        let world = &self.world;
        let ids = world.quarantine().bodies().iter().filter_map(|h| world.bodies.get(*h));
        self.state.frozen.extend(ids.map(|body| BodyId(body.user_data as u32)));
    }
}

/// Returns whether the axis about which a free body with this inertia rotates can move.
fn is_uneven(inertia: &Matrix3<f64>) -> bool {
    let even = Matrix3::from_diagonal_element(inertia.trace() / 3.0);
    (inertia - even).amax() > 1e-9 * inertia.trace()
}

fn is_valid_pose(pose: &Isometry3<f64>) -> bool {
    is_finite(&pose.translation.vector) && pose.rotation.coords.iter().all(|x| x.is_finite())
}

fn is_valid_mass(mass: &MassProps) -> bool {
    mass.mass.is_finite() && is_finite(&mass.com.coords) && mass.inertia.iter().all(|x| x.is_finite())
}

pub(super) fn is_valid_surface(s: &ContactSurface) -> bool {
    let numbers = [s.axis_friction, s.rolling_friction, s.spinning_friction];
    let axis = s.axis.is_none_or(|a| is_finite(&a)) && s.axis_angle.is_finite();
    is_finite(&s.velocity) && axis && numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
}

fn is_valid(desc: &BodyDesc) -> bool {
    is_valid_pose(&desc.pose)
        && is_finite(&desc.linear_velocity)
        && is_finite(&desc.angular_velocity)
        && desc.friction.is_finite()
        && desc.restitution.is_finite()
        && is_valid_surface(&desc.surface)
        && (desc.motion != MotionType::Dynamic || is_valid_mass(&desc.mass))
        && desc.parts.iter().all(|part| is_valid_pose(&part.pose))
}
