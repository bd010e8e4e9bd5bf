//! A band of rows from all that is ready to be drawn.

use super::camera::Camera;
use super::level::Level;
use super::polygon::Polygon;
use super::raster::{Buffer, Raster};
use super::round::Round;
use super::triangles::Triangles;

/// All that may be seen.
#[derive(Default)]
pub(super) struct Ready<'a> {
    pub polygons: Vec<Polygon>,
    pub rounds: Vec<Round>,
    pub meshes: Vec<Triangles<'a>>,
}

impl Ready<'_> {
    /// Draws the rows that `depth` holds, from row `first` on, and leaves what is seen in `buffer`.
    pub fn draw<'b, const ID: bool>(
        &self,
        level: Level,
        camera: &Camera,
        buffer: &'b mut Buffer,
        first: usize,
        depth: &mut [f32],
    ) -> Raster<'b, ID> {
        let mut raster = Raster::new(buffer, camera, first, first + depth.len() / camera.columns);
        match level {
            Level::Plain => draw(self, camera, &mut raster, depth),
            // SAFETY: a level is made only where the processor has its instructions.
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => unsafe { draw_avx2(self, camera, &mut raster, depth) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => unsafe { draw_avx512(self, camera, &mut raster, depth) },
        }
        raster
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn draw_avx2<const ID: bool>(ready: &Ready<'_>, camera: &Camera, raster: &mut Raster<'_, ID>, depth: &mut [f32]) {
    draw(ready, camera, raster, depth);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn draw_avx512<const ID: bool>(ready: &Ready<'_>, camera: &Camera, raster: &mut Raster<'_, ID>, depth: &mut [f32]) {
    draw(ready, camera, raster, depth);
}

#[inline(always)]
fn draw<const ID: bool>(ready: &Ready<'_>, camera: &Camera, raster: &mut Raster<'_, ID>, depth: &mut [f32]) {
    for polygon in &ready.polygons {
        polygon.draw(raster);
    }
    for round in &ready.rounds {
        round.draw(raster);
    }
    for mesh in &ready.meshes {
        mesh.draw(raster);
    }
    for (row, out) in depth.chunks_exact_mut(camera.columns).enumerate() {
        let w = &raster.w[row * raster.stride..];
        for (out, w) in out.iter_mut().zip(w) {
            *out = camera.depth(*w);
        }
    }
}
