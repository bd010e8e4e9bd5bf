//! Shapes, which are solids.

use std::sync::Arc;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tatu_geometry::Mesh;
use tatu_physics::{BodyId, ContactSurface};
use tatu_plugin_api::safe::Value;

use super::{
    DerivedGeometry, ObjectKind, Primitive,
    custom::{mesh_from_lists, parts_of, surface_value},
    parts::ShapePart,
    solver::JointSolver,
};
use crate::{
    property::{StoredValue, numbers_of, properties, refusal_as_text, text_of, unexpected},
    texture::ShapeTexture,
};

/// Id of the shape's body in the engine, or `None` if the shape has no body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ShapeBody(pub Option<BodyId>);

/// The properties of a shape, which is a solid.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
pub struct Shape {
    pub primitive: Primitive,
    pub size: Vector3<f64>,
    /// The mesh. A snapshot stores only its number in the document.
    #[serde(skip)]
    pub mesh: Option<Arc<Mesh>>,
    pub convex: bool,
    pub parts: Vec<ShapePart>,
    pub color: [f64; 3],
    pub opacity: f64,
    pub texture: Option<ShapeTexture>,
    pub mass: Option<f64>,
    pub inertia: Option<[f64; 9]>,
    /// Centre of mass in the shape's frame, m; `None`: that of the form at uniform density.
    pub com: Option<Vector3<f64>>,
    pub dynamic: bool,
    pub respondable: bool,
    pub mask: u16,
    pub friction: f64,
    pub restitution: f64,
    /// Whether beams detect the shape; if `None`, this depends on the form.
    pub detectable: Option<bool>,
    /// The solver for the joints of the mechanism whose root is this shape.
    pub joint_solver: JointSolver,
    /// Whether continuous collision detection includes collisions with other moving bodies.
    pub bullet: bool,
    /// Whether the shape sleeps when its body is created.
    pub asleep: bool,
    /// Initial velocity of the centre of mass, m/s, and angular velocity, rad/s, in the world frame.
    pub initial_velocity: Vector3<f64>,
    pub initial_angular_velocity: Vector3<f64>,
    /// Damping rates of velocity and angular velocity, 1/s.
    pub damping: [f64; 2],
    /// Velocity of the surface, and its axis, rolling and spinning friction. The number of the material is set only in
    /// the copy that is passed to the engine.
    pub surface: ContactSurface,
    pub material: String,
    /// Bit mask of the kinds of beams that detect the shape, if it is detectable.
    pub detectable_mask: u16,
    pub collide_as: Option<Primitive>,
    pub collide_size: Vector3<f64>,
    pub body: ShapeBody,
    /// Data computed from the form; not stored in snapshots.
    #[serde(skip)]
    pub derived: DerivedGeometry,
}

impl Default for Shape {
    fn default() -> Self {
        Shape {
            primitive: Primitive::Box,
            size: Vector3::repeat(0.1),
            mesh: None,
            convex: false,
            parts: Vec::new(),
            color: [0.7; 3],
            opacity: 1.0,
            texture: None,
            mass: None,
            inertia: None,
            com: None,
            dynamic: false,
            respondable: false,
            mask: 0xFFFF,
            friction: 1.0,
            restitution: 0.0,
            detectable: None,
            detectable_mask: u16::MAX,
            joint_solver: JointSolver::Auto,
            bullet: false,
            asleep: false,
            initial_velocity: Vector3::zeros(),
            initial_angular_velocity: Vector3::zeros(),
            damping: [0.0; 2],
            surface: ContactSurface::default(),
            material: String::new(),
            collide_as: None,
            collide_size: Vector3::zeros(),
            body: ShapeBody(None),
            derived: DerivedGeometry::default(),
        }
    }
}

impl Shape {
    /// Returns the textures of the shape and of its parts.
    pub fn textures(&self) -> impl Iterator<Item = &ShapeTexture> {
        self.texture.iter().chain(self.parts.iter().filter_map(|p| p.texture.as_ref()))
    }
    /// Returns mutable references to the textures of the shape and of its parts.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut ShapeTexture> {
        self.texture.iter_mut().chain(self.parts.iter_mut().filter_map(|p| p.texture.as_mut()))
    }
}

impl Shape {
    /// Returns whether beams detect the shape. Planes, which are mostly floors, are not detected unless the scene
    /// requests it.
    pub fn is_detectable(&self) -> bool {
        self.detectable.unwrap_or(self.primitive != Primitive::Plane)
    }
}

/// Names of the forms for collisions.
const COLLIDE_AS: &[&str] = &["same", "box", "sphere", "cylinder", "capsule"];

fn set_surface(s: &mut Shape, value: &Value) -> Result<bool, String> {
    let mesh = refusal_as_text(mesh_from_lists(value))?;
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    mesh.vertices.iter().for_each(|p| (low, high) = (low.inf(&p.coords), high.sup(&p.coords)));
    (s.primitive, s.size, s.mesh) = (Primitive::Mesh, high - low, Some(Arc::new(mesh)));
    Ok(true)
}

/// Sets the texture. The loaded image is retained if its number does not change.
fn set_texture(s: &mut Shape, value: &Value) -> Result<bool, String> {
    let image = s.texture.take().map(|old| (old.image_number, old.image));
    s.texture = refusal_as_text(ShapeTexture::from_value(value))?;
    if let (Some(new), Some((number, image))) = (&mut s.texture, image) {
        new.image = image.filter(|_| number == new.image_number);
    }
    Ok(true)
}

/// Returns the values of all parts; parts without values of their own have those of the shape. The result is empty if
/// no part has values of its own.
fn part_values<const N: usize>(
    s: &Shape,
    own: impl Fn(&super::ShapePart) -> Option<[f64; N]>,
    of_shape: [f64; N],
) -> Value {
    if s.parts.iter().all(|p| own(p).is_none()) {
        return Value::Floats(Vec::new());
    }
    Value::Floats(s.parts.iter().flat_map(|p| own(p).unwrap_or(of_shape)).collect())
}

/// Sets the colours of all parts, or removes them if the list is empty.
fn set_part_colors(s: &mut Shape, value: &Value) -> Result<bool, String> {
    let numbers = numbers_of(value)?;
    if !numbers.is_empty() && numbers.len() != 3 * s.parts.len() {
        let (parts, found) = (s.parts.len(), numbers.len());
        return Err(format!("expected 3 numbers for each of the {parts} parts, or none; found {found}"));
    }
    let mut changed = false;
    for (i, part) in s.parts.iter_mut().enumerate() {
        let new = numbers.get(i * 3..i * 3 + 3).map(|c| [c[0], c[1], c[2]]);
        changed |= std::mem::replace(&mut part.color, new) != new;
    }
    Ok(changed)
}

/// Sets the opacities of all parts, or removes them if the list is empty.
fn set_part_opacities(s: &mut Shape, value: &Value) -> Result<bool, String> {
    let numbers = numbers_of(value)?;
    if !numbers.is_empty() && numbers.len() != s.parts.len() {
        let (parts, found) = (s.parts.len(), numbers.len());
        return Err(format!("expected one number for each of the {parts} parts, or none; found {found}"));
    }
    let mut changed = false;
    for (i, part) in s.parts.iter_mut().enumerate() {
        let new = numbers.get(i).copied();
        changed |= std::mem::replace(&mut part.opacity, new) != new;
    }
    Ok(changed)
}

fn set_inertia(s: &mut Shape, value: &Value) -> Result<bool, String> {
    s.inertia = Some(match *numbers_of(value)? {
        [x, y, z] => [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z],
        ref v if v.len() == 9 => std::array::from_fn(|i| v[i]),
        ref v => return Err(format!("expected 3 numbers (xx yy zz) or 9 (by rows), found {}", v.len())),
    });
    Ok(true)
}

fn set_axis(s: &mut Shape, value: &Value) -> Result<bool, String> {
    let [x, y, z] = *numbers_of(value)? else { return unexpected(value) };
    s.surface.axis = Vector3::new(x, y, z).try_normalize(1e-9);
    Ok(true)
}

properties! { PROPERTIES: Shape, PropertyOwner::Kind(ObjectKind::Shape) =>
    "shape.primitive" text of (Primitive::WORDS) = "box", Form primitive: "Form of the shape.";
    "shape.size" numbers 3 in "m" from 1e-9 to 1e9 = [0.1, 0.1, 0.1], Form size: "Full extents along x, y, z; cylinders and capsules use x as the diameter and z as the length; a sphere with different extents is an ellipsoid.";
    "shape.mesh" mesh from 1.0, Rebuild _: "Number of the shape's mesh, from 1, for the primitive `mesh`.";
    "shape.surface" list, Form { get |s: &Shape| surface_value(s.mesh.as_deref()), set set_surface }: "Points and triangles of the mesh: a list of x y z, a list of three point indices per triangle, from 0, and, for a texture with the mapping `mesh`, a list of two image coordinates per point; setting this property makes the shape a mesh.";
    "shape.convex" bool = false, Form convex: "Whether the mesh is replaced by its convex hull.";
    "shape.parts" parts = none, Form { set |s: &mut Shape, v| { s.parts = refusal_as_text(parts_of(v))?; Ok(true) } }: "Parts of a compound: primitive, size, position, orientation or quaternion, color, opacity, texture, friction; mesh and convex for the primitive `mesh`.";
    "shape.texture" texture = none, Rebuild { get |s: &Shape| ShapeTexture::to_value(s.texture.as_ref()), set set_texture }: "Texture: image, mapping (plane, cylinder, sphere, box, mesh), size, position, orientation or quaternion, repeat, smooth, blend (modulate, decal, add); setting an empty table removes it.";
    "shape.color" numbers 3 from 0.0 to 1.0 = [0.7, 0.7, 0.7], Colour color: "Red, green and blue.";
    "shape.opacity" number from 0.0 to 1.0 = 1.0, Colour opacity: "Share of the light from behind that the surface blocks in pictures and colour images: 0 is invisible, 1 opaque; distances and detection do not depend on it.";
    "shape.part_colors" numbers from 0.0 to 1.0 = none, Colour { get |s: &Shape| part_values(s, |p| p.color, s.color), set set_part_colors }: "Red, green and blue of each part of a live compound, which files set with the parts; empty if all parts have the colour of the shape, and setting an empty list makes it so.";
    "shape.part_opacities" numbers from 0.0 to 1.0 = none, Colour { get |s: &Shape| part_values(s, |p| p.opacity.map(|x| [x]), [s.opacity]), set set_part_opacities }: "Opacity of each part of a live compound, which files set with the parts; empty if all parts have that of the shape, and setting an empty list makes it so.";
    "shape.mass" number in "kg" above 0.0, Rebuild { set |s: &mut Shape, v| { s.mass = numbers_of(v)?.first().copied(); Ok(true) } }: "Mass; default: 1000 kg/m^3 times the volume; of a mesh that is not closed, the volume of its convex hull.";
    "shape.inertia" numbers in "kg m^2", Rebuild { set set_inertia }: "Inertia about the centre of mass: 3 (xx yy zz) or 9 by rows; default: that of the form at uniform density about this point.";
    "shape.com" numbers 3 in "m", Rebuild { set |s: &mut Shape, v| s.com.insert(Vector3::zeros()).store(v) }: "Centre of mass in the shape's frame; default: that of the form at uniform density.";
    "shape.dynamic" bool = false, Rebuild dynamic: "Whether forces move the shape.";
    "shape.respondable" bool = false, Rebuild respondable: "Whether the shape collides with other shapes.";
    "shape.respondable_mask" int from 0.0 to 65535.0 = 65535, Rebuild mask: "Mask of the shapes that the shape collides with: low byte for shapes in the same tree, high byte for others.";
    "shape.friction" number from 0.0 = 1.0, Rebuild friction: "Friction coefficient; `scene.friction_rule` combines the coefficients of a pair, by default as their product.";
    "shape.restitution" number from 0.0 to 1.0 = 0.0, Rebuild restitution: "Coefficient of restitution.";
    "shape.detectable" bool = true, Rebuild { get |s: &Shape| Value::Bool(s.is_detectable()), set |s: &mut Shape, v| s.detectable.insert(true).store(v) }: "Whether beams detect the shape; for planes, the default is false.";
    "shape.detectable_mask" int from 0.0 to 65535.0 = 65535, Rebuild detectable_mask: "Mask of the beams that detect the shape, if it is detectable: those that have a bit in common with the mask (TATU_WAVES_* in tatu.h).";
    "shape.joint_solver_used" text, ReadOnly _: "Solver of the mechanism that the shape belongs to, and the reason, such as `tree: its own joint_solver`; empty if the shape does not belong to a mechanism.";
    "shape.joint_solver" text of (JointSolver::WORDS) = "auto", Rebuild joint_solver: "Solver for the joints of a mechanism, set on its first shape, or on another of its shapes if that sets none: with `tree` and `reduced`, joints cannot come apart; `tree` is several times as fast as `reduced`, and `impulse` is cheaper but softer; mechanisms with loops, screws or special surfaces use `reduced` instead of `tree`; `auto`: impulse for wheeled vehicles, otherwise tree.";
    "shape.bullet" bool = false, Rebuild bullet: "Whether the shape cannot pass through other moving shapes at any speed; no shape passes through shapes that do not move.";
    "shape.asleep" bool = false, Rebuild asleep: "Whether the shape, if it starts at rest, sleeps: it stays where it is, even in the air, until another shape, a force or a script moves it; shapes with joints do not sleep.";
    "shape.initial_velocity" numbers 3 in "m/s" = [0.0, 0.0, 0.0], Rebuild initial_velocity: "Initial velocity of the centre of mass, in the world frame.";
    "shape.initial_angular_velocity" numbers 3 in "rad/s" = [0.0, 0.0, 0.0], Rebuild initial_angular_velocity: "Initial angular velocity, in the world frame.";
    "shape.surface_velocity" numbers 3 in "m/s" = [0.0, 0.0, 0.0], Surface (surface.velocity): "Velocity of the surface relative to the shape, in the shape's frame, as of a conveyor belt.";
    "shape.friction_axis" numbers 3 = [0.0, 0.0, 0.0], Surface { get |s: &Shape| s.surface.axis.unwrap_or_default().value(), set set_axis }: "Axis in the shape's frame along which the friction differs, as for rollers, skates and tracks; 0 0 0: no axis.";
    "shape.friction_axis_angle" number in "rad" = 0.0, Surface (surface.axis_angle): "Angle by which `friction_axis` is rotated about the contact normal, which points out of the shape; if the axis is the axle of a wheel, the angle of the rollers on its rim, at any point of contact.";
    "shape.axis_friction" number from 0.0 = 0.0, Surface (surface.axis_friction): "Friction coefficient of a pair along `friction_axis`.";
    "shape.rolling_friction" number in "m" from 0.0 = 0.0, Surface (surface.rolling_friction): "Torque against rolling per newton of normal force; the greater value of a pair applies.";
    "shape.spinning_friction" number in "m" from 0.0 = 0.0, Surface (surface.spinning_friction): "Torque against spinning about the normal per newton of normal force; the greater value of a pair applies.";
    "shape.material" text = none, Surface material: "Name of the material, for the scene's `friction_pairs`.";
    "shape.linear_damping" number from 0.0 = 0.0, Rebuild (damping[0]): "Fraction of the velocity that the shape loses per second, as in a viscous fluid.";
    "shape.angular_damping" number from 0.0 = 0.0, Rebuild (damping[1]): "Fraction of the angular velocity that the shape loses per second.";
    "shape.collide_as" text of (COLLIDE_AS) = "same", Form { get |s: &Shape| Value::text(s.collide_as.map_or("same", Primitive::name)), set |s: &mut Shape, v| { s.collide_as = Primitive::parse(&text_of(v)?); Ok(true) } }: "Form for collisions; same: that of the shape.";
    "shape.collide_size" numbers 3 in "m" from 0.0 to 1e9 = [0.0, 0.0, 0.0], Form collide_size: "Size of the form for collisions; 0 0 0: that of the shape.";
}
