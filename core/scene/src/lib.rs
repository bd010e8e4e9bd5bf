//! The scene: the document that describes it, and the live tree of objects with handles, names, poses and properties.
//!
//! - [`document`]: descriptions of scenes from scene files, models and importers;
//! - [`noise`], [`graph`]: declarations of sensor noise, and of graphs;
//! - `object`: a single object; `tree`: the tree of all objects, in slots with generations; `names`, `name_index`:
//!   lookup by path and by unique name; `moves`: the shapes that have moved;
//! - `transforms`: poses by slot, current and at the last barrier; `poses`: reading and setting poses;
//! - `property`: declarations of properties; [`property_table`]: the table of the core's properties; `properties`:
//!   reading and setting them;
//! - [`folders`]: folders below which files are opened;
//! - `forms`: the solids of a shape; `mass_properties`: their mass, centre of mass and inertia at uniform density;
//!   `drive`: the wheel drive of a robot; `texture`: images on shapes;
//! - `dynamics`: bodies and joints of the engine; `body_rules`: rules for their creation from objects; `mechanisms`:
//!   the choice of solver for the joints of a mechanism; `loop_closure`: whether loops can be closed; `mechanics`:
//!   checks of a scene's mechanics; `notices`: warnings that are given once.

mod body_rules;
pub mod document;
mod drive;
mod dynamics;
pub mod folders;
mod forms;
pub mod graph;
mod loop_closure;
mod mass_properties;
mod mechanics;
mod mechanisms;
mod moves;
mod name_index;
mod names;
pub mod noise;
mod notices;
mod object;
mod poses;
mod properties;
mod property;
pub mod property_table;
mod texture;
mod transforms;
mod tree;

pub use document::FrictionPair;
pub use drive::WheelDrive;
pub use dynamics::{AfterStep, Dynamics, StepHooks, mass_props};
pub use forms::{collision_parts, is_infinite, visible_parts};
pub use mass_properties::{centre_of_mass, inertia, mass, uniform_inertia};
pub use mechanics::check_mechanics;
pub use mechanisms::describe_solvers;
pub use moves::MoveLog;
pub use names::{ALIAS_RULE, is_alias};
pub use object::{
    ActuatorObject, Camera, ControlMode, DerivedGeometry, FollowRule, ForceSensor, Joint, JointSolver, JointType,
    Light, LightForm, Object, ObjectKind, ObjectVariant, Primitive, ScenePath, SensorObject, SensorTargets, Shape,
    ShapeBody, ShapePart, TargetSpline, notes, notes_value, part_images, part_meshes,
};
pub use properties::{get, get_numbers, is_drive_parameter, set, set_numbers};
pub use property_table::ChangeEffect;
pub use texture::ShapeTexture;
pub use tree::{ObjectHandle, Scene};

use nalgebra::{Isometry3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Converts a pose to 7 values: position x y z, quaternion x y z w.
pub fn pose_to_array(p: &Isometry3<f64>) -> [f64; 7] {
    let (t, q) = (p.translation.vector, p.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w]
}

/// Converts 7 values, as from [`pose_to_array`], to a pose with a normalised quaternion. Returns `None` if a value is
/// not finite, or if the quaternion is zero.
pub fn pose_from_array(a: &[f64; 7]) -> Option<Isometry3<f64>> {
    let q = Quaternion::new(a[6], a[3], a[4], a[5]);
    let finite = a.iter().all(|x| x.is_finite()) && q.norm() > 1e-12;
    // A quaternion of length 1 is left unchanged, which preserves the bits of stored poses.
    let unit = |q: Quaternion<f64>| match (q.norm_squared() - 1.0).abs() <= 4.0 * f64::EPSILON {
        true => UnitQuaternion::new_unchecked(q),
        false => UnitQuaternion::from_quaternion(q),
    };
    finite.then(|| Isometry3::from_parts(Translation3::new(a[0], a[1], a[2]), unit(q)))
}

/// Returns the orientation that results from intrinsic rotations about x, then y, then z, rad.
pub fn from_euler(e: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), e[0])
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), e[1])
        * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), e[2])
}

/// Returns an orientation as intrinsic rotations about x, y and z, rad. If the second is within 0.2 degrees of +-90
/// degrees, the first is 0.
pub fn to_euler(q: &UnitQuaternion<f64>) -> [f64; 3] {
    let r: Rotation3<f64> = q.to_rotation_matrix();
    let beta = libm::asin(r[(0, 2)].clamp(-1.0, 1.0));
    if r[(0, 2)].abs() < 0.999_995 {
        [libm::atan2(-r[(1, 2)], r[(2, 2)]), beta, libm::atan2(-r[(0, 1)], r[(0, 0)])]
    } else {
        [0.0, beta, libm::atan2(r[(1, 0)], r[(1, 1)])]
    }
}
