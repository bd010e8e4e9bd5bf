//! Traversal of the targets for the packets of a part.

use fearless_simd::{Level, prelude::*};
use nalgebra::{Matrix3, Vector3};
use tatu_geometry::Form;

use super::{
    BundleCast, BundleHits, finish,
    forms::{Ball, Cuboid, Drum, Pill, Plane, Shape},
    lanes::{F, M, U, V, rows, short, splat},
    mesh,
    pack::{Cones, GROUPS, LANES, Lanes, PacketGroup},
    packet::{Best, Limits, NONE, Seen},
};
use crate::{BeamScene, simd::dispatch, tree::Quad};

/// Factor of `(distance + size of the target) / cosine of the incidence` that gives the error of a distance, relative
/// to the tolerance: a few rounding errors of 6e-8 each in a rotation, divided by 3e-5 m.
const BLUR: f32 = 2.5e-7 / 3e-5;

/// Casts the rays of a part of a bundle.
pub(super) fn part(scene: &BeamScene, level: Level, cast: &BundleCast<'_>, index: usize, hits: BundleHits<'_>) {
    let part = &cast.bundle.parts()[index];
    let pose = &cast.world_from_sensor;
    let placed = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
    let Some(limits) = Limits::new(cast).filter(|_| placed) else {
        return finish::nothing(hits);
    };
    let mut seen = Seen::new(part, limits.far);
    dispatch!(level, simd => walk(simd, scene, cast, part, &limits, &mut seen));
    finish::finish(scene, cast, part, &seen, hits);
}

/// The inputs shared by the visits of all targets.
struct Walk<'a> {
    scene: &'a BeamScene,
    cast: &'a BundleCast<'a>,
    part: &'a PacketGroup,
    limits: &'a Limits,
    sensor_from_world: Matrix3<f64>,
    origin: Vector3<f64>,
}

/// The bounding ball of a target relative to the sensor, prepared for tests against many cones at once.
struct Disc {
    centre: [f32; 3],
    /// Cosine and sine of the angle between the centre and the rim, times the distance of the centre.
    cos: f32,
    sin: f32,
    /// Margin for rounding errors.
    slack: f32,
    /// Lower bound of the distance to the ball.
    bound: f32,
}

impl Disc {
    #[inline(always)]
    fn new(centre: &Vector3<f64>, radius: f64) -> Self {
        let away = centre.norm();
        let radius = radius * (1.0 + 1e-6) + 1e-6;
        let power = away * away - radius * radius;
        let (cos, sin) = if power > 0.0 { (power.sqrt() as f32, radius as f32) } else { (-1e30, 1e30) };
        let bound = ((away - radius) * (1.0 - 1e-6) - 1e-5).max(0.0) as f32;
        Self { centre: short(centre), cos, sin, slack: away as f32 * 2e-6, bound }
    }

    /// Returns the lanes of cones that may contain a part of the ball nearer than the hits so far.
    #[inline(always)]
    fn seen_by<S: Simd>(&self, simd: S, cones: &Cones, far: &Lanes) -> u64 {
        let axis = V { x: cones.x.load(simd), y: cones.y.load(simd), z: cones.z.load(simd) };
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
    part: &PacketGroup,
    limits: &Limits,
    seen: &mut Seen,
) {
    let pose = &cast.world_from_sensor;
    let walk = Walk {
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
        walk.meet_plane(simd, index, &all, seen);
    }
    scene.top.walk_by(
        walk.reach(simd, seen),
        #[inline(always)]
        |quad: &Quad, _| quad.distances(&walk.origin),
        #[inline(always)]
        |place, limit| {
            if walk.visit(simd, scene.top.order[place], seen) { walk.reach(simd, seen) } else { limit }
        },
    );
}

impl Walk<'_> {
    /// Returns the largest distance at which a hit could still change the result.
    #[inline(always)]
    fn reach<S: Simd>(&self, simd: S, seen: &Seen) -> f64 {
        f64::from(seen.group_far.load(simd).reduce_max()) * (1.0 + 1e-5) + 1e-5
    }

    /// Tests a bounded target against all packets whose rays may hit it; returns whether it was hit.
    #[inline(always)]
    fn visit<S: Simd>(&self, simd: S, index: u32, seen: &mut Seen) -> bool {
        let (centre, radius) = self.scene.balls[index as usize];
        let disc = Disc::new(&(self.sensor_from_world * (centre - self.origin)), radius);
        let mut packets = [0; GROUPS];
        let mut groups = disc.seen_by(simd, &self.part.groups, &seen.group_far);
        let mut any = 0;
        while groups != 0 {
            let group = groups.trailing_zeros() as usize;
            groups &= groups - 1;
            packets[group] = disc.seen_by(simd, &self.part.cones[group], &seen.far[group]) as u32;
            any |= packets[group];
        }
        any != 0 && self.meet_target(simd, index, &packets, disc.bound, seen)
    }

    /// Returns a target's form and frame, unless it is excluded.
    fn frame(&self, index: u32) -> Option<Frame<'_>> {
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
        Some(Frame { form: &target.form, turn, origin })
    }

    #[inline(always)]
    fn meet_plane<S: Simd>(&self, simd: S, index: u32, packets: &[u32; GROUPS], seen: &mut Seen) {
        if let Some(Frame { turn, origin, .. }) = self.frame(index) {
            let height = origin.z as f32;
            let meet = Meet { walk: self, index, turn, size: height.abs(), bound: 0.0 };
            meet.all(simd, &Plane { height }, packets, seen);
        }
    }

    /// Tests packets against a target's form.
    #[inline(always)]
    fn meet_target<S: Simd>(&self, simd: S, index: u32, packets: &[u32; GROUPS], bound: f32, seen: &mut Seen) -> bool {
        let Some(Frame { form, turn, origin }) = self.frame(index) else { return false };
        let mut meet = Meet { walk: self, index, turn, size: 0.0, bound };
        match form {
            Form::Plane => false,
            Form::Box { half } => {
                meet.size = (origin.abs() + half).max() as f32;
                let least = (origin.abs() - half).map(|x| x.max(0.0)).norm();
                meet.bound = meet.bound.max((least * (1.0 - 1e-6) - 1e-5) as f32);
                let form = Cuboid { low: short(&(-half - origin)), high: short(&(half - origin)) };
                meet.all(simd, &form, packets, seen)
            }
            Form::Sphere { radius } => {
                meet.size = *radius as f32;
                meet.all(simd, &ball(&origin, *radius, 0.0), packets, seen)
            }
            Form::Cylinder { radius, half_length } => {
                meet.size = (radius + half_length) as f32;
                meet.all(simd, &drum(&origin, *radius, *half_length), packets, seen)
            }
            Form::Capsule { radius, half_length } => {
                meet.size = (radius + half_length) as f32;
                let balls = [ball(&origin, *radius, *half_length), ball(&origin, *radius, -half_length)];
                meet.all(simd, &Pill { drum: drum(&origin, *radius, *half_length), balls }, packets, seen)
            }
            Form::Mesh { .. } => match &self.scene.trees[index as usize] {
                Some(tree) => meet.mesh(simd, &tree.packets, &origin, packets, seen),
                None => false,
            },
        }
    }
}

/// A target relative to the sensor.
struct Frame<'a> {
    form: &'a Form,
    /// Rotation from the sensor's frame to the form's.
    turn: [[f32; 3]; 3],
    /// Origin of the sensor in the form's frame.
    origin: Vector3<f64>,
}

fn ball(origin: &Vector3<f64>, radius: f64, height: f64) -> Ball {
    let origin = [origin.x as f32, origin.y as f32, (origin.z - height) as f32];
    Ball { origin, radius: radius as f32, inverse: inverse(radius) }
}

fn drum(origin: &Vector3<f64>, radius: f64, half_length: f64) -> Drum {
    Drum {
        origin: short(origin),
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
struct Meet<'a> {
    walk: &'a Walk<'a>,
    index: u32,
    /// Rotation from the sensor's frame to the target's.
    turn: [[f32; 3]; 3],
    /// Magnitude of the coordinates that describe the form, m.
    size: f32,
    /// Lower bound of the distance to the target.
    bound: f32,
}

impl Meet<'_> {
    /// Calls `test` with the rays, in the target's frame, of each packet for which the target may be nearer than its
    /// hits so far, and updates the maximum distances of the packets and groups. Returns whether a ray has hit the
    /// target.
    #[inline(always)]
    fn each<S: Simd>(
        &self,
        simd: S,
        packets: &[u32; GROUPS],
        seen: &mut Seen,
        mut test: impl FnMut(&V<S>, &mut Best) -> bool,
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
                let d = V::load(simd, &self.walk.part.packets[packet]).turned(&self.turn);
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
    fn all<S: Simd, T: Shape<S>>(&self, simd: S, form: &T, packets: &[u32; GROUPS], seen: &mut Seen) -> bool {
        let limits = self.walk.limits;
        let near = splat(simd, limits.near);
        self.each(
            simd,
            packets,
            seen,
            #[inline(always)]
            |d, best| {
                let (span, more) = form.span(simd, d);
                let mut any = false;
                // Test the entry points first, and then, for rays whose entry point is not admissible, the exit points.
                let (mut t, mut leaving) = (span.enter, M::splat(simd, false));
                let mut open = span.valid;
                for end in 0..2 {
                    let so_far = best.t.load(simd);
                    let mut ok = open & t.simd_ge(near) & t.simd_le(so_far);
                    if ok.any_true() {
                        let (slope, primitive) = form.surface(simd, d, &span, &more, leaving);
                        if !limits.all {
                            ok &= limits.shows(simd, slope);
                        }
                        any |= self.take(simd, ok, t, slope, primitive, best);
                        open &= !ok;
                    }
                    if end == 1 || limits.all && !(open & t.simd_lt(near)).any_true() {
                        break;
                    }
                    (t, leaving) = (span.leave, M::splat(simd, true));
                }
                any
            },
        )
    }

    #[inline(always)]
    fn mesh<S: Simd>(
        &mut self,
        simd: S,
        tree: &mesh::PacketTree,
        origin: &Vector3<f64>,
        packets: &[u32; GROUPS],
        seen: &mut Seen,
    ) -> bool {
        let eye = tree.eye(origin);
        self.size = eye.size;
        self.each(
            simd,
            packets,
            seen,
            #[inline(always)]
            |d, best| {
                let met = tree.cast(simd, &eye, d, self.walk.limits, best.t.load(simd));
                met.ok.any_true() && self.take(simd, met.ok, met.t, met.slope, met.primitive, best)
            },
        )
    }

    /// Stores the hits of the lanes in `ok`, unless there is a hit of higher priority at exactly the same distance.
    #[inline(always)]
    fn take<S: Simd>(&self, simd: S, mut ok: M<S>, t: F<S>, slope: F<S>, primitive: U<S>, best: &mut Best) -> bool {
        let so_far = best.t.load(simd);
        let ties = (ok & t.simd_eq(so_far)).to_bitmask();
        if ties != 0 {
            let primitive: [u32; LANES] = primitive.to_array();
            let lost = (0..LANES).filter(|lane| {
                let (target, other) = (best.target[*lane], best.primitive[*lane]);
                ties >> lane & 1 != 0 && !self.before(primitive[*lane], target, other)
            });
            let lost = lost.fold(0, |bits, lane| bits | 1 << lane);
            ok = M::from_bitmask(simd, ok.to_bitmask() & !lost);
        }
        let margin = slope.abs() - (t + self.size) * BLUR;
        best.t.store(ok.select(t, so_far));
        best.margin.store(ok.select(margin, best.margin.load(simd)));
        ok.select(U::splat(simd, self.index), U::load_array_ref(simd, &best.target)).store_array(&mut best.target);
        ok.select(primitive, U::load_array_ref(simd, &best.primitive)).store_array(&mut best.primitive);
        true
    }

    /// Returns whether a hit of this target has priority over another hit at the same distance. Hits are compared by
    /// object, then by primitive, then by index of the target; the lowest value has priority.
    fn before(&self, primitive: u32, other: u32, other_primitive: u32) -> bool {
        let targets = &self.walk.scene.targets;
        other == NONE || {
            let rank = |index: u32, primitive: u32| (targets[index as usize].object, primitive, index);
            rank(self.index, primitive) < rank(other, other_primitive)
        }
    }
}
