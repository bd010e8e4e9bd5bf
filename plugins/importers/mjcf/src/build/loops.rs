//! Builds constraints that close loops: linked dummies, which hold two bodies together in all six directions.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, Vector3};
use tatu_importers_common::Mass;
use tatu_plugin_api::safe::Result;

use super::{ModelBuilder, Placed, forms};
use crate::{groups::Attachment, model::Equality, xml::Place};

/// Share of a body's mass that the link of a ball joint has, and the radius of gyration of that link, m.
const LINK_SHARE: f64 = 1e-3;
const LINK_RADIUS_M: f64 = 0.01;

impl<'b> ModelBuilder<'_, 'b> {
    /// Builds all constraints between bodies.
    pub(super) fn loops(&mut self, base: &Placed<'b>) -> Result {
        self.other_sensors();
        let model = self.model;
        let body_names: BTreeMap<&str, usize> =
            model.bodies.iter().enumerate().map(|(i, b)| (b.name.as_str(), i)).collect();
        let sites = model.bodies.iter().enumerate().flat_map(|(b, body)| body.sites.iter().map(move |s| (b, s)));
        let sites: BTreeMap<&str, (usize, Isometry3<f64>)> =
            sites.map(|(b, s)| (s.name.as_str(), (b, s.pose))).collect();
        for (i, equality) in model.equalities.iter().enumerate() {
            let body = |name: &str| body_names.get(name).copied();
            let site = |name: &str| sites.get(name).copied();
            let (ends, rigid, place) = match equality {
                Equality::Joints { .. } | Equality::Tendons { .. } => continue,
                Equality::Connect { bodies, anchor, place } => {
                    let [a, b] = [body(&bodies[0]), body(&bodies[1])];
                    let at = Isometry3::from_parts(Translation3::from(*anchor), Default::default());
                    let ends = a.zip(b).map(|(a, b)| [(a, at), (b, self.between(b, a) * at)]);
                    (ends, false, place)
                }
                Equality::Weld { bodies, relative, place } => {
                    let [a, b] = [body(&bodies[0]), body(&bodies[1])];
                    let ends = a.zip(b).map(|(a, b)| {
                        let at = relative.unwrap_or_else(|| self.between(a, b));
                        [(a, at), (b, Isometry3::identity())]
                    });
                    (ends, true, place)
                }
                Equality::Sites { sites, rigid, place } => {
                    let ends = site(&sites[0]).zip(site(&sites[1])).map(|(a, b)| [a, b]);
                    (ends, *rigid, place)
                }
            };
            let Some(ends) = ends else {
                self.report.warn(place, "an equality constraint refers to a body or site that does not exist");
                continue;
            };
            self.close(i, ends, rigid, place, base)?;
        }
        Ok(())
    }

    /// Returns the pose of a body in the frame of another, as in the file.
    fn between(&self, of: usize, other: usize) -> Isometry3<f64> {
        self.groups.world[of].inverse() * self.groups.world[other]
    }

    fn close(
        &mut self,
        number: usize,
        ends: [(usize, Isometry3<f64>); 2],
        rigid: bool,
        place: &Place,
        base: &Placed<'b>,
    ) -> Result {
        if ends.iter().any(|(body, _)| self.model.bodies[*body].is_mocap) {
            self.report
                .warn(place, "constraints that hold bodies at `mocap` bodies are omitted: move the bodies instead");
            return Ok(());
        }
        // Which of the ends belong to bodies that move.
        let moves = |body: usize| {
            let mut group = self.groups.of_body[body].0;
            while group != 0 && self.groups.all[group].attachment == Attachment::Fixed {
                group = self.groups.all[group].parent;
            }
            group != 0
        };
        let moving = ends.map(|(body, _)| moves(body));
        if moving == [false; 2] {
            return Ok(());
        }
        let names = [0, 1].map(|side| format!("equality_{number}_{side}"));
        let mut paths = Vec::new();
        let mut dummies = Vec::new();
        for (side, (body, at)) in ends.iter().enumerate() {
            let (group, in_group) = self.groups.of_body[*body];
            let first = self.groups.all[group].first;
            let carrier = self.bodies[first].clone().filter(|_| moving[side]);
            // A dummy below a body that does not move would belong to no mechanism; the base stands for the world.
            let (mut parent, mut pose) = match carrier {
                Some(shape) => (shape, in_group * at),
                None => (base.clone(), self.groups.world[*body] * at),
            };
            // The first end that moves carries a ball joint, which leaves the rotation free.
            if !rigid && moving[side] && (side == 0 || !moving[0]) {
                let joint = self.object("joint", &parent, &format!("{}_ball", names[side]), &pose)?;
                joint.node.set("joint.type", "spherical")?.set("joint.mode", "dynamic")?;
                let link = self.object("shape", &joint, &format!("{}_link", names[side]), &Isometry3::identity())?;
                forms::make_empty(link.node)?;
                let mass = self.groups.all[group].mass.mass.max(1e-3) * LINK_SHARE;
                let inertia = nalgebra::Matrix3::from_diagonal(&Vector3::repeat(mass * LINK_RADIUS_M * LINK_RADIUS_M));
                forms::set_mass(link.node, &Mass { mass, com: Vector3::zeros(), inertia })?;
                (parent, pose) = (link, Isometry3::identity());
                self.report.note(
                    place,
                    "a `connect` constraint is closed by a ball joint with a link of 1/1000 of the body's mass",
                );
            }
            let dummy = self.object("dummy", &parent, &names[side], &pose)?;
            paths.push(dummy.path.clone());
            dummies.push(dummy);
        }
        for (dummy, other) in dummies.iter().zip(paths.iter().rev()) {
            dummy.node.set("dummy.link", format!(":{other}").as_str())?;
        }
        Ok(())
    }
}
