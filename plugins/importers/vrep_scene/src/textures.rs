//! Imports the textures of shapes.
//!
//! Two facts are inferred. The origin of a projection is the centre of the image, since this centres logos on their
//! parts. For cylindrical and spherical mappings, sizes around the axis are fractions of a turn; this is untested,
//! because the examined files map textures only to planes and boxes.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::{Builder, Result, Value};

use crate::{
    describe::map,
    read::{
        file::{FileObject, VrepFile},
        pose::isometry,
        texture::{Texture, TextureMapping},
    },
    report::ImportReport,
};

/// Names of the mappings, by their index in the file.
const MAPPINGS: [&str; 4] = ["plane", "cylinder", "sphere", "box"];
/// Names of the ways in which an image is combined with the color of the shape, by their index in the file.
const BLENDS: [&str; 3] = ["modulate", "decal", "add"];

/// The images that were added to the scene, by their ids in the file.
#[derive(Default)]
pub struct ImportedImages(BTreeMap<i32, i64>);

impl ImportedImages {
    /// Returns the image of a part for the property `texture`, or `None` if the part has no image that is supported.
    pub fn texture(
        &mut self,
        (builder, file): (&Builder<'_>, &VrepFile),
        property: &TextureMapping,
        o: &FileObject,
        report: &mut ImportReport,
    ) -> Result<Option<Value>> {
        let Some(image) = file.textures.iter().find(|t| t.id == property.texture) else {
            report.add("without", "the image of a vision sensor on the shape is ignored", o);
            return Ok(None);
        };
        let mapping = usize::try_from(property.mode).ok().and_then(|m| MAPPINGS.get(m));
        let Some(mapping) = mapping.filter(|_| property.scale.iter().all(|x| x.is_finite() && *x > 0.0)) else {
            report.add(
                "without",
                format!("an image on the shape is ignored, because its mapping {} is unknown", property.mode),
                o,
            );
            return Ok(None);
        };
        let number = match self.0.get(&image.id) {
            Some(number) => *number,
            None => {
                let number = builder.image(&pixels(file, image), image.size[0] as u32, image.size[1] as u32)?;
                self.0.insert(image.id, number);
                number
            }
        };
        let pose = isometry(&property.pose);
        let (at, q) = (<[f64; 3]>::from(pose.translation.vector), pose.rotation.coords);
        let blend = usize::try_from(property.apply).ok().and_then(|b| BLENDS.get(b)).unwrap_or(&BLENDS[0]);
        Ok(Some(Value::Map(map! {
            "image": number,
            "mapping": *mapping,
            "size": Value::Floats(property.scale.to_vec()),
            "position": at,
            "quaternion": [q.x, q.y, q.z, q.w],
            "repeat": Value::List(property.repeat.map(Value::Bool).to_vec()),
            "smooth": property.smooth,
            "blend": *blend,
        })))
    }
}

/// Returns the pixels of an image with 4 bytes each, top row first; a file stores the bottom row first.
fn pixels(file: &VrepFile, image: &Texture) -> Vec<u8> {
    let (columns, each) = (image.size[0] as usize, if image.alpha { 4 } else { 3 });
    let bytes = image.pixels.of(&file.data);
    let rows = bytes.chunks_exact(each * columns).take(image.size[1] as usize);
    let pixel = |p: &[u8]| [p[0], p[1], p[2], p.get(3).copied().unwrap_or(255)];
    rows.rev().flat_map(|row| row.chunks_exact(each).flat_map(pixel)).collect()
}
