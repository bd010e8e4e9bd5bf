//! Measures with batches of sensors of a kind: casts the beams of many due sensors together, and calls the plugin once
//! for all of them.

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    RandomTable, Registry,
    border::ErrorSlot,
    watchdog::{CallWatch, PluginCall},
};
use tatu_scene::{Scene, pose_to_array};

use super::{
    Sensing, SensorDevice,
    batch::{BatchSensors, CallContext, MeasureFailure, call_kind, check_status_guards, complete},
    cast::{HitLimits, SensorView},
    scratch::{MeasureScratch, MeasureTime},
};

/// The sensors of one kind that measure together, and the time of the measurement.
#[derive(Debug, Clone, Copy)]
pub struct MeasureRequest<'a> {
    /// Index of the kind of these sensors.
    pub kind: usize,
    /// Indices into [`Sensing::devices`], ascending.
    pub devices: &'a [usize],
    /// Positions in `devices` at which a new batch begins. They do not depend on the number of threads, so that the
    /// same sensors fail together with any number of threads.
    pub batch_starts: &'a [usize],
    /// Options for all these sensors.
    pub options: &'a MeasureOptions,
    /// The time of the measurement.
    pub moment: MeasureTime,
}

/// Options that override the parameters of sensors.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeasureOptions {
    /// The only object that the sensors detect, if set.
    pub only: Option<tatu_object>,
    /// Limits that replace those of the sensors, if set.
    pub limits: Option<HitLimits>,
}

/// The inputs that all measurements share.
pub struct MeasureContext<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The registry of plugins.
    pub registry: &'a Registry,
    /// Returns the linear and angular velocity of the object in a slot.
    pub twist: &'a dyn Fn(u32) -> [f64; 6],
    /// The watchdog's record of plugin calls.
    pub watch: &'a CallWatch,
    /// Threads that cast the beams.
    pub pool: &'a rayon::ThreadPool,
}

/// Maximum number of rays and pixels in a batch, unless a single sensor has more, so that their results are still in
/// the processor's caches when the plugin reads them.
const MAX_BATCH_BEAMS: usize = 1 << 14;

/// Measures with the sensors of a request, and returns those that failed.
pub fn measure(sensing: &mut Sensing, job: &MeasureRequest<'_>, around: &MeasureContext<'_>) -> Vec<MeasureFailure> {
    job.device_groups()
        .flat_map(|devices| measure_group(sensing, &MeasureRequest { devices, batch_starts: &[], ..*job }, around))
        .collect()
}

impl<'a> MeasureRequest<'a> {
    /// Returns the groups of devices that are measured one after another.
    fn device_groups(&self) -> impl Iterator<Item = &'a [usize]> {
        let ends = self.batch_starts.iter().copied().chain([self.devices.len()]);
        let (devices, mut begin) = (self.devices, 0);
        ends.map(move |end| &devices[std::mem::replace(&mut begin, end)..end]).filter(|share| !share.is_empty())
    }
}

/// Measures with a group of devices, split into batches of limited size.
fn measure_group(sensing: &mut Sensing, job: &MeasureRequest<'_>, around: &MeasureContext<'_>) -> Vec<MeasureFailure> {
    let mut failed = Vec::new();
    let mut rest = job.devices;
    while !rest.is_empty() {
        let mut room = MAX_BATCH_BEAMS;
        let fits = |i: &&usize| {
            let had = room;
            room = room.saturating_sub(sensing.devices[**i].layout.plan.count());
            had == MAX_BATCH_BEAMS || room > 0
        };
        let n = rest.iter().take_while(fits).count();
        let (devices, after) = rest.split_at(n);
        failed.extend(measure_batch(sensing, &MeasureRequest { devices, ..*job }, around));
        rest = after;
    }
    failed
}

fn measure_batch(sensing: &mut Sensing, job: &MeasureRequest<'_>, around: &MeasureContext<'_>) -> Vec<MeasureFailure> {
    let MeasureRequest { kind, devices, options, moment, .. } = *job;
    let MeasureContext { scene, registry, twist, pool, watch, .. } = *around;
    let (calls, who) = (CallContext { registry, watch }, BatchSensors { kind, devices });
    let kind_info = &registry.sensors[kind];
    let inputs = kind_info.raw.inputs;
    let Sensing { devices: all, targets, scratch: s, .. } = sensing;
    s.clear();
    for i in devices {
        let d = &mut all[*i];
        let plan = &d.layout.plan;
        let world = scene.world(d.slot);
        let skip_group = plan.skip_model.then(|| scene.model_of(d.slot)).filter(|g| *g != 0);
        let limits = HitLimits::of(plan, options.limits);
        let choice = d.chosen.choice;
        let view = SensorView { world_from_sensor: world, limits, choice, skip_group, only_object: options.only };
        s.casts.add(plan, view);
        s.views.push(view);
        s.frames.add(plan, view, targets.filtered_beams(plan.target_filter(choice)), inputs, pool);
        if inputs & TATU_IN_POSE != 0 {
            s.motion.pose.push(pose_to_array(&world));
        }
        if inputs & TATU_IN_TWIST != 0 {
            s.motion.twist.push(twist(d.slot));
        }
        if inputs & TATU_IN_TARGETS != 0 {
            s.listed.begin();
            d.targets().for_each(|target| s.listed.push_from_scene(scene, target, twist));
        }
        d.prepare(s, scene.id(d.slot), moment.time);
    }
    if inputs & TATU_IN_TARGETS != 0 {
        s.listed.begin();
    }
    s.status.fill(devices.len(), TATU_OK);
    let keys = std::mem::take(&mut s.keys);
    let random = RandomTable::new(&keys);
    let mut error = s.error.take().unwrap_or_else(ErrorSlot::new);
    let mut failed = Vec::new();
    if s.aims.set_planned_rays(devices.iter().map(|i| &all[*i].layout.plan)) {
        let mut batch = s.batch(devices.len(), kind_info.fields.len(), &moment);
        batch.random = random.raw();
        failed = call_kind(PluginCall::Aim, &mut batch, &mut s.status, all, who, calls, &mut error);
        failed.extend(check_status_guards(PluginCall::Aim, s, all, who));
        failed.extend(add_aimed_rays(s, all, job));
    }
    s.casts.run(inputs, targets, scene, |sensor| &all[devices[sensor]].layout.plan, pool);
    if inputs & TATU_IN_HIT_TWIST != 0 {
        add_hit_twists(s, twist);
    }
    let mut batch = s.batch(devices.len(), kind_info.fields.len(), &moment);
    batch.random = random.raw();
    failed.extend(call_kind(PluginCall::Measure, &mut batch, &mut s.status, all, who, calls, &mut error));
    failed.extend(check_status_guards(PluginCall::Measure, s, all, who));
    failed.extend(complete(s, all, who, calls, pool, &mut batch, &mut error));
    (s.error, s.keys) = (Some(error), keys);
    failed
}

/// Adds the velocity of the object that each beam hit. Consecutive beams often hit the same object.
fn add_hit_twists(s: &mut MeasureScratch, twist: &dyn Fn(u32) -> [f64; 6]) {
    let mut last = (0, [0.0; 6]);
    let of_object = |object: &tatu_object| {
        if *object != last.0 {
            last = (*object, if *object == 0 { [0.0; 6] } else { twist(tatu_slot(*object)) });
        }
        last.1
    };
    s.motion.hit_twist.extend(s.casts.object.iter().map(of_object));
}

/// Adds the aimed rays of a batch to the beams to cast. A sensor with an invalid ray fails, and none of its rays is
/// cast.
fn add_aimed_rays(s: &mut MeasureScratch, all: &[SensorDevice], job: &MeasureRequest<'_>) -> Vec<MeasureFailure> {
    let mut failed = Vec::new();
    let whole = s.aims.are_whole();
    for (sensor, i) in job.devices.iter().enumerate() {
        let d = &all[*i];
        let plan = &d.layout.plan;
        if !plan.aimed {
            continue;
        }
        let frames = s.aims.next_rays(plan.directions.len()).filter(|_| whole);
        if s.status[sensor] < 0 {
            continue;
        }
        let Some(frames) = frames else {
            s.status[sensor] = TATU_ERR;
            let text = match whole {
                true => "broke the contract: a ray's origin is not finite, or its direction is not a unit vector",
                false => "broke the contract: it wrote outside the rays of its batch",
            };
            let text = text.to_owned();
            failed.push(MeasureFailure { slot: d.slot, kind: job.kind, call: PluginCall::Aim, text, status: TATU_ERR });
            continue;
        };
        s.casts.add_aimed(sensor, plan, s.views[sensor], frames);
    }
    failed
}
