//! The tree of live objects: slots with generations, parents and children.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::{tatu_object, tatu_slot};

use super::{
    FrictionPair, JointSolver, Object, ObjectVariant, moves::MoveLog, name_index::NameIndex, transforms::PoseTables,
};

/// Minimum number of free slots before one is reused, while slots can be added. If a script keeps the handle of a
/// removed object, the handle remains invalid until this many further objects have been removed. Free slots cost some
/// memory but no time.
const MIN_FREE_SLOTS: usize = 1 << 16;

/// The handle of an object in the ABI: generation << 20 | slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ObjectHandle(pub tatu_object);

impl ObjectHandle {
    /// Returns the slot, which scripts use as the object's handle.
    pub fn slot(self) -> u32 {
        tatu_slot(self.0)
    }
    /// Returns the generation; if it is 0, the handle means any object in the slot.
    pub fn generation(self) -> u64 {
        self.0 >> 20
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[repr(C, align(64))]
pub(super) struct ObjectSlot {
    pub object: Option<Object>,
    /// Alias of the last object that was removed from this slot, for messages about invalid handles.
    last: String,
}

/// The tree of all live objects.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Scene {
    /// All slots. Slot 0 stands for the world and is always empty.
    pub(super) slots: Vec<ObjectSlot>,
    /// The poses of all objects.
    pub(super) places: PoseTables,
    free: VecDeque<u32>,
    /// Slots that contain an object, to iterate over objects without visiting free slots.
    taken: BTreeSet<u32>,
    roots: Vec<u32>,
    /// Slots of all objects except scripts, parents before children, one tree after the other. Empty after a change of
    /// the tree, until it is rebuilt.
    order: Vec<u32>,
    next_uid: u64,
    /// Numbers that change with the scene.
    pub versions: SceneVersions,
    /// Friction and restitution by pairs of materials.
    pub friction_pairs: Vec<FrictionPair>,
    /// The solver of mechanisms whose own solver is [`JointSolver::Auto`].
    pub joint_solver: JointSolver,
    /// Custom data of the world itself, by tag.
    pub notes: BTreeMap<Vec<u8>, Vec<u8>>,
    #[serde(skip)]
    pub(super) index: NameIndex,
    /// Shapes whose world poses have changed.
    #[serde(skip)]
    pub moves: MoveLog,
    /// Reused buffer for [`Scene::refresh`].
    #[serde(skip)]
    pub(super) walk: Vec<(u32, Isometry3<f64>)>,
}

/// Counters of changes. Data derived from a scene is computed again when the corresponding counter has changed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SceneVersions {
    /// Incremented with every change of the tree, or of the data that bodies and beam targets are created from.
    pub shape: u64,
    /// Incremented when an object becomes visible or hidden.
    #[serde(skip)]
    pub seen: u64,
    /// Incremented with every change of a colour.
    #[serde(skip)]
    pub color: u64,
    /// Incremented with every change of a sensor's own settings.
    #[serde(skip)]
    pub sensor: u64,
}

impl Default for Scene {
    fn default() -> Self {
        Scene {
            friction_pairs: Vec::new(),
            joint_solver: JointSolver::Auto,
            slots: vec![ObjectSlot { object: None, last: String::new() }],
            places: PoseTables::default(),
            free: VecDeque::new(),
            taken: BTreeSet::new(),
            roots: Vec::new(),
            order: Vec::new(),
            next_uid: 1,
            versions: SceneVersions { shape: 1, seen: 0, color: 0, sensor: 0 },
            notes: BTreeMap::new(),
            index: NameIndex::default(),
            moves: MoveLog::default(),
            walk: Vec::new(),
        }
    }
}

impl Scene {
    /// Adds an object below `parent` (0 for the world). Returns its slot, or `None` if all slots are taken.
    pub fn add(&mut self, parent: u32, alias: &str, local: Isometry3<f64>, data: ObjectVariant) -> Option<u32> {
        // A slot is reused only if many are free. An outdated handle in a script therefore rarely refers to a new
        // object.
        let slot = if self.free.len() >= MIN_FREE_SLOTS {
            self.free.pop_front()?
        } else {
            let slot = u32::try_from(self.slots.len()).ok().filter(|s| *s < 0x10_0000);
            match slot {
                Some(s) => {
                    self.slots.push(ObjectSlot { object: None, last: String::new() });
                    self.places.push();
                    s
                }
                None => self.free.pop_front()?,
            }
        };
        let attached = matches!(data, ObjectVariant::Script);
        let world = if self.get(parent).is_some() { self.frame(parent) * local } else { local };
        let object = Object {
            alias: alias.to_owned(),
            suffix: -1,
            parent,
            children: Vec::new(),
            uid: self.next_uid,
            version: 0,
            visible: true,
            layer: 1,
            notes: BTreeMap::new(),
            drive: None,
            data,
        };
        self.next_uid += 1;
        self.places.init_slot(slot, parent, local, world);
        self.slots[slot as usize].object = Some(object);
        self.taken.insert(slot);
        self.index.add(alias, -1, slot);
        self.update_kind_flags(slot);
        match attached {
            // A script moves with its parent, and no reader tracks its pose, which is therefore computed on demand.
            true => self.places.links[slot as usize].hangs = true,
            false => self.siblings_mut(parent).push(slot),
        }
        self.invalidate_order();
        Some(slot)
    }

    fn siblings_mut(&mut self, parent: u32) -> &mut Vec<u32> {
        match self.slots.get_mut(parent as usize).and_then(|s| s.object.as_mut()) {
            Some(p) => &mut p.children,
            None => &mut self.roots,
        }
    }

    /// Removes an object; its children are attached to its parent and keep their world poses. Returns whether the
    /// object existed.
    pub fn remove(&mut self, slot: u32) -> bool {
        let Some(object) = self.slots.get_mut(slot as usize).and_then(|s| s.object.take()) else { return false };
        for child in object.children {
            self.attach(child, object.parent);
        }
        self.siblings_mut(object.parent).retain(|s| *s != slot);
        self.places.clear_slot(slot);
        self.index.remove(&object.alias, object.suffix, slot);
        self.slots[slot as usize].last = object.alias;
        self.taken.remove(&slot);
        self.free.push_back(slot);
        self.invalidate_order();
        true
    }

    fn attach(&mut self, slot: u32, parent: u32) {
        self.stop_hanging(slot);
        let frame = self.frame(parent);
        if let Some(o) = self.get_mut(slot) {
            o.parent = parent;
            o.version += 1;
            let places = &mut self.places;
            places.links[slot as usize].parent = parent;
            places.local[slot as usize] = frame.inverse() * places.world[slot as usize];
        }
        self.siblings_mut(parent).push(slot);
    }

    /// Attaches an object to a different parent, preserving its world pose. Returns `false` if the object does not
    /// exist, or if the new parent is the object itself or one of its descendants.
    pub fn set_parent(&mut self, slot: u32, parent: u32) -> bool {
        let mut up = parent;
        while up != 0 {
            if up == slot {
                return false;
            }
            up = self.get(up).map_or(0, |o| o.parent);
        }
        let Some(old) = self.get(slot).map(|o| o.parent) else { return false };
        self.siblings_mut(old).retain(|s| *s != slot);
        self.attach(slot, parent);
        for s in self.subtree(slot) {
            self.touch(s);
        }
        self.invalidate_order();
        true
    }

    /// Marks that the body and the beam targets of an object must be recreated.
    pub fn touch(&mut self, slot: u32) {
        self.versions.shape += 1;
        if let Some(o) = self.get_mut(slot) {
            o.version += 1;
        }
    }

    /// Changes the kind of an object, preserving its pose and name; returns whether the object exists.
    pub fn change_kind(&mut self, slot: u32, data: ObjectVariant) -> bool {
        let Some(o) = self.get_mut(slot) else { return false };
        o.data = data;
        self.versions.sensor += 1;
        self.stop_hanging(slot);
        for child in self.children(slot).to_vec() {
            self.stop_hanging(child);
        }
        self.update_kind_flags(slot);
        self.touch(slot);
        true
    }

    /// Updates the flags in an object's link after a change of the object's data.
    pub(super) fn update_kind_flags(&mut self, slot: u32) {
        let Some(o) = self.slots[slot as usize].object.as_ref() else { return };
        let link = &mut self.places.links[slot as usize];
        (link.shape, link.joint) =
            (matches!(o.data, ObjectVariant::Shape(_)), matches!(o.data, ObjectVariant::Joint(_)));
    }

    fn invalidate_order(&mut self) {
        self.versions.shape += 1;
        self.order.clear();
    }

    /// Rebuilds the order of traversal, if the tree has changed.
    pub fn update_order(&mut self) {
        if !self.order.is_empty() {
            return;
        }
        let mut ahead: Vec<u32> = self.roots.iter().rev().copied().collect();
        while let Some(slot) = ahead.pop() {
            self.order.push(slot);
            if let Some(o) = self.slots[slot as usize].object.as_ref() {
                ahead.extend(o.children.iter().rev());
            }
        }
    }

    /// Visits all objects of the tree except scripts, parents before children, one tree after the other. `f` must not
    /// change the tree.
    pub fn visit(&mut self, mut f: impl FnMut(&mut Self, u32)) {
        self.update_order();
        let order = std::mem::take(&mut self.order);
        for slot in &order {
            f(self, *slot);
        }
        self.order = order;
    }

    /// Returns an object and all its descendants, breadth first, or all objects if `base` is 0.
    pub fn subtree(&self, base: u32) -> Vec<u32> {
        let mut out = if base == 0 { self.roots.clone() } else { vec![base] };
        let mut at = 0;
        while at < out.len() {
            if let Some(o) = self.get(out[at]) {
                out.extend(&o.children);
            }
            at += 1;
        }
        out
    }

    /// Iterates over all slots that contain an object, including scripts, in ascending order.
    pub fn slots(&self) -> impl DoubleEndedIterator<Item = (u32, &Object)> {
        // If most slots are taken, iterating over the table is faster than over the set.
        let dense = 8 * self.taken.len() >= self.slots.len();
        let all =
            dense.then(|| self.slots.iter().enumerate().filter_map(|(i, s)| s.object.as_ref().map(|o| (i as u32, o))));
        let taken = (!dense).then(|| self.taken.iter().filter_map(|slot| Some((*slot, self.get(*slot)?))));
        all.into_iter().flatten().chain(taken.into_iter().flatten())
    }

    /// Returns the objects without a parent.
    pub fn roots(&self) -> &[u32] {
        &self.roots
    }
    /// Returns the children of an object, or of the world if `slot` is 0.
    pub fn children(&self, slot: u32) -> &[u32] {
        if slot == 0 { &self.roots } else { self.get(slot).map_or(&[], |o| &o.children) }
    }
    /// Returns the object in a slot, if any.
    pub fn get(&self, slot: u32) -> Option<&Object> {
        self.slots.get(slot as usize).and_then(|s| s.object.as_ref())
    }
    /// Returns whether an object is a joint.
    pub fn is_joint(&self, slot: u32) -> bool {
        self.places.links.get(slot as usize).is_some_and(|link| link.there && link.joint)
    }
    /// Returns a mutable reference to the object in a slot, if any.
    pub fn get_mut(&mut self, slot: u32) -> Option<&mut Object> {
        self.slots.get_mut(slot as usize).and_then(|s| s.object.as_mut())
    }
    /// Returns the handle of the object in a slot, or 0 if the slot is empty.
    pub fn id(&self, slot: u32) -> tatu_object {
        match self.places.links.get(slot as usize) {
            Some(link) if link.there => link.generation << 20 | u64::from(slot),
            _ => 0,
        }
    }
    /// Returns the slot of a handle. If the handle's object no longer exists, the error contains the alias of the last
    /// object that was removed from the slot, if any.
    pub fn resolve(&self, id: tatu_object) -> Result<u32, Option<&str>> {
        let handle = ObjectHandle(id);
        let slot = handle.slot();
        let Some(link) = self.places.links.get(slot as usize) else { return Err(None) };
        if link.there && (handle.generation() == 0 || handle.generation() == link.generation) {
            return Ok(slot);
        }
        Err(Some(self.slots[slot as usize].last.as_str()).filter(|name| !name.is_empty()))
    }
    /// Returns whether an object is the base of a model.
    pub fn is_model_base(&self, slot: u32) -> bool {
        self.places.links.get(slot as usize).is_some_and(|l| l.model_base)
    }
    /// Sets whether an object is the base of a model.
    pub fn set_model_base(&mut self, slot: u32, on: bool) {
        if self.get(slot).is_some() {
            self.places.links[slot as usize].model_base = on;
        }
    }

    /// Returns the nearest model base at or above an object, or 0 if there is none.
    pub fn model_of(&self, slot: u32) -> u32 {
        let mut at = slot;
        while at != 0 {
            match self.places.links.get(at as usize) {
                Some(link) if link.model_base => return at,
                link => at = link.map_or(0, |l| l.parent),
            }
        }
        0
    }
    /// Returns the scripts of an object in order of slots, or all scripts if `owner` is 0.
    pub fn scripts(&self, owner: u32) -> Vec<u32> {
        self.slots()
            .filter(|(_, o)| matches!(o.data, ObjectVariant::Script) && (owner == 0 || o.parent == owner))
            .map(|(s, _)| s)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn script_moves_with_its_object() {
        let mut scene = Scene::default();
        let body = scene.add(0, "body", Isometry3::identity(), ObjectVariant::Dummy(None)).unwrap();
        let script = scene.add(body, "script", Isometry3::identity(), ObjectVariant::Script).unwrap();
        scene.set_local(body, Isometry3::translation(1.0, 2.0, 3.0));
        assert_eq!(scene.world(script), scene.world(body));
    }

    /// The slot of a removed object is not reused before the number of removals that the reference promises.
    #[test]
    fn removed_slots_are_reused_late_and_in_order() {
        let mut scene = Scene::default();
        let new = |scene: &mut Scene| scene.add(0, "o", Isometry3::identity(), ObjectVariant::Dummy(None)).unwrap();
        let stays = new(&mut scene);
        let first = new(&mut scene);
        let id = scene.id(first);
        scene.remove(first);
        for _ in 1..MIN_FREE_SLOTS {
            let slot = new(&mut scene);
            assert_ne!(slot, first);
            scene.remove(slot);
        }
        assert!(scene.resolve(id).is_err() && scene.resolve(first.into()).is_err());
        assert_eq!((new(&mut scene), new(&mut scene)), (first, MIN_FREE_SLOTS as u32 + 2));
        let all: Vec<u32> = scene.slots().map(|(slot, _)| slot).collect();
        assert_eq!(all, [stays, first, MIN_FREE_SLOTS as u32 + 2]);
    }

    #[test]
    fn traversal_is_depth_first_with_parents_before_children() {
        let mut scene = Scene::default();
        let mut new = |parent| scene.add(parent, "o", Isometry3::identity(), ObjectVariant::Dummy(None)).unwrap();
        let (a, b) = (new(0), new(0));
        let (a1, b1, a2) = (new(a), new(b), new(a));
        let a11 = new(a1);
        scene.update_order();
        assert_eq!(scene.order, [a, a1, a11, a2, b, b1]);
    }
}
