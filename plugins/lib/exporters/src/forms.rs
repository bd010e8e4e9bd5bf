//! The forms of shapes.

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Result, ValueRef},
};

use crate::objects::{SceneReader, pose_of};

/// A form with its dimensions, m.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// A box with its full extents.
    Box([f64; 3]),
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A ball that is stretched along its axes, with its full extents.
    Ellipsoid([f64; 3]),
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Distance between the ends.
        length: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius.
        radius: f64,
        /// Length of the straight part.
        length: f64,
    },
    /// A plane, with the extents of what is seen of it.
    Plane([f64; 2]),
    /// A mesh.
    Mesh {
        /// Points.
        points: Vec<[f64; 3]>,
        /// Indices of three points each.
        triangles: Vec<[u32; 3]>,
    },
}

/// How a form looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Red, green, blue and opacity, 0 to 1.
    pub rgba: [f64; 4],
    /// Whether the form has an image.
    pub has_image: bool,
}

/// How a shape collides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Friction coefficient.
    pub friction: f64,
    /// Torque against rolling per newton, m.
    pub rolling: f64,
    /// Torque against spinning per newton, m.
    pub spinning: f64,
    /// The low byte decides about the same mechanism, the high byte about others.
    pub mask: u16,
    /// Whether meshes collide as their convex hulls.
    pub convex: bool,
}

/// A form of a shape, in the shape's frame.
pub struct ShapeForm {
    /// Pose in the frame of the shape.
    pub pose: Isometry3<f64>,
    /// The form.
    pub form: Form,
    /// How it looks.
    pub look: Look,
    /// Whether pictures show it.
    pub is_shown: bool,
    /// How it collides, if it does.
    pub surface: Option<Surface>,
}

/// Returns the form of a name with its full extents, m.
fn primitive(name: &str, size: [f64; 3]) -> Option<Form> {
    let radius = size[0] / 2.0;
    Some(match name {
        "plane" => Form::Plane([size[0], size[1]]),
        "box" => Form::Box(size),
        "sphere" if size[0] == size[1] && size[1] == size[2] => Form::Sphere { radius },
        "sphere" => Form::Ellipsoid(size),
        "cylinder" => Form::Cylinder { radius, length: size[2] },
        "capsule" => Form::Capsule { radius, length: (size[2] - size[0]).max(0.0) },
        _ => return None,
    })
}

fn mesh(part: ValueRef<'_>) -> Option<Form> {
    let (points, triangles) = (part.get("points")?.numbers()?, part.get("triangles")?.numbers()?);
    let points = points.as_chunks::<3>().0.to_vec();
    let triangles = triangles.as_chunks::<3>().0.iter().map(|t| t.map(|i| i as u32)).collect();
    Some(Form::Mesh { points, triangles })
}

/// Returns the full extents of forms about the origin.
fn extents(forms: &[ShapeForm]) -> [f64; 3] {
    let mut size = Vector3::zeros();
    for form in forms {
        if let Form::Mesh { points, .. } = &form.form {
            let half = points.iter().fold(Vector3::zeros(), |h: Vector3<f64>, p| h.sup(&Point3::from(*p).coords.abs()));
            size = size.sup(&(2.0 * half));
        }
    }
    size.into()
}

/// Reads the forms of a shape that are seen or collide.
pub fn forms_of(reader: &SceneReader<'_>, shape: tatu_object) -> Result<Vec<ShapeForm>> {
    let is_visible = reader.bool(shape, "object.visible");
    let surface = reader.bool(shape, "shape.respondable").then(|| Surface {
        friction: reader.f64(shape, "shape.friction"),
        rolling: reader.f64(shape, "shape.rolling_friction"),
        spinning: reader.f64(shape, "shape.spinning_friction"),
        mask: reader.f64(shape, "shape.respondable_mask") as u16,
        convex: reader.bool(shape, "shape.convex") || reader.text(shape, "shape.primitive") == "compound",
    });
    let other = reader.text(shape, "shape.collide_as");
    let collides_as_seen = other.is_empty() || other == "same";
    let own_name = reader.text(shape, "shape.primitive");
    let own_size = reader.array::<3>(shape, "shape.size").unwrap_or([0.1; 3]);
    let mut forms = Vec::new();
    for index in 0.. {
        let Some(part) = reader.world.part(shape, index)? else { break };
        let of = |key: &str| part.get(key).unwrap_or(ValueRef::NIL);
        let name = of("form").as_str().unwrap_or_default().into_owned();
        let size = of("size").array::<3>();
        // An ellipsoid is listed as a mesh.
        let is_ellipsoid = name == "mesh" && own_name == "sphere";
        let form = match name.as_str() {
            "mesh" if is_ellipsoid => primitive("sphere", own_size),
            "mesh" => mesh(part),
            "plane" => primitive("plane", own_size),
            name => size.and_then(|size| primitive(name, size)),
        };
        let Some(form) = form else { continue };
        let [r, g, b] = of("color").array::<3>().unwrap_or([0.7; 3]);
        let opacity = of("opacity").as_f64().unwrap_or(1.0);
        forms.push(ShapeForm {
            pose: of("pose").array::<7>().map_or_else(Isometry3::identity, pose_of),
            form,
            look: Look { rgba: [r, g, b, opacity], has_image: part.get("texture").is_some() },
            is_shown: is_visible && opacity > 0.0,
            surface: surface.filter(|_| collides_as_seen),
        });
    }
    if !collides_as_seen && surface.is_some() {
        let mut size = reader.array::<3>(shape, "shape.collide_size").unwrap_or([0.0; 3]);
        if size == [0.0; 3] {
            size = if own_name == "mesh" { extents(&forms) } else { own_size };
        }
        if let Some(form) = primitive(&other, size) {
            let look = Look { rgba: [0.7, 0.7, 0.7, 1.0], has_image: false };
            forms.push(ShapeForm { pose: Isometry3::identity(), form, look, is_shown: false, surface });
        }
    }
    forms.retain(|form| form.is_shown || form.surface.is_some());
    Ok(forms)
}

/// Number of points of an ellipsoid's mesh around its axis and from pole to pole.
const ROUND: [u32; 2] = [32, 16];

/// Returns an ellipsoid with these full extents as a mesh: points and triangles, seen from outside.
pub fn ellipsoid_mesh(size: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [around, rings] = ROUND;
    let point = |x: f64, y: f64, z: f64| [x * size[0] / 2.0, y * size[1] / 2.0, z * size[2] / 2.0];
    let mut points = vec![point(0.0, 0.0, 1.0)];
    for ring in 1..rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for i in 0..around {
            let angle = 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(around);
            let level = libm::sin(polar);
            points.push(point(level * libm::cos(angle), level * libm::sin(angle), libm::cos(polar)));
        }
    }
    points.push(point(0.0, 0.0, -1.0));
    let last = points.len() as u32 - 1;
    let at = |ring: u32, i: u32| 1 + ring * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(0, i), at(0, i + 1)]);
        for ring in 0..rings - 2 {
            triangles.push([at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)]);
            triangles.push([at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)]);
        }
        triangles.push([last, at(rings - 2, i + 1), at(rings - 2, i)]);
    }
    (points, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mesh_of_an_ellipsoid_has_nearly_its_volume() {
        let (points, triangles) = ellipsoid_mesh([2.0, 4.0, 6.0]);
        let volume: f64 = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| Vector3::from(points[i as usize]));
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 6.0;
        assert!((volume / exact - 1.0).abs() < 0.02, "{volume}");
    }
}
