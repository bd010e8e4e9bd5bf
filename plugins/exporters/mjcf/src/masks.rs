//! Which bodies collide.
//!
//! Two shapes of a scene collide if a byte of their masks has a common bit: the low one for shapes of the same mechanism,
//! the high one for others. Two geoms collide if the contact type of one has a bit in common with the affinity of the
//! other, and their bodies are not neighbours. The high byte becomes both type and affinity. If there is one mechanism
//! whose bodies do not collide with each other, its affinity is 0; otherwise pairs of its bodies are excluded.

use std::collections::BTreeMap;

use tatu_exporters_common::{ExportReport, Mechanisms, Surface, Tie};

/// Maximum number of pairs of bodies that are excluded.
const MAX_PAIRS: usize = 20_000;

/// The contact types of a scene.
pub struct Masks {
    /// The mechanism whose geoms have no affinity, by its topmost body.
    silent: Option<usize>,
    /// Pairs of bodies that do not collide.
    pub excluded: Vec<[usize; 2]>,
}

/// The masks of the forms of each body that collide, joined.
fn joined(all: &Mechanisms) -> Vec<u16> {
    let of = |surfaces: &mut dyn Iterator<Item = Surface>| surfaces.fold(0, |bits, s| bits | s.mask);
    all.bodies.iter().map(|b| of(&mut b.parts.iter().filter_map(|p| p.surface))).collect()
}

impl Masks {
    /// Determines contact types.
    pub fn new(all: &Mechanisms, report: &mut ExportReport) -> Self {
        let masks = joined(all);
        // What is rigidly connected, by its first body; 0: the world.
        let mut weld = vec![0; all.bodies.len()];
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for b in 1..all.bodies.len() {
            weld[b] = match all.bodies[b].tie {
                Tie::World => 0,
                Tie::Rigid { parent } => weld[parent],
                Tie::Free | Tie::Joint { .. } => b,
            };
            if masks[b] != 0 {
                members.entry(all.top_of(b)).or_default().push(b);
            }
        }
        // The parent of a weld group, to find neighbours, which MuJoCo excludes unless one is the world.
        let above = |b: usize| if weld[b] == 0 { 0 } else { weld[all.parent_of(weld[b])] };
        let meets = |a: usize, b: usize| {
            let (a, b) = (weld[a].min(weld[b]), weld[a].max(weld[b]));
            a != b && !(a != 0 && above(b) == a)
        };
        let pairs_of = |bodies: &[usize]| {
            let mut pairs = Vec::new();
            for (i, a) in bodies.iter().enumerate() {
                pairs.extend(bodies[i + 1..].iter().filter(|b| meets(*a, **b)).map(|b| [*a, *b]).take(MAX_PAIRS + 1));
                if pairs.len() > MAX_PAIRS {
                    break;
                }
            }
            pairs
        };
        let is_silent = |bodies: &Vec<usize>| {
            let low = bodies.iter().filter(|b| masks[**b] & 0xFF != 0).count();
            low < 2 && bodies.len() > 1
        };
        let silent: Vec<usize> = members.iter().filter(|(_, b)| is_silent(b)).map(|(top, _)| *top).collect();
        let silent = if let [one] = silent.as_slice() { Some(*one) } else { None };
        let mut excluded = Vec::new();
        for (top, bodies) in members.iter().filter(|(top, _)| Some(**top) != silent) {
            for [a, b] in pairs_of(bodies) {
                let (a_mask, b_mask) = (masks[a], masks[b]);
                let (wanted, would) = (a_mask & b_mask & 0xFF != 0, (a_mask & b_mask) >> 8 != 0);
                if would && !wanted {
                    excluded.push([a, b]);
                } else if wanted && !would {
                    report.lost("bodies that collide only within their mechanism do not collide", all.path_of(*top));
                }
            }
        }
        if excluded.len() > MAX_PAIRS {
            report.lost(
                format!("there are more than {MAX_PAIRS} pairs of bodies that do not collide: further ones collide"),
                "",
            );
            excluded.truncate(MAX_PAIRS);
        }
        Masks { silent, excluded }
    }

    /// Returns contact type and affinity of a form of a body.
    pub fn of(&self, all: &Mechanisms, body: usize, surface: &Surface) -> [u16; 2] {
        let bits = surface.mask >> 8;
        let is_silent = body != 0 && self.silent == Some(all.top_of(body));
        [bits, if is_silent { 0 } else { bits }]
    }
}
