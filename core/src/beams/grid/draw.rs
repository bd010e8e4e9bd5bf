//! A band of rows from all that is ready to be drawn.

use fearless_simd::{Level, prelude::*};

use super::camera::Camera;
use super::polygon::Polygon;
use super::raster::{Buffer, F, Raster, WIDE};
use super::round::Round;
use super::triangles::Triangles;
use crate::beams::simd::dispatch;

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
        dispatch!(level, simd => draw(simd, self, camera, &mut raster, depth));
        raster
    }
}

#[inline(always)]
fn draw<S: Simd, const ID: bool>(
    simd: S,
    ready: &Ready<'_>,
    camera: &Camera,
    raster: &mut Raster<'_, ID>,
    depth: &mut [f32],
) {
    for polygon in &ready.polygons {
        polygon.draw(simd, raster);
    }
    for round in &ready.rounds {
        round.draw(simd, raster);
    }
    for mesh in &ready.meshes {
        mesh.draw(simd, raster);
    }
    let nothing = F::splat(simd, f32::INFINITY);
    for (row, out) in depth.chunks_exact_mut(camera.columns).enumerate() {
        let w = &raster.w[row * raster.stride..];
        for (out, w) in out.chunks_mut(WIDE).zip(w.chunks_exact(WIDE)) {
            let w = F::from_slice(simd, w);
            let depth = if camera.perspective { F::splat(simd, 1.0) / w } else { -w };
            let depth = w.simd_gt(camera.w_nothing).select(depth, nothing);
            if out.len() == WIDE {
                depth.store_slice(out);
            } else {
                out.copy_from_slice(&depth.as_slice()[..out.len()]);
            }
        }
    }
}
