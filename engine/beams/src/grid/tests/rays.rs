//! Reference results from rays through the centres of pixels; they share no code with images.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::*;
use crate::{Beam, Hit};

/// Returns the ray of an image position, in columns and rows from the centre of the first pixel, and the depth per
/// metre of its length.
pub(super) fn ray(cast: &GridCast<'_>, column: f64, row: f64) -> (Beam, f64) {
    let Grid { columns, rows, projection: view, near, far } = *cast.grid;
    let (across, up) = (column + 0.5 - 0.5 * f64::from(columns), row + 0.5 - 0.5 * f64::from(rows));
    let (origin, along) = match view {
        ImageProjection::Perspective { angle } => {
            let f = 0.5 * f64::from(columns) / (0.5 * angle).tan();
            (Vector3::zeros(), Vector3::new(-across / f, up / f, 1.0))
        }
        ImageProjection::Orthographic { width } => {
            let size = width / f64::from(columns);
            (Vector3::new(-across * size, up * size, 0.0), Vector3::z())
        }
    };
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along).unwrap();
    let length = along.norm();
    let beam = Beam {
        near: near * length,
        faces: cast.faces,
        skip_group: cast.skip_group,
        only_object: cast.only_object,
        ..Beam::ray(cast.world_from_sensor * Isometry3::from_parts(Translation3::from(origin), turn), far * length)
    };
    (beam, 1.0 / length)
}

/// Returns the expected contents of the image at a position: the depth, the hit and the ray.
pub(super) fn expected(scene: &BeamScene, cast: &GridCast<'_>, column: f64, row: f64) -> (f64, Hit, Beam) {
    let (beam, per_metre) = ray(cast, column, row);
    let hit = scene.cast_one(&beam);
    (hit.distance * per_metre, hit, beam)
}

pub(super) fn same_depth(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-4 * a.abs().min(b.abs()).max(1.0)
}

/// Returns whether a depth is visible at most a hundredth of a pixel away: either a ray there has this depth, or two
/// rays on the same primitive have a greater and a smaller one. The near and far limits may be off by a few millionths.
pub(super) fn is_explained(scene: &BeamScene, cast: &GridCast<'_>, column: f64, row: f64, ours: f64) -> bool {
    let mut seen = vec![expected(scene, cast, column, row)];
    for k in 0..75 {
        let (turn, away) = (f64::from(k) * 0.7, 0.01 * f64::from(1 + k % 3) / 3.0);
        let (near, far) = (f64::from(k % 5 - 2), f64::from(k / 5 % 5 - 2));
        let grid =
            Grid { near: cast.grid.near * (1.0 + 1e-6 * near), far: cast.grid.far * (1.0 + 1e-6 * far), ..*cast.grid };
        let cast = GridCast { grid: &grid, ..*cast };
        seen.push(expected(scene, &cast, column + away * turn.cos(), row + away * turn.sin()));
    }
    let place = |hit: &Hit| (hit.object, hit.primitive);
    // Meshes are rounded to a fraction of a pixel, which changes the depth of steep surfaces.
    let size = match cast.grid.projection {
        ImageProjection::Perspective { angle } => 2.0 * ours * (0.5 * angle).tan(),
        ImageProjection::Orthographic { width } => width,
    } / f64::from(cast.grid.columns);
    let close = |a: f64, hit: &Hit| (ours - a).abs() < 1e-4 + size / 256.0 / hit.normal.z.abs().max(1e-3);
    seen.iter().any(|(a, one, _)| {
        let between = |b: f64| *a <= ours && ours <= b && b < f64::INFINITY;
        same_depth(ours, *a)
            || (one.is_some() && close(*a, one))
            || seen.iter().any(|(b, other, _)| between(*b) && place(one) == place(other))
    })
}

/// The number of pixels that differ from the hits of rays, by type of difference.
#[derive(Debug, Default)]
pub(super) struct PixelDifferences {
    /// Pixels with a different depth.
    pub depth: usize,
    /// Pixels with a different surface at the same depth: an edge between two faces.
    pub surface: usize,
}

/// Compares an image with rays. Returns the numbers of pixels that differ, which must be at silhouettes or on steep
/// surfaces.
pub(super) fn compare(scene: &BeamScene, cast: &GridCast<'_>, image: &GridImage, what: &str) -> PixelDifferences {
    let mut beside = PixelDifferences::default();
    for row in 0..cast.grid.rows {
        for column in 0..cast.grid.columns {
            let pixel = (row * cast.grid.columns + column) as usize;
            let (x, y) = (f64::from(column), f64::from(row));
            let ours = f64::from(image.depth[pixel]);
            let (depth, hit, beam) = expected(scene, cast, x, y);
            if !same_depth(ours, depth) {
                beside.depth += 1;
                assert!(
                    is_explained(scene, cast, x, y, ours),
                    "{what}: pixel {column}, {row}: {ours}, a ray sees {depth} of {hit:?}"
                );
                continue;
            }
            if !hit.is_some() {
                assert_eq!((image.object[pixel], image.primitive[pixel]), (0, 0), "{what}");
                continue;
            }
            if (image.object[pixel], image.primitive[pixel]) != (hit.object, hit.primitive) {
                // Two surfaces at the same depth, or an edge between two faces.
                beside.surface += 1;
                continue;
            }
            let normal = cast.world_from_sensor.inverse_transform_vector(&(beam.world_from_beam * hit.normal));
            let cosine = -hit.normal.z;
            let ours = Vector3::from(image.normal[pixel]).map(f64::from);
            // Near the rim of round forms, the normal changes quickly.
            let slack = 2e-3 + 2e-4 / cosine.abs().max(1e-3);
            assert!((normal - ours).norm() < slack, "{what}: pixel {column}, {row}: normal {ours} for {normal}");
            assert!((f64::from(image.cosine[pixel]) - cosine).abs() < slack, "{what}: cosine");
        }
    }
    beside
}

pub(super) fn render(scene: &BeamScene, cast: &GridCast<'_>) -> GridImage {
    let mut image = GridImage::default();
    scene.render(cast, &mut image);
    image
}
