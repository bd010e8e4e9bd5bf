//! V-REP's respond masks, and their implementation by rapier's collision groups.
//!
//! A group cannot express "only within this tree". The groups therefore contain the high bytes, which alone decide
//! between trees, and a filter runs only for bodies of trees in which the low bytes decide otherwise for some pair.

use rapier3d::{
    geometry::{ColliderHandle, Group, InteractionGroups, InteractionTestMode},
    pipeline::PhysicsWorld,
};
use serde::{Deserialize, Serialize};

use crate::{BodyId, CollisionMask};

/// The data of a collider that the filter needs, stored in its user data: body id, tree and mask.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct ColliderTag {
    pub body: u32,
    pub collision_mask: CollisionMask,
}

impl ColliderTag {
    pub fn pack(self) -> u128 {
        (u128::from(self.collision_mask.mask) << 64)
            | (u128::from(self.collision_mask.tree) << 32)
            | u128::from(self.body)
    }

    pub fn unpack(data: u128) -> Self {
        Self {
            body: data as u32,
            collision_mask: CollisionMask { mask: (data >> 64) as u16, tree: (data >> 32) as u32 },
        }
    }
}

pub(crate) fn body_of(world: &PhysicsWorld, collider: ColliderHandle) -> Option<BodyId> {
    Some(BodyId(ColliderTag::unpack(world.colliders.get(collider)?.user_data).body))
}

/// The bodies of one collision tree, without those that collide with nothing.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct CollisionTree {
    pub members: Vec<BodyId>,
    /// Whether the low bytes let some pair collide for which the high bytes alone would not allow it.
    pub wide: bool,
}

/// Returns whether the masks let two bodies collide.
pub(crate) fn masks_collide(a: CollisionMask, b: CollisionMask) -> bool {
    let shared = a.mask & b.mask;
    if a.tree == b.tree { shared & 0x00ff != 0 } else { shared & 0xff00 != 0 }
}

/// Returns whether the high bytes alone let two bodies collide.
pub(crate) fn high_bytes_collide(a: CollisionMask, b: CollisionMask) -> bool {
    a.mask & b.mask & 0xff00 != 0
}

/// Returns collision groups that pass exactly the pairs that the high bytes allow. If `low_too` is set, they pass all
/// pairs that the low or the high bytes allow, and the filter decides among these.
pub(crate) fn collision_groups(mask: u16, low_too: bool) -> InteractionGroups {
    let bits = if low_too { mask } else { mask & 0xff00 };
    let group = Group::from_bits_truncate(u32::from(bits));
    InteractionGroups::new(group, group, InteractionTestMode::And)
}
