//! The C table of a sensor kind, whose functions call those of [`Sensor`].

use std::{
    cell::{Ref, RefCell},
    ffi::c_void,
    sync::Arc,
};

use crate::abi::*;
use crate::safe::{
    Change, Fail, Param, Params, Result, ValueRef,
    declare::{
        plugin::StartedPlugin,
        sensor::{Form, Sensor},
    },
    entry::{
        life::{self, InstanceInfo, InstanceLife},
        panics,
    },
    value::{
        field::Field,
        list_cache::cached_list,
        sample::{Readout, Sample},
        table_arena::TableArena,
    },
};

/// The `data` that the host stores for a sensor: the sensor, and the directions of its beams.
///
/// A world may have thousands of sensors, all of which are visited in each step. The fields that a measurement reads
/// come first, so that they occupy few cache lines.
#[repr(C, align(64))]
struct SensorInstance<S: Sensor> {
    /// The declared fields of readings, shared by all sensors of the kind.
    fields: Arc<[Field]>,
    /// The sensor, in a cell because it must not be used while it is being configured, not even by a nested call. Only
    /// one thread at a time uses an instance.
    sensor: RefCell<S>,
    directions: RefCell<Vec<[f64; 3]>>,
    origins: RefCell<Vec<[f64; 3]>>,
}

struct SensorLists<S>(S);

fn fields_of<S: Sensor>() -> Arc<[Field]> {
    cached_list::<SensorLists<S>, _>(S::fields)
}
fn params_of<S: Sensor>() -> Arc<[Param]> {
    cached_list::<SensorLists<S>, _>(S::params)
}

impl<S: Sensor> SensorInstance<S> {
    fn sensor(&self) -> Result<Ref<'_, S>> {
        self.sensor.try_borrow().map_err(|_| in_use())
    }
}

#[cold]
fn in_use() -> Fail {
    Fail::with_code(TATU_ERR_BUSY, "the sensor is being configured")
}

impl<S: Sensor> InstanceLife for SensorInstance<S> {
    type Plugin = S::Plugin;
    const STATE_VERSION: u32 = S::STATE_VERSION;

    fn create(_: &StartedPlugin<S::Plugin>, info: &InstanceInfo<'_>) -> Result<Self> {
        let sensor = S::create(&info.world, info.instance, &Params::new(info.params, &params_of::<S>()))?;
        let (directions, origins) = Default::default();
        Ok(SensorInstance { fields: fields_of::<S>(), sensor: sensor.into(), directions, origins })
    }
    fn configure(&self, params: &[ValueRef<'_>], changed: u64) -> Result<Change> {
        let mut sensor = self.sensor.try_borrow_mut().map_err(|_| in_use())?;
        sensor.configure(&Params::new(params, &params_of::<S>()), changed)
    }
    fn save(&self) -> Result<Vec<u8>> {
        self.sensor()?.save()
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        self.sensor()?.load(bytes, version)
    }
}

pub(crate) fn table<S: Sensor>(keep: &mut TableArena) -> *const tatu_sensor {
    let params = params_of::<S>().iter().map(|p| p.to_table(keep)).collect();
    let fields = fields_of::<S>().iter().map(|f| f.to_table(keep)).collect();
    let raw = tatu_sensor {
        size: size_of::<tatu_sensor>() as u32,
        inputs: S::INPUTS,
        id: keep.text(S::ID),
        text: keep.text(S::TEXT),
        schemas: keep.texts(S::SCHEMAS),
        params: keep.list(params),
        fields: keep.list(fields),
        life: keep.table(life::table::<SensorInstance<S>>(S::STATE * size_of::<f64>())),
        beams: Some(beams::<S>),
        measure: Some(measure::<S>),
        presets: {
            let presets = S::PRESETS.iter().map(|p| p.to_table(keep)).collect();
            keep.list(presets)
        },
        finish: Some(finish::<S>),
        aim: Some(aim::<S>),
        flags: if S::EVERY_PHYSICS_STEP { TATU_SENSOR_EVERY_PHYSICS_STEP } else { 0 },
        reserved: 0,
    };
    keep.table(raw)
}

unsafe extern "C" fn beams<S: Sensor>(data: *mut c_void, out: *mut tatu_beams, error: *mut tatu_error) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `data` was created by `create` and is live; `out` is valid for a write.
        let (data, out) = unsafe { (life::instance_at::<SensorInstance<S>>(data), &mut *out) };
        let beams = data.sensor()?.beams_for(out.n_targets as usize)?;
        (out.near_m, out.far_m) = (beams.near, beams.far);
        out.max_incidence = beams.max_incidence;
        out.flags = 0;
        if beams.skip_own_model {
            out.flags |= TATU_BEAMS_SKIP_MODEL;
        }
        if beams.visible {
            out.flags |= TATU_BEAMS_VISIBLE;
        }
        if beams.occlude {
            out.flags |= TATU_BEAMS_OCCLUDE;
        }
        if beams.aimed {
            out.flags |= TATU_BEAMS_AIMED;
        }
        (out.own, out.without, out.waves) = (beams.own, beams.without, beams.waves);
        out.observed = beams.observed;
        if !beams.faces.0 {
            out.flags |= TATU_BEAMS_NO_FRONT;
        }
        if !beams.faces.1 {
            out.flags |= TATU_BEAMS_NO_BACK;
        }
        match beams.form {
            Form::None => out.form = TATU_BEAMS_NONE,
            Form::Cone { half_angle } => {
                out.form = TATU_BEAMS_CONE;
                out.count = [1, 1];
                out.dims[0] = half_angle;
            }
            Form::Volume { form, dims } => {
                (out.form, out.dims) = (form, dims);
                out.count = [1, 1];
            }
            Form::Image { columns, rows, horizontal_angle } => {
                out.form = TATU_BEAMS_GRID;
                out.count = [columns, rows];
                out.dims[0] = horizontal_angle;
            }
            Form::Parallel { columns, rows, width } => {
                out.form = TATU_BEAMS_PARALLEL;
                out.count = [columns, rows];
                out.dims[0] = width;
            }
            Form::Rays(directions) => {
                out.form = TATU_BEAMS_RAYS;
                let too_many = |_| Fail::new("a sensor can have at most 4294967295 rays");
                out.count = [u32::try_from(directions.len()).map_err(too_many)?, 1];
                if !beams.origins.is_empty() && beams.origins.len() != directions.len() {
                    let (origins, rays) = (beams.origins.len(), directions.len());
                    return Err(Fail::new(format!(
                        "the beams have {origins} origins, but must have none, or one for each of the {rays} rays"
                    )));
                }
                // The host reads directions and origins only until it requests the beams again.
                data.directions.replace(directions);
                data.origins.replace(beams.origins);
                out.directions = data.directions.borrow().as_ptr().cast();
                let origins = data.origins.borrow();
                out.origins = if origins.is_empty() { std::ptr::null() } else { origins.as_ptr().cast() };
            }
        }
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn measure<S: Sensor>(
    _: *mut c_void,
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes a batch that is valid during the call, and no other thread uses its instances.
    unsafe { for_each_sensor::<S>(batch, error, |sensor, sample, out| sensor.measure(sample, out)) }
}

unsafe extern "C" fn finish<S: Sensor>(
    _: *mut c_void,
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes a batch that is valid during the call, and no other thread uses its instances.
    unsafe { for_each_sensor::<S>(batch, error, |sensor, sample, out| sensor.finish(sample, out)) }
}

unsafe extern "C" fn aim<S: Sensor>(
    _: *mut c_void,
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
) -> tatu_status {
    let act = |sensor: &S, sample: &Sample<'_>, _: &mut Readout<'_>| {
        let sample = sample.before_the_cast();
        // SAFETY: the rays belong to this instance alone during the call, and a sample before the cast does not expose
        // them, so the mutable slice is not aliased.
        match unsafe { sample.rays_to_aim() } {
            [] => Ok(()),
            rays => sensor.aim(&sample, rays),
        }
    };
    // SAFETY: the host passes a batch that is valid during the call, and no other thread uses its instances.
    unsafe { for_each_sensor::<S>(batch, error, act) }
}

/// Calls a function for each sensor of a batch, except for sensors that have already failed.
///
/// # Safety
/// The batch must be valid during the call, and no other thread may use its instances.
unsafe fn for_each_sensor<S: Sensor>(
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
    act: impl Fn(&S, &Sample<'_>, &mut Readout<'_>) -> Result,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the caller guarantees that `batch` points to a batch that is valid during the call.
        let batch = unsafe { &*batch };
        for i in 0..batch.n as usize {
            // SAFETY: the arrays are valid during the call and have one entry per instance, and `i` is below `n`;
            // `data` was created by `create` and is alive.
            let (data, status) =
                unsafe { (life::instance_at::<SensorInstance<S>>(*batch.data.add(i)), &mut *batch.status.add(i)) };
            if *status < 0 {
                continue;
            }
            // SAFETY: the caller guarantees exclusive use of the batch's instances, of which this is one.
            let (sample, mut out) = unsafe { (Sample::new(batch, i), Readout::new(batch, i, &data.fields, S::STATE)) };
            if let Err(fail) = data.sensor().and_then(|sensor| act(&sensor, &sample, &mut out)) {
                // SAFETY: the host passes null or an error object that is live during the call.
                *status = unsafe { fail.write(error) };
            }
        }
        Ok(TATU_OK)
    })
}
