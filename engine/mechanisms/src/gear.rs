//! Geared joints: which independent joint moves each joint, and how.
//!
//! A geared joint has no position and velocity of its own. With v the velocities of the independent joints, those of all
//! joints are G v, so the mass matrix is G'MG and the forces are G't: gears are substituted, not enforced, and cost
//! nothing in addition to the joints.

use crate::{error::TreeError, link::Link};

/// The position of a joint as a function of that of an independent joint: `ratio` times that position plus `offset`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ResolvedGear {
    /// Index of the link whose joint is independent; the link's own index if the joint is not geared.
    pub leader: usize,
    pub ratio: f64,
    pub offset: f64,
}

/// Returns the independent joint that moves the joint of each link, through all gears in between.
pub(crate) fn resolve_gears(links: &[Link]) -> Result<Vec<ResolvedGear>, TreeError> {
    (0..links.len()).map(|link| resolve_gear(links, link)).collect()
}

fn resolve_gear(links: &[Link], link: usize) -> Result<ResolvedGear, TreeError> {
    let mut found = ResolvedGear { leader: link, ratio: 1.0, offset: 0.0 };
    let mut count = 0;
    while let Some(gear) = links[found.leader].gear {
        if links[link].joint.positions() != 1 {
            return Err(TreeError::Joint { link, why: "only revolute and prismatic joints can be geared" });
        }
        let wrong = |why| TreeError::Gear { link, leader: gear.leader, why };
        let leader = links.get(gear.leader).ok_or(wrong("which does not exist"))?;
        if leader.joint.positions() != 1 {
            return Err(wrong("which is neither revolute nor prismatic"));
        }
        count += 1;
        if count > links.len() {
            return Err(wrong("which follows this joint in turn"));
        }
        found.offset += found.ratio * gear.offset;
        found.ratio *= gear.ratio;
        found.leader = gear.leader;
    }
    Ok(found)
}
