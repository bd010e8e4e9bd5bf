//! Candidate targets shared by beams that start at nearly the same point.
//!
//! The cones of a robot's ring of sonars would each go down the scene's whole tree to the same few targets. Together they
//! go once, and each then tries those few.

use arrayvec::ArrayVec;

use super::{
    aabb::{Aabb, SLACK},
    beam::{Beam, Volume},
    probe::Probe,
    tree::{Quad, Tree, walk},
};

/// Fewer beams go down the tree by themselves.
const FEWEST: usize = 4;
/// Quads of targets that are near; where there are more targets, the tree is as good.
const QUADS: usize = 8;
const MOST: usize = 4 * QUADS;
/// How much larger the space of all may be than that of the one which sees farthest.
const STRAY: f64 = 1.5;

/// The targets near a group of beams.
pub(super) struct Candidates {
    quads: ArrayVec<Quad, QUADS>,
    /// Numbers of targets, four to a quad.
    targets: ArrayVec<u32, MOST>,
}

/// The space that a beam searches at most; `None` where its far end is no distance.
fn space(beam: &Beam) -> Option<Aabb> {
    let is_ball = matches!(beam.volume, Volume::Ray | Volume::Cone { .. });
    let origin = &beam.world_from_beam.translation.vector;
    // A tree is asked with some slack too.
    let reach = beam.far + 2.0 * SLACK;
    let space = Aabb { low: origin.add_scalar(-reach), high: origin.add_scalar(reach) };
    (is_ball && space.is_real()).then_some(space)
}

/// How many of the first beams look out from nearly one place and pass over the same targets, and the space they search;
/// `None` if they are too few.
pub(super) fn group(beams: &[Beam]) -> Option<(usize, Aabb)> {
    let first = beams.first()?;
    let mut all = space(first)?;
    let mut widest = all.high.x - all.low.x;
    let mut n = 1;
    let like = |beam: &Beam| if beam.skip_group == first.skip_group { space(beam) } else { None };
    for beam in beams[1..].iter().map_while(like) {
        let merged = all.merge(&beam);
        widest = widest.max(beam.high.x - beam.low.x);
        if (merged.high - merged.low).max() > STRAY * widest {
            break;
        }
        all = merged;
        n += 1;
    }
    (n >= FEWEST).then_some((n, all))
}

impl Candidates {
    /// The wanted targets in a space; `None` if they are too many.
    pub fn of(tree: &Tree, boxes: &[Aabb], space: &Aabb, wanted: impl Fn(u32) -> bool) -> Option<Self> {
        let mut targets = ArrayVec::new();
        if !tree.within(space, |target| !wanted(target) || targets.try_push(target).is_ok()) {
            return None;
        }
        let fours = targets.chunks(4).zip((0..).step_by(4));
        let quads =
            fours.map(|(four, first)| Quad::of_items(first, four.iter().map(|t| &boxes[*t as usize]))).collect();
        Some(Candidates { quads, targets })
    }

    /// As [`Tree::walk`], with numbers of targets.
    pub fn walk(&self, probe: &Probe, limit: f64, mut visit: impl FnMut(u32, f64) -> f64) {
        walk(&self.quads, self.quads.len(), probe, limit, |place, limit| visit(self.targets[place], limit));
    }
}
