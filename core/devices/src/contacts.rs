//! The contacts of bodies as inputs of devices.

use tatu_physics::{BodyContact, BodyId, Engine};
use tatu_plugin_api::abi::{tatu_contact, tatu_object};
use tatu_scene::{Dynamics, Scene};

/// The contacts of a batch, as columns for the plugin.
#[derive(Default)]
pub(crate) struct ContactColumns {
    /// For each device, the index of its first contact; the last entry is the total number of contacts.
    pub first_contact: Vec<u64>,
    pub contact: Vec<tatu_contact>,
    pub friction: Vec<[f64; 3]>,
}

impl ContactColumns {
    pub fn clear(&mut self) {
        self.first_contact.clear();
        self.contact.clear();
        self.friction.clear();
    }
    /// Marks the beginning of a device's contacts or, after the last device, the end.
    pub fn begin(&mut self) {
        self.first_contact.push(self.contact.len() as u64);
    }
}

/// The contacts of all bodies after a physics step.
pub(crate) struct BodyContacts {
    /// Handles of the shapes that bodies represent, in order of bodies.
    shapes: Vec<(BodyId, tatu_object)>,
    contacts: Vec<BodyContact>,
    /// For each of the two bodies of a contact, the body and the index of the contact, sorted by body.
    touching: Vec<(BodyId, u32)>,
}

impl BodyContacts {
    /// Lists the bodies of a scene, without their contacts.
    pub fn new(scene: &Scene, dynamics: &Dynamics) -> Self {
        let shapes = dynamics.shapes().map(|(body, slot)| (body, scene.id(slot))).collect();
        BodyContacts { shapes, contacts: Vec::new(), touching: Vec::new() }
    }

    /// Reads the contacts after the engine's last step.
    pub fn read(&mut self, engine: &dyn Engine) {
        engine.contacts(&mut self.contacts);
        let ends = (0..).zip(&self.contacts).flat_map(|(i, c)| [(c.bodies.0, i), (c.bodies.1, i)]);
        self.touching.clear();
        self.touching.extend(ends);
        self.touching.sort_unstable();
    }

    fn shape(&self, body: BodyId) -> tatu_object {
        self.shapes.binary_search_by_key(&body, |(b, _)| *b).map_or(0, |i| self.shapes[i].1)
    }

    /// Adds the contacts of a device's body to the inputs of its batch.
    pub fn add(&self, body: Option<BodyId>, to: &mut ContactColumns) {
        to.begin();
        let Some(body) = body else { return };
        let from = self.touching.partition_point(|(b, _)| *b < body);
        for (_, i) in self.touching[from..].iter().take_while(|(b, _)| *b == body) {
            let c = &self.contacts[*i as usize];
            let (other, side) = if c.bodies.1 == body { (c.bodies.0, 1.0) } else { (c.bodies.1, -1.0) };
            to.contact.push(tatu_contact {
                shape: [self.shape(other), self.shape(body)],
                point: c.point.coords.into(),
                normal: (side * c.normal).into(),
                force: c.force,
            });
            to.friction.push((side * c.friction).into());
        }
    }
}
