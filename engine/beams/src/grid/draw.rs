//! Rasterisation of the prepared surfaces into rows, and the conversion to depths afterwards.

use fearless_simd::{Level, prelude::*};

use super::{
    camera::GridCamera,
    raster::{FloatLanes, LANES, Raster},
    surfaces::PreparedSurfaces,
};
use crate::simd::dispatch;

/// Rasterises a band of rows.
pub(super) fn draw<const ID: bool>(
    level: Level,
    ready: &PreparedSurfaces<'_>,
    band: usize,
    raster: &mut Raster<'_, ID>,
) {
    dispatch!(level, simd => draw_with(simd, ready, band, raster));
}

#[inline(always)]
fn draw_with<S: Simd, const ID: bool>(simd: S, ready: &PreparedSurfaces<'_>, band: usize, raster: &mut Raster<'_, ID>) {
    for polygon in ready.solids.iter().flat_map(|solids| &solids.polygons) {
        polygon.draw(simd, raster);
    }
    for round in ready.solids.iter().flat_map(|solids| &solids.rounds) {
        round.draw(simd, raster);
    }
    for (mesh, sixteens) in ready.groups(band) {
        mesh.draw(simd, sixteens, raster);
    }
}

/// Computes the depths of the pixels of a band after all surfaces have been rasterised.
pub(super) fn write_depths<const ID: bool>(
    level: Level,
    camera: &GridCamera,
    raster: &Raster<'_, ID>,
    depth: &mut [f32],
) {
    dispatch!(level, simd => write_depths_with(simd, camera, raster, depth));
}

#[inline(always)]
fn write_depths_with<S: Simd, const ID: bool>(
    simd: S,
    camera: &GridCamera,
    raster: &Raster<'_, ID>,
    depth: &mut [f32],
) {
    let nothing = FloatLanes::splat(simd, f32::INFINITY);
    for (row, out) in depth.chunks_exact_mut(camera.columns).enumerate() {
        let w = &raster.w[row * raster.stride..];
        for (out, w) in out.chunks_mut(LANES).zip(w.chunks_exact(LANES)) {
            let w = FloatLanes::from_slice(simd, w);
            let depth = if camera.perspective { FloatLanes::splat(simd, 1.0) / w } else { -w };
            let depth = w.simd_gt(camera.w_empty).select(depth, nothing);
            if out.len() == LANES {
                depth.store_slice(out);
            } else {
                out.copy_from_slice(&depth.as_slice()[..out.len()]);
            }
        }
    }
}
