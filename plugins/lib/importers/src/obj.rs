//! Wavefront OBJ. Groups with the same material form a piece.

use std::{cell::RefCell, io::Cursor};

use tobj::{LoadError, LoadOptions, Material};

use crate::{
    model::{ImportedModel, MeshModel, PieceCollector, translucent},
    picture::{FileLoader, ImageCache},
};

/// Returns the text without comments behind numbers, and with lines of numbers joined that end in a backslash, neither of
/// which the parser knows. Names, which may contain `#` and end in a backslash, are not changed.
fn without_comments(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut is_continued = false;
    let mut has_numbers = false;
    for line in bytes.split_inclusive(|b| *b == b'\n') {
        let text = line.trim_ascii_end();
        if !is_continued {
            let word = text.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
            has_numbers = matches!(word, b"v" | b"vt" | b"vn" | b"vp" | b"f" | b"l" | b"p");
        }
        let text = match text.iter().position(|b| *b == b'#') {
            Some(comment) if has_numbers => text[..comment].trim_ascii_end(),
            _ => text,
        };
        let joined = text.strip_suffix(b"\\").filter(|_| has_numbers);
        out.extend_from_slice(joined.unwrap_or(text));
        is_continued = joined.is_some();
        out.push(if is_continued { b' ' } else { b'\n' });
    }
    out
}

pub fn read(bytes: &[u8], files: FileLoader<'_>) -> Result<ImportedModel, String> {
    let options = LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let notes = RefCell::new(Vec::new());
    let library = |path: &std::path::Path| {
        let name = path.to_string_lossy();
        let found = files(&name).ok_or(LoadError::OpenFileFailed);
        let read = found.and_then(|bytes| tobj::load_mtl_buf(&mut Cursor::new(bytes)));
        // Missing materials are not an error, because the mesh is also useful without colours.
        Ok(read.unwrap_or_else(|e| {
            notes.borrow_mut().push(format!("the materials in `{name}` are ignored: {e}"));
            Default::default()
        }))
    };
    let (models, materials) = tobj::load_obj_buf(&mut Cursor::new(without_comments(bytes)), &options, library)
        .map_err(|e| format!("the OBJ file is incomplete or damaged: {e}"))?;
    let materials = materials.unwrap_or_default();
    let mut collected = PieceCollector::new();
    for tobj::Model { mesh, .. } in models {
        let material = mesh.material_id.filter(|i| *i < materials.len());
        let piece = collected.piece(material, mesh.indices.len() / 3)?;
        let (first, had) = (piece.points.len() as u32, piece.points.len());
        piece.points.extend(mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(f64::from)));
        piece
            .triangles
            .extend(mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| i.saturating_add(first))));
        if piece.coordinates.len() == had {
            piece.coordinates.extend(mesh.texcoords.chunks_exact(2).map(|t| [t[0], t[1]]));
        }
    }
    let mut gallery = ImageCache::new(files);
    for (material, piece) in &mut collected.pieces {
        let Some(material) = material.map(|i| &materials[i]) else { continue };
        piece.color = material.diffuse.map(|c| c.map(|x| f64::from(x).clamp(0.0, 1.0)));
        piece.opacity = opacity(material);
        piece.picture = image(material).and_then(|name| gallery.file(name));
    }
    let mut notes = notes.into_inner();
    notes.append(&mut gallery.notes);
    let pieces = collected.pieces.into_iter().map(|(_, piece)| piece).collect();
    Ok(ImportedModel { model: MeshModel { pieces, y_up: false }, notes })
}

/// Returns the opacity of a material: `d`, or 1 minus `Tr`.
fn opacity(material: &Material) -> Option<f64> {
    let inverse = || Some(1.0 - material.unknown_param.get("Tr")?.trim().parse::<f64>().ok()?);
    translucent(material.dissolve.map(f64::from).or_else(inverse)?)
}

/// Returns the file name of a material's image, which follows the options of `map_Kd`.
fn image(material: &Material) -> Option<&str> {
    let text = material.diffuse_texture.as_deref()?.trim();
    let name = if text.starts_with('-') { text.rsplit(' ').next()? } else { text };
    (!name.is_empty()).then_some(name)
}
