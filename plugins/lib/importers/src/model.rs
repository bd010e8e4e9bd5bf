//! The content of a mesh file.

use std::rc::Rc;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};

use crate::picture::DecodedImage;

/// Maximum number of triangles of a file.
pub const MAX_TRIANGLES: usize = 4_000_000;

/// Maximum nesting depth of nodes.
const MAX_DEPTH: usize = 64;

/// Maximum number of visits of nodes. A node with several references is visited for each of them, so without this
/// limit, a small file could keep an importer busy for a practically unlimited time.
const MAX_VISITS: usize = 100_000;

/// The triangles of a file, divided into one piece per material.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshModel {
    /// The pieces, none of which is empty.
    pub pieces: Vec<MeshPiece>,
    /// Whether the y axis is up, according to the file or its format. If false, the z axis is up, or the direction is
    /// unknown.
    pub y_up: bool,
}

/// Triangles with the same material, in metres if the file specifies its unit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshPiece {
    /// Corner points, each x, y, z.
    pub points: Vec<[f64; 3]>,
    /// Three indices of points per triangle, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of each point: 0 to 1 from left to right, and 0 to 1 from bottom to top of the image. Empty
    /// if the file has none.
    pub coordinates: Vec<[f32; 2]>,
    /// Red, green and blue of the material, each 0 to 1.
    pub color: Option<[f64; 3]>,
    /// Opacity of the material, from 0 (invisible) to below 1, if it is translucent.
    pub opacity: Option<f64>,
    /// The image of the material; if present, `coordinates` is not empty.
    pub picture: Option<Rc<DecodedImage>>,
}

/// A model, and notes on omitted parts, one sentence each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImportedModel {
    /// The triangles of the file.
    pub model: MeshModel,
    /// Notes on omitted parts, such as missing or damaged images.
    pub notes: Vec<String>,
}

/// Returns an opacity limited to 0 to 1, or `None` if it is 1, or not a number.
pub(crate) fn translucent(opacity: f64) -> Option<f64> {
    (opacity < 1.0).then(|| opacity.max(0.0))
}

impl ImportedModel {
    /// Creates a model that consists of a single piece.
    pub(crate) fn of(piece: MeshPiece) -> Self {
        ImportedModel { model: MeshModel { pieces: vec![piece], y_up: false }, notes: Vec::new() }
    }
}

impl MeshModel {
    /// Rotates a model whose y axis is up, so that the z axis is up.
    pub fn turn_y_up_to_z_up(&mut self) {
        if std::mem::take(&mut self.y_up) {
            self.pieces.iter_mut().flat_map(|p| &mut p.points).for_each(|p| *p = [p[0], -p[2], p[1]]);
        }
    }
}

/// Returns the points and triangles of several pieces as a single mesh, without materials.
pub fn merge_pieces(pieces: &[MeshPiece]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for piece in pieces {
        let first = points.len() as u32;
        points.extend_from_slice(&piece.points);
        triangles.extend(piece.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    (points, triangles)
}

impl MeshPiece {
    /// Returns the piece with its points scaled by `scale`, then transformed.
    pub fn moved(&self, scale: [f64; 3], pose: &Isometry3<f64>) -> MeshPiece {
        let scale = Vector3::from(scale);
        let point = |p: &[f64; 3]| (pose * Point3::from(Vector3::from(*p).component_mul(&scale))).coords.into();
        let mirrors = scale.product() < 0.0;
        MeshPiece {
            points: self.points.iter().map(point).collect(),
            triangles: self.triangles.iter().map(|t| reverse_if_mirrored(*t, mirrors)).collect(),
            ..self.clone()
        }
    }
}

/// Pieces that are being collected from the nodes of a scene: one per material, in the order of first use.
pub(crate) struct PieceCollector<K> {
    pub pieces: Vec<(K, MeshPiece)>,
    triangles: usize,
    visits: usize,
}

impl<K: PartialEq> PieceCollector<K> {
    pub(crate) fn new() -> Self {
        PieceCollector { pieces: Vec::new(), triangles: 0, visits: 0 }
    }

    /// Counts the visit of a node at the given depth; returns an error if a limit is exceeded.
    pub(crate) fn visit(&mut self, depth: usize) -> Result<(), String> {
        self.visits += 1;
        match depth > MAX_DEPTH || self.visits > MAX_VISITS {
            true => Err(format!(
                "the file has more than {MAX_DEPTH} nested nodes, or more than {MAX_VISITS} nodes in total"
            )),
            false => Ok(()),
        }
    }

    /// Returns the piece of a material, to which `triangles` triangles will be added.
    pub(crate) fn piece(&mut self, material: K, triangles: usize) -> Result<&mut MeshPiece, String> {
        self.triangles += triangles;
        check_triangle_count(self.triangles)?;
        let at = self.pieces.iter().position(|(known, _)| *known == material).unwrap_or_else(|| {
            self.pieces.push((material, MeshPiece::default()));
            self.pieces.len() - 1
        });
        Ok(&mut self.pieces[at].1)
    }
}

/// Adds the transformed triangles of a node to a piece. A transform that mirrors would reverse their winding; this is
/// corrected.
pub(crate) fn append_transformed(piece: &mut MeshPiece, more: &MeshPiece, transform: &Matrix4<f64>) {
    let (first, had) = (piece.points.len() as u32, piece.points.len());
    piece.points.extend(more.points.iter().map(|p| <[f64; 3]>::from(transform.transform_point(&Point3::from(*p)))));
    let mirrors = transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    piece.triangles.extend(more.triangles.iter().map(|t| reverse_if_mirrored(t.map(|i| i + first), mirrors)));
    // If a part has no texture coordinates, the whole piece has none.
    if piece.coordinates.len() == had {
        piece.coordinates.extend_from_slice(&more.coordinates);
    }
}

/// Reverses the winding of a triangle if `mirrors` is set.
fn reverse_if_mirrored([a, b, c]: [u32; 3], mirrors: bool) -> [u32; 3] {
    if mirrors { [a, c, b] } else { [a, b, c] }
}

/// Returns an error if the number of triangles exceeds the limit.
pub(crate) fn check_triangle_count(triangles: usize) -> Result<(), String> {
    match triangles > MAX_TRIANGLES {
        true => Err(format!("the mesh has {triangles} triangles; at most {MAX_TRIANGLES} are supported")),
        false => Ok(()),
    }
}
