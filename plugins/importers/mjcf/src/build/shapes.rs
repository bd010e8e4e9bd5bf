//! Builds the shapes of bodies: what collides as one compound, and what is only seen as shapes below it.

use std::{collections::BTreeMap, rc::Rc};

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{ShapeBuilder, merge_pieces};
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use super::{ModelBuilder, Placed, joints::LINK_SHARE};
use crate::{
    groups::Attachment,
    mass::Mass,
    mesh::MeshAsset,
    model::{Geom, GeomForm, Picture},
};

/// Full size of a shape that stands for a body without geoms, m.
const EMPTY_SIZE: f64 = 0.01;
/// Mass of a moving body without any, kg.
const LEAST_MASS: f64 = 1e-6;
/// Size of the image on a plane without an end, m.
const PLANE_SIZE: f64 = 2.0;

/// Meshes and images that have been added to the scene.
#[derive(Default)]
pub struct ShapeMaker {
    merged: BTreeMap<usize, (Rc<MeshAsset>, i64)>,
    images: BTreeMap<usize, (Rc<Picture>, i64)>,
    pieces: ShapeBuilder,
}

/// Makes a shape that neither collides nor is seen.
pub fn make_empty(node: Node<'_>) -> Result {
    node.set("shape.primitive", "box")?
        .set("shape.size", [EMPTY_SIZE; 3])?
        .set("object.visible", false)?
        .set("shape.detectable", false)?;
    Ok(())
}

/// Makes a shape dynamic, with this mass.
pub fn set_mass(node: Node<'_>, mass: &Mass) -> Result {
    node.set("shape.dynamic", true)?.set("shape.mass", mass.mass)?.set("shape.com", <[f64; 3]>::from(mass.com))?;
    // Rounding must not make the tensor asymmetric.
    let inertia = (mass.inertia + mass.inertia.transpose()) * 0.5;
    if inertia.symmetric_eigenvalues().min() > 0.0 {
        node.set("shape.inertia", Value::Floats(inertia.as_slice().to_vec()))?;
    } else {
        // A point mass: the least tensor that the engine can invert.
        let least = 1e-9 * mass.mass;
        let axes = inertia.symmetric_eigen();
        let moments = axes.eigenvalues.map(|x| x.max(least));
        let inertia = axes.eigenvectors * nalgebra::Matrix3::from_diagonal(&moments) * axes.eigenvectors.transpose();
        node.set("shape.inertia", Value::Floats(((inertia + inertia.transpose()) * 0.5).as_slice().to_vec()))?;
    }
    Ok(())
}

/// Returns primitive and full size of a form that is not a mesh.
fn primitive(form: &GeomForm) -> (&'static str, [f64; 3]) {
    match form {
        GeomForm::Plane([x, y]) => {
            let side = |half: f64| if half > 0.0 { 2.0 * half } else { 1000.0 };
            ("plane", [side(*x), side(*y), 0.1])
        }
        GeomForm::Ellipsoid(half) => ("sphere", half.map(|x| 2.0 * x)),
        GeomForm::Capsule { radius, half } => ("capsule", [2.0 * radius, 2.0 * radius, 2.0 * (half + radius)]),
        GeomForm::Cylinder { radius, half } => ("cylinder", [2.0 * radius, 2.0 * radius, 2.0 * half]),
        GeomForm::Box(half) => ("box", half.map(|x| 2.0 * x)),
        GeomForm::Mesh(_) | GeomForm::Heights(_) => ("mesh", [1.0; 3]),
    }
}

/// Returns the bits of contact types in one byte.
fn byte(bits: u32) -> i64 {
    i64::from((bits | bits >> 8 | bits >> 16 | bits >> 24) & 0xFF)
}

/// Returns the friction of a geom; without tangential contact dimensions, it has none.
fn friction(geom: &Geom) -> f64 {
    if geom.condim == 1 { 0.0 } else { geom.friction[0].max(0.0) }
}

impl ShapeMaker {
    /// Returns the number of a mesh in one piece.
    fn mesh(&mut self, builder: &Builder<'_>, mesh: &Rc<MeshAsset>) -> Result<i64> {
        let key = Rc::as_ptr(mesh) as usize;
        if let Some((_, number)) = self.merged.get(&key) {
            return Ok(*number);
        }
        let (points, triangles) = merge_pieces(&mesh.pieces);
        let number = builder.mesh(&points, &triangles)?;
        self.merged.insert(key, (mesh.clone(), number));
        Ok(number)
    }

    /// Returns the property `texture` of a picture on a form.
    fn texture(&mut self, builder: &Builder<'_>, picture: &Rc<Picture>, form: &GeomForm) -> Result<Option<Value>> {
        let key = Rc::as_ptr(picture) as usize;
        let number = match self.images.get(&key) {
            Some((_, number)) => *number,
            None => {
                let number = builder.image(&picture.rgba, picture.columns, picture.rows)?;
                self.images.insert(key, (picture.clone(), number));
                number
            }
        };
        let GeomForm::Plane(half) = form else { return Ok(None) };
        let size = [0, 1].map(|i| {
            let whole = match (picture.per_metre, half[i] > 0.0) {
                (true, _) => 1.0,
                (false, true) => 2.0 * half[i],
                (false, false) => PLANE_SIZE,
            };
            (whole / picture.repeat[i].max(1e-3)).clamp(1e-3, 1e3)
        });
        let text = Value::text;
        Ok(Some(Value::Map(vec![
            (text("image"), Value::Int(number)),
            (text("mapping"), text("plane")),
            (text("size"), Value::from(size)),
            (text("repeat"), Value::List(vec![Value::Bool(true), Value::Bool(true)])),
        ])))
    }

    /// Sets the form and look of a shape that consists of a single geom.
    fn form(&mut self, builder: &Builder<'_>, node: Node<'_>, geom: &Geom, convex: bool) -> Result {
        let look = &geom.look;
        let [r, g, b, opacity] = look.rgba;
        node.set("shape.color", [r, g, b])?;
        if opacity < 1.0 {
            node.set("shape.opacity", opacity)?;
        }
        match &geom.form {
            GeomForm::Mesh(mesh) if !convex => {
                self.pieces.shape(builder, node, &mesh.pieces, look.is_default)?;
            }
            GeomForm::Mesh(mesh) | GeomForm::Heights(mesh) => {
                let number = self.mesh(builder, mesh)?;
                let convex = matches!(geom.form, GeomForm::Mesh(_));
                node.set("shape.primitive", "mesh")?.set("shape.mesh", number)?.set("shape.convex", convex)?;
            }
            form => {
                let (name, size) = primitive(form);
                node.set("shape.primitive", name)?.set("shape.size", size)?;
                if let Some(picture) = &look.texture
                    && let Some(texture) = self.texture(builder, picture, form)?
                {
                    node.set("shape.texture", texture)?;
                }
            }
        }
        Ok(())
    }

    /// Returns a geom as a part of a compound.
    fn part(&mut self, builder: &Builder<'_>, geom: &Geom, pose: &Isometry3<f64>, hidden: bool) -> Result<Value> {
        let at = pose * geom.pose;
        let q = at.rotation.coords;
        let (name, size) = primitive(&geom.form);
        let [r, g, b, opacity] = geom.look.rgba;
        let text = Value::text;
        let mut keys = vec![
            (text("primitive"), text(name)),
            (text("position"), Value::from(<[f64; 3]>::from(at.translation.vector))),
            (text("quaternion"), Value::from([q.x, q.y, q.z, q.w])),
            (text("color"), Value::from([r, g, b])),
            (text("opacity"), Value::from(if hidden { 0.0 } else { opacity })),
            (text("friction"), Value::from(friction(geom))),
        ];
        match &geom.form {
            GeomForm::Mesh(mesh) | GeomForm::Heights(mesh) => {
                keys.push((text("mesh"), Value::Int(self.mesh(builder, mesh)?)));
                keys.push((text("convex"), Value::Bool(true)));
            }
            _ => keys.push((text("size"), Value::from(size))),
        }
        Ok(Value::Map(keys))
    }
}

impl<'b> ModelBuilder<'_, 'b> {
    /// Returns whether a geom collides, by its own bits or as a member of a contact pair.
    pub(super) fn collides(&self, geom: &Geom) -> bool {
        geom.collides() || (!geom.name.is_empty() && self.model.paired_geoms.contains(&geom.name))
    }

    /// Returns the mask of a shape with these geoms. The bits of contact types decide between mechanisms; within one,
    /// shapes collide only on request.
    fn mask(&self, geoms: &[&Geom]) -> i64 {
        let types = geoms.iter().fold(0, |bits, g| bits | g.contype | g.conaffinity);
        let high = if types == 0 { 1 } else { byte(types) };
        let within = geoms.iter().fold(0, |bits, g| bits | (g.contype & g.conaffinity));
        let low = if self.settings.self_collision { byte(within) } else { 0 };
        high << 8 | low
    }

    /// Builds a shape that consists of one geom. A mesh that collides is convex, unless it stands still by itself.
    pub(super) fn single(&mut self, node: Node<'b>, geom: &Geom, is_world: bool) -> Result {
        let collides = self.collides(geom);
        self.shapes.form(self.builder, node, geom, collides)?;
        node.set("shape.respondable", collides)?;
        if collides {
            let mask = self.mask(&[geom]);
            // The world has no other part with which it could collide.
            node.set("shape.respondable_mask", if is_world { mask | 0xFF } else { mask })?
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
                .set("shape.respondable_mask", self.mask(&geoms))?
                .set("shape.friction", geoms.iter().map(|g| friction(g)).fold(0.0, f64::max))?;
            if seen && !shown {
                node.set("object.visible", false)?.set("shape.detectable", false)?;
            }
            let alone = group.attachment != Attachment::Joints && !self.carriers.contains(&number);
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
            self.single(part.node, geom, false)?;
        }
        Ok(())
    }

    fn mass(&mut self, number: usize, node: Node<'b>) -> Result {
        let group = &self.groups.all[number];
        let body = &self.model.bodies[group.first];
        let links = body.joints.len().saturating_sub(1) as f64;
        let mut mass = group.mass;
        if mass.mass <= 0.0 {
            self.report.warn(&body.place, format!("moving bodies without mass weigh {LEAST_MASS} kg"));
            let inertia = nalgebra::Matrix3::from_diagonal(&Vector3::repeat(LEAST_MASS * 1e-4));
            mass = Mass { mass: LEAST_MASS, com: Vector3::zeros(), inertia };
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
