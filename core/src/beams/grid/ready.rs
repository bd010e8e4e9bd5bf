//! What is in sight, made ready to be drawn.
//!
//! Which triangles of a mesh may be seen is asked of all its groups, by all threads of the frame: they come while the first of
//! them makes all else ready.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use fearless_simd::Level;

use super::bands::Piece;
use super::camera::Camera;
use super::polygon::{Polygon, ViewFrom, cuboid, plane};
use super::round::{Ends, Round};
use super::shade::Surface;
use super::triangles::{Seen, Triangles};
use super::{Clusters, GridCast};
use crate::beams::BeamScene;
use crate::geometry::Form;

/// Rows of groups that a thread looks at in one go.
const ROWS: usize = 32;

/// What may be seen, and the meshes among it that nobody has looked at yet.
pub(super) struct Sketch<'a> {
    /// What numbers stand for.
    pub surfaces: Vec<Surface>,
    meshes: Vec<Triangles<'a>>,
    parts: Vec<Part>,
    /// The first part that nobody has taken.
    next: AtomicUsize,
}

/// Some groups of a mesh.
struct Part {
    mesh: u32,
    groups: Range<usize>,
    /// Which of them may be seen; `None`: nobody has looked yet.
    seen: Mutex<Option<Vec<Seen>>>,
}

/// All that may be seen.
pub(super) struct Ready<'a> {
    pub polygons: Vec<Polygon>,
    pub rounds: Vec<Round>,
    pub meshes: &'a [Triangles<'a>],
    /// What meshes have in sight: places in `meshes`, and groups.
    seen: Vec<(u32, Vec<Seen>)>,
}

impl Ready<'_> {
    /// What meshes have in sight.
    pub fn pieces(&self) -> impl Iterator<Item = Piece> {
        let piece = |mesh, seen: &Seen| Piece { mesh, sixteens: seen.sixteens, rows: seen.rows };
        self.seen.iter().flat_map(move |(mesh, all)| all.iter().map(move |seen| piece(*mesh, seen)))
    }
}

impl<'a> Sketch<'a> {
    /// What may be seen. Numbers grow with the tag, then the place of the target, then the primitive: the order in which equal
    /// depths are decided.
    pub fn new(scene: &'a BeamScene, cast: &GridCast<'_>, camera: &'a Camera) -> Self {
        let targets = scene.targets();
        let mut wanted: Vec<u32> = (0..targets.len() as u32)
            .filter(|i| {
                let target = &targets[*i as usize];
                cast.skip_group != Some(target.group) && cast.only_object.is_none_or(|object| object == target.object)
            })
            .collect();
        if cast.want.visibility() {
            wanted.sort_by_key(|i| (targets[*i as usize].object, *i));
        }
        let (mut surfaces, mut meshes) = (Vec::with_capacity(wanted.len()), Vec::new());
        let mut id = 0u32;
        for index in wanted {
            let target = &targets[index as usize];
            let view_from_form = ViewFrom::new(camera, &target.world_from_target);
            let primitives = match &target.form {
                Form::Plane | Form::Sphere { .. } => 1,
                Form::Box { .. } => 6,
                Form::Cylinder { .. } | Form::Capsule { .. } => 3,
                Form::Mesh { mesh, .. } => {
                    if let Some(tree) = &scene.trees[index as usize] {
                        let clusters = tree.clusters.get_or_init(|| Clusters::new(mesh, &tree.triangles));
                        let view_from_mesh =
                            ViewFrom { translation: view_from_form.point(&clusters.centre), ..view_from_form };
                        meshes.extend(Triangles::new(camera, clusters, view_from_mesh, cast.faces, id));
                    }
                    mesh.triangles.len() as u32
                }
            };
            surfaces.push(Surface { first: id, target: index, view_from_form });
            // Beyond four thousand million triangles names would no longer be right; depths are.
            id = id.saturating_add(primitives);
        }
        let part = |mesh, from, to| Part { mesh, groups: from..to, seen: Mutex::new(None) };
        let parts = meshes.iter().zip(0..).flat_map(|(triangles, mesh)| {
            let count = triangles.groups();
            (0..count).step_by(ROWS).map(move |from| part(mesh, from, count.min(from + ROWS)))
        });
        Sketch { parts: parts.collect(), surfaces, meshes, next: AtomicUsize::new(0) }
    }

    /// Looks at a part of a mesh that nobody has taken; `false`: there is none.
    pub fn look(&self, level: Level) -> bool {
        if self.next.load(Ordering::Relaxed) >= self.parts.len() {
            return false;
        }
        let Some(part) = self.parts.get(self.next.fetch_add(1, Ordering::Relaxed)) else { return false };
        let seen = self.meshes[part.mesh as usize].look(level, part.groups.clone());
        *part.seen.lock().unwrap_or_else(PoisonError::into_inner) = Some(seen);
        true
    }

    /// Makes the rest ready, on the thread that leads.
    pub fn finish(&'a self, scene: &BeamScene, cast: &GridCast<'_>, camera: &Camera, level: Level) -> Ready<'a> {
        let (mut polygons, mut rounds) = (Vec::new(), Vec::new());
        for Surface { first, target, view_from_form } in &self.surfaces {
            let (id, faces) = (*first, cast.faces);
            let misses = |radius: f64| camera.misses(&view_from_form.translation, radius);
            let mut round = |shape| rounds.extend(Round::new(camera, view_from_form, shape, faces, id));
            match &scene.targets()[*target as usize].form {
                Form::Plane => plane(camera, view_from_form, faces, id, &mut polygons),
                Form::Box { half } => {
                    if !misses(half.norm()) {
                        cuboid(camera, view_from_form, half, faces, id, &mut polygons);
                    }
                }
                Form::Sphere { radius } => round((*radius, 0.0, Ends::Sphere)),
                Form::Cylinder { radius, half_length } => round((*radius, *half_length, Ends::Flat)),
                Form::Capsule { radius, half_length } => round((*radius, *half_length, Ends::Round)),
                Form::Mesh { .. } => {}
            }
        }
        while self.look(level) {}
        let seen = |part: &Part| {
            let take = || part.seen.lock().unwrap_or_else(PoisonError::into_inner).take();
            // Another thread is about to be done with it; if it takes long, it is done here once more.
            let mut seen = None;
            super::crew::look_for(|| {
                seen = take();
                seen.is_some()
            });
            seen.unwrap_or_else(|| self.meshes[part.mesh as usize].look(level, part.groups.clone()))
        };
        let seen = self.parts.iter().map(|part| (part.mesh, seen(part))).collect();
        Ready { polygons, rounds, meshes: &self.meshes, seen }
    }
}
