//! Default cameras.

use ::tatu_beams::bounds;
use nalgebra::{Point3, Vector3};
use tatu_core::World;
use tatu_scene::{Data, visible_parts};

use super::Camera;

/// Direction from the target to the camera, for a scene without a camera: the camera is behind, to the right and above,
/// if the front is +x. Not normalized.
const FROM: [f64; 3] = [-0.55, -0.65, 0.5];
/// Scale of the margin around the visible shapes.
const ROOM: f64 = 1.05;
/// Assumed size of a scene in which nothing is visible, in metres.
const NOTHING: f64 = 1.0;

/// Returns the first camera of the scene and its path. `fov`, in radians, overrides its own angle.
pub fn scene_camera(world: &World, fov: Option<f64>, [columns, rows]: [u32; 2]) -> Option<(Camera, String)> {
    world.look_at(|scene, _| {
        let (slot, camera) = scene.slots().find_map(|(slot, o)| match &o.data {
            Data::Camera(camera) => Some((slot, camera)),
            _ => None,
        })?;
        let pose = scene.world(slot);
        let from = Point3::from(pose.translation.vector);
        // The angle of a camera is that of the longer side.
        let own = match rows > columns {
            false => camera.angle,
            true => 2.0 * libm::atan(libm::tan(camera.angle / 2.0) * f64::from(columns) / f64::from(rows)),
        };
        let camera = Camera { from, to: from + pose.rotation * Vector3::z(), fov: fov.unwrap_or(own), columns, rows };
        Some((camera, scene.path(slot)))
    })
}

/// Returns a camera that shows all visible shapes except planes.
pub fn framing(world: &World, fov: f64, [columns, rows]: [u32; 2]) -> Camera {
    let all = world.look_at(|scene, _| {
        let shapes = scene.slots().filter_map(|(slot, o)| Some((slot, o.shape().filter(|_| o.is_visible())?)));
        let parts = shapes.flat_map(|(slot, shape)| {
            visible_parts(shape).into_iter().filter_map(move |p| bounds(&p.form, &(scene.world(slot) * p.pose)))
        });
        parts.reduce(|[low, high], [a, b]| [low.inf(&a), high.sup(&b)])
    });
    let [low, high] = all.unwrap_or([Vector3::repeat(-NOTHING / 2.0), Vector3::repeat(NOTHING / 2.0)]);
    let middle = Point3::from((low + high) / 2.0);
    let radius = ((high - low).norm() / 2.0).max(1e-3);
    let upright = 2.0 * libm::atan(libm::tan(fov / 2.0) * f64::from(rows) / f64::from(columns));
    let distance = ROOM * radius / libm::sin(fov.min(upright) / 2.0);
    Camera { from: middle + Vector3::from(FROM).normalize() * distance, to: middle, fov, columns, rows }
}
