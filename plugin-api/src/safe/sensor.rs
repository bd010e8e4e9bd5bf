//! Sensor kinds: beams and a measure.

use std::{cell::RefCell, f64::consts::FRAC_PI_2, ffi::c_void};

use super::{
    Fail, Host, Instance, Param, Params, Plugin, Result, ValueRef, fail::bytes_of, guard, offer::Keep, plugin::Started,
};
use crate::abi::*;

/// One field that a sensor fills.
#[derive(Debug, Clone)]
pub struct Field {
    name: &'static str,
    elem: u32,
    dims: [u32; 3],
    unit: Option<&'static str>,
    text: &'static str,
}

impl Field {
    fn of(name: &'static str, elem: u32) -> Self {
        Field { name, elem, dims: [1; 3], unit: None, text: "" }
    }
    /// Doubles. Name: `<schema>.<field>`.
    pub fn f64(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F64)
    }
    /// 32-bit integers.
    pub fn i32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_I32)
    }
    /// 32-bit floats.
    pub fn f32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F32)
    }
    /// 16-bit numbers.
    pub fn u16(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U16)
    }
    /// Bytes.
    pub fn u8(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U8)
    }
    /// Objects.
    pub fn object(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_OBJECT)
    }
    /// Shape, outermost first; 0: as many as there are beams or pixels; [`TATU_DIM_ROWS`] and [`TATU_DIM_COLUMNS`] of
    /// the image.
    pub fn dims(mut self, dims: [u32; 3]) -> Self {
        self.dims = dims;
        self
    }
    /// Unit.
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }
    /// One sentence, with the meaning of "nothing".
    pub fn text(mut self, text: &'static str) -> Self {
        self.text = text;
        self
    }
    fn keep(&self, keep: &mut Keep) -> *const tatu_field {
        let raw = tatu_field {
            size: size_of::<tatu_field>() as u32,
            elem: self.elem,
            dims: self.dims,
            reserved: 0,
            name: keep.text(self.name),
            unit: self.unit.map_or(std::ptr::null(), |u| keep.text(u)),
            text: keep.text(self.text),
        };
        keep.table(raw)
    }
}

/// Form of the beams; they leave the sensor's origin and look along its +z.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// None: the sensor looks at its own motion only.
    None,
    /// Rays along these unit vectors, in the sensor's frame.
    Rays(Vec<[f64; 3]>),
    /// A volume with a round far end; half of the opening angle, rad, 0 to pi.
    Cone {
        /// Half of the opening angle, rad.
        half_angle: f64,
    },
    /// Another volume, `TATU_BEAMS_PYRAMID`, `_CYLINDER` or `_DISC`, with its numbers as `tatu.h` tells.
    Volume {
        /// Which.
        form: u32,
        /// Its numbers.
        dims: [f64; 6],
    },
    /// A pinhole image with square pixels: `horizontal_angle` rad.
    Image {
        /// Pixels in a row.
        columns: u32,
        /// Rows.
        rows: u32,
        /// Between the left and the right edge of the image, rad.
        horizontal_angle: f64,
    },
    /// An image of parallel rays with square pixels, `width` m.
    Parallel {
        /// Pixels in a row.
        columns: u32,
        /// Rows.
        rows: u32,
        /// From the left to the right edge of the image, m.
        width: f64,
    },
}

/// What a sensor sends out.
#[derive(Debug, Clone, PartialEq)]
pub struct Beams {
    /// Their form.
    pub form: Form,
    /// Nothing is seen nearer, m.
    pub near: f64,
    /// Nothing is seen farther, m.
    pub far: f64,
    /// Greatest angle between line of sight and surface normal, rad; pi/2: no limit.
    pub max_incidence: f64,
    /// Objects of the sensor's own model are not seen.
    pub skip_own_model: bool,
    /// Whether faces turned to the sensor, and faces turned away, are seen.
    pub faces: (bool, bool),
    /// Visible objects are seen, as by a camera, instead of detectable ones.
    pub visible: bool,
    /// Numbers that [`TATU_DIM_OWN`] stands for in shapes of fields; 0: there is no such field.
    pub own: [u32; 4],
    /// `TATU_IN_*`: inputs that this one does not need; what it is given of them is 0, or not there.
    pub without: u32,
    /// What a volume finds counts only if nothing lies between it and the sensor.
    pub occlude: bool,
    /// What they are made of: a sum of `TATU_WAVES_*`.
    pub waves: u32,
    /// They are rays that [`Sensor::aim`] moves and turns.
    pub aimed: bool,
}

impl Default for Beams {
    fn default() -> Self {
        Beams {
            form: Form::None,
            near: 0.0,
            far: f64::INFINITY,
            max_incidence: FRAC_PI_2,
            skip_own_model: false,
            faces: (true, true),
            visible: false,
            own: [0; 4],
            without: 0,
            occlude: false,
            waves: TATU_WAVES_ALL,
            aimed: false,
        }
    }
}

/// What one sensor of a batch sees.
pub struct Sample<'a> {
    batch: &'a tatu_sensor_batch,
    i: usize,
}

impl<'a> Sample<'a> {
    fn beams(&self) -> (usize, usize) {
        // SAFETY: `first_beam` has n + 1 entries.
        unsafe { (*self.batch.first_beam.add(self.i) as usize, *self.batch.first_beam.add(self.i + 1) as usize) }
    }
    fn per_beam<T>(&self, ptr: *const T) -> &'a [T] {
        let (from, to) = self.beams();
        if ptr.is_null() || from == to {
            return &[];
        }
        // SAFETY: the host's arrays hold all beams of the batch.
        unsafe { std::slice::from_raw_parts(ptr.add(from), to - from) }
    }
    /// Simulation time, s.
    pub fn time(&self) -> f64 {
        self.batch.time
    }
    /// The sensor.
    pub fn sensor(&self) -> tatu_object {
        // SAFETY: one per instance.
        unsafe { *self.batch.sensor.add(self.i) }
    }
    /// Per beam: distance, m; infinity: nothing. Asked for with `TATU_IN_DISTANCE`.
    pub fn distances(&self) -> &'a [f64] {
        self.per_beam(self.batch.distance)
    }
    /// Per beam: point, sensor frame, m. `TATU_IN_POINT`.
    pub fn points(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.point.cast())
    }
    /// Per beam: unit normal, sensor frame. `TATU_IN_NORMAL`.
    pub fn normals(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.normal.cast())
    }
    /// Per beam: the object seen. `TATU_IN_OBJECT`.
    pub fn objects(&self) -> &'a [tatu_object] {
        self.per_beam(self.batch.object)
    }
    /// Per beam: red green blue. `TATU_IN_COLOR`.
    pub fn colors(&self) -> &'a [[u8; 3]] {
        self.per_beam(self.batch.color.cast())
    }
    /// Per beam: which triangle or face. `TATU_IN_PRIMITIVE`.
    pub fn primitives(&self) -> &'a [u32] {
        self.per_beam(self.batch.primitive)
    }

    fn pixels(&self) -> (usize, usize) {
        if self.batch.first_pixel.is_null() {
            return (0, 0);
        }
        // SAFETY: `first_pixel` has n + 1 entries.
        unsafe { (*self.batch.first_pixel.add(self.i) as usize, *self.batch.first_pixel.add(self.i + 1) as usize) }
    }
    fn per_pixel<T>(&self, ptr: *const T) -> &'a [T] {
        let (from, to) = self.pixels();
        if ptr.is_null() || from == to {
            return &[];
        }
        // SAFETY: the host's arrays hold all pixels of the batch.
        unsafe { std::slice::from_raw_parts(ptr.add(from), to - from) }
    }
    /// Per pixel, the lowest row first: m along +z; infinity: nothing. `TATU_IN_DISTANCE`.
    pub fn depths(&self) -> &'a [f32] {
        self.per_pixel(self.batch.depth)
    }
    /// Per pixel: red green blue. `TATU_IN_COLOR`.
    pub fn pixel_colors(&self) -> &'a [[u8; 3]] {
        self.per_pixel(self.batch.pixel_color.cast())
    }
    /// Per pixel: cosine of the angle between line of sight and normal. `TATU_IN_COSINE`.
    pub fn pixel_cosines(&self) -> &'a [f32] {
        self.per_pixel(self.batch.pixel_cosine)
    }
    /// Per pixel: the object seen. `TATU_IN_OBJECT`.
    pub fn pixel_objects(&self) -> &'a [tatu_object] {
        self.per_pixel(self.batch.pixel_object)
    }

    /// Per beam: where it begins and points, in the sensor's frame; empty if they are not aimed.
    pub fn rays(&self) -> &'a [[f64; 6]] {
        let (from, to) = self.beams();
        match self.ray_list() {
            // SAFETY: 6 numbers per ray of this instance.
            Some(rays) => unsafe { std::slice::from_raw_parts(rays, to - from) },
            None => &[],
        }
    }
    fn ray_list(&self) -> Option<*mut [f64; 6]> {
        // An older host has no such list.
        if (self.batch.size as usize) < size_of::<tatu_sensor_batch>() || self.batch.rays.is_null() {
            return None;
        }
        // SAFETY: one entry per instance.
        let rays = unsafe { *self.batch.rays.add(self.i) };
        (!rays.is_null()).then_some(rays.cast())
    }

    fn draw(
        &self,
        fill: impl Fn(&tatu_random) -> Option<unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64)>,
        first: u64,
        out: &mut [f64],
    ) {
        // SAFETY: the host's generator, or null from a host that has none: then the numbers stay as they are.
        if let Some(random) = unsafe { self.batch.random.as_ref() }
            && let Some(fill) = fill(random)
        {
            // SAFETY: `out` has as many places as asked for.
            unsafe { fill(random, self.i as u32, first, out.len() as u64, out.as_mut_ptr()) };
        }
    }
    /// Numbers from 0 to below 1: those with the indices from `first` on of this sensor's measure.
    pub fn uniform(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.uniform, first, out);
    }
    /// Numbers of the normal distribution, mean 0, standard deviation 1.
    pub fn normal(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.normal, first, out);
    }

    /// The sensor's pose in the world. `TATU_IN_POSE`.
    pub fn pose(&self) -> Option<[f64; 7]> {
        // SAFETY: 7 per instance, if asked for.
        (!self.batch.pose.is_null()).then(|| unsafe { *self.batch.pose.cast::<[f64; 7]>().add(self.i) })
    }
    /// The twist of its mount. `TATU_IN_TWIST`.
    pub fn twist(&self) -> Option<[f64; 6]> {
        // SAFETY: 6 per instance, if asked for.
        (!self.batch.twist.is_null()).then(|| unsafe { *self.batch.twist.cast::<[f64; 6]>().add(self.i) })
    }
}

/// Where a sensor writes its fields, in the order of declaration.
pub struct Readout<'a> {
    sample: &'a Sample<'a>,
    fields: &'a [Field],
    /// Rows and columns of the sensor's image.
    image: (u32, u32),
    own: [u32; 4],
}

impl Readout<'_> {
    fn slice<T>(&mut self, k: usize, elem: u32) -> &mut [T] {
        let Some(field) = self.fields.get(k).filter(|f| f.elem == elem) else {
            return &mut [];
        };
        let count = |(from, to): (usize, usize)| to - from;
        let all = count(self.sample.beams()) + count(self.sample.pixels());
        let dim = |d: &u32| match *d {
            0 => all,
            TATU_DIM_ROWS => self.image.0 as usize,
            TATU_DIM_COLUMNS => self.image.1 as usize,
            d if (TATU_DIM_OWN..TATU_DIM_OWN + 4).contains(&d) => self.own[(d - TATU_DIM_OWN) as usize] as usize,
            n => n as usize,
        };
        let len: usize = field.dims.iter().map(dim).product();
        // SAFETY: the host gives one buffer per instance and field, as large as declared.
        unsafe {
            let at = *self.sample.batch.fields.add(self.sample.i * self.sample.batch.n_fields as usize + k);
            std::slice::from_raw_parts_mut(at.cast(), len)
        }
    }
    /// Field `k`, declared with [`Field::f64`].
    pub fn f64(&mut self, k: usize) -> &mut [f64] {
        self.slice(k, TATU_ELEM_F64)
    }
    /// Field `k`, declared with [`Field::i32`].
    pub fn i32(&mut self, k: usize) -> &mut [i32] {
        self.slice(k, TATU_ELEM_I32)
    }
    /// Field `k`, declared with [`Field::f32`].
    pub fn f32(&mut self, k: usize) -> &mut [f32] {
        self.slice(k, TATU_ELEM_F32)
    }
    /// Field `k`, declared with [`Field::u16`].
    pub fn u16(&mut self, k: usize) -> &mut [u16] {
        self.slice(k, TATU_ELEM_U16)
    }
    /// Field `k`, declared with [`Field::u8`].
    pub fn u8(&mut self, k: usize) -> &mut [u8] {
        self.slice(k, TATU_ELEM_U8)
    }
    /// Field `k`, declared with [`Field::object`].
    pub fn object(&mut self, k: usize) -> &mut [tatu_object] {
        self.slice(k, TATU_ELEM_OBJECT)
    }
}

/// Settings under a name: `(id, one sentence with the source of the numbers, lines of TOML as a scene writes them)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// "hokuyo_urg_04lx"
    pub id: &'static str,
    /// One sentence, with the source of the numbers.
    pub text: &'static str,
    /// What a scene would write in the object of the sensor, its noise included.
    pub settings: &'static str,
}

/// A kind of sensor. One value per sensor in a world.
pub trait Sensor: Sized + Send + Sync + 'static {
    /// The plugin that offers it.
    type Plugin: Plugin;
    /// What scenes write: "proximity".
    const ID: &'static str;
    /// One sentence.
    const TEXT: &'static str;
    /// What readers look for: "proximity/1".
    const SCHEMAS: &'static [&'static str];
    /// What the measure wants: a sum of `TATU_IN_*`.
    const INPUTS: u32;

    /// Its parameters.
    fn params() -> Vec<Param>;
    /// What it fills.
    fn fields() -> Vec<Field>;
    /// Settings under a name.
    const PRESETS: &'static [Preset] = &[];
    /// Makes one.
    fn create(host: &Host, instance: Instance, params: &Params<'_>) -> Result<Self>;
    /// Whether it takes new values of live parameters by [`Sensor::configure`]; else any change makes a new sensor.
    const CONFIGURES: bool = false;
    /// Takes new values: `changed` has a bit for each parameter, in the order of declaration. It is then asked for its
    /// beams. After an error it is as if nothing had changed. A parameter with [`Param::rebuilds`] never comes here.
    fn configure(&mut self, params: &Params<'_>, changed: u64) -> Result {
        let _ = (params, changed);
        Err(Fail::unsupported("it takes no new values"))
    }
    /// Its beams.
    fn beams(&self) -> Result<Beams>;
    /// Version of what [`Sensor::save`] writes; count it when that changes.
    const STATE_VERSION: u32 = 0;
    /// What a reading depends on beside parameters and what is seen, for a snapshot. Most sensors have no such thing.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Takes back what `save` of `version` wrote, into a sensor made with the same parameters.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("it reads no state")) }
    }
    /// Turns what was seen into a reading. Must not block; runs on several threads.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result;
    /// Whether [`Sensor::aim`] is there for instances whose [`Beams::aimed`] asks for it.
    const AIMS: bool = false;
    /// Moves and turns rays before they are cast: origin (m) and unit direction of each, in the sensor's frame. Of the
    /// sample, what was met is not there yet.
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let _ = (sample, rays);
        Ok(())
    }
    /// Whether [`Sensor::finish`] is called.
    const FINISHES: bool = false;
    /// Brings fields that follow from others in line with them, after the noise that a scene declares. As
    /// [`Sensor::measure`], but for the fields, which are as the noise left them. Not called where there is no noise, so
    /// `measure` fills all fields.
    fn finish(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let _ = (sample, out);
        Ok(())
    }
}

/// What the host keeps as `data`: the sensor, and the directions that its beams point to.
struct Data<S: Sensor> {
    /// In a cell: while it is configured nothing else may use it, not even what it calls itself. Each instance is used
    /// by one thread at a time.
    sensor: RefCell<S>,
    directions: std::cell::UnsafeCell<Vec<[f64; 3]>>,
    /// Rows and columns of its image.
    image: std::cell::Cell<(u32, u32)>,
    /// As declared: asked for once, since a script may measure hundreds of times in a call.
    fields: Vec<Field>,
    /// Lengths of its own that fields may have.
    own: std::cell::Cell<[u32; 4]>,
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
            configure: if S::CONFIGURES { Some(configure::<S>) } else { None },
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
        finish: if S::FINISHES { Some(finish::<S>) } else { None },
        aim: if S::AIMS { Some(aim::<S>) } else { None },
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
            let (directions, image, fields) = (Vec::new().into(), (0, 0).into(), S::fields());
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
        data.sensor.try_borrow_mut().map_err(|_| in_use())?.configure(&Params::new(values, &declared), changed)?;
        Ok(TATU_OK)
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
    // SAFETY: as above.
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
    // SAFETY: as above.
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
        // SAFETY: as promised.
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
