//! Casts the beams of all sensors of a batch in one pass, and stores the results in arrays that the plugin reads.

use ::tatu_beams::{Beam, BeamScene, BundleCast, BundleHits, Faces, Hit, Volume};
use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::SolidPart;
use tatu_plugin_api::abi::*;
use tatu_scene::{Scene, visible_parts};

use super::{
    Targets,
    plan::{BeamPlan, look_along},
    targets::TargetFilter,
};

/// Beams of a batch and their results; beam `i` of the batch has index `i` in each requested array.
#[derive(Default)]
pub(super) struct BeamCasts {
    /// For each sensor, the index of its first beam; the last entry is the total number of beams.
    pub first: Vec<u64>,
    /// Pose of each sensor.
    views: Vec<Isometry3<f64>>,
    pub distance: Vec<f64>,
    pub point: Vec<[f64; 3]>,
    pub normal: Vec<[f64; 3]>,
    pub object: Vec<tatu_object>,
    pub primitive: Vec<u32>,
    pub color: Vec<[u8; 3]>,
    /// Beams that are cast one by one, for each distinct set of targets; reused from batch to batch.
    singles: Vec<SingleBeams>,
    hits: Vec<Hit>,
    /// Sensors whose rays are cast as bundles; a reused buffer.
    bundles: Vec<BundledSensor>,
}

/// Beams that are cast one by one, of sensors with the same set of targets.
struct SingleBeams {
    sees: TargetFilter,
    beams: Vec<Beam>,
    /// For each beam, its pose in the sensor's frame.
    frames: Vec<Isometry3<f64>>,
    /// For each beam, its index in the batch.
    places: Vec<u32>,
    /// Indices of the beams whose hit may be hidden by another surface.
    occluded: Vec<u32>,
    /// Indices of the beams whose hit may be too far away, with the maximum distance, m.
    short: Vec<(u32, f64)>,
}

/// A sensor whose rays are cast as a bundle.
#[derive(Clone, Copy)]
struct BundledSensor {
    /// Index of the sensor in the batch.
    sensor: usize,
    look: SensorView,
}

/// A sensor's pose, and the conditions on the targets and hits that it detects.
#[derive(Clone, Copy)]
pub(super) struct SensorView {
    pub world_from_sensor: Isometry3<f64>,
    pub limits: HitLimits,
    /// See [`TargetFilter::choice`].
    pub choice: u32,
    pub skip_group: Option<u32>,
    pub only_object: Option<u64>,
}

/// Conditions that a hit must meet to be detected.
#[derive(Debug, Clone, Copy)]
pub struct HitLimits {
    /// Sides of faces that can be hit.
    pub faces: Faces,
    /// Largest angle between a ray and the normal of the face that it hits, rad.
    pub max_incidence: f64,
    /// Maximum distance of a hit from the sensor, m, in addition to the range of the beams; may be infinite.
    pub reach: f64,
    /// Whether surfaces hide those behind them, even if they do not meet these conditions themselves.
    pub occlude: bool,
}

impl HitLimits {
    /// Returns the limits `once` of a single measurement if they are given, otherwise those of the sensor's plan.
    pub fn of(plan: &BeamPlan, once: Option<HitLimits>) -> Self {
        let BeamPlan { faces, range, occlude, .. } = *plan;
        once.unwrap_or(HitLimits { faces, max_incidence: range.max_incidence, reach: f64::INFINITY, occlude })
    }
}

impl BeamCasts {
    pub fn clear(&mut self) {
        self.first.clear();
        self.first.push(0);
        self.views.clear();
        self.distance.clear();
        self.point.clear();
        self.normal.clear();
        self.object.clear();
        self.primitive.clear();
        self.color.clear();
        self.bundles.clear();
        self.hits.clear();
        for SingleBeams { beams, frames, places, occluded, short, .. } in &mut self.singles {
            beams.clear();
            frames.clear();
            places.clear();
            occluded.clear();
            short.clear();
        }
    }

    /// Adds the next sensor. Aimed rays are added later by [`add_aimed`](Self::add_aimed), before the cast.
    pub fn add(&mut self, plan: &BeamPlan, look: SensorView) {
        let begin = self.first.last().copied().unwrap_or(0);
        self.first.push(begin + plan.directions.len() as u64);
        self.views.push(look.world_from_sensor);
        if plan.aimed {
            return;
        }
        if plan.bundle.is_some() {
            self.bundles.push(BundledSensor { sensor: self.first.len() - 2, look });
            return;
        }
        let origin = |i: usize| plan.origins.get(i).map_or_else(Vector3::zeros, |o| Vector3::from(*o));
        let turns = plan.turns.iter().enumerate();
        let frames = turns.map(|(i, turn)| Isometry3::from_parts(origin(i).into(), *turn));
        self.add_single_beams(plan, look, begin as u32, frames);
    }

    /// Adds the aimed rays of a sensor of the batch, given by their poses in the sensor's frame.
    pub fn add_aimed(&mut self, sensor: usize, plan: &BeamPlan, look: SensorView, frames: &[Isometry3<f64>]) {
        self.add_single_beams(plan, look, self.first[sensor] as u32, frames.iter().copied());
    }

    fn add_single_beams(
        &mut self,
        plan: &BeamPlan,
        look: SensorView,
        begin: u32,
        frames: impl Iterator<Item = Isometry3<f64>>,
    ) {
        let sees = plan.target_filter(look.choice);
        let at = self.singles.iter().position(|s| s.sees == sees).unwrap_or_else(|| {
            let (beams, frames, places, occluded, short) = Default::default();
            self.singles.push(SingleBeams { sees, beams, frames, places, occluded, short });
            self.singles.len() - 1
        });
        let set = &mut self.singles[at];
        let limits = look.limits;
        // The far end of a volume with flat ends is a part of its shape, so it is not moved to `reach`.
        let is_flat = matches!(plan.volume, Volume::Pyramid { .. } | Volume::Cylinder { .. });
        let far = if is_flat { plan.range.far } else { plan.range.far.min(limits.reach) };
        for (k, frame) in frames.enumerate() {
            if limits.occlude && plan.volume != Volume::Ray {
                set.occluded.push(set.beams.len() as u32);
            }
            if is_flat && limits.reach < f64::INFINITY {
                set.short.push((set.beams.len() as u32, limits.reach));
            }
            set.places.push(begin + k as u32);
            set.frames.push(frame);
            set.beams.push(Beam {
                world_from_beam: look.world_from_sensor * frame,
                volume: plan.volume,
                near: plan.range.near.min(far),
                far,
                max_incidence: limits.max_incidence,
                faces: limits.faces,
                skip_group: look.skip_group,
                only_object: look.only_object,
            });
        }
    }

    /// Casts all beams, and fills the arrays that `inputs` (`TATU_IN_*` flags) requests. `plan` returns the plan of a
    /// sensor of the batch.
    pub fn run<'a>(
        &mut self,
        inputs: u32,
        targets: &Targets,
        scene: &Scene,
        plan: impl Fn(usize) -> &'a BeamPlan,
        pool: &rayon::ThreadPool,
    ) {
        let n = self.first.last().copied().unwrap_or(0) as usize;
        let sized = |flags: u32| if inputs & flags != 0 { n } else { 0 };
        self.distance.resize(sized(TATU_IN_DISTANCE), f64::INFINITY);
        // The colour of a textured surface depends on the point, normal, object and primitive.
        self.point.resize(sized(TATU_IN_POINT | TATU_IN_COLOR), [0.0; 3]);
        self.normal.resize(sized(TATU_IN_NORMAL | TATU_IN_COLOR), [0.0; 3]);
        self.object.resize(sized(TATU_IN_OBJECT | TATU_IN_COLOR | TATU_IN_HIT_TWIST), 0);
        self.primitive.resize(sized(TATU_IN_PRIMITIVE | TATU_IN_COLOR), 0);
        for set in 0..self.singles.len() {
            self.cast_singles(set, targets, pool);
        }
        self.cast_bundled_sensors(targets, plan, pool);
        if inputs & TATU_IN_COLOR != 0 {
            self.colors(scene);
        }
    }

    /// Fills the colours of the surfaces that were hit.
    fn colors(&mut self, scene: &Scene) {
        for (sensor, world_from_sensor) in self.views.iter().enumerate() {
            for i in self.first[sensor] as usize..self.first[sensor + 1] as usize {
                let point = world_from_sensor * Point3::from(self.point[i]);
                let normal = world_from_sensor * Vector3::from(self.normal[i]);
                self.color.push(surface_color(scene, self.object[i], self.primitive[i], &point, &normal));
            }
        }
    }

    fn cast_singles(&mut self, set: usize, targets: &Targets, pool: &rayon::ThreadPool) {
        let (SingleBeams { sees, beams, frames, places, occluded, short }, hits) = (&self.singles[set], &mut self.hits);
        if beams.is_empty() {
            return;
        }
        let seen = targets.filtered_beams(*sees);
        hits.resize(beams.len(), Hit::NONE);
        pool.install(|| seen.cast(beams, hits));
        for (i, reach) in short {
            let hit = &mut hits[*i as usize];
            if hit.distance > *reach {
                *hit = Hit::NONE;
            }
        }
        for i in occluded {
            let (beam, hit) = (&beams[*i as usize], &mut hits[*i as usize]);
            if hit.is_some() && is_hidden(seen, beam, hit) {
                *hit = Hit::NONE;
            }
        }
        for ((hit, place), frame) in hits.drain(..).zip(places).zip(frames) {
            let place = *place as usize;
            if !hit.is_some() {
                continue;
            }
            store(&mut self.distance, place, || hit.distance);
            store(&mut self.object, place, || hit.object);
            store(&mut self.primitive, place, || hit.primitive);
            store(&mut self.point, place, || (frame * hit.point).coords.into());
            store(&mut self.normal, place, || (frame * hit.normal).into());
        }
    }

    fn cast_bundled_sensors<'a>(
        &mut self,
        targets: &Targets,
        plan: impl Fn(usize) -> &'a BeamPlan,
        pool: &rayon::ThreadPool,
    ) {
        if self.bundles.is_empty() {
            return;
        }
        let BeamCasts { first, distance, point, normal, object, primitive, bundles, .. } = self;
        let (mut distance, mut point, mut normal) = (&mut distance[..], &mut point[..], &mut normal[..]);
        let (mut object, mut primitive) = (&mut object[..], &mut primitive[..]);
        let mut at = 0;
        // The casts are grouped by set of targets, which is usually the same for all sensors.
        let mut jobs: Vec<(&BeamScene, Vec<(BundleCast<'_>, BundleHits<'_>)>)> = Vec::new();
        for BundledSensor { sensor, look } in bundles.iter().copied() {
            let plan = plan(sensor);
            let Some(bundle) = plan.bundle.get() else { continue };
            let (begin, end) = (first[sensor] as usize, first[sensor + 1] as usize);
            let skip = begin - at;
            at = end;
            let far = plan.range.far.min(look.limits.reach);
            let cast = BundleCast {
                bundle,
                world_from_sensor: look.world_from_sensor,
                near: plan.range.near.min(far),
                far,
                max_incidence: look.limits.max_incidence,
                faces: look.limits.faces,
                skip_group: look.skip_group,
                only_object: look.only_object,
            };
            let hits = BundleHits {
                distance: split_part(&mut distance, skip, end - begin),
                object: split_part(&mut object, skip, end - begin),
                primitive: split_part(&mut primitive, skip, end - begin),
                point: split_part(&mut point, skip, end - begin),
                normal: split_part(&mut normal, skip, end - begin),
            };
            let seen = targets.filtered_beams(plan.target_filter(look.choice));
            match jobs.iter_mut().find(|(s, _)| std::ptr::eq(*s, seen)) {
                Some((_, casts)) => casts.push((cast, hits)),
                None => jobs.push((seen, vec![(cast, hits)])),
            }
        }
        for (seen, casts) in jobs {
            pool.install(|| seen.cast_bundles(casts));
        }
    }
}

/// Returns whether any surface, regardless of side and incidence, is between a beam's origin and the point that it hit.
fn is_hidden(seen: &BeamScene, beam: &Beam, hit: &Hit) -> bool {
    let turn = look_along(hit.point.coords.normalize().into());
    // The ray ends before the surface that was hit, which must not hide itself.
    let before = hit.distance * (1.0 - OCCLUDER_MARGIN);
    let ray = Beam { skip_group: beam.skip_group, ..Beam::ray(beam.world_from_beam * turn, before) };
    hit.distance > 0.0 && seen.cast_one(&ray).is_some()
}

/// An occluder must be closer than the hit by this fraction of the hit's distance.
const OCCLUDER_MARGIN: f64 = 1e-6;

/// Writes a value, if its array was requested.
fn store<T>(to: &mut [T], place: usize, value: impl FnOnce() -> T) {
    if let Some(x) = to.get_mut(place) {
        *x = value();
    }
}

/// Skips `skip` elements and splits off the next `n`. Returns an empty slice if the array was not requested.
fn split_part<'a, T>(rest: &mut &'a mut [T], skip: usize, n: usize) -> &'a mut [T] {
    if rest.is_empty() {
        return &mut [];
    }
    let (_, after) = std::mem::take(rest).split_at_mut(skip);
    let (part, after) = after.split_at_mut(n);
    *rest = after;
    part
}

/// Returns the colour of the surface that was hit at `point`, in the world frame, or black if nothing was hit.
/// Compounds have the colour of their shape, without textures.
fn surface_color(
    scene: &Scene,
    object: tatu_object,
    primitive: u32,
    point: &Point3<f64>,
    normal: &Vector3<f64>,
) -> [u8; 3] {
    let slot = tatu_slot(object);
    let met = (object != 0).then(|| scene.get(slot)).flatten();
    let Some(shape) = met.and_then(|o| o.shape()) else { return [0; 3] };
    let mut color = shape.color;
    if shape.texture.is_some()
        && let [SolidPart { texture: Some(texture), form, .. }] = visible_parts(shape).as_slice()
    {
        let world = scene.world(slot);
        let (point, normal) = (world.inverse_transform_point(point), world.inverse_transform_vector(normal));
        color = texture.color((form, primitive), &point, &normal, color.map(|c| c as f32)).map(f64::from);
    }
    color.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}
