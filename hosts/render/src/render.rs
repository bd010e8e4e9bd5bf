//! Rendering of all pixels of a picture.

use std::ops::Range;

use nalgebra::{Point3, Unit, Vector3};
use rayon::prelude::*;

use super::{
    Camera,
    camera::CameraAxes,
    light::{LinearColor, ShadingPoint, fade_to_horizon, grid_darkening, lamp_direction, sky},
    render_scene::{RenderScene, SeenSurface, SurfaceKind},
};

/// A rendered RGB image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Number of pixels per row.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
    /// Red, green and blue of each pixel, from the top row down, each row from left to right.
    pub rgb: Vec<u8>,
}

/// The surfaces hit by the ray through the centre of a pixel.
struct PixelSample {
    nearest: SurfaceSample,
    /// The surfaces that are seen through the nearest one, if it is translucent, from near to far.
    behind: Vec<SurfaceSample>,
}

impl PixelSample {
    /// Returns the nearest surface (0) or one of those behind it.
    fn layer(&self, number: usize) -> Option<&SurfaceSample> {
        if number == 0 { Some(&self.nearest) } else { self.behind.get(number - 1) }
    }
}

/// A surface hit by a ray, with its illumination.
#[derive(Clone, Copy)]
struct SurfaceSample {
    seen: SeenSurface,
    lamp: bool,
    /// Unoccluded share of the sky, estimated from the few rays of this pixel alone.
    sky_share: f64,
}

/// Rays per pixel that sample the sky. The 16 pixels of a block use different directions and share the results.
const SKY_RAYS_PER_PIXEL: u32 = 6;
/// Side of a block of pixels that share results.
const BLOCK_SIDE_PX: u32 = 4;
/// Minimum number of similar pixels in a block for its shared result to be used.
const MIN_SIMILAR_PIXELS: f64 = 13.0;
/// Maximum distance of objects that occlude the sky, in metres.
const MAX_OCCLUDER_DISTANCE_M: f64 = 0.7;
/// Number of samples along each side of an antialiased pixel.
const SAMPLES_PER_PIXEL_SIDE: u32 = 4;

/// Renders a picture in rayon's current pool. Rendering in bands keeps the size of intermediate data independent of the
/// height of the picture.
pub(super) fn render(stage: &RenderScene, camera: &Camera) -> Picture {
    render_in_bands(stage, camera, BAND_ROWS)
}

/// Number of rows in a band.
const BAND_ROWS: u32 = 256;

fn render_in_bands(stage: &RenderScene, camera: &Camera, height: u32) -> Picture {
    let (columns, rows) = (camera.columns, camera.rows);
    let view = PictureView { stage, lens: camera.axes(), columns, rows };
    let mut rgb = Vec::with_capacity(columns as usize * rows as usize * 3);
    for first in (0..rows).step_by(height as usize) {
        let band = |more: u32| first.saturating_sub(more)..(first + height + more).min(rows);
        // Each pixel is compared with its neighbours, and each estimate of the sky uses the block around its pixel.
        let samples = PixelValues::of(columns, band(BLOCK_SIDE_PX), |x, y| view.sample(x, y));
        let open = PixelValues::of(columns, band(1), |x, y| view.averaged_sky_share(&samples, (x, y), 0));
        let colors = PixelValues::of(columns, band(0), |x, y| view.pixel(&samples, &open, x, y).bytes());
        rgb.extend(colors.values.into_iter().flatten());
    }
    Picture { columns, rows, rgb }
}

/// One value per pixel for a range of rows.
struct PixelValues<T> {
    first: u32,
    columns: u32,
    values: Vec<T>,
}

impl<T: Send> PixelValues<T> {
    fn of(columns: u32, rows: Range<u32>, f: impl Fn(u32, u32) -> T + Sync) -> Self {
        let (first, wide) = (rows.start, columns as usize);
        let pixel = |i: usize| f((i % wide) as u32, first + (i / wide) as u32);
        let values = (0..rows.len() * wide).into_par_iter().with_min_len(256).map(pixel).collect();
        PixelValues { first, columns, values }
    }
    fn at(&self, x: u32, y: u32) -> &T {
        &self.values[(y - self.first) as usize * self.columns as usize + x as usize]
    }
}

struct PictureView<'a> {
    stage: &'a RenderScene,
    lens: CameraAxes,
    columns: u32,
    rows: u32,
}

impl PictureView<'_> {
    fn sample(&self, x: u32, y: u32) -> PixelSample {
        let direction = self.lens.direction(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let mut behind = Vec::new();
        let nearest = self.stage.visible_surfaces(&self.lens.eye, &direction, &mut behind);
        let turn = (x % BLOCK_SIDE_PX) + BLOCK_SIDE_PX * (y % BLOCK_SIDE_PX);
        let sample = |seen: SeenSurface| {
            let sky_share = if is_solid(&seen) { self.sky_share(&seen, turn) } else { 1.0 };
            SurfaceSample { seen, lamp: self.is_lit(&seen), sky_share }
        };
        PixelSample { nearest: sample(nearest), behind: behind.into_iter().map(sample).collect() }
    }

    fn is_lit(&self, seen: &SeenSurface) -> bool {
        let lamp = lamp_direction();
        is_solid(seen)
            && seen.normal.dot(&lamp) > 0.0
            && !self.stage.is_blocked(&offset_from_surface(seen), &lamp, f64::INFINITY)
    }

    /// Returns the share of the sky over a surface point that nearby objects do not occlude. `turn`, 0 to 15, selects
    /// the set of directions that are sampled.
    fn sky_share(&self, seen: &SeenSurface, turn: u32) -> f64 {
        let (n, from) = (seen.normal, offset_from_surface(seen));
        let side = if n.z.abs() < 0.7 { Vector3::z() } else { Vector3::x() };
        let (a, b) = (n.cross(&side).normalize(), n.cross(&n.cross(&side)).normalize());
        let count = SKY_RAYS_PER_PIXEL * BLOCK_SIDE_PX * BLOCK_SIDE_PX;
        let free = (0..SKY_RAYS_PER_PIXEL).filter(|i| {
            // A sunflower pattern on the disc below the hemisphere gives an even, cosine-weighted distribution.
            // Neighbouring pixels use different points of it.
            let k = f64::from(i * BLOCK_SIDE_PX * BLOCK_SIDE_PX + SAMPLE_ORDER[turn as usize]) + 0.5;
            let (r, angle) = ((k / f64::from(count)).sqrt(), k * 2.399_963_229_728_653);
            let direction = a * (r * libm::cos(angle)) + b * (r * libm::sin(angle)) + n * (1.0 - r * r).sqrt();
            !self.stage.is_blocked(&from, &Unit::new_normalize(direction), MAX_OCCLUDER_DISTANCE_M)
        });
        free.count() as f64 / f64::from(SKY_RAYS_PER_PIXEL)
    }

    /// Returns the share of the sky over a surface of a pixel, the nearest one (0) or one of those behind it, averaged
    /// over the similar pixels of its block.
    fn averaged_sky_share(&self, samples: &PixelValues<PixelSample>, (x, y): (u32, u32), layer: usize) -> f64 {
        let Some(SurfaceSample { seen: here, .. }) = samples.at(x, y).layer(layer).filter(|s| is_solid(&s.seen)) else {
            return 1.0;
        };
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for v in y.saturating_sub(1)..(y + 3).min(self.rows) {
            for u in x.saturating_sub(1)..(x + 3).min(self.columns) {
                if let Some(other) = samples.at(u, v).layer(layer)
                    && on_same_surface(here, &other.seen)
                {
                    (sum, count) = (sum + other.sky_share, count + 1.0);
                }
            }
        }
        if count < MIN_SIMILAR_PIXELS {
            // If too few pixels are similar, as at an edge, this pixel samples all directions itself.
            let all = BLOCK_SIDE_PX * BLOCK_SIDE_PX;
            return (0..all).map(|turn| self.sky_share(here, turn)).sum::<f64>() / f64::from(all);
        }
        sum / count
    }

    /// Returns the colour of a pixel: one sample, or several at edges.
    fn pixel(&self, samples: &PixelValues<PixelSample>, open: &PixelValues<f64>, x: u32, y: u32) -> LinearColor {
        let here = samples.at(x, y);
        let around = (y.saturating_sub(1)..(y + 2).min(self.rows))
            .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(self.columns)).map(move |u| (u, v)));
        let near: Vec<(&PixelSample, f64)> = around.map(|(u, v)| (samples.at(u, v), *open.at(u, v))).collect();
        let same = |(other, _): &(&PixelSample, f64)| {
            let same = |(a, b): (&SurfaceSample, &SurfaceSample)| a.lamp == b.lamp && on_same_surface(&a.seen, &b.seen);
            same((&here.nearest, &other.nearest))
                && here.behind.len() == other.behind.len()
                && here.behind.iter().zip(&other.behind).all(same)
        };
        if near.iter().all(same) {
            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let color = self.shade(&here.nearest.seen, here.nearest.lamp, *open.at(x, y), at, 1.0);
            let behind = here.behind.iter().enumerate().map(|(i, layer)| {
                let open = self.averaged_sky_share(samples, (x, y), i + 1);
                (layer.seen, self.shade(&layer.seen, layer.lamp, open, at, 1.0))
            });
            return self.seen_through(&here.nearest.seen, color, behind);
        }
        let (mut sum, mut behind) = (Vector3::zeros(), Vec::new());
        for k in 0..SAMPLES_PER_PIXEL_SIDE * SAMPLES_PER_PIXEL_SIDE {
            let step = |k: u32| (f64::from(k) + 0.5) / f64::from(SAMPLES_PER_PIXEL_SIDE);
            let at = [f64::from(x) + step(k % SAMPLES_PER_PIXEL_SIDE), f64::from(y) + step(k / SAMPLES_PER_PIXEL_SIDE)];
            let seen = self.stage.visible_surfaces(&self.lens.eye, &self.lens.direction(at[0], at[1]), &mut behind);
            let shaded = |seen: &SeenSurface, layer: usize| {
                let (mut known, mut count) = (0.0, 0.0);
                for (other, open) in &near {
                    let Some(other) = other.layer(layer).filter(|o| on_same_surface(seen, &o.seen)) else { continue };
                    let open = if layer == 0 { *open } else { other.sky_share };
                    (known, count) = (known + open, count + 1.0);
                }
                let open = if count > 0.0 {
                    known / count
                } else if is_solid(seen) {
                    self.sky_share(seen, k)
                } else {
                    1.0
                };
                self.shade(seen, self.is_lit(seen), open, at, 1.0 / f64::from(SAMPLES_PER_PIXEL_SIDE))
            };
            let layers = behind.iter().enumerate().map(|(i, seen)| (*seen, shaded(seen, i + 1)));
            // Clamping prevents a very bright sample from dominating an edge.
            let c = self.seen_through(&seen, shaded(&seen, 0), layers);
            sum += c.0.map(|v| v.min(1.0));
        }
        LinearColor(sum / f64::from(SAMPLES_PER_PIXEL_SIDE * SAMPLES_PER_PIXEL_SIDE))
    }

    /// Returns the colour of a surface with those behind it, if it is translucent. The colours are given from near to
    /// far; the last one is opaque.
    fn seen_through(
        &self,
        nearest: &SeenSurface,
        color: LinearColor,
        behind: impl DoubleEndedIterator<Item = (SeenSurface, LinearColor)>,
    ) -> LinearColor {
        let over =
            |behind: LinearColor, seen: &SeenSurface, color: LinearColor| behind.mix(color, self.stage.opacity(seen));
        let farther = behind.rev().reduce(|(_, behind), (seen, color)| (seen, over(behind, &seen, color)));
        farther.map_or(color, |(_, behind)| over(behind, nearest, color))
    }

    fn shade(&self, seen: &SeenSurface, lamp: bool, open: f64, at: [f64; 2], width: f64) -> LinearColor {
        let direction = self.lens.direction(at[0], at[1]);
        let mut color = self.stage.color(seen);
        if seen.kind == SurfaceKind::Sky {
            return sky(&direction);
        }
        if let SurfaceKind::Mark(_) = seen.kind {
            // Drawings are not lit, only slightly shaded to look round.
            let round = 0.75 + 0.25 * (-seen.normal.dot(&direction)).clamp(0.0, 1.0);
            return LinearColor(color.0 * round);
        }
        let floor = self.stage.has_grid(seen);
        if floor {
            color.0 *= 1.0 - grid_darkening(&seen.point, self.pixel_extent(seen, at, width));
        }
        let gloss = if floor { 0.0 } else { 0.12 };
        let lit =
            ShadingPoint { color, normal: seen.normal, to_eye: -direction.into_inner(), lamp, sky_share: open, gloss };
        fade_to_horizon(lit.shade(), seen.distance, self.lens.eye.z)
    }

    /// Returns the extent along x and y of a pixel on the surface, in metres.
    fn pixel_extent(&self, seen: &SeenSurface, at: [f64; 2], width: f64) -> [f64; 2] {
        let on_plane = |x: f64, y: f64| {
            let d = self.lens.direction(x, y);
            let t = (seen.point - self.lens.eye).dot(&seen.normal) / d.dot(&seen.normal);
            self.lens.eye + d.into_inner() * t
        };
        let [x, y] = at;
        let (right, below) = (on_plane(x + width, y) - seen.point, on_plane(x, y + width) - seen.point);
        [0, 1].map(|i| right[i].abs() + below[i].abs())
    }
}

/// Assignment of sampling directions to the pixels of a block: adjacent pixels use distant directions.
const SAMPLE_ORDER: [u32; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];

fn is_solid(seen: &SeenSurface) -> bool {
    matches!(seen.kind, SurfaceKind::Floor | SurfaceKind::Solid(..))
}

/// Returns whether two samples lie on the same smooth surface.
fn on_same_surface(a: &SeenSurface, b: &SeenSurface) -> bool {
    let same = match (a.kind, b.kind) {
        (SurfaceKind::Solid(i, _), SurfaceKind::Solid(k, _)) => i == k,
        (a, b) => a == b,
    };
    let smooth = a.normal.dot(&b.normal) > 0.9;
    match a.kind {
        SurfaceKind::Sky => same,
        SurfaceKind::Mark(_) => false,
        // The distance test rejects steps between parts of the same form at different depths.
        _ => same && smooth && ((a.point - b.point).dot(&a.normal).abs() < 0.02 + 0.05 * a.distance),
    }
}

/// Returns a point slightly above the surface, where secondary rays start.
fn offset_from_surface(seen: &SeenSurface) -> Point3<f64> {
    seen.point + seen.normal * (1e-6 * (1.0 + seen.distance))
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;
    use tatu_core::figures::Figures;
    use tatu_scene::{ObjectVariant, Scene, Shape};

    #[test]
    fn bands_leave_no_seams() {
        let mut scene = Scene::default();
        for x in [0.0, 0.13, 0.31] {
            scene.add(0, "box", Isometry3::translation(x, x, 0.05 + x), ObjectVariant::Shape(Box::<Shape>::default()));
        }
        let camera = Camera {
            from: Point3::new(-0.6, -0.5, 0.4),
            to: Point3::new(0.1, 0.1, 0.1),
            fov: 0.9,
            columns: 48,
            rows: 37,
        };
        let stage = RenderScene::of(&scene, &Figures::default(), &camera, &[], true);
        let whole = render_in_bands(&stage, &camera, 100);
        assert_eq!(whole.rgb.len(), 48 * 37 * 3);
        assert!(whole == render_in_bands(&stage, &camera, 5) && whole == render_in_bands(&stage, &camera, 1));
    }

    /// Returns the colour at the centre of a picture of a red pane of an opacity before a white wall.
    fn pane_before_wall(opacity: f64) -> [u8; 3] {
        let mut scene = Scene::default();
        for (y, color, opacity) in [(0.0, [1.0, 0.0, 0.0], opacity), (1.5, [1.0; 3], 1.0)] {
            let shape = Shape { size: Vector3::new(4.0, 0.02, 4.0), color, opacity, ..Default::default() };
            scene.add(0, "pane", Isometry3::translation(0.0, y, 2.5), ObjectVariant::Shape(Box::new(shape)));
        }
        let camera = Camera {
            from: Point3::new(0.0, -2.0, 2.5),
            to: Point3::new(0.0, 0.0, 2.5),
            fov: 0.5,
            columns: 17,
            rows: 17,
        };
        let picture = render(&RenderScene::of(&scene, &Figures::default(), &camera, &[], true), &camera);
        let at = 3 * (8 * 17 + 8);
        [picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]]
    }

    #[test]
    fn translucent_surface_lets_light_through_by_opacity() {
        let linear = |c: [u8; 3]| LinearColor::of(c.map(|x| f64::from(x) / 255.0));
        let (pane, wall) = (pane_before_wall(1.0), pane_before_wall(0.0));
        assert!(pane[1] < 60 && wall[1] > 150, "{pane:?} {wall:?}");
        for opacity in [0.25, 0.6] {
            let wanted = linear(wall).mix(linear(pane), opacity).bytes();
            let seen = pane_before_wall(opacity);
            assert!(seen.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1), "{seen:?} for {wanted:?}");
        }
    }
}
