//! Pictures of a world for people, without a display: rays of light, no GPU.
//!
//! - [`Camera`]: from where to where, how wide, how many pixels;
//! - `framing`: cameras for who names none: the scene's own, or one that sees all;
//! - `stage`: what can be seen: visible forms with their colours, drawings, curves, the floor;
//! - `marks`: drawings and curves of graphs as small solids;
//! - `light`: the lamp, the sky, the grid on the floor, and what they make of a surface;
//! - `render`: all pixels, with shadows, and smooth edges where something ends.
//!
//! A picture depends on the world and the camera alone: not on the number of threads.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod camera;
mod framing;
mod light;
mod marks;
mod render;
mod stage;

pub use camera::Camera;
pub use framing::{framing, scene_camera};
pub use light::TO_LAMP;
pub use marks::Line;
pub use render::Picture;

use tatu_core::World;

/// A picture of the scene as it is now: visible shapes, drawings, and curves of graphs in space.
///
/// It takes 10 to 30 rays a pixel, cast on the world's threads. `lines` are drawn in addition to what is in the scene.
///
/// `ground`: whether a floor is drawn below all of it where the scene has none.
pub fn picture(world: &World, camera: &Camera, lines: &[Line], ground: bool) -> Picture {
    let stage = world.look_at(|scene, figures| stage::Stage::of(scene, figures, camera, lines, ground));
    world.install(|| render::render(&stage, camera))
}
