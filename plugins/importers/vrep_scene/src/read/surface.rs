//! Triangles of a mesh, in the frame of its shape.

use nalgebra::{Isometry3, Point3};

use super::{
    cursor::{ReadError, ReadResult},
    file::VrepFile,
    legacy_mesh::SharedArrays,
    mesh::{ArrayLocation, MeshLeaf, MeshPart},
    pool::{self, IndexArray},
    pose::isometry,
};

/// Points and triangles of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleSurface {
    /// Points in the frame of the vertices, m.
    pub points: Vec<[f64; 3]>,
    /// Three zero-based point indices per triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A leaf, and its vertex frame in the frame of the shape.
pub struct PlacedLeaf<'a> {
    /// The part that contains the leaf.
    pub part: &'a MeshPart,
    /// The leaf, whose vertices `frame` transforms.
    pub leaf: &'a MeshLeaf,
    /// Transform from the vertex frame to the frame of the shape.
    pub frame: Isometry3<f64>,
}

/// Returns all leaves of a shape, in order.
pub fn leaves(root: &MeshPart) -> Vec<PlacedLeaf<'_>> {
    let mut out = Vec::new();
    // The stored frame of the root is ignored.
    walk(root, Isometry3::identity(), &mut out);
    out
}

fn walk<'a>(part: &'a MeshPart, frame: Isometry3<f64>, out: &mut Vec<PlacedLeaf<'a>>) {
    if let Some(leaf) = &part.leaf {
        let own = match (&part.vertex_frame, leaf.arrays) {
            (Some(vertices), _) => frame * isometry(vertices),
            // Vertices of serialization 15 are already in the shape's frame.
            (None, ArrayLocation::Range { .. }) => Isometry3::identity(),
            (None, _) => isometry(&leaf.old_frame),
        };
        out.push(PlacedLeaf { part, leaf, frame: own });
    }
    for child in &part.children {
        let below = child.frame.as_ref().map_or(frame, |f| frame * isometry(f));
        walk(child, below, out);
    }
}

impl VrepFile {
    fn arrays(&self, leaf: &MeshLeaf, shared: Option<&SharedArrays>) -> Option<(super::cursor::ByteSpan, IndexArray)> {
        let at = |i: i32| usize::try_from(i).ok();
        match leaf.arrays {
            ArrayLocation::Pool { vertices, indices } => {
                Some((*self.pool.vertices.get(at(vertices)?)?, *self.pool.indices.get(at(indices)?)?))
            }
            ArrayLocation::Own { vertices, indices } => Some((vertices, indices?)),
            ArrayLocation::Range { .. } => shared.and_then(|s| Some((s.vertices, s.indices?))),
        }
    }

    /// Returns the number of triangles of a leaf.
    pub fn count(&self, leaf: &MeshLeaf, shared: Option<&SharedArrays>) -> usize {
        match (leaf.arrays, self.arrays(leaf, shared)) {
            (ArrayLocation::Range { triangles, .. }, _) => usize::try_from(triangles[1]).unwrap_or(0),
            (_, Some((_, indices))) => pool::count(&self.data, indices) / 3,
            _ => 0,
        }
    }

    /// Returns the triangles of a leaf; indices out of range are an error.
    pub fn surface(&self, leaf: &MeshLeaf, shared: Option<&SharedArrays>, at: usize) -> ReadResult<TriangleSurface> {
        let broken = |what: String| ReadError::new(at, what).within("mesh");
        let (vertices, indices) =
            self.arrays(leaf, shared).ok_or_else(|| broken("the vertices or indices of a mesh are missing".into()))?;
        let points = pool::points(&self.data, vertices);
        let corners = pool::corners(&self.data, indices)?;
        let mut triangles: Vec<[u32; 3]> = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        if let ArrayLocation::Range { triangles: [first, n], .. } = leaf.arrays {
            let range = usize::try_from(first).ok().zip(usize::try_from(n).ok());
            let own = range.and_then(|(first, n)| triangles.get(first..first.checked_add(n)?));
            let text = || format!("expected {n} triangles from index {first}, found {} in total", triangles.len());
            triangles = own.ok_or_else(|| broken(text()))?.to_vec();
        }
        if let Some(i) = triangles.iter().flatten().find(|i| **i as usize >= points.len()) {
            return Err(broken(format!(
                "a triangle refers to the point with index {i}, but the mesh has only {} points",
                points.len()
            )));
        }
        if points.iter().flatten().any(|x| !x.is_finite()) {
            return Err(broken("a coordinate of a point is not finite".into()));
        }
        Ok(compact(&points, triangles))
    }
}

/// Removes points that no triangle uses: the arrays can contain the points of a whole shape.
fn compact(points: &[[f32; 3]], mut triangles: Vec<[u32; 3]>) -> TriangleSurface {
    let mut places = vec![u32::MAX; points.len()];
    let mut used = Vec::with_capacity(points.len());
    for corner in triangles.iter_mut().flatten() {
        let place = &mut places[*corner as usize];
        if *place == u32::MAX {
            *place = used.len() as u32;
            used.push(points[*corner as usize].map(f64::from));
        }
        *corner = *place;
    }
    TriangleSurface { points: used, triangles }
}

impl TriangleSurface {
    /// Returns the surface transformed by a pose.
    pub fn moved(mut self, pose: &Isometry3<f64>) -> Self {
        if *pose != Isometry3::identity() {
            self.points.iter_mut().for_each(|p| *p = (pose * Point3::from(*p)).coords.into());
        }
        self
    }

    /// Returns the minimum and maximum coordinates, or `None` if there are no points.
    pub fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        let mut points = self.points.iter();
        let first = *points.next()?;
        Some(points.fold((first, first), |(low, high), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        }))
    }
}
