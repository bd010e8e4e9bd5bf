//! A sensor kind as the host sees it: a table of functions over [`Sensor`].

use std::{
    any::TypeId,
    cell::RefCell,
    collections::BTreeMap,
    ffi::c_void,
    sync::{Arc, Mutex, PoisonError},
};

use super::{
    Fail, Instance, Params, Result, ValueRef,
    fail::bytes_of,
    guard,
    offer::Keep,
    plugin::Started,
    sample::{Readout, Sample},
    sensor::{Field, Form, Sensor},
};
use crate::abi::*;

/// What the host keeps as `data`: the sensor, and the directions that its beams point to.
///
/// There may be thousands, and each step goes through all: what a measure needs comes first, in few lines of the
/// processor's cache.
#[repr(C, align(64))]
struct Data<S: Sensor> {
    /// As declared; one list for all of a kind.
    fields: Arc<[Field]>,
    /// Rows and columns of its image.
    image: std::cell::Cell<(u32, u32)>,
    /// Lengths of its own that fields may have.
    own: std::cell::Cell<[u32; 4]>,
    /// In a cell: while it is configured nothing else may use it, not even what it calls itself. Each instance is used
    /// by one thread at a time.
    sensor: RefCell<S>,
    directions: std::cell::UnsafeCell<Vec<[f64; 3]>>,
}

/// The declared fields of a kind, asked for once.
fn fields_of<S: Sensor>() -> Arc<[Field]> {
    static LISTS: Mutex<BTreeMap<TypeId, Arc<[Field]>>> = Mutex::new(BTreeMap::new());
    let mut lists = LISTS.lock().unwrap_or_else(PoisonError::into_inner);
    lists.entry(TypeId::of::<S>()).or_insert_with(|| S::fields().into()).clone()
}

pub(crate) fn table<S: Sensor>(keep: &mut Keep) -> *const tatu_sensor {
    let params = S::params().iter().map(|p| p.keep(keep)).collect();
    let fields = S::fields().iter().map(|f| f.keep(keep)).collect();
    let raw = tatu_sensor {
        size: size_of::<tatu_sensor>() as u32,
        inputs: S::INPUTS,
        id: keep.text(S::ID),
        text: keep.text(S::TEXT),
        schemas: keep.texts(S::SCHEMAS),
        params: keep.list(params),
        fields: keep.list(fields),
        life: keep.table(tatu_life {
            size: size_of::<tatu_life>() as u32,
            state_bytes: 0,
            create: Some(create::<S>),
            destroy: Some(destroy::<S>),
            configure: Some(configure::<S>),
            save: Some(save::<S>),
            load: Some(load::<S>),
            version: S::STATE_VERSION,
            reserved: 0,
        }),
        beams: Some(beams::<S>),
        measure: Some(measure::<S>),
        presets: {
            let presets = S::PRESETS.iter().map(|p| {
                let raw = tatu_preset {
                    size: size_of::<tatu_preset>() as u32,
                    reserved: 0,
                    id: keep.text(p.id),
                    text: keep.text(p.text),
                    settings: keep.text(p.settings),
                };
                keep.table(raw)
            });
            let presets = presets.collect();
            keep.list(presets)
        },
        finish: Some(finish::<S>),
        aim: Some(aim::<S>),
        flags: 0,
        reserved: 0,
    };
    keep.table(raw)
}

unsafe extern "C" fn create<S: Sensor>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: `me` was made by `init`; the host gives valid pointers.
        unsafe {
            let (started, info) = (&*me.cast::<Started<S::Plugin>>(), &*info);
            let declared = S::params();
            let values = ValueRef::slice(info.params, info.n_params as usize);
            let instance = Instance { owner: info.owner, id: info.id, seed: info.seed, world: info.world };
            let sensor = S::create(&started.host, instance, &Params::new(values, &declared))?;
            let (directions, image, fields) = (Vec::new().into(), (0, 0).into(), fields_of::<S>());
            let new = Data { sensor: sensor.into(), directions, image, fields, own: [0; 4].into() };
            *data = Box::into_raw(Box::new(new)).cast();
        }
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn configure<S: Sensor>(
    data: *mut c_void,
    params: *const tatu_value,
    n: u32,
    changed: u64,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        let declared = S::params();
        // SAFETY: made by `create`; the host gives one value per declared parameter.
        let (data, values) = unsafe { (&*data.cast::<Data<S>>(), ValueRef::slice(params, n as usize)) };
        let mut sensor = data.sensor.try_borrow_mut().map_err(|_| in_use())?;
        Ok(sensor.configure(&Params::new(values, &declared), changed)?.status())
    })
}

fn in_use() -> Fail {
    Fail::with_code(TATU_ERR_BUSY, "the sensor is being configured")
}

unsafe extern "C" fn destroy<S: Sensor>(data: *mut c_void) {
    guard::quiet(|| {
        // SAFETY: made by `create`, given back once.
        drop(unsafe { Box::from_raw(data.cast::<Data<S>>()) });
    });
}

unsafe extern "C" fn save<S: Sensor>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: made by `create`; the host gives a valid writer.
    guard::run(error, || unsafe {
        guard::write(writer, &(*data.cast::<Data<S>>()).sensor.try_borrow().map_err(|_| in_use())?.save()?)
    })
}

unsafe extern "C" fn load<S: Sensor>(
    data: *mut c_void,
    bytes: tatu_str,
    version: u32,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: made by `create`; the bytes are valid during the call.
        unsafe { (*data.cast::<Data<S>>()).sensor.try_borrow().map_err(|_| in_use())?.load(bytes_of(bytes), version)? };
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn beams<S: Sensor>(data: *mut c_void, out: *mut tatu_beams, error: *mut tatu_error) -> tatu_status {
    guard::run(error, || {
        // SAFETY: made by `create`; `[setup]`: nobody else uses the instance now.
        let (data, out) = unsafe { (&*data.cast::<Data<S>>(), &mut *out) };
        let beams = data.sensor.try_borrow().map_err(|_| in_use())?.beams()?;
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
        // An older host has no place for these.
        if out.size as usize >= std::mem::offset_of!(tatu_beams, reserved3) {
            (out.own, out.without) = (beams.own, beams.without);
            data.own.set(beams.own);
        }
        if out.size as usize >= std::mem::offset_of!(tatu_beams, reserved2) {
            out.waves = beams.waves;
        }
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
                data.image.set((rows, columns));
            }
            Form::Parallel { columns, rows, width } => {
                out.form = TATU_BEAMS_PARALLEL;
                out.count = [columns, rows];
                out.dims[0] = width;
                data.image.set((rows, columns));
            }
            Form::Rays(directions) => {
                out.form = TATU_BEAMS_RAYS;
                out.count = [u32::try_from(directions.len()).map_err(|_| Fail::new("too many rays"))?, 1];
                // SAFETY: `[setup]`, as above.
                let kept = unsafe { &mut *data.directions.get() };
                *kept = directions;
                out.directions = kept.as_ptr().cast();
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
    // SAFETY: the host gives a valid batch; its instances belong to this call alone.
    unsafe { each::<S>(batch, error, S::measure) }
}

unsafe extern "C" fn finish<S: Sensor>(
    _: *mut c_void,
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host gives a valid batch; its instances belong to this call alone.
    unsafe { each::<S>(batch, error, S::finish) }
}

unsafe extern "C" fn aim<S: Sensor>(
    _: *mut c_void,
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
) -> tatu_status {
    let act = |sensor: &S, sample: &Sample<'_>, _: &mut Readout<'_>| {
        let (from, to) = sample.beams();
        let Some(rays) = sample.ray_list() else { return Ok(()) };
        // SAFETY: 6 numbers per ray, of this instance alone.
        sensor.aim(sample, unsafe { std::slice::from_raw_parts_mut(rays, to - from) })
    };
    // SAFETY: the host gives a valid batch; its instances belong to this call alone.
    unsafe { each::<S>(batch, error, act) }
}

/// Does something with each sensor of a batch; one that failed before is left alone.
///
/// # Safety
/// The batch is valid, and its instances are used by nobody else.
unsafe fn each<S: Sensor>(
    batch: *const tatu_sensor_batch,
    error: *mut tatu_error,
    act: impl Fn(&S, &Sample<'_>, &mut Readout<'_>) -> Result,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: the caller promises it.
        let batch = unsafe { &*batch };
        for i in 0..batch.n as usize {
            // SAFETY: one status and one entry per instance.
            let (data, status) = unsafe { (&*(*batch.data.add(i)).cast::<Data<S>>(), &mut *batch.status.add(i)) };
            if *status < 0 {
                continue;
            }
            let sample = Sample { batch, i };
            let mut out =
                Readout { sample: &sample, fields: &data.fields, image: data.image.get(), own: data.own.get() };
            let sensor = data.sensor.try_borrow().map_err(|_| in_use());
            if let Err(fail) = sensor.and_then(|sensor| act(&sensor, &sample, &mut out)) {
                // SAFETY: the host's error object.
                *status = unsafe { fail.write(error) };
            }
        }
        Ok(TATU_OK)
    })
}
