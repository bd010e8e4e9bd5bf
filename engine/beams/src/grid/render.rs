//! Rendering of a frame: the visible surfaces are prepared, then bands of rows are rasterised in parallel.

use fearless_simd::Level;
use rayon::prelude::*;

use super::{
    GridCast, GridImage,
    bands::RowBands,
    camera::GridCamera,
    draw::{draw, write_depths},
    raster::Raster,
    shade::Shader,
    surfaces::PreparedSurfaces,
};
use crate::{BeamScene, simd};

impl BeamScene {
    /// Renders an image, in rayon's current pool and on the calling thread.
    ///
    /// The image depends only on the cast and the targets, not on the number of threads, the processor or earlier
    /// images. A camera that cannot show any surface (no pixels, no range, an invalid angle or pose) yields an empty
    /// image. The time grows with the number of targets, pixels and visible triangles.
    pub fn render(&self, cast: &GridCast<'_>, image: &mut GridImage) {
        self.draw(cast, image, simd::level(), None);
    }

    /// Renders an image like [`render`](Self::render), but with a given instruction set and number of rows per band.
    #[cfg(test)]
    pub(super) fn render_by(&self, cast: &GridCast<'_>, image: &mut GridImage, level: Level, rows: usize) {
        self.draw(cast, image, level, Some(rows));
    }

    fn draw(&self, cast: &GridCast<'_>, image: &mut GridImage, level: Level, rows: Option<usize>) {
        image.prepare(cast);
        let Some(camera) = GridCamera::new(cast.grid, &cast.world_from_sensor) else {
            image.depth.fill(f32::INFINITY);
            image.parts(0).0.clear(cast.light.sky_bytes());
            return;
        };
        if cast.outputs.needs_surface_ids() {
            self.draw_all::<true>(cast, &camera, image, level, rows);
        } else {
            self.draw_all::<false>(cast, &camera, image, level, rows);
        }
    }

    fn draw_all<const ID: bool>(
        &self,
        cast: &GridCast<'_>,
        camera: &GridCamera,
        image: &mut GridImage,
        level: Level,
        rows: Option<usize>,
    ) {
        let bands = match rows {
            Some(height) => RowBands::of_height(camera.rows, height),
            None => RowBands::new(camera.rows, rayon::current_num_threads()),
        };
        let ready = &PreparedSurfaces::new(self, cast, camera, level, bands);
        let shader = &Shader::new(cast, camera, self, &ready.surfaces);
        let (mut rest, buffers) = image.parts(bands.count());
        let mut tasks = Vec::with_capacity(bands.count());
        for ((band, rows), buffer) in bands.rows().enumerate().zip(buffers) {
            let (part, after) = rest.split((rows.1 - rows.0) * camera.columns);
            rest = after;
            tasks.push((band, rows, part, buffer));
        }
        tasks.into_par_iter().with_max_len(1).for_each(|(band, rows, mut part, buffer)| {
            let mut raster = Raster::<ID>::new(buffer, camera, rows);
            draw(level, ready, band, &mut raster);
            write_depths(level, camera, &raster, part.depth);
            if ID {
                shader.shade(level, &raster, &mut part);
                if cast.outputs.color && self.has_translucent_targets() {
                    shader.blend(&raster, part.color);
                }
            }
        });
    }
}
