//! Writes the tree of bodies.

use nalgebra::{Isometry3, Vector3};
use tatu_exporters_common::{Control, Export, JointKind, JointProperties, Mechanisms, Tie, XmlWriter, number, numbers};

use crate::{
    attached::{Sensors, write_attached},
    geoms::{Meshes, add_pose, write_geom},
    inertia::write_inertial,
    masks::Masks,
    naming::Names,
};

/// What the functions that write bodies share.
pub struct BodyWriter<'w, 'e> {
    pub all: &'w Mechanisms,
    pub names: Names,
    pub masks: Masks,
    pub meshes: Meshes,
    pub sensors: Sensors,
    pub export: &'w mut Export<'e>,
    /// Whether MuJoCo has to balance the inertia of a body.
    pub balances: bool,
}

/// Returns the bodies in the order in which they are written: each before those that it carries.
pub fn order(all: &Mechanisms) -> Vec<usize> {
    let children = all.children();
    let mut order = Vec::with_capacity(all.bodies.len());
    let mut open = vec![0];
    while let Some(body) = open.pop() {
        order.push(body);
        open.extend(children[body].iter().rev());
    }
    order
}

impl BodyWriter<'_, '_> {
    /// Writes the world and all bodies.
    pub fn write(&mut self, xml: &mut XmlWriter) {
        xml.begin("worldbody", &[]);
        self.contents(xml, 0);
        // The bodies whose elements are open, from the outermost; a chain can be longer than a stack of calls.
        let mut open: Vec<usize> = Vec::new();
        for body in order(self.all).into_iter().skip(1) {
            let parent = self.all.parent_of(body);
            while open.last().is_some_and(|last| *last != parent) {
                open.pop();
                xml.end();
            }
            self.begin(xml, body);
            open.push(body);
        }
        open.iter().for_each(|_| xml.end());
        xml.end();
    }

    fn begin(&mut self, xml: &mut XmlWriter, body: usize) {
        let of = &self.all.bodies[body];
        let mut attributes = vec![("name", self.names.bodies[body].clone())];
        add_pose(&mut attributes, &of.in_parent);
        xml.begin("body", &attributes);
        match &of.tie {
            Tie::Free => xml.empty("freejoint", &[]),
            Tie::Joint { item, below, joint, .. } => {
                let at = below.inverse();
                let path = &self.all.items[*item].path;
                let name = self.names.joints.get(item).cloned().unwrap_or_default();
                write_joint(xml, name, joint, &at);
                if joint.kind == JointKind::Spherical && (joint.stiffness != 0.0 || joint.dry_friction != 0.0) {
                    self.export.report.lost("springs and friction of ball joints are left out", path);
                }
            }
            Tie::World | Tie::Rigid { .. } => {}
        }
        if !matches!(of.tie, Tie::World) {
            let path = self.all.path_of(body);
            self.balances |= write_inertial(xml, of.mass.as_ref(), path, &mut self.export.report);
        }
        self.contents(xml, body);
    }

    fn contents(&mut self, xml: &mut XmlWriter, body: usize) {
        let BodyWriter { all, names, masks, meshes, sensors, export, .. } = self;
        for part in &all.bodies[body].parts {
            write_geom(xml, all, (body, part), masks, names, meshes, &mut export.report);
        }
        write_attached(xml, all, body, names, sensors, export);
    }
}

fn write_joint(xml: &mut XmlWriter, name: String, joint: &JointProperties, at: &Isometry3<f64>) {
    let kind = match joint.kind {
        JointKind::Revolute => "hinge",
        JointKind::Prismatic => "slide",
        JointKind::Spherical => "ball",
    };
    let mut attributes = vec![("name", name), ("type", kind.to_owned())];
    let place = at.translation.vector;
    if place != Vector3::zeros() {
        attributes.push(("pos", numbers([place.x, place.y, place.z])));
    }
    if joint.kind != JointKind::Spherical {
        let axis = at.rotation * Vector3::z();
        let nearest = |x: f64| if (x - x.round()).abs() < 4.0 * f64::EPSILON { x.round() } else { x };
        attributes.push(("axis", numbers([axis.x, axis.y, axis.z].map(nearest))));
        if let Some([low, high]) = joint.limits.filter(|[low, high]| low < high) {
            attributes.push(("range", numbers([low, high])));
        }
        // In spring control, the actuator is the spring.
        if joint.stiffness != 0.0 && joint.control != Control::Spring {
            attributes.push(("stiffness", number(joint.stiffness)));
            if joint.rest_position != 0.0 {
                attributes.push(("springref", number(joint.rest_position)));
            }
        }
        for (key, value) in [("armature", joint.armature), ("frictionloss", joint.dry_friction)] {
            if value != 0.0 {
                attributes.push((key, number(value)));
            }
        }
    }
    if joint.damping != 0.0 {
        attributes.push(("damping", number(joint.damping)));
    }
    xml.empty("joint", &attributes);
}
