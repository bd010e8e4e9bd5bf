//! Pictures of a world for human viewers, ray traced on the CPU without a display.
//!
//! - [`Camera`]: position, direction, field of view and resolution;
//! - `framing`: the choice of a camera, which is one of the scene's own or one that shows the visible shapes;
//! - `render_scene`: the contents of a picture, that is visible forms with their colours, drawings, curves and the
//!   floor;
//! - `marks`: drawings and curves of graphs as small solids;
//! - `light`: the lamp, the sky, the grid on the floor, and the shading of surfaces;
//! - `render`: the pixels, with shadows and antialiased edges.
//!
//! A picture depends only on the arguments of [`picture`], not on the number of threads.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod camera;
mod framing;
mod light;
mod marks;
mod render;
mod render_scene;

pub use camera::Camera;
pub use framing::{camera_at, framing_camera, model_camera, scene_camera, shows_most};
pub use light::LAMP_DIRECTION;
pub use marks::LineSegment;
pub use render::Picture;

use tatu_core::World;

/// Renders a picture of the scene in its current state: visible shapes, drawings, and curves of graphs in space.
///
/// A pixel on a smooth surface requires 8 rays, and one at an edge more than 100; the rays are cast on the threads of
/// the world. `lines` are rendered in addition to the contents of the scene. `ground` selects whether a floor is
/// rendered below all shapes if the scene has no visible plane.
pub fn picture(world: &World, camera: &Camera, lines: &[LineSegment], ground: bool) -> Picture {
    let stage = world.with_scene(|scene, figures| render_scene::RenderScene::of(scene, figures, camera, lines, ground));
    world.install(|| render::render(&stage, camera))
}
