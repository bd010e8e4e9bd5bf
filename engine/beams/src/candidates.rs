//! Candidate targets shared by beams that start at nearly the same point.
//!
//! Without candidates, each cone of a robot's ring of sonars would traverse the whole tree and find the same few
//! targets. Instead, the tree is traversed once for a group of beams, and each beam is tested against the targets that
//! were found.

use arrayvec::ArrayVec;

use super::{
    aabb::{Aabb, BOX_TOLERANCE_M},
    beam::{Beam, Volume},
    probe::Probe,
    tree::{BoxTree, QuadNode, walk},
};

/// Minimum number of beams in a group; smaller groups use the tree directly.
const MIN_GROUP_SIZE: usize = 4;
/// Maximum number of quads of candidates; with more candidates, the tree is equally fast.
const MAX_QUADS: usize = 8;
const MAX_CANDIDATES: usize = 4 * MAX_QUADS;
/// Maximum ratio of the size of the merged region to that of the largest beam's region.
const MAX_SPREAD_RATIO: f64 = 1.5;

/// The targets near a group of beams.
pub(super) struct Candidates {
    quads: ArrayVec<QuadNode, MAX_QUADS>,
    /// Indices of targets: four for each quad, or fewer for the last one.
    targets: ArrayVec<u32, MAX_CANDIDATES>,
}

/// Returns a region that contains everything within the range of a ray or cone, or `None` if the beam has another
/// volume or its far limit is not finite.
fn search_region(beam: &Beam) -> Option<Aabb> {
    let is_ball = matches!(beam.volume, Volume::Ray | Volume::Cone { .. });
    let origin = &beam.world_from_beam.translation.vector;
    // Queries of the tree use a tolerance, too.
    let reach = beam.far + 2.0 * BOX_TOLERANCE_M;
    let space = Aabb { low: origin.add_scalar(-reach), high: origin.add_scalar(reach) };
    (is_ball && space.is_valid()).then_some(space)
}

/// Returns the length of the longest initial part of `beams` in which all beams start at nearly the same point and skip
/// the same group, and the region that they search; or `None` if these are too few beams.
pub(super) fn leading_group(beams: &[Beam]) -> Option<(usize, Aabb)> {
    let first = beams.first()?;
    let mut all = search_region(first)?;
    let mut widest = all.high.x - all.low.x;
    let mut n = 1;
    let like = |beam: &Beam| if beam.skip_group == first.skip_group { search_region(beam) } else { None };
    for beam in beams[1..].iter().map_while(like) {
        let merged = all.merge(&beam);
        widest = widest.max(beam.high.x - beam.low.x);
        if (merged.high - merged.low).max() > MAX_SPREAD_RATIO * widest {
            break;
        }
        all = merged;
        n += 1;
    }
    (n >= MIN_GROUP_SIZE).then_some((n, all))
}

impl Candidates {
    /// Returns the targets in a region for which `wanted` is true, or `None` if there are too many.
    pub fn of(tree: &BoxTree, boxes: &[Aabb], space: &Aabb, wanted: impl Fn(u32) -> bool) -> Option<Self> {
        let mut targets = ArrayVec::new();
        if !tree.visit_overlapping(space, |target| !wanted(target) || targets.try_push(target).is_ok()) {
            return None;
        }
        let fours = targets.chunks(4).zip((0..).step_by(4));
        let quads =
            fours.map(|(four, first)| QuadNode::of_items(first, four.iter().map(|t| &boxes[*t as usize]))).collect();
        Some(Candidates { quads, targets })
    }

    /// Visits the candidates like [`BoxTree::walk`], but passes the indices of targets to `visit`.
    pub fn walk(&self, probe: &Probe, limit: f64, mut visit: impl FnMut(u32, f64) -> f64) {
        walk(&self.quads, self.quads.len(), probe, limit, |place, limit| visit(self.targets[place], limit));
    }
}
