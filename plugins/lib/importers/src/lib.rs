//! Reads mesh files for importers, and builds shapes from them: Wavefront OBJ with its materials, STL, PLY, COLLADA and
//! glTF. `mass` combines the masses of bodies, and `masks` chooses which bodies of a robot collide with each other.
//!
//! Files are not trusted: for any bytes, the result is a model or an error in one sentence.

mod collada;
mod gltf;
mod masks;
mod mass;
mod model;
mod obj;
mod picture;
mod ply;
mod shape;
mod stl;

pub use masks::SelfCollisionMasks;
pub use mass::{Mass, Solid};
pub use model::{ImportedModel, MeshModel, MeshPiece, merge_pieces};
pub use picture::{DecodedImage, FileLoader};
pub use shape::ShapeBuilder;

use model::check_triangle_count;

/// Suffixes of the supported file formats, in lower case.
pub const SUFFIXES: &[&str] = &[".obj", ".stl", ".ply", ".dae", ".gltf", ".glb"];

/// Reads a mesh file. The format is determined from the first bytes or from the suffix of `name`; a file that neither
/// identifies is read as OBJ. The error is one sentence.
pub fn read(name: &str, bytes: &[u8], files: FileLoader<'_>) -> Result<ImportedModel, String> {
    let lower = name.to_lowercase();
    let is = |suffix: &str| lower.ends_with(suffix);
    let start = bytes.trim_ascii_start();
    let mut read = match bytes {
        _ if start.starts_with(b"ply") => ImportedModel::of(ply::read(bytes)?),
        _ if start.starts_with(b"glTF") || start.starts_with(b"{") || is(".gltf") || is(".glb") => {
            gltf::read(bytes, files)?
        }
        _ if is(".dae") || start.starts_with(b"<") || start.starts_with(b"\xEF\xBB\xBF<") => {
            collada::read(bytes, files)?
        }
        _ if stl::is_stl(bytes) || is(".stl") => ImportedModel::of(stl::read(bytes)?),
        _ => obj::read(bytes, files)?,
    };
    read.model.pieces.retain(|p| !p.triangles.is_empty());
    if read.model.pieces.is_empty() {
        return Err("the file contains no triangles".into());
    }
    check_triangle_count(read.model.pieces.iter().map(|p| p.triangles.len()).sum())?;
    for piece in &mut read.model.pieces {
        let n = piece.points.len();
        if piece.triangles.iter().flatten().any(|i| *i as usize >= n) {
            return Err("the file is damaged: a face refers to a point that does not exist".into());
        }
        if piece.points.iter().flatten().any(|x| !x.is_finite()) {
            return Err("the file is damaged: a coordinate of a point is not finite".into());
        }
        let whole = piece.coordinates.len() == n && piece.coordinates.iter().flatten().all(|x| x.is_finite());
        if !whole {
            (piece.coordinates, piece.picture) = (Vec::new(), None);
        }
    }
    Ok(read)
}

#[cfg(test)]
mod tests;
