//! Forms, colours and masses of shapes, and the meshes and images that they share.

use std::{collections::BTreeMap, rc::Rc};

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{DecodedImage, Mass, MeshPiece, ShapeBuilder, merge_pieces};
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{
    groups::BodyGroup,
    mesh::MeshAsset,
    model::{Geom, GeomForm, Picture},
};

/// Share of a body's mass that each link between two of its joints gets. The mass of the body is reduced, so that
/// nothing is added.
pub const LINK_SHARE: f64 = 1e-4;
/// Full size of a shape that stands for a body without geoms, m.
const EMPTY_SIZE: f64 = 0.01;
/// Mass of a moving body without any, kg.
pub const LEAST_MASS: f64 = 1e-6;
/// Size of the image on a plane without an end, m.
const PLANE_SIZE: f64 = 2.0;

/// Meshes and images that have been added to the scene.
#[derive(Default)]
pub struct ShapeMaker {
    merged: BTreeMap<usize, (Rc<MeshAsset>, i64)>,
    images: BTreeMap<usize, (Rc<DecodedImage>, i64)>,
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

/// Returns the mass of a group that moves, which must have one.
pub fn moving_mass(group: &BodyGroup) -> Mass {
    if group.mass.mass > 0.0 {
        return group.mass;
    }
    let inertia = nalgebra::Matrix3::from_diagonal(&Vector3::repeat(LEAST_MASS * 1e-4));
    Mass { mass: LEAST_MASS, com: Vector3::zeros(), inertia }
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
pub fn byte(bits: u32) -> i64 {
    i64::from((bits | bits >> 8 | bits >> 16 | bits >> 24) & 0xFF)
}

/// Returns the friction of a geom; without tangential contact dimensions, it has none.
pub fn friction(geom: &Geom) -> f64 {
    if geom.condim == 1 { 0.0 } else { geom.friction[0].max(0.0) }
}

/// Returns whether an image can be drawn on a mesh.
fn has_coordinates(mesh: &MeshAsset) -> bool {
    mesh.pieces.iter().any(|p| !p.coordinates.is_empty())
}

/// Returns the pieces of a mesh with an image on those that have texture coordinates.
fn painted(mesh: &MeshAsset, image: &Rc<DecodedImage>, color: [f64; 3]) -> Vec<MeshPiece> {
    let each = |piece: &MeshPiece| MeshPiece {
        picture: Some(image.clone()).filter(|_| !piece.coordinates.is_empty()),
        color: Some(color),
        ..piece.clone()
    };
    mesh.pieces.iter().map(each).collect()
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
        let Some(image) = &picture.image else { return Ok(None) };
        let key = Rc::as_ptr(image) as usize;
        let number = match self.images.get(&key) {
            Some((_, number)) => *number,
            None => {
                let number = builder.image(&image.rgba, image.columns, image.rows)?;
                self.images.insert(key, (image.clone(), number));
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
    pub fn form(&mut self, builder: &Builder<'_>, node: Node<'_>, geom: &Geom, convex: bool) -> Result {
        let look = &geom.look;
        let opacity = look.rgba[3];
        node.set("shape.color", look.flat_color())?;
        if opacity < 1.0 {
            node.set("shape.opacity", opacity)?;
        }
        match &geom.form {
            GeomForm::Mesh(mesh) if !convex => {
                match look.texture.as_ref().and_then(|t| t.image.as_ref()).filter(|_| has_coordinates(mesh)) {
                    Some(image) => {
                        let [r, g, b, _] = look.rgba;
                        node.set("shape.color", [r, g, b])?;
                        self.pieces.shape(builder, node, &painted(mesh, image, [r, g, b]), true)?;
                    }
                    None => drop(self.pieces.shape(builder, node, &mesh.pieces, look.is_default)?),
                }
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
                    let [r, g, b, _] = look.rgba;
                    node.set("shape.color", [r, g, b])?.set("shape.texture", texture)?;
                }
            }
        }
        Ok(())
    }

    /// Returns a geom as a part of a compound.
    pub fn part(&mut self, builder: &Builder<'_>, geom: &Geom, pose: &Isometry3<f64>, hidden: bool) -> Result<Value> {
        let at = pose * geom.pose;
        let q = at.rotation.coords;
        let (name, size) = primitive(&geom.form);
        let opacity = geom.look.rgba[3];
        let text = Value::text;
        let mut keys = vec![
            (text("primitive"), text(name)),
            (text("position"), Value::from(<[f64; 3]>::from(at.translation.vector))),
            (text("quaternion"), Value::from([q.x, q.y, q.z, q.w])),
            (text("color"), Value::from(geom.look.flat_color())),
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
