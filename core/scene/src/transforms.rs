//! Where objects are, in dense tables by slot: what a step goes through for every object lies side by side, apart from
//! the rest of the objects.
//!
//! An object whose place in the world nobody keeps *hangs*: it is computed from its parent's when it is asked for. A
//! hundred sensors on a robot then cost nothing as the robot moves, but for those that measure.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

/// What a slot's object is to those that go through places.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Link {
    /// How many objects the slot has held.
    pub generation: u64,
    /// Slot of the object above; 0: the world.
    pub parent: u32,
    /// When `before` was noted last.
    noted: u32,
    /// It was created at the time in `noted`, so it has no earlier pose.
    new: bool,
    /// Its place in the world is not kept.
    pub hangs: bool,
    /// Its children hang on a frame that its joint moves.
    pub joint: bool,
    /// Its moves are recorded for readers that track shapes.
    pub shape: bool,
    /// It is the base of a model.
    pub model_base: bool,
    /// There is an object.
    pub there: bool,
}

/// The places of all objects.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Transforms {
    pub links: Vec<Link>,
    /// In the frame of the parent.
    pub local: Vec<Isometry3<f64>>,
    /// In the world; for those that hang, some earlier place.
    pub world: Vec<Isometry3<f64>>,
    /// In the world at the last barrier, for those that were moved since.
    before: Vec<Isometry3<f64>>,
    /// The number of the last barrier.
    now: u32,
    /// Whether there was a barrier.
    known: bool,
}

impl Default for Transforms {
    fn default() -> Self {
        let mut places = Transforms {
            links: Vec::new(),
            local: Vec::new(),
            world: Vec::new(),
            before: Vec::new(),
            now: 1,
            known: false,
        };
        places.push();
        places
    }
}

impl Transforms {
    /// Room for another slot.
    pub fn push(&mut self) {
        self.links.push(Link::default());
        for table in [&mut self.local, &mut self.world, &mut self.before] {
            table.push(Isometry3::identity());
        }
    }

    /// An object was made in a slot.
    pub fn begin(&mut self, slot: u32, parent: u32, local: Isometry3<f64>, world: Isometry3<f64>) {
        let at = slot as usize;
        let generation = self.links[at].generation + 1;
        self.links[at] = Link { generation, parent, noted: self.now, new: true, there: true, ..Link::default() };
        (self.local[at], self.world[at]) = (local, world);
    }

    /// The object of a slot is gone.
    pub fn end(&mut self, slot: u32) {
        let at = slot as usize;
        self.links[at] = Link { generation: self.links[at].generation, ..Link::default() };
        (self.local[at], self.world[at]) = (Isometry3::identity(), Isometry3::identity());
    }

    /// A barrier: what is moved from now on was here before.
    pub fn barrier(&mut self) {
        self.known = true;
        self.now = self.now.wrapping_add(1);
        if self.now == 0 {
            self.now = 1;
            self.links.iter_mut().for_each(|l| l.noted = 0);
        }
    }

    /// Nobody knows any more where anything was before.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Notes where an object is, before it is moved, hung elsewhere, or begins or ceases to hang.
    #[inline]
    pub fn note(&mut self, slot: u32) {
        let at = slot as usize;
        if self.links[at].noted != self.now {
            self.before[at] = self.at_barrier(slot);
            (self.links[at].noted, self.links[at].new) = (self.now, false);
        }
    }

    /// Where an object was at the last barrier; `None`: it was not there yet, or there was none.
    pub fn before(&self, slot: u32) -> Option<Isometry3<f64>> {
        let link = self.links.get(slot as usize)?;
        let unknown = !self.known || link.new && link.noted == self.now;
        (!unknown).then(|| self.at_barrier(slot))
    }

    fn at_barrier(&self, slot: u32) -> Isometry3<f64> {
        let at = slot as usize;
        match self.links[at] {
            link if link.noted == self.now => self.before[at],
            // Nothing hangs on a joint.
            link if link.hangs => self.at_barrier(link.parent) * self.local[at],
            _ => self.world[at],
        }
    }

    /// Keeps where an object is in the world; whether it is elsewhere now. Nothing, for one that hangs.
    #[inline]
    pub fn put(&mut self, slot: u32, world: Isometry3<f64>) -> bool {
        let (at, link) = (slot as usize, &mut self.links[slot as usize]);
        if link.hangs {
            return false;
        }
        if link.noted != self.now {
            self.before[at] = self.world[at];
            (link.noted, link.new) = (self.now, false);
        }
        std::mem::replace(&mut self.world[at], world) != world
    }
}
