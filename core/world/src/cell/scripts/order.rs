//! The order in which scripts are called.
//!
//! - Parents first: threaded child scripts, child scripts, then customization scripts; within a kind, down each tree,
//!   siblings by the priority of their scripts.
//! - By kind: the same kinds, but up each tree.
//! - Deepest first: child scripts, then customization scripts; within a kind, by depth in the whole scene, and at equal
//!   depth in the order of the hierarchy. The priority orders only the scripts of one object.
//!
//! Add-ons, the sandbox and referees are called last. The languages of the scripts determine the order of a world.

use std::{collections::BTreeMap, rc::Rc};

use tatu_scene::Scene;

use crate::cell::{
    scripts::kinds::{ScriptKind, ScriptOrder},
    scripts::list::Script,
};

/// Position of an object among others; scripts of objects with smaller positions are called first.
type OrderKey = (usize, usize);

/// Sorts scripts into their order of calling.
pub(crate) fn sort(scripts: &mut [Rc<Script>], scene: &Scene, order: ScriptOrder) {
    let owner = |s: &Script| scene.get(s.slot).map_or(0, |o| o.parent);
    let class = |s: &Script| match s.kind {
        // A main script calls the other scripts and is not called itself.
        ScriptKind::Main => 0,
        ScriptKind::Child if order != ScriptOrder::DeepestFirst && s.instance.threaded.get() => 1,
        ScriptKind::Child => 2,
        ScriptKind::Customization => 3,
        ScriptKind::Addon => 4,
        ScriptKind::Sandbox => 5,
        ScriptKind::Referee => 6,
    };
    let places = match order {
        ScriptOrder::DeepestFirst => by_depth(scene),
        ScriptOrder::ParentsFirst => by_tree(scripts, scene, &owner, true),
        ScriptOrder::ByKind => by_tree(scripts, scene, &owner, false),
    };
    scripts.sort_by_cached_key(|s| {
        let place = places.get(&owner(s)).copied().unwrap_or((usize::MAX, 0));
        (class(s), place, s.priority, s.slot)
    });
}

/// Returns positions of objects by depth, deepest first, then by hierarchy.
fn by_depth(scene: &Scene) -> BTreeMap<u32, OrderKey> {
    let mut places = BTreeMap::new();
    let (mut level, mut depth) = (scene.roots().to_vec(), 0);
    let mut at = 0;
    while !level.is_empty() {
        let mut next = Vec::new();
        for slot in level {
            places.insert(slot, (usize::MAX - 1 - depth, at));
            at += 1;
            next.extend(scene.children(slot));
        }
        (level, depth) = (next, depth + 1);
    }
    places
}

/// Returns positions of objects tree by tree, parents before or after their children; siblings by priority, then by
/// hierarchy.
fn by_tree(
    scripts: &[Rc<Script>],
    scene: &Scene,
    owner: &dyn Fn(&Script) -> u32,
    parents_first: bool,
) -> BTreeMap<u32, OrderKey> {
    let mut priority: BTreeMap<u32, u8> = BTreeMap::new();
    for s in scripts {
        let known = priority.entry(owner(s)).or_insert(s.priority);
        *known = s.priority.min(*known);
    }
    let sorted = |slots: &[u32]| {
        let mut slots = slots.to_vec();
        slots.sort_by_key(|s| priority.get(s).copied().unwrap_or(tatu_scene::document::NORMAL_PRIORITY));
        slots
    };
    let mut places = BTreeMap::new();
    // Stack of objects to visit, the next one last. The flag is set if the children of the object have been visited.
    let mut open: Vec<(u32, bool)> = sorted(scene.roots()).into_iter().rev().map(|s| (s, false)).collect();
    while let Some((slot, below_done)) = open.pop() {
        if parents_first != below_done {
            places.insert(slot, (places.len(), 0));
        }
        if !below_done {
            if !parents_first {
                open.push((slot, true));
            }
            open.extend(sorted(scene.children(slot)).into_iter().rev().map(|s| (s, false)));
        }
    }
    places
}
