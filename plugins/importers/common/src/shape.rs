//! Shapes of what mesh files contain.

use std::rc::Rc;

use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{model::Piece, picture::Picture};

/// Makes shapes of pieces, and adds each image to the scene once.
#[derive(Default)]
pub struct Shapes(Vec<(Rc<Picture>, i64)>);

impl Shapes {
    /// Makes an object a shape of pieces: a mesh, or of several pieces a compound of meshes. Without `materials` it has
    /// neither their colours nor their images.
    pub fn shape<'a>(
        &mut self,
        builder: &Builder<'a>,
        node: Node<'a>,
        pieces: &[Piece],
        materials: bool,
    ) -> Result<Node<'a>> {
        if let [piece] = pieces {
            let number = builder.textured_mesh(&piece.points, &piece.coordinates, &piece.triangles)?;
            node.set("shape.primitive", "mesh")?.set("shape.mesh", number)?;
            if let Some(color) = piece.color.filter(|_| materials) {
                node.set("shape.color", color)?;
            }
            if let Some(texture) = self.texture(builder, piece)?.filter(|_| materials) {
                node.set("shape.texture", texture)?;
            }
            return Ok(node);
        }
        let mut parts = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let number = builder.textured_mesh(&piece.points, &piece.coordinates, &piece.triangles)?;
            let mut part = vec![pair("primitive", Value::text("mesh")), pair("mesh", Value::Int(number))];
            if let Some(color) = piece.color.filter(|_| materials) {
                part.push(pair("color", Value::Floats(color.to_vec())));
            }
            if let Some(texture) = self.texture(builder, piece)?.filter(|_| materials) {
                part.push(pair("texture", texture));
            }
            parts.push(Value::Map(part));
        }
        node.set("shape.primitive", "compound")?.set("shape.parts", Value::List(parts))
    }

    /// Returns the property `texture` of a piece that has an image.
    fn texture(&mut self, builder: &Builder<'_>, piece: &Piece) -> Result<Option<Value>> {
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
