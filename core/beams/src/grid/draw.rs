//! What is ready, drawn into rows; and depths, when all of it is.

use fearless_simd::{Level, prelude::*};

use super::camera::Camera;
use super::raster::{F, Raster, WIDE};
use super::ready::{Group, Ready};
use crate::simd::dispatch;

/// Draws all but the groups that are drawn once, from one row to before another.
pub(super) fn surfaces<const ID: bool>(
    level: Level,
    ready: &Ready<'_>,
    rows: (usize, usize),
    raster: &mut Raster<'_, ID>,
) {
    dispatch!(level, simd => surfaces_with(simd, ready, raster.view(rows.0, rows.1)));
}

#[inline(always)]
fn surfaces_with<S: Simd, const ID: bool>(simd: S, ready: &Ready<'_>, mut rows: Raster<'_, ID>) {
    for polygon in ready.solids.iter().flat_map(|solids| &solids.polygons) {
        polygon.draw(simd, &mut rows);
    }
    for round in ready.solids.iter().flat_map(|solids| &solids.rounds) {
        round.draw(simd, &mut rows);
    }
    for Group { mesh, seen } in ready.tall() {
        if (seen.rows.0 as usize) < rows.end && seen.rows.1 as usize > rows.first {
            mesh.draw(simd, seen.sixteens, &mut rows);
        }
    }
}

/// Draws groups of triangles, from one row to before another.
pub(super) fn groups<'a, const ID: bool>(
    level: Level,
    groups: impl Iterator<Item = Group<'a>>,
    rows: (usize, usize),
    raster: &mut Raster<'_, ID>,
) {
    dispatch!(level, simd => groups_with(simd, groups, raster.view(rows.0, rows.1)));
}

#[inline(always)]
fn groups_with<'a, S: Simd, const ID: bool>(
    simd: S,
    groups: impl Iterator<Item = Group<'a>>,
    mut rows: Raster<'_, ID>,
) {
    for Group { mesh, seen } in groups {
        mesh.draw(simd, seen.sixteens, &mut rows);
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
