//! Flat faces: those of boxes, and infinite planes.

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use nalgebra::{Isometry3, Vector3};

use super::{
    camera::{GridCamera, LinearFunction, PixelBounds},
    raster::Raster,
    span::{SpanEdge, SpanFace},
};
use crate::{Faces, solid::face};

/// A flat face prepared for rasterisation.
#[derive(Debug, Clone)]
pub(super) struct Polygon {
    edges: ArrayVec<SpanEdge, 4>,
    w: LinearFunction,
    rows: (usize, usize),
    id: u32,
}

impl Polygon {
    #[inline(always)]
    pub fn draw<S: Simd, const ID: bool>(&self, simd: S, raster: &mut Raster<'_, ID>) {
        let limits = (f32::NEG_INFINITY, f32::INFINITY);
        SpanFace { edges: &self.edges, w: self.w, limits, id: self.id }.draw(simd, raster, self.rows);
    }
}

/// Returns the edge function from one corner to the next; the corners are results of [`GridCamera::homogeneous`].
///
/// The function is exactly the negative of that in the opposite direction. Corners behind the camera need no special
/// treatment.
pub(super) fn edge_function(camera: &GridCamera, from: &Vector3<f64>, to: &Vector3<f64>) -> LinearFunction {
    let line = from.cross(to);
    camera.line_from_middle(line.x, line.y, line.z)
}

/// Adds the surface of a half-space.
pub(super) fn add_plane(
    camera: &GridCamera,
    view_from_form: &ViewTransform,
    faces: Faces,
    id: u32,
    out: &mut Vec<Polygon>,
) {
    let normal = view_from_form.rotation.column(2).into_owned();
    let height = normal.dot(&view_from_form.translation);
    let front = camera.sees_front(&normal, height);
    if if front { faces.front } else { faces.back } {
        let w = camera.plane(&normal, height);
        // The edge excludes the part behind the camera or beyond its range.
        let seen = LinearFunction { c: w.c - f64::from(camera.w_empty), ..w };
        if [w.a, w.b, w.c].iter().all(|x| x.is_finite()) {
            out.push(Polygon { edges: ArrayVec::from_iter([SpanEdge(seen)]), w, rows: (0, camera.rows), id });
        }
    }
}

/// Adds the visible faces of a box; the first face has the number `id`.
pub(super) fn add_box(
    camera: &GridCamera,
    view_from_form: &ViewTransform,
    half: &Vector3<f64>,
    faces: Faces,
    id: u32,
    out: &mut Vec<Polygon>,
) {
    if half.min() < 0.0 {
        return;
    }
    let corners = view_from_form.corners(&Vector3::zeros(), half);
    let Some(bounds) = camera.bounds(&corners) else { return };
    // If the near plane clips nothing, the front faces hide the back faces.
    let hides = faces.front && view_from_form.is_unclipped(camera, half, &bounds);
    for index in 0..6 {
        let normal = view_from_form.rotation.column(index / 2) * if index % 2 == 1 { 1.0 } else { -1.0 };
        let height = normal.dot(&view_from_form.translation) + half[index / 2];
        let front = camera.sees_front(&normal, height);
        if if front { !faces.front } else { !faces.back || hides } {
            continue;
        }
        let (place, _) = face(half, index);
        let points = place.map(|p| corners[corner_number(&p)]);
        let Some(bounds) = camera.bounds(&points) else { continue };
        let w = camera.plane(&normal, height);
        if ![w.a, w.b, w.c].iter().all(|x| x.is_finite()) {
            continue;
        }
        let points = points.map(|p| camera.homogeneous(&p));
        let edges = (0..4).map(|i| {
            let (a, b) = (&points[i], &points[(i + 1) % 4]);
            SpanEdge(if front { edge_function(camera, a, b) } else { edge_function(camera, b, a) })
        });
        out.push(Polygon { edges: edges.collect(), w, rows: bounds.rows, id: id + index as u32 });
    }
}

/// Returns the index of a corner of a box in [`ViewTransform::corners`].
fn corner_number(corner: &Vector3<f64>) -> usize {
    corner.iter().enumerate().fold(0, |number, (i, x)| number | usize::from(x.is_sign_positive()) << i)
}

/// The transform from the frame of a form to that of the view.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewTransform {
    pub rotation: nalgebra::Matrix3<f64>,
    pub translation: Vector3<f64>,
}

impl ViewTransform {
    pub fn new(camera: &GridCamera, world_from_form: &Isometry3<f64>) -> Self {
        Self {
            rotation: camera.rotation * world_from_form.rotation.to_rotation_matrix().matrix(),
            translation: camera.rotation * world_from_form.translation.vector + camera.translation,
        }
    }

    pub fn point(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * p + self.translation
    }

    /// Returns the corners of a box along the form's axes; bit i of a corner's index is set if the corner is on the
    /// positive side of axis i.
    pub fn corners(&self, centre: &Vector3<f64>, half: &Vector3<f64>) -> [Vector3<f64>; 8] {
        std::array::from_fn(|number| {
            let sign = |axis: usize| if number >> axis & 1 == 1 { 1.0 } else { -1.0 };
            self.point(&(centre + half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)))))
        })
    }

    /// Returns whether the near plane clips nothing that is in the image, for a form within a box around its origin.
    pub fn is_unclipped(&self, camera: &GridCamera, half: &Vector3<f64>, bounds: &PixelBounds) -> bool {
        if bounds.beyond_near {
            return true;
        }
        if !camera.perspective {
            return false;
        }
        let eye = -(self.rotation.transpose() * self.translation);
        let away = eye.zip_map(half, |x, h| (x.abs() - h).max(0.0)).norm();
        away > camera.near * camera.slant * (1.0 + 1e-6)
    }
}
