//! What is in sight, made ready to be drawn by all threads of the frame.

use std::ops::Range;

use fearless_simd::Level;

use super::bands::{Band, Cut, Found, Reaches, Seen, Segment};
use super::camera::Camera;
use super::jobs::Jobs;
use super::polygon::{Polygon, ViewFrom, cuboid, plane};
use super::round::{Ends, Round};
use super::shade::Surface;
use super::triangles::Triangles;
use super::{Clusters, GridCast};
use crate::BeamScene;
use tatu_geometry::Form;

/// Rows of groups that a thread looks at in one go, some microseconds; each part is one more place where bands look for
/// theirs.
const ROWS: usize = 128;
/// Surfaces that it makes ready in one go.
const SURFACES: usize = 16;

/// What may be seen, and what is still to be done before it can be drawn.
pub(super) struct Sketch<'a> {
    scene: &'a BeamScene,
    cast: &'a GridCast<'a>,
    camera: &'a Camera,
    level: Level,
    /// What numbers stand for.
    pub surfaces: Vec<Surface>,
    /// Meshes, and which of their groups may be seen.
    meshes: Vec<Triangles<'a>>,
    groups: Jobs<(u32, Range<usize>), Found>,
    /// How rows are cut for threads.
    cut: Cut,
    reaches: Reaches,
    /// All that is no mesh.
    solids: Jobs<Range<usize>, Solids>,
}

/// Surfaces that are ready.
pub(super) struct Solids {
    pub polygons: Vec<Polygon>,
    pub rounds: Vec<Round>,
}

/// All that may be seen.
pub(super) struct Ready<'a> {
    pub solids: Vec<&'a Solids>,
    found: Vec<(&'a Triangles<'a>, &'a Found)>,
    pub segments: Vec<Segment>,
}

/// A group that may be seen.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub mesh: &'a Triangles<'a>,
    pub seen: &'a Seen,
}

impl<'a> Ready<'a> {
    /// The groups that each band draws as far as its rows go.
    pub fn tall(&self) -> impl Iterator<Item = Group<'a>> {
        self.of_meshes(|found| found.tall.iter())
    }

    /// Those that are drawn once, with a band.
    pub fn of_band(&self, band: &'a Band) -> impl Iterator<Item = Group<'a>> {
        self.of_meshes(|found| found.of_band(band))
    }

    fn of_meshes<I: Iterator<Item = &'a Seen>>(&self, of: impl Fn(&'a Found) -> I) -> impl Iterator<Item = Group<'a>> {
        self.found.iter().flat_map(move |(mesh, found)| of(found).map(|seen| Group { mesh, seen }))
    }
}

impl<'a> Sketch<'a> {
    /// What may be seen. Numbers grow with the tag, then the place of the target, then the primitive: the order in which equal
    /// depths are decided.
    pub fn new(scene: &'a BeamScene, cast: &'a GridCast<'a>, camera: &'a Camera, level: Level, cut: Cut) -> Self {
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
            let primitives = match &target.form {
                Form::Plane | Form::Sphere { .. } => 1,
                Form::Box { .. } => 6,
                Form::Cylinder { .. } | Form::Capsule { .. } => 3,
                Form::Mesh { mesh, .. } => {
                    if let Some(tree) = &scene.trees[index as usize] {
                        let clusters = tree.clusters.get_or_init(|| Clusters::new(mesh, &tree.triangles));
                        let view_from_form = ViewFrom::new(camera, &target.world_from_target);
                        let view_from_mesh =
                            ViewFrom { translation: view_from_form.point(&clusters.centre), ..view_from_form };
                        meshes.extend(Triangles::new(camera, clusters, view_from_mesh, cast.faces, id));
                    }
                    mesh.triangles.len() as u32
                }
            };
            surfaces.push(Surface { first: id, target: index });
            // Beyond four thousand million triangles names would no longer be right; depths are.
            id = id.saturating_add(primitives);
        }
        let groups = meshes
            .iter()
            .zip(0..)
            .flat_map(|(triangles, mesh)| parts(triangles.groups(), ROWS).map(move |groups| (mesh, groups)));
        let (groups, solids) = (Jobs::new(groups), Jobs::new(parts(surfaces.len(), SURFACES)));
        let reaches = cut.reaches();
        Self { scene, cast, camera, level, surfaces, meshes, groups, cut, reaches, solids }
    }

    /// Does something that nobody has begun, the first or the last; `false`: there is nothing.
    pub fn assist(&self, last: bool) -> bool {
        self.groups.take(last, |groups| self.look(groups)) || self.solids.take(last, |surfaces| self.make(surfaces))
    }

    /// All of it, when there is nothing that nobody has begun.
    pub fn ready(&'a self) -> Ready<'a> {
        let solids = self.solids.made(|surfaces| self.make(surfaces)).map(|(_, solids)| solids).collect();
        let found = self.groups.made(|groups| self.look(groups));
        let found = found.map(|((mesh, _), found)| (&self.meshes[*mesh as usize], found)).collect();
        Ready { solids, found, segments: self.cut.cut(&self.reaches) }
    }

    /// Which triangles of a mesh may be seen.
    fn look(&self, (mesh, groups): &(u32, Range<usize>)) -> Found {
        let (seen, tall) = self.meshes[*mesh as usize].look(self.level, groups.clone(), &self.cut);
        self.cut.sort(seen, tall, &self.reaches)
    }

    /// Makes surfaces ready that are no meshes.
    fn make(&self, surfaces: &Range<usize>) -> Solids {
        let (mut polygons, mut rounds) = (Vec::new(), Vec::new());
        let (camera, faces) = (self.camera, self.cast.faces);
        for Surface { first: id, target } in &self.surfaces[surfaces.clone()] {
            let target = &self.scene.targets()[*target as usize];
            if matches!(target.form, Form::Mesh { .. }) {
                continue;
            }
            let view_from_form = &ViewFrom::new(camera, &target.world_from_target);
            let misses = |radius: f64| camera.misses(&view_from_form.translation, radius);
            let mut round = |shape| rounds.extend(Round::new(camera, view_from_form, shape, faces, *id));
            match &target.form {
                Form::Plane => plane(camera, view_from_form, faces, *id, &mut polygons),
                Form::Box { half } => {
                    if !misses(half.norm()) {
                        cuboid(camera, view_from_form, half, faces, *id, &mut polygons);
                    }
                }
                Form::Sphere { radius } => round((*radius, 0.0, Ends::Sphere)),
                Form::Cylinder { radius, half_length } => round((*radius, *half_length, Ends::Flat)),
                Form::Capsule { radius, half_length } => round((*radius, *half_length, Ends::Round)),
                Form::Mesh { .. } => {}
            }
        }
        Solids { polygons, rounds }
    }
}

/// Parts of so many.
fn parts(count: usize, of: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(of).map(move |from| from..count.min(from + of))
}
