//! A frame: what is in sight is made ready, then bands of rows are drawn side by side.

use fearless_simd::Level;

use super::bands::{Cut, segments};
use super::camera::Camera;
use super::crew::{self, Sight, Work};
use super::draw::Ready;
use super::polygon::{ViewFrom, cuboid, plane};
use super::round::{Ends, Round};
use super::shade::{Shader, Surface};
use super::triangles::Triangles;
use super::{Clusters, GridCast, GridImage};
use crate::beams::{BeamScene, simd};
use crate::geometry::Form;

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
        let (ready, surfaces) = self.ready(cast, &camera, level);
        let shader = Shader::new(cast, &camera, self.targets(), &surfaces);
        let threads = rayon::current_num_threads();
        let cut = match rows {
            Some(rows) => Cut::Even(rows),
            None if threads == 1 => Cut::Even(camera.rows),
            None => Cut::Balanced { shaded: cast.want.visibility() },
        };
        let segments = segments(&ready, &camera, threads.div_ceil(2), cut);
        let (mut rest, mut buffers) = image.parts(2 * segments.len());
        let sight = Sight { ready: &ready, camera: &camera, shader: &shader, level };
        let parts = segments.iter().map(|segment| {
            let (part, after) = std::mem::take(&mut rest).split((segment.rows.1 - segment.rows.0) * camera.columns);
            let (two, others) = std::mem::take(&mut buffers).split_at_mut(2);
            (rest, buffers) = (after, others);
            (segment, part, two)
        });
        if cast.want.visibility() {
            let work: Vec<Work<'_, true>> = parts.map(|(s, part, two)| Work::new(sight, s, part, two)).collect();
            crew::run(&work);
        } else {
            let work: Vec<Work<'_, false>> = parts.map(|(s, part, two)| Work::new(sight, s, part, two)).collect();
            crew::run(&work);
        }
    }

    /// What may be seen, and what its numbers stand for. Numbers grow with the tag, then the place of the target,
    /// then the primitive: the order in which equal depths are decided.
    fn ready<'a>(&'a self, cast: &GridCast<'_>, camera: &'a Camera, level: Level) -> (Ready<'a>, Vec<Surface>) {
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
            let misses = |radius: f64| camera.misses(&view_from_form.translation, radius);
            let mut round = |shape| ready.rounds.extend(Round::new(camera, &view_from_form, shape, faces, id));
            let primitives = match &target.form {
                Form::Plane => {
                    plane(camera, &view_from_form, faces, id, &mut ready.polygons);
                    1
                }
                Form::Box { half } => {
                    if !misses(half.norm()) {
                        cuboid(camera, &view_from_form, half, faces, id, &mut ready.polygons);
                    }
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
                        ready.meshes.extend(Triangles::new(level, camera, clusters, view_from_mesh, faces, id));
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
