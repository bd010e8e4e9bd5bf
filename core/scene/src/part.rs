//! Some neighbouring slots of a scene, for a thread of its own that moves what is in them.

use std::ops::Range;

use nalgebra::Isometry3;

use super::{
    Data, Joint, Scene,
    moves::Moves,
    places::{Places, Rows},
    tree::Slot,
};

/// Objects and places of some slots.
pub(super) struct Part<'a> {
    first: u32,
    slots: &'a mut [Slot],
    pub places: Rows<'a>,
}

impl Scene {
    /// Parts of so many slots each, ascending and apart, and the list of what has moved, for the time after.
    pub(super) fn parts<'a>(&'a mut self, ranges: impl Iterator<Item = Range<u32>>) -> (Vec<Part<'a>>, &'a mut Moves) {
        let (mut slots, mut places) = (&mut self.slots[..], Places::rows(&mut self.places));
        let (mut begun, mut parts) = (0, Vec::new());
        for range in ranges {
            let (from, count) = ((range.start - begun) as usize, range.len());
            let (here, after) = std::mem::take(&mut slots)[from..].split_at_mut(count);
            let (rows, rest) = places.split(from, count);
            parts.push(Part { first: range.start, slots: here, places: rows });
            (slots, places, begun) = (after, rest, range.end);
        }
        (parts, &mut self.moves)
    }
}

impl Part<'_> {
    /// The joint in a slot.
    pub fn joint(&mut self, slot: u32) -> Option<&mut Joint> {
        match self.slots[(slot - self.first) as usize].object.as_mut().map(|o| &mut o.data) {
            Some(Data::Joint(joint)) => Some(joint),
            _ => None,
        }
    }
    /// The frame that the children of an object hang on, which does not hang itself. 0: the world's.
    pub fn frame(&mut self, slot: u32) -> Isometry3<f64> {
        let Some(at) = slot.checked_sub(self.first) else { return Isometry3::identity() };
        let world = self.places.world[at as usize];
        match self.places.links[at as usize].joint {
            true => self.joint(slot).map_or(world, |joint| world * joint.motion()),
            false => world,
        }
    }
    /// The place of an object in the frame of its parent.
    pub fn local(&mut self, slot: u32) -> &mut Isometry3<f64> {
        &mut self.places.local[(slot - self.first) as usize]
    }
    /// Keeps the place of an object in the world; whether it is a shape that has moved.
    pub fn put(&mut self, slot: u32, world: Isometry3<f64>) -> bool {
        let at = (slot - self.first) as usize;
        self.places.put(at, world) && self.places.links[at].shape
    }
}
