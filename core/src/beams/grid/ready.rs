//! What is in sight, made ready to be drawn by all threads of the frame.

use std::ops::Range;

use fearless_simd::Level;

use super::bands::{Cut, Piece, Segment, segments};
use super::camera::Camera;
use super::jobs::Jobs;
use super::polygon::{Polygon, ViewFrom, cuboid, plane};
use super::round::{Ends, Round};
use super::shade::Surface;
use super::triangles::{Seen, Triangles};
use super::{Clusters, GridCast};
use crate::beams::BeamScene;
use crate::geometry::Form;

/// Rows of groups that a thread looks at in one go.
const ROWS: usize = 32;
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
    groups: Jobs<(u32, Range<usize>), Vec<Seen>>,
    /// How rows are cut for threads, and what comes of it, once all groups are taken.
    cut: (usize, Cut),
    segments: Jobs<(), Vec<Segment>>,
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
    pub meshes: &'a [Triangles<'a>],
    pub segments: Vec<&'a Segment>,
}

impl<'a> Sketch<'a> {
    /// What may be seen. Numbers grow with the tag, then the place of the target, then the primitive: the order in which equal
    /// depths are decided. Rows will be cut into so many segments.
    pub fn new(
        scene: &'a BeamScene,
        cast: &'a GridCast<'a>,
        camera: &'a Camera,
        level: Level,
        cut: (usize, Cut),
    ) -> Self {
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
        let groups = meshes
            .iter()
            .zip(0..)
            .flat_map(|(triangles, mesh)| parts(triangles.groups(), ROWS).map(move |groups| (mesh, groups)));
        let (groups, solids) = (Jobs::new(groups), Jobs::new(parts(surfaces.len(), SURFACES)));
        let segments = Jobs::new([()]);
        Self { scene, cast, camera, level, surfaces, meshes, groups, cut, segments, solids }
    }

    /// Does something that nobody has begun; `false`: there is nothing.
    pub fn assist(&self) -> bool {
        self.groups.take(|groups| self.look(groups))
            || self.segments.take(|()| self.cut_rows())
            || self.solids.take(|surfaces| self.make(surfaces))
    }

    /// All of it, when there is nothing that nobody has begun.
    pub fn ready(&'a self) -> Ready<'a> {
        let solids = self.solids.made(|surfaces| self.make(surfaces)).map(|(_, solids)| solids).collect();
        let segments = self.segments.made(|()| self.cut_rows()).flat_map(|(_, segments)| segments).collect();
        Ready { solids, meshes: &self.meshes, segments }
    }

    /// Which triangles of a mesh may be seen.
    fn look(&self, (mesh, groups): &(u32, Range<usize>)) -> Vec<Seen> {
        let closely = !self.cut.1.is_one_band(self.camera.rows);
        self.meshes[*mesh as usize].look(self.level, groups.clone(), closely)
    }

    /// Cuts the image for the threads.
    fn cut_rows(&self) -> Vec<Segment> {
        let mut pieces = Vec::new();
        for ((mesh, _), seen) in self.groups.made(|groups| self.look(groups)) {
            let piece = |seen: &Seen| Piece { mesh: *mesh, sixteens: seen.sixteens, rows: seen.rows };
            pieces.extend(seen.iter().map(piece));
        }
        segments(pieces, self.camera, self.cut)
    }

    /// Makes surfaces ready that are no meshes.
    fn make(&self, surfaces: &Range<usize>) -> Solids {
        let (mut polygons, mut rounds) = (Vec::new(), Vec::new());
        let (camera, faces) = (self.camera, self.cast.faces);
        for Surface { first: id, target, view_from_form } in &self.surfaces[surfaces.clone()] {
            let misses = |radius: f64| camera.misses(&view_from_form.translation, radius);
            let mut round = |shape| rounds.extend(Round::new(camera, view_from_form, shape, faces, *id));
            match &self.scene.targets()[*target as usize].form {
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
