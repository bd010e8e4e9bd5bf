//! Builds shapes from the content of mesh files.

use std::rc::Rc;

use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{model::MeshPiece, picture::DecodedImage};

/// Builds shapes from pieces; each image is added to the scene only once.
#[derive(Default)]
pub struct ShapeBuilder(Vec<(Rc<DecodedImage>, i64)>);

impl ShapeBuilder {
    /// Sets up an object as a shape of pieces: a mesh or, for several pieces, a compound of meshes. If `materials` is
    /// false, the colours and images of the pieces are ignored.
    pub fn shape<'a>(
        &mut self,
        builder: &Builder<'a>,
        node: Node<'a>,
        pieces: &[MeshPiece],
        materials: bool,
    ) -> Result<Node<'a>> {
        if let [piece] = pieces {
            node.set("shape.primitive", "mesh")?;
            for (key, value) in self.keys(builder, piece, materials)? {
                node.set(&format!("shape.{key}"), value)?;
            }
            return Ok(node);
        }
        let mut parts = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let mesh = pair("primitive", Value::text("mesh"));
            let keys = self.keys(builder, piece, materials)?.into_iter().map(|(key, value)| pair(key, value));
            parts.push(Value::Map([mesh].into_iter().chain(keys).collect()));
        }
        node.set("shape.primitive", "compound")?.set("shape.parts", Value::List(parts))
    }

    /// Adds the mesh of a piece; returns the mesh and its material as properties, whose keys are the same for shapes
    /// and for parts of shapes.
    fn keys(
        &mut self,
        builder: &Builder<'_>,
        piece: &MeshPiece,
        materials: bool,
    ) -> Result<Vec<(&'static str, Value)>> {
        let number = builder.textured_mesh(&piece.points, &piece.coordinates, &piece.triangles)?;
        let mut keys = vec![("mesh", Value::Int(number))];
        if materials {
            keys.extend(piece.color.map(|color| ("color", Value::Floats(color.to_vec()))));
            keys.extend(piece.opacity.map(|opacity| ("opacity", Value::Float(opacity))));
            keys.extend(self.texture(builder, piece)?.map(|texture| ("texture", texture)));
        }
        Ok(keys)
    }

    /// Returns the property `texture` of a piece, or `None` if the piece has no image.
    fn texture(&mut self, builder: &Builder<'_>, piece: &MeshPiece) -> Result<Option<Value>> {
        let Some(picture) = &piece.picture else { return Ok(None) };
        let known = self.0.iter().find(|(known, _)| Rc::ptr_eq(known, picture)).map(|(_, number)| *number);
        let number = match known {
            Some(number) => number,
            None => {
                let number = builder.image(&picture.rgba, picture.columns, picture.rows)?;
                self.0.push((picture.clone(), number));
                number
            }
        };
        Ok(Some(Value::Map(vec![pair("image", Value::Int(number)), pair("mapping", Value::text("mesh"))])))
    }
}

fn pair(key: &str, value: Value) -> (Value, Value) {
    (Value::text(key), value)
}
