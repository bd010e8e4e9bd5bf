//! Pictures of a world for people, without a display: rays of light, no GPU.
//!
//! - [`Camera`]: from where to where, how wide, how many pixels;
//! - `stage`: what can be seen: visible forms with their colours, drawings, curves, the floor;
//! - `marks`: drawings and curves of graphs as small solids;
//! - `light`: the lamp, the sky, the grid on the floor, and what they make of a surface;
//! - `render`: all pixels, with shadows, and smooth edges where something ends;
//! - `reading`: what a sensor measured, with the shapes of its fields; `outline`: the edges of what it sends out.
//!
//! A picture depends on the world and the camera alone: not on the number of threads.

mod camera;
mod light;
mod marks;
mod outline;
mod reading;
mod render;
mod stage;

pub use camera::Camera;
pub use light::TO_LAMP;
pub use marks::Line;
pub use outline::Edge;
pub use reading::{Field, Reading};
pub use render::Picture;

use crate::world::World;

impl World {
    /// A picture of the scene as it is now: visible shapes, drawings, and curves of graphs in space.
    ///
    /// It takes 10 to 30 rays a pixel, cast on the world's threads.
    pub fn picture(&self, camera: &Camera) -> Picture {
        self.picture_with(camera, &[])
    }

    /// The same with lines that are no part of the scene.
    pub fn picture_with(&self, camera: &Camera, lines: &[Line]) -> Picture {
        let cell = self.cell();
        let stage = stage::Stage::of(&cell.scene.borrow(), &cell.figures.borrow(), camera, lines);
        cell.install(|| render::render(&stage, camera))
    }
}
