//! Choice of a camera for a picture: cameras of the scene, and default cameras.

use ::tatu_beams::bounds;
use nalgebra::{Point3, Vector3};
use tatu_core::World;
use tatu_scene::{ObjectVariant, Scene, visible_parts};

use super::Camera;

/// Direction from the target to the default camera of a scene, not normalised: behind, to the right and above, if the
/// front is +x.
const SCENE_VIEW_DIRECTION: [f64; 3] = [-0.55, -0.65, 0.5];
/// Direction from the target to the default camera of a single model, not normalised: ahead, to the right and above.
const MODEL_VIEW_DIRECTION: [f64; 3] = [0.62, -0.6, 0.42];
/// A part belongs to the model if, along each axis, its distance from the bounding box of the parts found so far is at
/// most this fraction of the length of the box's diagonal.
const MAX_PART_GAP: f64 = 0.4;
/// Factor of the camera distance that leaves a margin around the visible shapes.
const DISTANCE_MARGIN: f64 = 1.05;
/// Edge length, in metres, of the cube at the origin that the camera shows if a scene has no visible shapes.
const EMPTY_SCENE_SIZE_M: f64 = 1.0;

/// Returns the first camera of the scene and its path, or `None` if the scene has no camera. `fov`, in radians,
/// overrides the camera's angle.
pub fn scene_camera(world: &World, fov: Option<f64>, [columns, rows]: [u32; 2]) -> Option<(Camera, String)> {
    world.with_scene(|scene, _| {
        let slot = scene.slots().find_map(|(slot, o)| matches!(o.data, ObjectVariant::Camera(_)).then_some(slot))?;
        Some((camera_of_object(scene, slot, fov, [columns, rows])?, scene.path(slot)))
    })
}

/// Returns the camera of the scene with the given path or unique name, or `None` if no such camera exists. `fov`, in
/// radians, overrides the camera's angle.
pub fn camera_at(world: &World, path: &str, fov: Option<f64>, size: [u32; 2]) -> Option<Camera> {
    world.with_scene(|scene, _| camera_of_object(scene, scene.find(0, path)?, fov, size))
}

fn camera_of_object(scene: &Scene, slot: u32, fov: Option<f64>, [columns, rows]: [u32; 2]) -> Option<Camera> {
    let ObjectVariant::Camera(camera) = &scene.get(slot)?.data else { return None };
    let pose = scene.world(slot);
    let from = Point3::from(pose.translation.vector);
    // The angle of a camera spans the longer side of the picture.
    let own = match rows > columns {
        false => camera.angle,
        true => 2.0 * libm::atan(libm::tan(camera.angle / 2.0) * f64::from(columns) / f64::from(rows)),
    };
    Some(Camera { from, to: from + pose.rotation * Vector3::z(), fov: fov.unwrap_or(own), columns, rows })
}

/// Returns whether a camera shows at least half of the scene: of the corners and centres of the bounding boxes of visible
/// shapes, except planes. Surfaces in front of others are not considered.
pub fn shows_most(world: &World, camera: &Camera) -> bool {
    let axes = camera.axes();
    let (mut shown, mut all) = (0, 0);
    for [low, high] in visible_bounds(world) {
        let corner = |i: usize| Point3::from(Vector3::from_fn(|k, _| if i >> k & 1 == 0 { low[k] } else { high[k] }));
        let centre = Point3::from((low + high) / 2.0);
        let points = (0..8).map(corner).chain([centre]);
        shown += points.filter(|p| axes.shows(p, [camera.columns, camera.rows])).count();
        all += 9;
    }
    2 * shown >= all
}

/// Returns a camera that shows all visible shapes except planes.
pub fn framing_camera(world: &World, fov: f64, size: [u32; 2]) -> Camera {
    let all = visible_bounds(world).into_iter().reduce(merge_bounds);
    camera_facing(all, Vector3::from(SCENE_VIEW_DIRECTION), fov, size)
}

/// Returns a camera in front of a single model. It shows the first visible part and, repeatedly, every part close to
/// those already included. It thus leaves out distant markers such as waypoints.
pub fn model_camera(world: &World, fov: f64, size: [u32; 2]) -> Camera {
    let mut left = visible_bounds(world);
    let mut all = (!left.is_empty()).then(|| left.remove(0));
    while let Some(bounds) = all {
        let reach = MAX_PART_GAP * (bounds[1] - bounds[0]).norm();
        let near = |[low, high]: &WorldBounds| {
            (0..3).all(|k| low[k] <= bounds[1][k] + reach && high[k] >= bounds[0][k] - reach)
        };
        let Some(next) = left.iter().position(near) else { break };
        all = Some(merge_bounds(bounds, left.remove(next)));
    }
    camera_facing(all, Vector3::from(MODEL_VIEW_DIRECTION), fov, size)
}

/// A bounding box in the world frame: the least and the greatest coordinates, in metres.
type WorldBounds = [Vector3<f64>; 2];

fn merge_bounds([low, high]: WorldBounds, [a, b]: WorldBounds) -> WorldBounds {
    [low.inf(&a), high.sup(&b)]
}

/// Returns the bounding box of each part of the visible shapes, except planes.
fn visible_bounds(world: &World) -> Vec<WorldBounds> {
    world.with_scene(|scene, _| {
        let shapes = scene.slots().filter_map(|(slot, o)| Some((slot, o.shape().filter(|_| o.is_visible())?)));
        let parts = shapes.flat_map(|(slot, shape)| {
            visible_parts(shape).into_iter().filter_map(move |p| bounds(&p.form, &(scene.world(slot) * p.pose)))
        });
        parts.collect()
    })
}

/// Returns a camera that looks at a bounding box from the direction `from`.
fn camera_facing(all: Option<WorldBounds>, from: Vector3<f64>, fov: f64, [columns, rows]: [u32; 2]) -> Camera {
    let [low, high] =
        all.unwrap_or([Vector3::repeat(-EMPTY_SCENE_SIZE_M / 2.0), Vector3::repeat(EMPTY_SCENE_SIZE_M / 2.0)]);
    let middle = Point3::from((low + high) / 2.0);
    let radius = ((high - low).norm() / 2.0).max(1e-3);
    let upright = 2.0 * libm::atan(libm::tan(fov / 2.0) * f64::from(rows) / f64::from(columns));
    let distance = DISTANCE_MARGIN * radius / libm::sin(fov.min(upright) / 2.0);
    Camera { from: middle + from.normalize() * distance, to: middle, fov, columns, rows }
}
