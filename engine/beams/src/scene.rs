//! All detectable targets of a scene, and the casting of many beams against them.

use std::{collections::HashMap, sync::Arc};

use nalgebra::{Isometry3, Point3, Vector3};
use rayon::prelude::*;
use tatu_geometry::{Form, Mesh, Texture};

use super::{
    aabb::Aabb,
    beam::{Beam, Hit},
    candidates::{self, Candidates},
    convex,
    mesh::MeshTree,
    probe::Probe,
    ray,
    sight::FormHit,
    solid,
    tree::BoxTree,
};

/// One form that beams can hit. An object with several forms has several targets with the same tag.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamTarget {
    /// Tag chosen by the caller and returned in hits.
    pub object: u64,
    /// Group that is compared with [`Beam::skip_group`], for example the model to which the target belongs.
    pub group: u32,
    /// Pose of the form in the world frame.
    pub world_from_target: Isometry3<f64>,
    /// The form, in the target's frame.
    pub form: Form,
    /// Colour in full light: red, green and blue, each 0 to 1.
    pub color: [f32; 3],
    /// Opacity in images: 0 is invisible, 1 opaque. Distances do not depend on it.
    pub opacity: f32,
    /// The texture of the form, in its frame.
    pub texture: Option<Arc<Texture>>,
}

/// Number of beams per task of the thread pool.
const BEAMS_PER_TASK: usize = 64;
/// If fewer than one in `PARTIAL_REFIT_RATIO` targets move, only the ancestors of each moved target are refitted;
/// otherwise the whole tree is.
const PARTIAL_REFIT_RATIO: usize = 8;
/// Number of moved targets per task of the thread pool.
const MOVES_PER_TASK: usize = 256;

/// The set of targets that beams are cast against.
///
/// The hit of a beam depends only on the beam and the targets, not on the other beams, the number of threads or earlier
/// poses.
#[derive(Debug, Default)]
pub struct BeamScene {
    pub(super) targets: Vec<BeamTarget>,
    /// Number of targets with an opacity of less than 1.
    translucent: usize,
    /// Triangle tree of each target; `None` unless its form is a mesh.
    pub(super) trees: Vec<Option<Arc<MeshTree>>>,
    /// The meshes in use, by address. Keeping a reference to each mesh prevents its address from being reused.
    pub(super) meshes: HashMap<usize, (Arc<Mesh>, Arc<MeshTree>)>,
    /// Bounding box of each target in the world frame; empty for an unbounded form and for an invalid pose or size.
    boxes: Vec<Aabb>,
    /// Targets with an unbounded form, tested for every beam.
    pub(super) unbounded: Vec<u32>,
    /// Bounding sphere of each target; unspecified for an unbounded form.
    pub(super) balls: Vec<BoundingBall>,
    pub(super) top: BoxTree,
    /// Buffer reused by each update: bounds of the moved targets at their new poses.
    moved_bounds: Vec<(Aabb, BoundingBall)>,
}

/// Centre and radius.
type BoundingBall = (Vector3<f64>, f64);

impl BeamScene {
    /// Replaces all targets. The trees of meshes that were already present are reused.
    pub fn set(&mut self, targets: impl IntoIterator<Item = BeamTarget>) {
        self.targets.clear();
        self.targets.extend(targets);
        self.translucent = self.targets.iter().filter(|t| t.opacity < 1.0).count();
        let mut before = std::mem::take(&mut self.meshes);
        self.trees.clear();
        for target in &self.targets {
            let Form::Mesh { mesh, .. } = &target.form else {
                self.trees.push(None);
                continue;
            };
            let address = Arc::as_ptr(mesh) as usize;
            let (_, tree) = self.meshes.entry(address).or_insert_with(|| {
                before.remove(&address).unwrap_or_else(|| (mesh.clone(), Arc::new(MeshTree::new(mesh))))
            });
            self.trees.push(Some(tree.clone()));
        }

        self.unbounded.clear();
        self.unbounded
            .extend((0..self.targets.len() as u32).filter(|&i| matches!(self.targets[i as usize].form, Form::Plane)));
        self.boxes.clear();
        self.balls.clear();
        for (index, target) in self.targets.iter().enumerate() {
            let (aabb, ball) = self.bounds_at(index, &target.world_from_target);
            self.boxes.push(aabb);
            self.balls.push(ball);
        }
        self.rebuild();
    }

    /// Returns the targets in the order in which they were set.
    pub fn targets(&self) -> &[BeamTarget] {
        &self.targets
    }

    /// Moves targets, which are given by their indices in [`targets`](Self::targets). The time per target is
    /// proportional to the depth of the tree; if many targets move, the whole tree is refitted once instead. Long lists
    /// are processed in rayon's current pool.
    ///
    /// # Panics
    /// Panics if an index is out of range.
    pub fn update_poses(&mut self, poses: &[(usize, Isometry3<f64>)]) {
        let mut around = std::mem::take(&mut self.moved_bounds);
        if poses.len() <= MOVES_PER_TASK {
            around.extend(poses.iter().map(|(index, pose)| self.bounds_at(*index, pose)));
        } else {
            let all = poses.par_iter().with_min_len(MOVES_PER_TASK).map(|(index, pose)| self.bounds_at(*index, pose));
            all.collect_into_vec(&mut around);
        }
        let mut changed = false;
        for ((index, pose), around) in poses.iter().zip(around.drain(..)) {
            changed |= self.set_pose(*index, pose, around);
        }
        self.moved_bounds = around;
        if changed {
            self.rebuild();
        } else if poses.len() * PARTIAL_REFIT_RATIO < self.targets.len() {
            poses.iter().for_each(|(index, _)| self.top.update(*index as u32, &self.boxes));
        } else {
            self.top.refit(&self.boxes);
        }
        if self.top.needs_rebuild() {
            self.rebuild();
        }
    }

    /// Moves one target, in time proportional to the depth of the tree.
    ///
    /// # Panics
    /// Panics if the index is out of range.
    pub fn update_pose(&mut self, index: usize, pose: Isometry3<f64>) {
        self.update_poses(&[(index, pose)]);
    }

    /// Stores the pose and the bounds of a target. Returns whether the tree must be rebuilt because the target has
    /// gained or lost valid bounds.
    fn set_pose(&mut self, index: usize, pose: &Isometry3<f64>, (aabb, ball): (Aabb, BoundingBall)) -> bool {
        self.targets[index].world_from_target = *pose;
        self.boxes[index] = aabb;
        self.balls[index] = ball;
        aabb.is_valid() != self.top.contains(index as u32)
    }

    /// Sets the colour and the opacity of a target, given by its index in [`targets`](Self::targets).
    ///
    /// # Panics
    /// Panics if the index is out of range.
    pub fn set_color(&mut self, index: usize, color: [f32; 3], opacity: f32) {
        let target = &mut self.targets[index];
        self.translucent += usize::from(opacity < 1.0);
        self.translucent -= usize::from(target.opacity < 1.0);
        (target.color, target.opacity) = (color, opacity);
    }

    /// Returns whether any target is translucent. If none is, colours are those of the nearest surfaces.
    pub fn has_translucent_targets(&self) -> bool {
        self.translucent > 0
    }

    /// Casts `beams` in rayon's current pool; `hits[i]` receives the result of `beams[i]`.
    ///
    /// # Panics
    /// Panics if the lengths of `beams` and `hits` differ.
    pub fn cast(&self, beams: &[Beam], hits: &mut [Hit]) {
        assert_eq!(beams.len(), hits.len(), "`hits` must have one element per beam");
        if beams.len() <= BEAMS_PER_TASK {
            return self.cast_here(beams, hits);
        }
        beams
            .par_chunks(BEAMS_PER_TASK)
            .zip(hits.par_chunks_mut(BEAMS_PER_TASK))
            .for_each(|(beams, hits)| self.cast_here(beams, hits));
    }

    /// Casts beams like [`cast`](Self::cast), but on the current thread.
    pub fn cast_here(&self, beams: &[Beam], hits: &mut [Hit]) {
        let mut done = 0;
        while done < beams.len() {
            let Some((n, space)) = candidates::leading_group(&beams[done..]) else {
                hits[done] = self.cast_one(&beams[done]);
                done += 1;
                continue;
            };
            let near = self.collect_candidates(&space, beams[done].skip_group);
            for (beam, hit) in beams[done..done + n].iter().zip(&mut hits[done..]) {
                *hit = self.cast_among(beam, near.as_ref());
            }
            done += n;
        }
    }

    /// Collects the targets in a region, except those of the group to skip; returns `None` if there are too many.
    fn collect_candidates(&self, space: &Aabb, skip_group: Option<u32>) -> Option<Candidates> {
        Candidates::of(&self.top, &self.boxes, space, |index| skip_group != Some(self.targets[index as usize].group))
    }

    /// Casts one beam.
    pub fn cast_one(&self, beam: &Beam) -> Hit {
        self.cast_among(beam, None)
    }

    /// Casts a beam against the given candidates, or against all targets if `near` is `None`.
    fn cast_among(&self, beam: &Beam, near: Option<&Candidates>) -> Hit {
        let mut best: Option<(FormHit, u32)> = None;
        for piece in 0..convex::pieces(&beam.volume) {
            if let Some(probe) = Probe::new(beam, piece) {
                self.cast_probe(beam, &probe, near, &mut best);
            }
        }
        best.map_or(Hit::NONE, |(found, index)| self.hit(beam, &found, index as usize))
    }

    /// Updates `best` with the nearest admissible point for one piece of a beam.
    fn cast_probe(&self, beam: &Beam, probe: &Probe, near: Option<&Candidates>, best: &mut Option<(FormHit, u32)>) {
        let mut limit = best.as_ref().map_or(probe.far(), |(found, _)| found.distance.min(probe.far()));
        let mut visit = |index: u32, limit: f64| {
            if self.is_considered(beam, index)
                && let Some(found) = self.cast_at(index as usize, probe, limit)
            {
                let rank = |found: &FormHit, index: u32| {
                    (found.distance, self.targets[index as usize].object, found.primitive, index)
                };
                if best.as_ref().is_none_or(|(old, at)| rank(&found, index) < rank(old, *at)) {
                    *best = Some((found, index));
                }
            }
            best.as_ref().map_or(limit, |(found, _)| found.distance)
        };
        for &index in &self.unbounded {
            limit = visit(index, limit);
        }
        match near {
            Some(near) => near.walk(probe, limit, visit),
            None => self.top.walk(probe, limit, |place, limit| visit(self.top.order[place], limit)),
        }
    }

    /// Returns whether a beam considers a target at all.
    pub(super) fn is_considered(&self, beam: &Beam, index: u32) -> bool {
        let target = &self.targets[index as usize];
        beam.skip_group != Some(target.group) && beam.only_object.is_none_or(|object| object == target.object)
    }

    /// Returns the nearest admissible point of one target, at most `limit` metres away, in the frame of the target.
    pub(super) fn cast_at(&self, index: usize, probe: &Probe, limit: f64) -> Option<FormHit> {
        let BeamTarget { world_from_target, form, .. } = &self.targets[index];
        match (&self.trees[index], probe) {
            (Some(tree), probe) => tree.cast(&probe.in_form(world_from_target, limit)),
            (None, Probe::Ray(sight)) => ray::cast(&sight.in_form(world_from_target, limit), form),
            (None, Probe::Cone(cone)) => solid::cast(&cone.in_form(world_from_target, limit), form),
            (None, Probe::Convex(space)) => convex::cast(&space.in_form(world_from_target, limit), form),
        }
    }

    /// Converts a point found on a target to the hit that the beam reports.
    pub(super) fn hit(&self, beam: &Beam, found: &FormHit, index: usize) -> Hit {
        let target = &self.targets[index];
        let beam_from_target = beam.world_from_beam.rotation.inverse() * target.world_from_target.rotation;
        let facing = if found.normal.dot(&found.point) > 0.0 { -found.normal } else { found.normal };
        Hit {
            distance: found.distance,
            point: Point3::from(beam_from_target * found.point),
            normal: beam_from_target * facing,
            object: target.object,
            primitive: found.primitive,
        }
    }

    /// Returns the bounding box and the bounding sphere of a target at a pose.
    fn bounds_at(&self, index: usize, pose: &Isometry3<f64>) -> (Aabb, BoundingBall) {
        (self.box_of(index, pose), self.ball_of(index, pose))
    }

    /// Returns the bounding box of a target, which is empty for an unbounded form and if the pose or the size is not
    /// finite.
    fn box_of(&self, index: usize, pose: &Isometry3<f64>) -> Aabb {
        let aabb = match &self.trees[index] {
            Some(tree) => tree.aabb.transformed(pose),
            None => Aabb::of_form(&self.targets[index].form, pose).unwrap_or(Aabb::EMPTY),
        };
        if aabb.is_valid() { aabb } else { Aabb::EMPTY }
    }

    fn ball_of(&self, index: usize, pose: &Isometry3<f64>) -> BoundingBall {
        let radius = match &self.targets[index].form {
            Form::Plane => f64::INFINITY,
            Form::Box { half } => half.norm(),
            Form::Sphere { radius } => *radius,
            Form::Cylinder { radius, half_length } => crate::length(*radius, *half_length),
            Form::Capsule { radius, half_length } => radius + half_length,
            Form::Mesh { .. } => {
                let aabb = self.trees[index].as_ref().map_or(Aabb::EMPTY, |tree| tree.aabb);
                return ((pose * Point3::from(aabb.centre())).coords, 0.5 * (aabb.high - aabb.low).norm());
            }
        };
        (pose.translation.vector, radius)
    }

    fn rebuild(&mut self) {
        let bounded = (0..self.targets.len() as u32).filter(|&i| self.boxes[i as usize].is_valid());
        self.top.build(bounded, &self.boxes, 2);
    }
}
