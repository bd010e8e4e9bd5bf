//! A frame: what is in sight is made ready, then bands of rows are drawn side by side.

use fearless_simd::Level;
use rayon::prelude::*;

use super::camera::Camera;
use super::draw::Ready;
use super::image::Part;
use super::polygon::{ViewFrom, cuboid, plane};
use super::raster::{Buffer, Raster};
use super::round::{Ends, Round};
use super::shade::{Shader, Surface};
use super::triangles::Triangles;
use super::{Clusters, GridCast, GridImage};
use crate::beams::{BeamScene, simd};
use crate::geometry::Form;

/// Bands per thread when they are drawn side by side, so that those with much in them even out.
const BANDS: usize = 8;
/// Least rows of a band: what crosses a border is made ready twice.
const LEAST_ROWS: usize = 16;

impl BeamScene {
    /// Takes an image, on rayon's current pool.
    ///
    /// The image depends only on the cast and the targets: not on the number of threads, the processor or earlier
    /// images. A camera that can see nothing (no pixels, no range, an angle or a pose that is none) gives an image
    /// of nothing. Costs time for each target, pixel and triangle in sight.
    pub fn render(&self, cast: &GridCast<'_>, image: &mut GridImage) {
        let threads = rayon::current_num_threads();
        let band =
            if threads == 1 { usize::MAX } else { (cast.grid.rows as usize / (threads * BANDS)).max(LEAST_ROWS) };
        self.render_by(cast, image, simd::level(), band);
    }

    /// The same with given instructions and rows of a band.
    pub(super) fn render_by(&self, cast: &GridCast<'_>, image: &mut GridImage, level: Level, band: usize) {
        image.prepare(cast);
        let Some(camera) = Camera::new(cast.grid, &cast.world_from_sensor) else {
            image.depth.fill(f32::INFINITY);
            image.split(usize::MAX).for_each(|mut part| part.clear(cast.light.sky_bytes()));
            return;
        };
        let (ready, surfaces) = self.ready(cast, &camera);
        let band = band.min(camera.rows);
        let mut bands = std::mem::take(&mut image.bands);
        bands.resize_with(camera.rows.div_ceil(band), Buffer::default);
        let shader = Shader::new(cast, &camera, self.targets(), &surfaces);
        let parts = image.split(band * camera.columns).zip(&mut bands).enumerate();
        let draw = |(index, (mut part, buffer)): (usize, (Part<'_>, &mut Buffer))| {
            let first = index * band;
            if cast.want.visibility() {
                let raster: Raster<'_, true> = ready.draw(level, &camera, buffer, first, part.depth);
                shader.shade(&raster, &mut part);
            } else {
                let _: Raster<'_, false> = ready.draw(level, &camera, buffer, first, part.depth);
            }
        };
        if band == camera.rows {
            parts.for_each(draw);
        } else {
            let parts: Vec<_> = parts.collect();
            parts.into_par_iter().with_max_len(1).for_each(draw);
        }
        image.bands = bands;
    }

    /// What may be seen, and what its numbers stand for. Numbers grow with the tag, then the place of the target,
    /// then the primitive: the order in which equal depths are decided.
    fn ready<'a>(&'a self, cast: &GridCast<'_>, camera: &'a Camera) -> (Ready<'a>, Vec<Surface>) {
        let targets = self.targets();
        let mut wanted: Vec<u32> = (0..targets.len() as u32)
            .filter(|i| {
                let target = &targets[*i as usize];
                cast.skip_group != Some(target.group) && cast.only_object.is_none_or(|object| object == target.object)
            })
            .collect();
        if cast.want.visibility() {
            wanted.sort_by_key(|i| (targets[*i as usize].object, *i));
        }
        let (mut ready, mut surfaces) = (Ready::default(), Vec::with_capacity(wanted.len()));
        let mut id = 0u32;
        for index in wanted {
            let target = &targets[index as usize];
            let view_from_form = ViewFrom::new(camera, &target.world_from_target);
            let faces = cast.faces;
            let mut round = |shape| ready.rounds.extend(Round::new(camera, &view_from_form, shape, faces, id));
            let primitives = match &target.form {
                Form::Plane => {
                    plane(camera, &view_from_form, faces, id, &mut ready.polygons);
                    1
                }
                Form::Box { half } => {
                    cuboid(camera, &view_from_form, half, faces, id, &mut ready.polygons);
                    6
                }
                Form::Sphere { radius } => {
                    round((*radius, 0.0, Ends::Sphere));
                    1
                }
                Form::Cylinder { radius, half_length } => {
                    round((*radius, *half_length, Ends::Flat));
                    3
                }
                Form::Capsule { radius, half_length } => {
                    round((*radius, *half_length, Ends::Round));
                    3
                }
                Form::Mesh { mesh, .. } => {
                    if let Some(tree) = &self.trees[index as usize] {
                        let clusters = tree.clusters.get_or_init(|| Clusters::new(mesh, &tree.triangles));
                        let view_from_mesh =
                            ViewFrom { translation: view_from_form.point(&clusters.centre), ..view_from_form };
                        ready.meshes.extend(Triangles::new(camera, clusters, view_from_mesh, faces, id));
                    }
                    mesh.triangles.len() as u32
                }
            };
            surfaces.push(Surface { first: id, target: index, view_from_form });
            // Beyond four thousand million triangles names would no longer be right; depths are.
            id = id.saturating_add(primitives);
        }
        (ready, surfaces)
    }
}
