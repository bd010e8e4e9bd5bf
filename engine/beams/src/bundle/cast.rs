//! Traversal of the targets for the packets of a part.

use fearless_simd::{Level, prelude::*};
use nalgebra::{Matrix3, Vector3};
use tatu_geometry::Form;

use super::{
    BundleCast, BundleHits, finish,
    forms::{AnalyticForm, BoxForm, CapsuleForm, CylinderForm, PlaneForm, SphereForm},
    lanes::{FloatLanes, MaskLanes, UintLanes, VectorLanes, rows, splat, to_f32},
    mesh,
    pack::{BoundingCones, BundlePart, GROUPS, LANES, LaneArray},
    packet::{CastLimits, NO_TARGET, PacketHits, PartHits},
};
use crate::{BeamScene, simd::dispatch, tree::QuadNode};

/// Factor of `(distance + size of the target) / cosine of the incidence` that gives the error of a distance, relative
/// to the tolerance: a few rounding errors of 6e-8 each in a rotation, divided by 3e-5 m.
const DISTANCE_ERROR_FACTOR: f32 = 2.5e-7 / 3e-5;

/// Casts the rays of a part of a bundle.
pub(super) fn cast_part(scene: &BeamScene, level: Level, cast: &BundleCast<'_>, index: usize, hits: BundleHits<'_>) {
    let part = &cast.bundle.parts()[index];
    let pose = &cast.world_from_sensor;
    let placed = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
    let Some(limits) = CastLimits::new(cast).filter(|_| placed) else {
        return finish::clear_hits(hits);
    };
    let mut seen = PartHits::new(part, limits.far);
    dispatch!(level, simd => walk(simd, scene, cast, part, &limits, &mut seen));
    finish::write_hits(scene, cast, part, &seen, hits);
}

/// The inputs shared by the visits of all targets.
struct PartTraversal<'a> {
    scene: &'a BeamScene,
    cast: &'a BundleCast<'a>,
    part: &'a BundlePart,
    limits: &'a CastLimits,
    sensor_from_world: Matrix3<f64>,
    origin: Vector3<f64>,
}

/// The bounding ball of a target relative to the sensor, prepared for tests against many cones at once.
struct BallOutline {
    centre: [f32; 3],
    /// Cosine and sine of the angle between the centre and the rim, times the distance of the centre.
    cos: f32,
    sin: f32,
    /// Margin for rounding errors.
    slack: f32,
    /// Lower bound of the distance to the ball.
    bound: f32,
}

impl BallOutline {
    #[inline(always)]
    fn new(centre: &Vector3<f64>, radius: f64) -> Self {
        let away = centre.norm();
        let radius = radius * (1.0 + 1e-6) + 1e-6;
        let power = away * away - radius * radius;
        let (cos, sin) = if power > 0.0 { (power.sqrt() as f32, radius as f32) } else { (-1e30, 1e30) };
        let bound = ((away - radius) * (1.0 - 1e-6) - 1e-5).max(0.0) as f32;
        Self { centre: to_f32(centre), cos, sin, slack: away as f32 * 2e-6, bound }
    }

    /// Returns the lanes of cones that may contain a part of the ball nearer than the hits so far.
    #[inline(always)]
    fn seen_by<S: Simd>(&self, simd: S, cones: &BoundingCones, far: &LaneArray) -> u64 {
        let axis = VectorLanes { x: cones.x.load(simd), y: cones.y.load(simd), z: cones.z.load(simd) };
        // The ball may be visible if the angle between the cone's axis and the ball's centre is at most the sum of the
        // two half angles.
        let rim = cones.cos.load(simd) * self.cos - cones.sin.load(simd) * self.sin - self.slack;
        let misses = axis.dot(&self.centre).simd_lt(rim);
        let open = far.load(simd).simd_ge(splat(simd, self.bound));
        (open & !misses).to_bitmask()
    }
}

#[inline(always)]
fn walk<S: Simd>(
    simd: S,
    scene: &BeamScene,
    cast: &BundleCast<'_>,
    part: &BundlePart,
    limits: &CastLimits,
    seen: &mut PartHits,
) {
    let pose = &cast.world_from_sensor;
    let walk = PartTraversal {
        scene,
        cast,
        part,
        limits,
        sensor_from_world: pose.rotation.to_rotation_matrix().matrix().transpose(),
        origin: pose.translation.vector,
    };
    let mut all = [0; GROUPS];
    for packet in 0..part.packets.len() {
        all[packet / LANES] |= 1 << (packet % LANES);
    }
    for &index in &scene.unbounded {
        walk.test_plane(simd, index, &all, seen);
    }
    scene.top.walk_with_bounds(
        walk.reach(simd, seen),
        #[inline(always)]
        |quad: &QuadNode, _| quad.distances(&walk.origin),
        #[inline(always)]
        |place, limit| {
            if walk.visit(simd, scene.top.order[place], seen) { walk.reach(simd, seen) } else { limit }
        },
    );
}

impl PartTraversal<'_> {
    /// Returns the largest distance at which a hit could still change the result.
    #[inline(always)]
    fn reach<S: Simd>(&self, simd: S, seen: &PartHits) -> f64 {
        f64::from(seen.group_far.load(simd).reduce_max()) * (1.0 + 1e-5) + 1e-5
    }

    /// Tests a bounded target against all packets whose rays may hit it; returns whether it was hit.
    #[inline(always)]
    fn visit<S: Simd>(&self, simd: S, index: u32, seen: &mut PartHits) -> bool {
        let (centre, radius) = self.scene.balls[index as usize];
        let disc = BallOutline::new(&(self.sensor_from_world * (centre - self.origin)), radius);
        let mut packets = [0; GROUPS];
        let mut groups = disc.seen_by(simd, &self.part.groups, &seen.group_far);
        let mut any = 0;
        while groups != 0 {
            let group = groups.trailing_zeros() as usize;
            groups &= groups - 1;
            packets[group] = disc.seen_by(simd, &self.part.cones[group], &seen.far[group]) as u32;
            any |= packets[group];
        }
        any != 0 && self.test_target(simd, index, &packets, disc.bound, seen)
    }

    /// Returns a target's form and frame, unless it is excluded.
    fn frame(&self, index: u32) -> Option<TargetFrame<'_>> {
        let target = &self.scene.targets[index as usize];
        let wanted = self.cast.skip_group != Some(target.group)
            && self.cast.only_object.is_none_or(|object| object == target.object);
        if !wanted {
            return None;
        }
        let pose = &target.world_from_target;
        let turn = pose.rotation.inverse() * self.cast.world_from_sensor.rotation;
        let turn = rows(turn.to_rotation_matrix().matrix());
        let origin = pose.rotation.inverse_transform_vector(&(self.origin - pose.translation.vector));
        Some(TargetFrame { form: &target.form, turn, origin })
    }

    #[inline(always)]
    fn test_plane<S: Simd>(&self, simd: S, index: u32, packets: &[u32; GROUPS], seen: &mut PartHits) {
        if let Some(TargetFrame { turn, origin, .. }) = self.frame(index) {
            let height = origin.z as f32;
            let meet = TargetTest { walk: self, index, turn, size: height.abs(), bound: 0.0 };
            meet.test_form(simd, &PlaneForm { height }, packets, seen);
        }
    }

    /// Tests packets against a target's form.
    #[inline(always)]
    fn test_target<S: Simd>(
        &self,
        simd: S,
        index: u32,
        packets: &[u32; GROUPS],
        bound: f32,
        seen: &mut PartHits,
    ) -> bool {
        let Some(TargetFrame { form, turn, origin }) = self.frame(index) else { return false };
        let mut meet = TargetTest { walk: self, index, turn, size: 0.0, bound };
        match form {
            Form::Plane => false,
            Form::Box { half } => {
                meet.size = (origin.abs() + half).max() as f32;
                let least = (origin.abs() - half).map(|x| x.max(0.0)).norm();
                meet.bound = meet.bound.max((least * (1.0 - 1e-6) - 1e-5) as f32);
                let form = BoxForm { low: to_f32(&(-half - origin)), high: to_f32(&(half - origin)) };
                meet.test_form(simd, &form, packets, seen)
            }
            Form::Sphere { radius } => {
                meet.size = *radius as f32;
                meet.test_form(simd, &sphere_form(&origin, *radius, 0.0), packets, seen)
            }
            Form::Cylinder { radius, half_length } => {
                meet.size = (radius + half_length) as f32;
                meet.test_form(simd, &cylinder_form(&origin, *radius, *half_length), packets, seen)
            }
            Form::Capsule { radius, half_length } => {
                meet.size = (radius + half_length) as f32;
                let balls = [sphere_form(&origin, *radius, *half_length), sphere_form(&origin, *radius, -half_length)];
                meet.test_form(
                    simd,
                    &CapsuleForm { cylinder: cylinder_form(&origin, *radius, *half_length), spheres: balls },
                    packets,
                    seen,
                )
            }
            Form::Mesh { .. } => match &self.scene.trees[index as usize] {
                Some(tree) => meet.test_mesh(simd, &tree.packets, &origin, packets, seen),
                None => false,
            },
        }
    }
}

/// A target relative to the sensor.
struct TargetFrame<'a> {
    form: &'a Form,
    /// Rotation from the sensor's frame to the form's.
    turn: [[f32; 3]; 3],
    /// Origin of the sensor in the form's frame.
    origin: Vector3<f64>,
}

fn sphere_form(origin: &Vector3<f64>, radius: f64, height: f64) -> SphereForm {
    let origin = [origin.x as f32, origin.y as f32, (origin.z - height) as f32];
    SphereForm { origin, radius: radius as f32, inverse: inverse(radius) }
}

fn cylinder_form(origin: &Vector3<f64>, radius: f64, half_length: f64) -> CylinderForm {
    CylinderForm {
        origin: to_f32(origin),
        radius: radius as f32,
        inverse: inverse(radius),
        low: (-half_length - origin.z) as f32,
        high: (half_length - origin.z) as f32,
        within: origin.xy().norm() <= radius,
    }
}

fn inverse(radius: f64) -> f32 {
    if radius > 0.0 { (1.0 / radius) as f32 } else { 0.0 }
}

/// A target, with the data shared by all packets that are tested against it.
struct TargetTest<'a> {
    walk: &'a PartTraversal<'a>,
    index: u32,
    /// Rotation from the sensor's frame to the target's.
    turn: [[f32; 3]; 3],
    /// Magnitude of the coordinates that describe the form, m.
    size: f32,
    /// Lower bound of the distance to the target.
    bound: f32,
}

impl TargetTest<'_> {
    /// Calls `test` with the rays, in the target's frame, of each packet for which the target may be nearer than its
    /// hits so far, and updates the maximum distances of the packets and groups. Returns whether a ray has hit the
    /// target.
    #[inline(always)]
    fn for_each_packet<S: Simd>(
        &self,
        simd: S,
        packets: &[u32; GROUPS],
        seen: &mut PartHits,
        mut test: impl FnMut(&VectorLanes<S>, &mut PacketHits) -> bool,
    ) -> bool {
        let mut any = false;
        for (group, bits) in packets.iter().enumerate().take(self.walk.part.cones.len()) {
            let mut bits = *bits;
            let mut changed = false;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let packet = group * LANES + lane;
                if seen.far[group].0[lane] < self.bound {
                    continue;
                }
                let d = VectorLanes::load(simd, &self.walk.part.packets[packet]).rotated(&self.turn);
                let best = &mut seen.best[packet];
                if test(&d, best) {
                    seen.far[group].0[lane] = best.t.load(simd).reduce_max();
                    changed = true;
                }
            }
            if changed {
                seen.group_far.0[group] = seen.far[group].load(simd).reduce_max();
                any = true;
            }
        }
        any
    }

    #[inline(always)]
    fn test_form<S: Simd, T: AnalyticForm<S>>(
        &self,
        simd: S,
        form: &T,
        packets: &[u32; GROUPS],
        seen: &mut PartHits,
    ) -> bool {
        let limits = self.walk.limits;
        let near = splat(simd, limits.near);
        self.for_each_packet(
            simd,
            packets,
            seen,
            #[inline(always)]
            |d, best| {
                let (span, more) = form.span(simd, d);
                let mut any = false;
                // Test the entry points first, and then, for rays whose entry point is not admissible, the exit points.
                let (mut t, mut leaving) = (span.enter, MaskLanes::splat(simd, false));
                let mut open = span.valid;
                for end in 0..2 {
                    let so_far = best.t.load(simd);
                    let mut ok = open & t.simd_ge(near) & t.simd_le(so_far);
                    if ok.any_true() {
                        let (slope, primitive) = form.surface(simd, d, &span, &more, leaving);
                        if !limits.any_surface {
                            ok &= limits.admits(simd, slope);
                        }
                        any |= self.store_hits(simd, ok, t, slope, primitive, best);
                        open &= !ok;
                    }
                    if end == 1 || limits.any_surface && !(open & t.simd_lt(near)).any_true() {
                        break;
                    }
                    (t, leaving) = (span.leave, MaskLanes::splat(simd, true));
                }
                any
            },
        )
    }

    #[inline(always)]
    fn test_mesh<S: Simd>(
        &mut self,
        simd: S,
        tree: &mesh::PacketTree,
        origin: &Vector3<f64>,
        packets: &[u32; GROUPS],
        seen: &mut PartHits,
    ) -> bool {
        let eye = tree.ray_origin(origin);
        self.size = eye.size;
        self.for_each_packet(
            simd,
            packets,
            seen,
            #[inline(always)]
            |d, best| {
                let met = tree.cast(simd, &eye, d, self.walk.limits, best.t.load(simd));
                met.ok.any_true() && self.store_hits(simd, met.ok, met.t, met.slope, met.primitive, best)
            },
        )
    }

    /// Stores the hits of the lanes in `ok`, unless there is a hit of higher priority at exactly the same distance.
    #[inline(always)]
    fn store_hits<S: Simd>(
        &self,
        simd: S,
        mut ok: MaskLanes<S>,
        t: FloatLanes<S>,
        slope: FloatLanes<S>,
        primitive: UintLanes<S>,
        best: &mut PacketHits,
    ) -> bool {
        let so_far = best.t.load(simd);
        let ties = (ok & t.simd_eq(so_far)).to_bitmask();
        if ties != 0 {
            let primitive: [u32; LANES] = primitive.to_array();
            let lost = (0..LANES).filter(|lane| {
                let (target, other) = (best.target[*lane], best.primitive[*lane]);
                ties >> lane & 1 != 0 && !self.has_priority(primitive[*lane], target, other)
            });
            let lost = lost.fold(0, |bits, lane| bits | 1 << lane);
            ok = MaskLanes::from_bitmask(simd, ok.to_bitmask() & !lost);
        }
        let margin = slope.abs() - (t + self.size) * DISTANCE_ERROR_FACTOR;
        best.t.store(ok.select(t, so_far));
        best.margin.store(ok.select(margin, best.margin.load(simd)));
        ok.select(UintLanes::splat(simd, self.index), UintLanes::load_array_ref(simd, &best.target))
            .store_array(&mut best.target);
        ok.select(primitive, UintLanes::load_array_ref(simd, &best.primitive)).store_array(&mut best.primitive);
        true
    }

    /// Returns whether a hit of this target has priority over another hit at the same distance. Hits are compared by
    /// object, then by primitive, then by index of the target; the lowest value has priority.
    fn has_priority(&self, primitive: u32, other: u32, other_primitive: u32) -> bool {
        let targets = &self.walk.scene.targets;
        other == NO_TARGET || {
            let rank = |index: u32, primitive: u32| (targets[index as usize].object, primitive, index);
            rank(self.index, primitive) < rank(other, other_primitive)
        }
    }
}
