//! A frame: what is in sight is made ready, then bands of rows are drawn side by side.

use std::sync::OnceLock;

use fearless_simd::Level;

use super::bands::{Cut, LEAST_ROWS};
use super::camera::Camera;
use super::crew;
use super::ready::Sketch;
use super::shade::Shader;
use super::work::{Sight, Work};
use super::{GridCast, GridImage};
use crate::{BeamScene, simd};

impl BeamScene {
    /// Takes an image, on rayon's current pool and with the calling thread.
    ///
    /// The image depends only on the cast and the targets: not on the number of threads, the processor or earlier
    /// images. A camera that can see nothing (no pixels, no range, an angle or a pose that is none) gives an image
    /// of nothing. Costs time for each target, pixel and triangle in sight.
    pub fn render(&self, cast: &GridCast<'_>, image: &mut GridImage) {
        self.draw(cast, image, simd::level(), None);
    }

    /// The same with given instructions and rows of a band.
    #[cfg(test)]
    pub(super) fn render_by(&self, cast: &GridCast<'_>, image: &mut GridImage, level: Level, rows: usize) {
        self.draw(cast, image, level, Some(rows));
    }

    fn draw(&self, cast: &GridCast<'_>, image: &mut GridImage, level: Level, rows: Option<usize>) {
        image.prepare(cast);
        let Some(camera) = Camera::new(cast.grid, &cast.world_from_sensor) else {
            image.depth.fill(f32::INFINITY);
            image.parts(0).0.clear(cast.light.sky_bytes());
            return;
        };
        if cast.want.visibility() {
            self.draw_all::<true>(cast, &camera, image, level, rows);
        } else {
            self.draw_all::<false>(cast, &camera, image, level, rows);
        }
    }

    fn draw_all<const ID: bool>(
        &self,
        cast: &GridCast<'_>,
        camera: &Camera,
        image: &mut GridImage,
        level: Level,
        rows: Option<usize>,
    ) {
        let threads = rayon::current_num_threads();
        let cut = match rows {
            Some(height) => Cut::into_bands(camera.rows, threads, height),
            None => Cut::new(camera.rows, threads),
        };
        let (mut rest, buffers) = image.parts(cut.segments());
        // Made by the thread that leads, for all.
        let (sketch, ready, shader, work) = (OnceLock::new(), OnceLock::new(), OnceLock::new(), OnceLock::new());
        let assist = |thread: usize| sketch.get().is_some_and(|sketch: &Sketch<'_>| sketch.assist(thread % 2 == 1));
        let helpers = (threads - 1).min(camera.rows / LEAST_ROWS);
        crew::run::<ID>(helpers, &work, &assist, || {
            let sketch = sketch.get_or_init(|| Sketch::new(self, cast, camera, level, cut));
            while assist(0) {}
            let ready = ready.get_or_init(|| sketch.ready());
            let shader = shader.get_or_init(|| Shader::new(cast, camera, self.targets(), &sketch.surfaces));
            let sight = Sight { ready, camera, shader, level };
            work.get_or_init(|| {
                let parts = ready.segments.iter().zip(buffers).map(|(segment, buffers)| {
                    let pixels = (segment.rows.1 - segment.rows.0) * camera.columns;
                    let (part, after) = std::mem::take(&mut rest).split(pixels);
                    rest = after;
                    Work::new(sight, segment, part, buffers.each_mut())
                });
                parts.collect()
            })
        });
    }
}
