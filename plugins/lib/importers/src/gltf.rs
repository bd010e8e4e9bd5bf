//! glTF 2.0: triangles, their base colours and opacities, placed by the nodes of the scene. Skins, morph targets,
//! compressed primitives and all other properties of materials are ignored.

use std::rc::Rc;

use base64::{Engine as _, engine::general_purpose::STANDARD};
use gltf::{
    Document, Node, Semantic, buffer,
    json::{Root, validation::Checked},
    material::AlphaMode,
    mesh::Mode,
};
use nalgebra::Matrix4;

use crate::{
    model::{
        ImportedModel, MeshModel, MeshPiece, PieceCollector, append_transformed, check_triangle_count, translucent,
    },
    picture::{DecodedImage, FileLoader, ImageCache},
};

pub fn read(bytes: &[u8], files: FileLoader<'_>) -> Result<ImportedModel, String> {
    let (document, mut blob) = open(bytes).map_err(|e| format!("the glTF file is incomplete or damaged: {e}"))?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            buffer::Source::Bin => blob.take(),
            buffer::Source::Uri(uri) => load(uri, files),
        };
        let bytes = bytes.filter(|b| b.len() >= buffer.length());
        let missing = || format!("the buffer {} of the glTF file is missing or truncated", buffer.index());
        buffers.push(bytes.ok_or_else(missing)?);
    }
    let mut walk = NodeWalk { buffers: &buffers, collected: PieceCollector::new() };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    for node in scene.into_iter().flat_map(|s| s.nodes()) {
        walk.node(&node, &Matrix4::identity(), 0)?;
    }
    let pieces = walk.collected.pieces;
    let mut gallery = ImageCache::new(files);
    let mut model = MeshModel { pieces: Vec::new(), y_up: true };
    for (material, mut piece) in pieces {
        let material = material.and_then(|i| document.materials().nth(i));
        if let Some(material) = material {
            let surface = material.pbr_metallic_roughness();
            let [r, g, b, alpha] = surface.base_color_factor();
            piece.color = Some([r, g, b].map(|x| linear_to_srgb(f64::from(x))));
            if material.alpha_mode() == AlphaMode::Blend {
                piece.opacity = translucent(f64::from(alpha));
            }
            let image = surface.base_color_texture().map(|t| t.texture().source().index());
            piece.picture = image.and_then(|i| picture(&document, i, &buffers, &mut gallery, files));
        }
        model.pieces.push(piece);
    }
    Ok(ImportedModel { model, notes: gallery.notes })
}

/// Reads and checks the document; returns it with the binary chunk, if the file has one.
fn open(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), String> {
    let (json, blob) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let mut root: Root = gltf::json::deserialize::from_slice(json).map_err(|e| e.to_string())?;
    root.extensions_required.retain(|name| !is_irrelevant(name));
    // The validation of the `gltf` crate would panic if one of these indices were out of range.
    let all = root.meshes.iter().flat_map(|m| &m.primitives);
    let position =
        |p: &gltf::json::mesh::Primitive| p.attributes.get(&Checked::Valid(Semantic::Positions)).map(|a| a.value());
    if let Some(beyond) = all.filter_map(position).find(|a| *a >= root.accessors.len()) {
        return Err(format!("the accessor {beyond} does not exist"));
    }
    Ok((Document::from_json(root).map_err(|e| e.to_string())?, blob))
}

/// Returns whether an extension does not concern the form of a mesh, its base colour or its opacity, so that files that
/// require it can be read without it.
fn is_irrelevant(extension: &str) -> bool {
    const OTHERS: [&str; 4] =
        ["KHR_lights_punctual", "KHR_animation_pointer", "KHR_xmp_json_ld", "EXT_lights_image_based"];
    extension.starts_with("KHR_materials_") || OTHERS.contains(&extension)
}

/// Returns the JSON text and the binary chunk of a binary file, which consists of a header of 12 bytes, and of chunks
/// that begin with their length and kind.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<Vec<u8>>), String> {
    let (mut text, mut blob) = (None, None);
    let mut rest = bytes.get(12..).unwrap_or_default();
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, kind @ ..] = *head;
        let length = u32::from_le_bytes([a, b, c, d]) as usize;
        let body = after.get(..length).ok_or("the file is truncated: it ends within a chunk")?;
        match &kind {
            b"JSON" if text.is_none() => text = Some(body),
            b"BIN\0" if blob.is_none() => blob = Some(body.to_vec()),
            _ => {}
        }
        rest = &after[length..];
    }
    Ok((text.ok_or("the file has no JSON chunk")?, blob))
}

/// Converts a component of a colour from linear to sRGB, which images and scenes use.
fn linear_to_srgb(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 }
}

/// Returns the bytes to which a URI refers: embedded data, or the content of a file.
fn load(uri: &str, files: FileLoader<'_>) -> Option<Vec<u8>> {
    match uri.strip_prefix("data:") {
        Some(data) => STANDARD.decode(data.split_once("base64,")?.1).ok(),
        None => files(&uri.replace("%20", " ")),
    }
}

fn picture(
    document: &Document,
    index: usize,
    buffers: &[Vec<u8>],
    gallery: &mut ImageCache<'_>,
    files: FileLoader<'_>,
) -> Option<Rc<DecodedImage>> {
    let name = format!("number {index}");
    // Read the JSON, because the crate's own access to an image panics if the URI and the MIME type are missing.
    let image = document.as_json().images.get(index)?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) if uri.starts_with("data:") => gallery.bytes(name, load(uri, files).as_deref()),
        (Some(uri), _) => gallery.file(uri),
        (None, view) => {
            let view = view.and_then(|v| document.views().nth(v.value()));
            let bytes = view.and_then(|v| buffers.get(v.buffer().index())?.get(v.offset()..)?.get(..v.length()));
            gallery.bytes(name, bytes)
        }
    }
}

struct NodeWalk<'a> {
    buffers: &'a [Vec<u8>],
    collected: PieceCollector<Option<usize>>,
}

impl NodeWalk<'_> {
    fn node(&mut self, node: &Node<'_>, above: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.collected.visit(depth)?;
        let own = node.transform().matrix().map(|column| column.map(f64::from));
        let here = above * Matrix4::from(own);
        for primitive in node.mesh().into_iter().flat_map(|m| m.primitives()) {
            let Some(piece) = self.piece(&primitive)? else { continue };
            let of_material = self.collected.piece(primitive.material().index(), piece.triangles.len())?;
            append_transformed(of_material, &piece, &here);
        }
        node.children().try_for_each(|child| self.node(&child, &here, depth + 1))
    }

    fn piece(&self, primitive: &gltf::Primitive<'_>) -> Result<Option<MeshPiece>, String> {
        let lies = |a: Option<gltf::Accessor<'_>>| a.is_none_or(|a| self.is_within_buffer(&a));
        let coordinates = primitive.get(&Semantic::TexCoords(0));
        if !(lies(primitive.get(&Semantic::Positions)) && lies(primitive.indices()) && lies(coordinates)) {
            return Err("the glTF file is damaged: the data of a mesh exceeds its buffer".into());
        }
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let Some(positions) = reader.read_positions() else { return Ok(None) };
        let points: Vec<_> = positions.map(|p| p.map(f64::from)).collect();
        let corners: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().collect(),
            None => (0..points.len() as u32).collect(),
        };
        let triangles: Vec<_> = match primitive.mode() {
            Mode::Triangles => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]).collect(),
            Mode::TriangleStrip => {
                let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                corners.windows(3).enumerate().map(turned).collect()
            }
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Ok(None),
        };
        check_triangle_count(triangles.len())?;
        if triangles.iter().flatten().any(|i| *i as usize >= points.len()) {
            return Err("the file is damaged: a face refers to a point that does not exist".into());
        }
        // The origin of texture coordinates is the top of the image in glTF, but the bottom in scenes.
        let coordinates = reader.read_tex_coords(0).map(|t| t.into_f32().map(|[x, y]| [x, 1.0 - y]).collect());
        Ok(Some(MeshPiece { points, triangles, coordinates: coordinates.unwrap_or_default(), ..Default::default() }))
    }

    /// Returns whether the data of an accessor is within its buffer. Sparse accessors are not supported.
    fn is_within_buffer(&self, accessor: &gltf::Accessor<'_>) -> bool {
        if accessor.sparse().is_some() {
            return false;
        }
        let Some(view) = accessor.view() else { return accessor.count() == 0 };
        let (size, count) = (accessor.size(), accessor.count());
        let stride = view.stride().unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(size));
        let end = last.and_then(|n| n.checked_add(accessor.offset()));
        let buffer = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        let view_end = view.offset().checked_add(view.length());
        end.is_some_and(|end| end <= view.length()) && view_end.is_some_and(|end| end <= buffer) && stride >= size
    }
}
