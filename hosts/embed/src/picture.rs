//! Renders the view of a camera in a world.

use tatu_core::{
    World,
    errors::{Error, Result},
};
use tatu_render::{Camera, Picture};

/// The viewpoint of a picture.
#[derive(Debug, Clone)]
pub enum CameraView {
    /// The first camera of the scene; without one, a viewpoint that shows all shapes.
    SceneCamera,
    /// A camera of the scene, by its path.
    Camera(String),
    /// From the first point towards the second, both in the world frame, m.
    Points([f64; 3], [f64; 3]),
}

/// Default field of view, rad.
const DEFAULT_FOV_RAD: f64 = 0.872_664_625_997_164_8;

/// Renders a picture of `size` columns and rows. `fov` is the angle between its left and right edge, rad; if it is
/// `None`, the camera's angle or, without a camera, a default is used.
///
/// # Errors
/// The size or the field of view is out of range, there is no such camera, or the view has no direction.
pub fn picture(world: &World, view: &CameraView, size: [u32; 2], fov: Option<f64>) -> Result<Picture> {
    let [columns, rows] = size;
    if columns == 0 || rows == 0 || u64::from(columns) * u64::from(rows) > 1 << 26 {
        let error = Error::new("E102", format!("cannot render a picture of {columns} x {rows} pixels"));
        return Err(error.expected("at least 1 column and 1 row, and at most 67108864 pixels"));
    }
    if let Some(fov) = fov.filter(|fov| !(*fov > 0.0 && *fov < std::f64::consts::PI)) {
        let error = Error::new("E102", format!("the field of view of {fov} rad is out of range"));
        return Err(error.expected("more than 0 and less than pi rad"));
    }
    let camera = match view {
        CameraView::SceneCamera => match tatu_render::scene_camera(world, fov, size) {
            Some((camera, _)) => camera,
            None => tatu_render::framing_camera(world, fov.unwrap_or(DEFAULT_FOV_RAD), size),
        },
        CameraView::Camera(path) => {
            tatu_render::camera_at(world, path, fov, size).ok_or_else(|| no_camera(world, path))?
        }
        CameraView::Points(from, to) if from == to => {
            return Err(Error::new("E102", "the view has no direction, because both of its points are equal")
                .expected("two different points"));
        }
        CameraView::Points(from, to) => {
            Camera { from: (*from).into(), to: (*to).into(), fov: fov.unwrap_or(DEFAULT_FOV_RAD), columns, rows }
        }
    };
    Ok(tatu_render::picture(world, &camera, &[], true))
}

fn no_camera(world: &World, path: &str) -> Error {
    let error = Error::new("E110", format!("there is no camera `{path}`")).expected("the path of a camera");
    match world.nearest(path) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error,
    }
}
