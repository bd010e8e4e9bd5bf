//! A band of rows from all that is ready to be drawn.

use fearless_simd::{Level, prelude::*};

use super::bands::{Band, Segment};
use super::camera::Camera;
use super::raster::{F, Raster, WIDE};
use super::ready::Ready;
use crate::beams::simd::dispatch;

/// Draws a band; triangles that begin in it, up to row `reach`.
pub(super) fn draw<const ID: bool>(
    level: Level,
    ready: &Ready<'_>,
    segment: &Segment,
    band: &Band,
    reach: usize,
    raster: &mut Raster<'_, ID>,
) {
    dispatch!(level, simd => draw_with(simd, ready, segment, band, reach, raster));
}

#[inline(always)]
fn draw_with<S: Simd, const ID: bool>(
    simd: S,
    ready: &Ready<'_>,
    segment: &Segment,
    band: &Band,
    reach: usize,
    raster: &mut Raster<'_, ID>,
) {
    let mut rows = raster.view(band.rows.0, band.rows.1);
    for polygon in ready.solids.iter().flat_map(|solids| &solids.polygons) {
        polygon.draw(simd, &mut rows);
    }
    for round in ready.solids.iter().flat_map(|solids| &solids.rounds) {
        round.draw(simd, &mut rows);
    }
    for piece in &segment.tall {
        if (piece.rows.0 as usize) < band.rows.1 && piece.rows.1 as usize > band.rows.0 {
            ready.meshes[piece.mesh as usize].draw(simd, piece.sixteens, &mut rows);
        }
    }
    let mut rows = raster.view(band.rows.0, reach);
    let own = &segment.own[band.own.0..band.own.1];
    for (piece, i) in own.iter().zip(1..) {
        // They are in order within a band only: the processor does not guess where the next begins.
        if let Some(next) = own.get(i) {
            ready.meshes[next.mesh as usize].fetch(next.sixteens.0);
        }
        ready.meshes[piece.mesh as usize].draw(simd, piece.sixteens, &mut rows);
    }
}

/// The depth of pixels from a row on.
pub(super) fn finish<const ID: bool>(
    level: Level,
    camera: &Camera,
    raster: &Raster<'_, ID>,
    first: usize,
    depth: &mut [f32],
) {
    dispatch!(level, simd => finish_with(simd, camera, raster, first, depth));
}

#[inline(always)]
fn finish_with<S: Simd, const ID: bool>(
    simd: S,
    camera: &Camera,
    raster: &Raster<'_, ID>,
    first: usize,
    depth: &mut [f32],
) {
    let nothing = F::splat(simd, f32::INFINITY);
    for (row, out) in depth.chunks_exact_mut(camera.columns).enumerate() {
        let w = &raster.w[(first - raster.first + row) * raster.stride..];
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
