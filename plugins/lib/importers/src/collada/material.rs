//! Materials: the colour or the image of an effect.

use roxmltree::Node;

use super::tree::{ElementIndex, child, children, numbers};

/// The supported properties of a material.
#[derive(Debug, Default)]
pub struct Material {
    pub color: Option<[f64; 3]>,
    /// File name of the image.
    pub image: Option<String>,
}

impl Material {
    /// Reads the material with the given id; returns the default if it does not exist.
    pub fn read<'a>(tree: &ElementIndex<'a>, reference: &str) -> Self {
        let effect = || tree.follow(child(tree.get(reference)?, "instance_effect")?, "url");
        let Some(profile) = effect().and_then(|e| child(e, "profile_COMMON")) else { return Material::default() };
        let shader = child(profile, "technique").and_then(|t| {
            let known = ["phong", "lambert", "blinn", "constant"];
            t.children().find(|n| known.contains(&n.tag_name().name()))
        });
        // A material that only emits light has the colour of this light.
        let part = shader.and_then(|s| child(s, "diffuse").or_else(|| child(s, "emission")));
        let Some(part) = part else { return Material::default() };
        let color = child(part, "color").map(numbers::<f64>).and_then(|c| Some([*c.first()?, *c.get(1)?, *c.get(2)?]));
        let image = child(part, "texture").and_then(|t| image(tree, profile, t.attribute("texture")?));
        Material { color: color.map(|c| c.map(|x| x.clamp(0.0, 1.0))), image }
    }
}

/// Resolves the name in a `<texture>` through its sampler and surface to an image file; many files name the image
/// directly.
fn image<'a>(tree: &ElementIndex<'a>, profile: Node<'a, 'a>, name: &str) -> Option<String> {
    let parameter = |sid: &str| children(profile, "newparam").find(|n| n.attribute("sid") == Some(sid));
    let mut image = None;
    if let Some(sampler) = parameter(name).and_then(|p| child(p, "sampler2D")) {
        image = child(sampler, "instance_image").and_then(|n| tree.follow(n, "url"));
        let surface = || parameter(child(sampler, "source")?.text()?.trim());
        if image.is_none() {
            image = surface().and_then(|p| tree.get(child(child(p, "surface")?, "init_from")?.text()?.trim()));
        }
    }
    let image = image.or_else(|| tree.get(name)).filter(|n| n.tag_name().name() == "image")?;
    let from = child(image, "init_from")?;
    // In version 1.5, the name is in a separate element.
    let text = child(from, "ref").unwrap_or(from).text()?.trim();
    (!text.is_empty()).then(|| text.to_owned())
}
