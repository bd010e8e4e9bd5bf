//! Surfaces that may be visible, prepared by several threads for rasterisation.

use std::ops::Range;

use fearless_simd::Level;
use rayon::prelude::*;
use tatu_geometry::Form;

use super::{
    GridCast, MeshClusters,
    bands::RowBands,
    camera::GridCamera,
    polygon::{Polygon, ViewTransform, add_box, add_plane},
    round::{RoundEnds, RoundForm},
    shade::TargetSurface,
    triangles::PreparedMesh,
};
use crate::BeamScene;

/// Number of rows of groups per task; smaller tasks would finish before another thread could start them.
const GROUP_ROWS_PER_TASK: usize = 256;
/// Number of surfaces prepared per task.
const SURFACES_PER_TASK: usize = 256;

/// Surfaces that may be visible, ready for rasterisation.
pub(super) struct PreparedSurfaces<'a> {
    /// The surfaces, each with the start of its range of primitive numbers.
    pub surfaces: Vec<TargetSurface>,
    /// Surfaces other than meshes.
    pub solids: Vec<PreparedSolids>,
    meshes: Vec<PreparedMesh<'a>>,
    /// Groups of the meshes that may be visible.
    mesh_groups: Vec<VisibleGroups>,
}

/// Prepared surfaces other than meshes.
pub(super) struct PreparedSolids {
    pub polygons: Vec<Polygon>,
    pub rounds: Vec<RoundForm>,
}

/// Groups of a mesh that may be visible.
struct VisibleGroups {
    mesh: usize,
    /// For each band, ranges of vectors as (first, end), in the order in which they are stored.
    groups: Vec<Vec<(u32, u32)>>,
}

impl<'a> PreparedSurfaces<'a> {
    /// Prepares the surfaces that may be visible. If the image stores the visible surface of each pixel, primitive
    /// numbers increase with the tag, then with the target's index, then with the primitive, since this order decides
    /// ties in depth.
    pub fn new(
        scene: &'a BeamScene,
        cast: &'a GridCast<'a>,
        camera: &'a GridCamera,
        level: Level,
        bands: RowBands,
    ) -> Self {
        let targets = scene.targets();
        let mut wanted: Vec<u32> = (0..targets.len() as u32)
            .filter(|i| {
                let target = &targets[*i as usize];
                cast.skip_group != Some(target.group) && cast.only_object.is_none_or(|object| object == target.object)
            })
            .collect();
        if cast.outputs.needs_surface_ids() {
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
                        let clusters = tree.clusters.get_or_init(|| MeshClusters::new(mesh, &tree.triangles));
                        let view_from_form = ViewTransform::new(camera, &target.world_from_target);
                        let view_from_mesh =
                            ViewTransform { translation: view_from_form.point(&clusters.centre), ..view_from_form };
                        meshes.extend(PreparedMesh::new(camera, clusters, view_from_mesh, cast.faces, id));
                    }
                    mesh.triangles.len() as u32
                }
            };
            surfaces.push(TargetSurface { first: id, target: index });
            // Beyond 2^32 triangles, primitive numbers are no longer correct, but depths are.
            id = id.saturating_add(primitives);
        }
        let parts_of_meshes: Vec<(usize, Range<usize>)> = meshes
            .iter()
            .enumerate()
            .flat_map(|(mesh, triangles)| {
                parts(triangles.group_row_count(), GROUP_ROWS_PER_TASK).map(move |groups| (mesh, groups))
            })
            .collect();
        let look = |(mesh, groups): (usize, Range<usize>)| VisibleGroups {
            mesh,
            groups: meshes[mesh].find_visible(level, groups, bands),
        };
        let found = parts_of_meshes.into_par_iter().map(look).collect();
        let solid = |surfaces| PreparedSolids::new(scene, cast, camera, surfaces);
        let solids = surfaces.par_chunks(SURFACES_PER_TASK).map(solid).collect();
        Self { surfaces, solids, meshes, mesh_groups: found }
    }

    /// Returns the groups of triangles that may be in a band.
    pub fn groups(&self, band: usize) -> impl Iterator<Item = (&PreparedMesh<'a>, (u32, u32))> {
        self.mesh_groups.iter().flat_map(move |found| {
            let mesh = &self.meshes[found.mesh];
            found.groups[band].iter().map(move |sixteens| (mesh, *sixteens))
        })
    }
}

impl PreparedSolids {
    /// Prepares surfaces other than meshes.
    fn new(scene: &BeamScene, cast: &GridCast<'_>, camera: &GridCamera, surfaces: &[TargetSurface]) -> Self {
        let (mut polygons, mut rounds) = (Vec::new(), Vec::new());
        let faces = cast.faces;
        for TargetSurface { first: id, target } in surfaces {
            let target = &scene.targets()[*target as usize];
            if matches!(target.form, Form::Mesh { .. }) {
                continue;
            }
            let view_from_form = &ViewTransform::new(camera, &target.world_from_target);
            let misses = |radius: f64| camera.misses(&view_from_form.translation, radius);
            let mut round = |shape| rounds.extend(RoundForm::new(camera, view_from_form, shape, faces, *id));
            match &target.form {
                Form::Plane => add_plane(camera, view_from_form, faces, *id, &mut polygons),
                Form::Box { half } => {
                    if !misses(half.norm()) {
                        add_box(camera, view_from_form, half, faces, *id, &mut polygons);
                    }
                }
                Form::Sphere { radius } => round((*radius, 0.0, RoundEnds::Sphere)),
                Form::Cylinder { radius, half_length } => round((*radius, *half_length, RoundEnds::Flat)),
                Form::Capsule { radius, half_length } => round((*radius, *half_length, RoundEnds::Round)),
                Form::Mesh { .. } => {}
            }
        }
        Self { polygons, rounds }
    }
}

/// Splits `count` items into ranges of at most `of` items.
fn parts(count: usize, of: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(of).map(move |from| from..count.min(from + of))
}
