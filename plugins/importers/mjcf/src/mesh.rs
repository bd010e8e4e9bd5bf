//! Mesh files, and the masses of meshes.

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_importers_common::{MeshPiece, SUFFIXES, Solid, merge_pieces, read};

/// Maximum number of triangles of one mesh.
const MAX_TRIANGLES: usize = 4_000_000;

/// How the mass of a mesh follows from its triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshInertia {
    /// The volumes of the pyramids between the centroid and the triangles, all counted as positive.
    Legacy,
    /// The signed volumes of these pyramids.
    Exact,
    /// The surface.
    Shell,
}

/// A mesh in the frame of its asset, after scaling.
pub struct MeshAsset {
    pub pieces: Vec<MeshPiece>,
    pub solid: Solid,
    /// Notes on omitted parts.
    pub notes: Vec<String>,
}

/// What an asset does to the contents of its file, and how it is weighed.
pub struct MeshSettings {
    pub scale: [f64; 3],
    pub reference: Isometry3<f64>,
    pub inertia: MeshInertia,
}

impl MeshAsset {
    /// Reads a mesh file.
    pub fn read(
        name: &str,
        bytes: &[u8],
        settings: &MeshSettings,
        files: &dyn Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Self, String> {
        let lower = name.to_lowercase();
        let (pieces, notes) = if lower.ends_with(".msh") {
            (vec![read_msh(bytes)?], Vec::new())
        } else if SUFFIXES.iter().any(|s| lower.ends_with(s)) {
            let read = read(name, bytes, files)?;
            (read.model.pieces, read.notes)
        } else {
            return Err(format!("the format is not supported; expected one of {}, .msh", SUFFIXES.join(", ")));
        };
        let mut asset = MeshAsset::of(pieces, settings)?;
        asset.notes = notes;
        Ok(asset)
    }

    /// Creates the asset of triangles.
    pub fn of(pieces: Vec<MeshPiece>, settings: &MeshSettings) -> Result<Self, String> {
        let back = settings.reference.inverse();
        let pieces: Vec<MeshPiece> =
            pieces.iter().map(|p| p.moved([1.0; 3], &back).moved(settings.scale, &Isometry3::identity())).collect();
        let (points, triangles) = merge_pieces(&pieces);
        let solid = weigh(&points, &triangles, settings.inertia);
        let numbers =
            [solid.volume].into_iter().chain(solid.centre.iter().copied()).chain(solid.inertia.iter().copied());
        if points.is_empty() || numbers.into_iter().any(|x| !x.is_finite()) {
            return Err("the mesh has no extent".into());
        }
        Ok(MeshAsset { pieces, solid, notes: Vec::new() })
    }
}

/// Returns the solid of triangles about the centroid of their surface.
fn weigh(points: &[[f64; 3]], triangles: &[[u32; 3]], mode: MeshInertia) -> Solid {
    let at = |i: u32| points.get(i as usize).map_or_else(Vector3::zeros, |p| Vector3::from(*p));
    let corners = |t: &[u32; 3]| t.map(at);
    let surface = |[a, b, c]: &[Vector3<f64>; 3]| (b - a).cross(&(c - a)) / 2.0;
    let (mut area, mut middle) = (0.0, Vector3::zeros());
    for t in triangles {
        let t = corners(t);
        let own = surface(&t).norm();
        area += own;
        middle += own * (t[0] + t[1] + t[2]) / 3.0;
    }
    let middle = if area > 0.0 { middle / area } else { middle };
    if mode == MeshInertia::Shell {
        let mut second = Matrix3::zeros();
        for t in triangles {
            let t = corners(t).map(|p| p - middle);
            second += surface(&t).norm() / 12.0 * products(&t);
        }
        return Solid { volume: area, centre: middle, inertia: moments(second) };
    }
    let pyramid = |t: &[Vector3<f64>; 3]| {
        let volume = t[0].dot(&surface(t)) / 3.0;
        if mode == MeshInertia::Legacy { volume.abs() } else { volume }
    };
    let (mut volume, mut centre) = (0.0, Vector3::zeros());
    for t in triangles {
        let t = corners(t).map(|p| p - middle);
        let own = pyramid(&t);
        volume += own;
        centre += own * (t[0] + t[1] + t[2]) / 4.0;
    }
    let centre = if volume.abs() > 0.0 { centre / volume } else { centre } + middle;
    // With all volumes positive, the sum depends on the apex, which is now the centre of mass.
    let (mut volume, mut second) = (0.0, Matrix3::zeros());
    for t in triangles {
        let t = corners(t).map(|p| p - centre);
        let own = pyramid(&t);
        volume += own;
        second += own / 20.0 * products(&t);
    }
    Solid { volume, centre, inertia: moments(second) }
}

/// Returns the sum of the products of coordinates over the corners, plus that of their sum.
fn products(t: &[Vector3<f64>; 3]) -> Matrix3<f64> {
    let sum = t[0] + t[1] + t[2];
    t.iter().map(|p| p * p.transpose()).sum::<Matrix3<f64>>() + sum * sum.transpose()
}

fn moments(second: Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * second.trace() - second
}

/// Reads MuJoCo's binary format: four counts, then points, normals, texture coordinates and triangles.
fn read_msh(bytes: &[u8]) -> Result<MeshPiece, String> {
    let word = |at: usize| bytes.get(4 * at..4 * at + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
    let count = |at: usize| word(at).map(i32::from_le_bytes).and_then(|n| usize::try_from(n).ok());
    let counts = [count(0), count(1), count(2), count(3)];
    let [Some(points), Some(normals), Some(coordinates), Some(triangles)] = counts else {
        return Err("the MSH file is damaged: it has no counts".into());
    };
    let total = 4 + 3 * points as u64 + 3 * normals as u64 + 2 * coordinates as u64 + 3 * triangles as u64;
    if total * 4 != bytes.len() as u64 || triangles > MAX_TRIANGLES {
        return Err("the MSH file is damaged: its length does not match its counts".into());
    }
    if triangles == 0 {
        return Err("the MSH file has no triangles".into());
    }
    let float = |at: usize| word(at).map_or(f64::NAN, |b| f64::from(f32::from_le_bytes(b)));
    let index = |at: usize| word(at).map_or(u32::MAX, u32::from_le_bytes);
    let own: Vec<[f64; 3]> = (0..points).map(|i| [0, 1, 2].map(|k| float(4 + 3 * i + k))).collect();
    let first = 4 + 3 * points + 3 * normals + 2 * coordinates;
    let faces: Vec<[u32; 3]> = (0..triangles).map(|i| [0, 1, 2].map(|k| index(first + 3 * i + k))).collect();
    if own.iter().flatten().any(|x| !x.is_finite()) || faces.iter().flatten().any(|i| *i as usize >= points) {
        return Err("the MSH file is damaged: a point is not finite, or a face refers to a missing point".into());
    }
    Ok(MeshPiece { points: own, triangles: faces, ..MeshPiece::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism over a polygon in the plane z = 0, of height 1, as points and triangles.
    fn prism(outline: &[[f64; 2]], caps: &[[u32; 3]]) -> MeshPiece {
        let n = outline.len() as u32;
        let points = [0.0, 1.0].iter().flat_map(|z| outline.iter().map(move |[x, y]| [*x, *y, *z])).collect();
        let mut triangles = Vec::new();
        for t in caps {
            triangles.push([t[0], t[2], t[1]]);
            triangles.push(t.map(|i| i + n));
        }
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
        }
        MeshPiece { points, triangles, ..MeshPiece::default() }
    }

    fn volume(piece: MeshPiece, inertia: MeshInertia) -> f64 {
        let settings = MeshSettings { scale: [1.0; 3], reference: Isometry3::identity(), inertia };
        MeshAsset::of(vec![piece], &settings).unwrap().solid.volume
    }

    #[test]
    fn volumes_are_those_that_mujoco_computes() {
        let l = || {
            let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
            prism(&outline, &[[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]])
        };
        assert!((volume(l(), MeshInertia::Legacy) - 3.0).abs() < 1e-12);
        assert!((volume(l(), MeshInertia::Exact) - 3.0).abs() < 1e-12);
        // Two ends of area 3 and six sides of total length 8.
        assert!((volume(l(), MeshInertia::Shell) - 14.0).abs() < 1e-12);
    }

    #[test]
    fn damaged_files_are_refused() {
        assert!(read_msh(&[]).is_err());
        assert!(read_msh(&[255; 64]).is_err());
        let mut huge: Vec<u8> = [i32::MAX; 4].iter().flat_map(|n| n.to_le_bytes()).collect();
        assert!(read_msh(&huge).is_err());
        huge[..16].fill(0);
        assert!(read_msh(&huge).is_err());
    }
}
