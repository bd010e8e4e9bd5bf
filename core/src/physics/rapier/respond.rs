//! V-REP's respond masks as rapier's collision groups and, where those cannot tell, as a filter.
//!
//! A group cannot say "only within this tree". So the groups carry the high bytes, which is the whole rule between
//! trees, and the filter runs only for bodies of those trees in which the low bytes decide otherwise for some pair.

use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode, SolverFlags};
use rapier3d::pipeline::{PairFilterContext, PhysicsHooks};

use crate::physics::Respond;

/// What the filter must know of a collider, kept in its user data: body id, tree and mask.
#[derive(Clone, Copy)]
pub(super) struct Tag {
    pub body: u32,
    pub respond: Respond,
}

impl Tag {
    pub fn pack(self) -> u128 {
        (u128::from(self.respond.mask) << 64) | (u128::from(self.respond.tree) << 32) | u128::from(self.body)
    }

    pub fn unpack(data: u128) -> Self {
        Self { body: data as u32, respond: Respond { mask: (data >> 64) as u16, tree: (data >> 32) as u32 } }
    }
}

/// Whether the masks let the two collide.
pub(super) fn responds(a: Respond, b: Respond) -> bool {
    let shared = a.mask & b.mask;
    if a.tree == b.tree { shared & 0x00ff != 0 } else { shared & 0xff00 != 0 }
}

/// What the high bytes alone would say.
pub(super) fn responds_by_groups(a: Respond, b: Respond) -> bool {
    a.mask & b.mask & 0xff00 != 0
}

/// Groups that let through exactly what the high bytes allow or, for bodies whose filter decides, whatever the low
/// or the high bytes allow.
pub(super) fn groups(mask: u16, low_too: bool) -> InteractionGroups {
    let bits = if low_too { mask } else { mask & 0xff00 };
    let group = Group::from_bits_truncate(u32::from(bits));
    InteractionGroups::new(group, group, InteractionTestMode::And)
}

/// The filter. It holds no state, so that it gives the same answer on every thread and after a restore.
pub(super) struct MaskFilter;

impl PhysicsHooks for MaskFilter {
    fn filter_contact_pair(&self, pair: &PairFilterContext) -> Option<SolverFlags> {
        // A filter also replaces rapier's own rule that one of the two must be moved by forces.
        let dynamic = |body: Option<RigidBodyHandle>| body.is_some_and(|b| pair.bodies[b].is_dynamic());
        if !dynamic(pair.rigid_body1) && !dynamic(pair.rigid_body2) {
            return None;
        }
        let a = Tag::unpack(pair.colliders[pair.collider1].user_data).respond;
        let b = Tag::unpack(pair.colliders[pair.collider2].user_data).respond;
        responds(a, b).then_some(SolverFlags::COMPUTE_RIGID_IMPULSES)
    }
}
