//! Surfaces that may be visible, prepared by several threads for rasterisation.

use std::ops::Range;

use fearless_simd::Level;
use rayon::prelude::*;
use tatu_geometry::Form;

use super::{
    Clusters, GridCast,
    bands::Bands,
    camera::Camera,
    polygon::{Polygon, ViewFrom, cuboid, plane},
    round::{Ends, Round},
    shade::Surface,
    triangles::Triangles,
};
use crate::BeamScene;

/// Number of rows of groups per task; smaller tasks would finish before another thread could take them.
const ROWS: usize = 256;
/// Number of surfaces prepared per task.
const SURFACES: usize = 256;

/// Surfaces that may be visible, ready for rasterisation.
pub(super) struct Ready<'a> {
    /// The surfaces, each with the start of its range of primitive numbers.
    pub surfaces: Vec<Surface>,
    /// Surfaces other than meshes.
    pub solids: Vec<Solids>,
    /// Prepared meshes.
    meshes: Vec<Triangles<'a>>,
    /// Groups of the meshes that may be visible.
    found: Vec<Found>,
}

/// Prepared surfaces other than meshes.
pub(super) struct Solids {
    pub polygons: Vec<Polygon>,
    pub rounds: Vec<Round>,
}

/// Groups of a mesh that may be visible.
struct Found {
    mesh: usize,
    /// For each band, ranges of vectors as (first, end), in the order in which they are stored.
    groups: Vec<Vec<(u32, u32)>>,
}

impl<'a> Ready<'a> {
    /// Prepares the surfaces that may be visible. If the image stores the visible surface of each pixel, primitive
    /// numbers increase with the tag, then with the target's index, then with the primitive, since this order decides
    /// ties in depth.
    pub fn new(scene: &'a BeamScene, cast: &'a GridCast<'a>, camera: &'a Camera, level: Level, bands: Bands) -> Self {
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
            // Beyond 2^32 triangles, primitive numbers are no longer correct, but depths are.
            id = id.saturating_add(primitives);
        }
        let parts_of_meshes: Vec<(usize, Range<usize>)> = meshes
            .iter()
            .enumerate()
            .flat_map(|(mesh, triangles)| parts(triangles.groups(), ROWS).map(move |groups| (mesh, groups)))
            .collect();
        let look =
            |(mesh, groups): (usize, Range<usize>)| Found { mesh, groups: meshes[mesh].look(level, groups, bands) };
        let found = parts_of_meshes.into_par_iter().map(look).collect();
        let solid = |surfaces| Solids::new(scene, cast, camera, surfaces);
        let solids = surfaces.par_chunks(SURFACES).map(solid).collect();
        Self { surfaces, solids, meshes, found }
    }

    /// Returns the groups of triangles that may be in a band.
    pub fn groups(&self, band: usize) -> impl Iterator<Item = (&Triangles<'a>, (u32, u32))> {
        self.found.iter().flat_map(move |found| {
            let mesh = &self.meshes[found.mesh];
            found.groups[band].iter().map(move |sixteens| (mesh, *sixteens))
        })
    }
}

impl Solids {
    /// Prepares surfaces other than meshes.
    fn new(scene: &BeamScene, cast: &GridCast<'_>, camera: &Camera, surfaces: &[Surface]) -> Self {
        let (mut polygons, mut rounds) = (Vec::new(), Vec::new());
        let faces = cast.faces;
        for Surface { first: id, target } in surfaces {
            let target = &scene.targets()[*target as usize];
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
        Self { polygons, rounds }
    }
}

/// Splits `count` items into ranges of at most `of` items.
fn parts(count: usize, of: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(of).map(move |from| from..count.min(from + of))
}
