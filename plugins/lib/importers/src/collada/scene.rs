//! The scene: nodes, which place geometries and bind their material symbols to materials.

use std::collections::HashMap;

use nalgebra::{Matrix4, Quaternion, Unit, UnitQuaternion, Vector3};
use roxmltree::{Node, NodeId};

use super::{
    geometry,
    material::Material,
    tree::{ElementIndex, child, children, numbers},
};
use crate::{
    model::{ImportedModel, MeshModel, MeshPiece, PieceCollector, append_transformed},
    picture::{FileLoader, ImageCache},
};

/// Reads the scene of the file or, if the file has no scene, all geometries.
pub fn read(tree: &ElementIndex<'_>, files: FileLoader<'_>) -> Result<ImportedModel, String> {
    let asset = child(tree.root, "asset");
    let unit = asset.and_then(|a| child(a, "unit")?.attribute("meter")?.parse::<f64>().ok());
    let unit = unit.filter(|m| m.is_finite() && *m > 0.0).unwrap_or(1.0);
    let up = asset.and_then(|a| child(a, "up_axis")?.text()).map_or("Y_UP", str::trim);
    let mut walk = SceneWalk { tree, known: HashMap::new(), collected: PieceCollector::new() };
    let begin = Matrix4::new_scaling(unit);
    let shown = child(tree.root, "scene").and_then(|s| tree.follow(child(s, "instance_visual_scene")?, "url"));
    match shown {
        Some(scene) => children(scene, "node").try_for_each(|n| walk.node(n, &begin, 0))?,
        None => {
            let libraries = children(tree.root, "library_geometries");
            for geometry in libraries.flat_map(|l| children(l, "geometry")) {
                walk.geometry(geometry, None, &begin)?;
            }
        }
    }
    let mut gallery = ImageCache::new(files);
    let mut model = MeshModel { pieces: Vec::new(), y_up: up == "Y_UP" };
    for (material, mut piece) in walk.collected.pieces {
        let material = Material::read(tree, material);
        piece.color = material.color;
        piece.picture = material.image.and_then(|name| gallery.file(&name));
        model.pieces.push(piece);
    }
    Ok(ImportedModel { model, notes: gallery.notes })
}

struct SceneWalk<'t, 'a> {
    tree: &'t ElementIndex<'a>,
    /// Pieces of the geometries visited so far, because several nodes may place the same geometry.
    known: HashMap<NodeId, Vec<(&'a str, MeshPiece)>>,
    collected: PieceCollector<&'a str>,
}

impl<'a> SceneWalk<'_, 'a> {
    fn node(&mut self, node: Node<'a, 'a>, above: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.collected.visit(depth)?;
        let mut here = *above;
        for part in node.children() {
            if let Some(transform) = transform(part) {
                here *= transform;
            }
        }
        for part in node.children() {
            match part.tag_name().name() {
                "node" => self.node(part, &here, depth + 1)?,
                "instance_node" => {
                    if let Some(node) = self.tree.follow(part, "url") {
                        self.node(node, &here, depth + 1)?;
                    }
                }
                "instance_geometry" => {
                    if let Some(geometry) = self.tree.follow(part, "url") {
                        self.geometry(geometry, Some(part), &here)?;
                    }
                }
                "instance_controller" => {
                    let skin = self.tree.follow(part, "url").and_then(|c| child(c, "skin"));
                    let Some(skin) = skin else { continue };
                    let bound = child(skin, "bind_shape_matrix").and_then(matrix).unwrap_or_else(Matrix4::identity);
                    if let Some(geometry) = self.tree.follow(skin, "source") {
                        self.geometry(geometry, Some(part), &(here * bound))?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Places a geometry, with the materials that its instance binds to symbols.
    fn geometry(
        &mut self,
        geometry: Node<'a, 'a>,
        instance: Option<Node<'a, 'a>>,
        at: &Matrix4<f64>,
    ) -> Result<(), String> {
        if !self.known.contains_key(&geometry.id()) {
            self.known.insert(geometry.id(), geometry::pieces(self.tree, geometry)?);
        }
        let materials = instance.and_then(|i| child(child(i, "bind_material")?, "technique_common"));
        for (symbol, piece) in self.known.get(&geometry.id()).into_iter().flatten() {
            let mut bound = materials.into_iter().flat_map(|m| children(m, "instance_material"));
            let bound = bound.find(|m| m.attribute("symbol") == Some(symbol));
            let material = bound.and_then(|m| m.attribute("target")).unwrap_or(symbol);
            append_transformed(self.collected.piece(material, piece.triangles.len())?, piece, at);
        }
        Ok(())
    }
}

fn matrix(node: Node<'_, '_>) -> Option<Matrix4<f64>> {
    let numbers: Vec<f64> = numbers(node);
    (numbers.len() >= 16).then(|| Matrix4::from_row_slice(&numbers[..16]))
}

/// Returns the transform that an element specifies, or `None` if the element is not a transform.
fn transform(node: Node<'_, '_>) -> Option<Matrix4<f64>> {
    let name = node.tag_name().name();
    if name == "matrix" {
        return matrix(node);
    }
    if !matches!(name, "translate" | "rotate" | "scale") {
        return None;
    }
    let numbers: Vec<f64> = numbers(node);
    let v = Vector3::new(*numbers.first()?, *numbers.get(1)?, *numbers.get(2)?);
    Some(match name {
        "translate" => Matrix4::new_translation(&v),
        "scale" => Matrix4::new_nonuniform_scaling(&v),
        _ => {
            let (sine, cosine) = libm::sincos(numbers.get(3)?.to_radians() / 2.0);
            let axis = Unit::try_new(v, 0.0)?;
            UnitQuaternion::from_quaternion(Quaternion::from_parts(cosine, *axis * sine)).to_homogeneous()
        }
    })
}
