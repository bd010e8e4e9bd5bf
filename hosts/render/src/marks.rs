//! Conversion of drawings, and of graph curves in space, to small solids: lines become capsules, points become spheres.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_core::figures::{self, Drawing, Figures};
use tatu_geometry::{Form, Mesh};
use tatu_scene::Scene;

use super::Camera;

/// A small solid that represents part of a drawing, such as a point, a line or a face.
pub(super) struct Mark {
    pub pose: Isometry3<f64>,
    pub form: Form,
    pub color: [f64; 3],
}

/// A line segment in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSegment {
    /// Ends of the line in the world frame, in metres; if they coincide, the line is rendered as a dot.
    pub ends: [Point3<f64>; 2],
    /// Red, green and blue, each 0 to 1.
    pub color: [f64; 3],
    /// Width in pixels.
    pub width: f64,
}

/// Width of the curve of a graph, in pixels.
const CURVE_WIDTH: f64 = 2.5;

/// Returns the marks of all drawings, curves and lines, at their current positions in the world frame.
pub(super) fn collect_marks(scene: &Scene, figures: &Figures, camera: &Camera, lines: &[LineSegment]) -> Vec<Mark> {
    let mut pen = MarkBuilder { camera, marks: Vec::new(), color: [0.0; 3] };
    for d in figures.drawings.values() {
        let frame = scene.resolve(d.parent).ok().map(|slot| scene.world(slot));
        pen.add_drawing(d, &frame.unwrap_or_default());
    }
    for graph in figures.graphs.values() {
        for curve in graph.curves.iter().filter(|c| c.spec.axes.len() == 3 && ["", "m"].contains(&&*c.spec.unit)) {
            pen.color = curve.color;
            let points = graph.points(curve);
            for pair in points.windows(2) {
                if let ([a, b, c], [d, e, f]) = (&pair[0][..], &pair[1][..]) {
                    pen.add_line(Point3::new(*a, *b, *c), Point3::new(*d, *e, *f), CURVE_WIDTH);
                }
            }
        }
    }
    for line in lines {
        pen.color = line.color;
        pen.add_line(line.ends[0], line.ends[1], line.width);
    }
    pen.marks
}

struct MarkBuilder<'a> {
    camera: &'a Camera,
    marks: Vec<Mark>,
    color: [f64; 3],
}

impl MarkBuilder<'_> {
    fn add(&mut self, pose: Isometry3<f64>, form: Form) {
        let there = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
        if there {
            self.marks.push(Mark { pose, form, color: self.color });
        }
    }

    /// Returns the radius, in metres, at which a mark at a point appears `pixels` wide, but at least one pixel wide.
    fn radius(&self, pixels: f64, at: &Point3<f64>) -> f64 {
        (pixels.max(1.0) / 2.0 * self.camera.pixel() * (at - self.camera.from).norm()).max(1e-6)
    }

    fn add_point(&mut self, at: Point3<f64>, pixels: f64) {
        let radius = self.radius(pixels, &at);
        self.add(Translation3::from(at.coords).into(), Form::Sphere { radius });
    }

    fn add_line(&mut self, a: Point3<f64>, b: Point3<f64>, pixels: f64) {
        let (middle, along) = (nalgebra::center(&a, &b), b - a);
        let radius = self.radius(pixels, &middle);
        let turn = rotation_to(&along);
        let form = Form::Capsule { radius, half_length: along.norm() / 2.0 };
        self.add(Isometry3::from_parts(middle.into(), turn), form);
    }

    fn add_triangle(&mut self, corners: &[Point3<f64>]) {
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Default::default() };
        if corners.iter().all(|p| p.iter().all(|x| x.is_finite())) {
            self.add(Isometry3::identity(), Form::Mesh { mesh: Arc::new(mesh), convex: false });
        }
    }

    fn add_drawing(&mut self, d: &Drawing, frame: &Isometry3<f64>) {
        use figures::DrawingForm as F;
        self.color = d.color;
        let half = d.size.abs() / 2.0;
        if !(half.is_finite() && half > 0.0) {
            return;
        }
        let (all, stride) = (d.in_world(frame), d.stride());
        let mut before: Option<Point3<f64>> = None;
        for item in all.chunks_exact(stride) {
            let at = |i: usize| Point3::new(item[3 * i], item[3 * i + 1], item[3 * i + 2]);
            let facing = |i: usize| Isometry3::from_parts(at(0).into(), rotation_to(&at(i).coords));
            match d.form {
                F::Points => self.add_point(at(0), d.size),
                F::Lines => self.add_line(at(0), at(1), d.size),
                F::LineStrip => {
                    if let Some(last) = before.replace(at(0)) {
                        self.add_line(last, at(0), d.size);
                    }
                }
                F::Triangles => self.add_triangle(&[at(0), at(1), at(2)]),
                F::SpherePoints => self.add(Translation3::from(at(0).coords).into(), Form::Sphere { radius: half }),
                F::CubePoints => self.add(facing(1), Form::Box { half: Vector3::repeat(half) }),
                F::QuadPoints => self.add(facing(1), Form::Box { half: Vector3::new(half, half, half * 0.02) }),
                F::DiscPoints | F::TrianglePoints => {
                    self.add(facing(1), Form::Cylinder { radius: half, half_length: half * 0.02 })
                }
            }
        }
    }
}

/// Returns a rotation from the z axis to a direction, or the identity if the direction is zero.
fn rotation_to(to: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), to).unwrap_or_else(|| {
        let back = if to.z < 0.0 { std::f64::consts::PI } else { 0.0 };
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), back)
    })
}
