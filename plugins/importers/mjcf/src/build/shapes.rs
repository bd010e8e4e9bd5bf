//! Builds the shapes of bodies: what collides as one compound, and what is only seen as shapes below it.

use nalgebra::Isometry3;
use tatu_plugin_api::safe::{Node, Result, Value};

use super::{
    ModelBuilder, Placed,
    forms::{LEAST_MASS, LINK_SHARE, byte, friction, make_empty, moving_mass, set_mass},
};
use crate::{
    groups::Attachment,
    model::{Geom, GeomForm},
};

impl<'b> ModelBuilder<'_, 'b> {
    /// Returns whether a geom collides, by its own bits or as a member of a contact pair.
    pub(super) fn collides(&self, geom: &Geom) -> bool {
        geom.collides() || (!geom.name.is_empty() && self.model.paired_geoms.contains(&geom.name))
    }

    /// Returns the mask of a shape of a group with these geoms. The bits of contact types decide between mechanisms.
    fn mask(&self, geoms: &[&Geom], group: usize) -> i64 {
        let types = geoms.iter().fold(0, |bits, g| bits | g.contype | g.conaffinity);
        let high = if types == 0 { 1 } else { byte(types) };
        high << 8 | i64::from(self.low_masks[group])
    }

    /// Builds a shape of a group that consists of one geom. A mesh that collides is convex, unless it stands still by
    /// itself.
    pub(super) fn single(&mut self, node: Node<'b>, geom: &Geom, group: usize) -> Result {
        let collides = self.collides(geom);
        self.shapes.form(self.builder, node, geom, collides)?;
        node.set("shape.respondable", collides)?;
        if collides {
            let mask = self.mask(&[geom], group);
            // The world has no other part with which it could collide.
            node.set("shape.respondable_mask", if group == 0 { mask | 0xFF } else { mask })?
                .set("shape.friction", friction(geom))?;
            self.surface(node, &[geom])?;
        }
        if !geom.is_shown() {
            node.set("object.visible", false)?.set("shape.detectable", false)?;
        }
        Ok(())
    }

    /// Sets the friction against spinning and rolling.
    fn surface(&mut self, node: Node<'b>, geoms: &[&Geom]) -> Result {
        let most = |condim: i64, index: usize| {
            geoms.iter().filter(|g| g.condim >= condim).map(|g| g.friction[index]).fold(0.0, f64::max)
        };
        let (spinning, rolling) = (most(4, 1), most(6, 2));
        if spinning > 0.0 {
            node.set("shape.spinning_friction", spinning)?;
        }
        if rolling > 0.0 {
            node.set("shape.rolling_friction", rolling)?;
        }
        Ok(())
    }

    /// Builds the shape of a group: its collision geometry, mass and visuals.
    pub(super) fn body_shape(&mut self, number: usize, shape: &Placed<'b>) -> Result {
        let (model, groups) = (self.model, self.groups);
        let group = &groups.all[number];
        let node = shape.node;
        let moves = group.attachment != Attachment::Fixed;
        let mut all: Vec<(usize, usize, Isometry3<f64>, &Geom)> = Vec::new();
        for (body, pose) in &group.bodies {
            all.extend(model.bodies[*body].geoms.iter().enumerate().map(|(i, geom)| (*body, i, *pose, geom)));
        }
        // Planes and height fields are not convex, so they need shapes of their own.
        let apart = |g: &Geom| matches!(g.form, GeomForm::Plane(_) | GeomForm::Heights(_));
        let colliding: Vec<_> = all.iter().filter(|(_, _, _, g)| self.collides(g) && !apart(g)).collect();
        let seen = all.iter().any(|(_, _, _, g)| !self.collides(g) && g.is_shown());
        let shown = colliding.iter().any(|(_, _, _, g)| g.is_shown());
        if colliding.is_empty() {
            make_empty(node)?;
        } else {
            let mut parts = Vec::with_capacity(colliding.len());
            for (_, _, pose, geom) in &colliding {
                // What viewers hide is shown only if there is nothing else to see.
                let hidden = !geom.is_shown() && (shown || seen);
                parts.push(self.shapes.part(self.builder, geom, pose, hidden)?);
            }
            let geoms: Vec<&Geom> = colliding.iter().map(|(_, _, _, g)| *g).collect();
            node.set("shape.primitive", "compound")?
                .set("shape.parts", Value::List(parts))?
                .set("shape.respondable", true)?
                .set("shape.respondable_mask", self.mask(&geoms, number))?
                .set("shape.friction", geoms.iter().map(|g| friction(g)).fold(0.0, f64::max))?;
            if seen && !shown {
                node.set("object.visible", false)?.set("shape.detectable", false)?;
            }
            let alone = group.attachment != Attachment::Joints && !group.carries;
            if alone {
                self.surface(node, &geoms)?;
            } else if geoms.iter().any(|g| g.condim >= 4) {
                self.report.note(
                    &model.bodies[group.first].place,
                    "friction against spinning and rolling (`condim` 4 and 6) is omitted on bodies with joints, because \
                     it would slow the solver down",
                );
            }
        }
        if moves {
            self.mass(number, node)?;
        }
        for (body, i, pose, geom) in &all {
            let separate = apart(geom) || (!self.collides(geom) && geom.is_shown());
            if !separate {
                continue;
            }
            let name = match geom.name.as_str() {
                "" => format!("{}_geom_{i}", model.bodies[*body].name),
                name => name.to_owned(),
            };
            let part = self.attached("shape", shape, &name, &(*pose * geom.pose))?;
            self.single(part.node, geom, number)?;
        }
        Ok(())
    }

    fn mass(&mut self, number: usize, node: Node<'b>) -> Result {
        let group = &self.groups.all[number];
        let body = &self.model.bodies[group.first];
        let links = body.joints.len().saturating_sub(1) as f64;
        let mass = moving_mass(group);
        if group.mass.mass <= 0.0 {
            self.report.warn(&body.place, format!("moving bodies without mass weigh {LEAST_MASS} kg"));
        }
        if body.damping > 0.0 {
            let inertia = mass.inertia.trace() / 3.0;
            node.set("shape.linear_damping", body.damping / mass.mass)?;
            if inertia > 0.0 {
                node.set("shape.angular_damping", body.damping / inertia)?;
            }
        }
        set_mass(node, &mass.scaled(1.0 - links * LINK_SHARE))
    }
}
