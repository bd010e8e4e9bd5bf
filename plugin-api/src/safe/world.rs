//! A world, as plugins see it: objects, poses, readings, bodies. What is said in it stands in `talk`.

use std::ffi::{CStr, CString};

use super::value::Room;
use super::{
    Fail, Host, Prop, Result, Value, ValueRef,
    fail::{bytes_of, bytes_raw, text_raw},
};
use crate::abi::*;

/// An object and its kind (`TATU_KIND_*`), checked to exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Object {
    /// Generation and slot.
    pub id: tatu_object,
    /// `TATU_KIND_*`.
    pub kind: i32,
}

impl Object {
    /// The number that scripts see.
    pub fn handle(self) -> i64 {
        (self.id & 0xF_FFFF) as i64
    }
}

/// The shortest way between two shapes, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// On the first, m.
    pub from: [f64; 3],
    /// On the second, m.
    pub to: [f64; 3],
    /// The shapes.
    pub pair: [tatu_object; 2],
}

/// Two shapes that touch.
pub type Contact = tatu_contact;

/// One field of a sensor's last reading.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    view: tatu_field_view,
    life: std::marker::PhantomData<&'a ()>,
}

impl<'a> Reading<'a> {
    /// How often the sensor has been handled; 0: never, or reset since.
    pub fn sequence(&self) -> u64 {
        self.view.sequence
    }
    /// Simulation time of the reading, s.
    pub fn time(&self) -> f64 {
        self.view.time
    }
    /// Shape, outermost first.
    pub fn dims(&self) -> [u32; 3] {
        self.view.dims
    }
    fn slice<T>(&self, elem: u32) -> &'a [T] {
        if self.view.elem != elem || self.view.ptr.is_null() {
            return &[];
        }
        // SAFETY: the host's buffer has this many elements of this type, valid until the sensor is next handled.
        unsafe { std::slice::from_raw_parts(self.view.ptr.cast(), self.view.len as usize) }
    }
    /// The numbers, if they are doubles.
    pub fn f64s(&self) -> &'a [f64] {
        self.slice(TATU_ELEM_F64)
    }
    /// The numbers, if they are 32-bit integers.
    pub fn i32s(&self) -> &'a [i32] {
        self.slice(TATU_ELEM_I32)
    }
    /// The numbers, if they are 32-bit floats.
    pub fn f32s(&self) -> &'a [f32] {
        self.slice(TATU_ELEM_F32)
    }
    /// The numbers, if they are 16-bit numbers.
    pub fn u16s(&self) -> &'a [u16] {
        self.slice(TATU_ELEM_U16)
    }
    /// The bytes, if they are bytes.
    pub fn u8s(&self) -> &'a [u8] {
        self.slice(TATU_ELEM_U8)
    }
    /// `TATU_ELEM_*`.
    pub fn elem(&self) -> u32 {
        self.view.elem
    }
    /// The objects, if they are objects.
    pub fn objects(&self) -> &'a [tatu_object] {
        self.slice(TATU_ELEM_OBJECT)
    }
}

/// A world during a call.
#[derive(Clone, Copy)]
pub struct World<'a> {
    raw: *mut tatu_world,
    pub(super) host: &'a Host,
}

/// Calls a function of a service, or says that this host lacks it.
macro_rules! service {
    ($world:ident . $table:ident . $function:ident) => {
        $world.host.$table.and_then(|t| t.$function).ok_or_else(|| {
            $crate::safe::Fail::unsupported(concat!(
                "this host offers no ",
                stringify!($table),
                ".",
                stringify!($function)
            ))
        })?
    };
}

pub(super) use service;

impl<'a> World<'a> {
    /// # Safety
    /// `raw` is a world of `host`, and this is a `[step]` call of it.
    pub(crate) unsafe fn new(raw: *mut tatu_world, host: &'a Host) -> Self {
        World { raw, host }
    }
    /// A world from its pointer: for plugins that keep it between calls.
    ///
    /// # Safety
    /// `raw` is a living world of `host`, and this is a `[step]` call of it.
    pub unsafe fn from_raw(raw: *mut tatu_world, host: &'a Host) -> Self {
        World { raw, host }
    }
    /// The raw pointer.
    pub fn raw(&self) -> *mut tatu_world {
        self.raw
    }
    /// The host.
    pub fn host(&self) -> &'a Host {
        self.host
    }
    pub(super) fn check(&self, status: tatu_status) -> Result {
        if status >= 0 { Ok(()) } else { Err(self.refusal(status)) }
    }
    #[cold]
    fn refusal(&self, status: tatu_status) -> Fail {
        match self.host.log.and_then(|l| l.last_error) {
            // SAFETY: the host gives a live error or null.
            Some(last) => unsafe { Fail::read(status, last(self.raw)) },
            None => Fail::with_code(status, "refused"),
        }
    }

    /// Checks a number that a script gave, or an id: it must name an object.
    pub fn look(&self, object: tatu_object) -> Result<Object> {
        let (mut id, mut kind) = (0, 0);
        // SAFETY: valid pointers; likewise in all calls below.
        self.check(unsafe { service!(self.scene.look)(self.raw, object, &mut id, &mut kind) })?;
        Ok(Object { id, kind })
    }
    /// Finds an object by path or unique name.
    pub fn find(&self, from: tatu_object, path: &str) -> Result<tatu_object> {
        let mut id = 0;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.find)(self.raw, from, text_raw(path), &mut id) })?;
        Ok(id)
    }
    /// Reads a property; text and arrays live until the call that you are in returns.
    pub fn get(&self, object: tatu_object, prop: Prop) -> Result<ValueRef<'a>> {
        let mut value = ValueRef::NIL.raw();
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the value lives until the plugin's call returns, which 'a does not outlive.
        unsafe {
            self.check(service!(self.scene.get)(self.raw, object, prop.0, &mut value))?;
            Ok(ValueRef::new(value))
        }
    }
    /// Reads `N` numbers of a property.
    #[inline]
    pub fn f64s<const N: usize>(&self, object: tatu_object, prop: Prop) -> Result<[f64; N]> {
        let mut out = [0.0; N];
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.get_f64)(self.raw, object, prop.0, out.as_mut_ptr(), N as u32) })?;
        Ok(out)
    }
    /// Reads one number.
    #[inline]
    pub fn f64(&self, object: tatu_object, prop: Prop) -> Result<f64> {
        Ok(self.f64s::<1>(object, prop)?[0])
    }
    /// Sets a property.
    pub fn set(&self, object: tatu_object, prop: Prop, value: &Value) -> Result {
        let mut room = Room::default();
        let raw = room.raw(value);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; `room` lives until after the call.
        self.check(unsafe { service!(self.scene.set)(self.raw, object, prop.0, &raw) })
    }
    /// Sets numbers of a property.
    #[inline]
    pub fn set_f64s(&self, object: tatu_object, prop: Prop, values: &[f64]) -> Result {
        let (ptr, n) = (values.as_ptr(), values.len() as u32);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.set_f64)(self.raw, object, prop.0, ptr, n) })
    }
    /// Pose in a frame (0: world): x y z, quaternion x y z w.
    pub fn pose(&self, object: tatu_object, frame: tatu_object) -> Result<[f64; 7]> {
        let mut out = [0.0; 7];
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.pose)(self.raw, object, frame, out.as_mut_ptr()) })?;
        Ok(out)
    }
    /// Places an object.
    pub fn set_pose(&self, object: tatu_object, frame: tatu_object, pose: &[f64; 7]) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.set_pose)(self.raw, object, frame, pose.as_ptr()) })
    }
    /// Makes an object.
    pub fn create(&self, kind: &str, parent: tatu_object, alias: &str) -> Result<tatu_object> {
        let kind = CString::new(kind).unwrap_or_default();
        let mut id = 0;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.create)(self.raw, kind.as_ptr(), parent, text_raw(alias), &mut id) })?;
        Ok(id)
    }
    /// Removes objects.
    pub fn remove(&self, objects: &[tatu_object]) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.remove)(self.raw, objects.as_ptr(), objects.len() as u32) })
    }
    /// Lists objects below `base` (0: all); see the header for `kinds` and `flags`.
    pub fn list(&self, base: tatu_object, kinds: u32, flags: u32) -> Result<Vec<tatu_object>> {
        let list = service!(self.scene.list);
        self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { list(self.raw, base, kinds, flags, out, cap, n) }
        })
    }
    /// Copies objects, in place; the copies in the same order.
    pub fn copy(&self, objects: &[tatu_object]) -> Result<Vec<tatu_object>> {
        let mut out = vec![0; objects.len()];
        let (from, n) = (objects.as_ptr(), objects.len() as u32);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.copy)(self.raw, from, n, out.as_mut_ptr()) })?;
        Ok(out)
    }
    /// Reads a scene file, or one that an importer reads, below `parent` (0: the world); its first object. `file` is what
    /// [`World::file`] gave.
    pub fn load(&self, file: &[u8], parent: tatu_object) -> Result<tatu_object> {
        let mut out = 0;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.load)(self.raw, bytes_raw(file), parent, &mut out) })?;
        Ok(out)
    }
    /// Writes an object and all below it (0: the whole scene) as a scene file. `file` is what [`World::file`] gave.
    pub fn save(&self, file: &[u8], base: tatu_object) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.scene.save)(self.raw, bytes_raw(file), base) })
    }
    pub(super) fn fill<T: Copy + Default>(
        &self,
        call: impl Fn(*mut T, u32, *mut u32) -> tatu_status,
    ) -> Result<Vec<T>> {
        let (mut out, mut n) = (vec![T::default(); 64], 0);
        loop {
            self.check(call(out.as_mut_ptr(), out.len() as u32, &mut n))?;
            if n as usize <= out.len() {
                out.truncate(n as usize);
                return Ok(out);
            }
            out.resize(n as usize, T::default());
        }
    }

    /// One field of a sensor's last reading.
    #[inline]
    pub fn reading(&self, sensor: tatu_object, field: Prop) -> Result<Reading<'a>> {
        let mut view = tatu_field_view { ptr: std::ptr::null(), len: 0, elem: 0, dims: [0; 3], time: 0.0, sequence: 0 };
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.readings.field)(self.raw, sensor, field.0, &mut view) })?;
        Ok(Reading { view, life: std::marker::PhantomData })
    }
    /// Handles a sensor now; `only`: see only this object, 0: all.
    pub fn sense_now(&self, sensor: tatu_object, only: tatu_object) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.readings.sense_now)(self.raw, sensor, only) })
    }
    /// Handles a sensor now, with a look of its own; `size` is set here.
    pub fn look_through(&self, sensor: tatu_object, look: tatu_look) -> Result {
        let look = tatu_look { size: size_of::<tatu_look>() as u32, ..look };
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.readings.look)(self.raw, sensor, &look) })
    }
    /// Forgets a sensor's reading.
    pub fn reset_reading(&self, sensor: tatu_object) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.readings.reset)(self.raw, sensor) })
    }
    /// The sensors that fill a schema ("proximity/1").
    pub fn sensors(&self, schema: &str) -> Result<Vec<tatu_object>> {
        let schema = CString::new(schema).unwrap_or_default();
        let list = service!(self.readings.list);
        self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { list(self.raw, schema.as_ptr(), out, cap, n) }
        })
    }

    /// The declaration of a sensor's `index`-th field, with its shape for this sensor: name and shape. `None`: no more.
    pub fn field_of(&self, sensor: tatu_object, index: u32) -> Option<(&'a str, [u32; 3])> {
        let describe = self.host.readings.and_then(|t| t.describe)?;
        // SAFETY: a table of numbers and pointers, which may be null.
        let mut field: tatu_field = unsafe { std::mem::zeroed() };
        field.size = size_of::<tatu_field>() as u32;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the name lives as long as the world.
        unsafe {
            (describe(self.raw, sensor, index, &mut field) >= 0 && !field.name.is_null())
                .then(|| CStr::from_ptr(field.name).to_str().ok())
                .flatten()
                .map(|name| (name, field.dims))
        }
    }

    /// Velocity of an object: m/s, rad/s, world.
    pub fn twist(&self, object: tatu_object) -> Result<[f64; 6]> {
        let mut out = [0.0; 6];
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.bodies.twist)(self.raw, object, out.as_mut_ptr()) })?;
        Ok(out)
    }
    /// Sets the velocity of a dynamic shape.
    pub fn set_twist(&self, object: tatu_object, twist: &[f64; 6]) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.bodies.set_twist)(self.raw, object, twist.as_ptr()) })
    }
    /// Pushes a dynamic shape in the next physics step: N and N m at its centre of mass, world.
    pub fn push(&self, object: tatu_object, force: &[f64; 3], torque: &[f64; 3]) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.bodies.push)(self.raw, object, force.as_ptr(), torque.as_ptr()) })
    }
    /// Touching pairs of a shape, or (0) of all.
    pub fn contacts(&self, object: tatu_object) -> Result<Vec<Contact>> {
        let contacts = service!(self.bodies.contacts);
        self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { contacts(self.raw, object, out, cap, n) }
        })
    }

    /// Friction at the contacts of [`Self::contacts`], in the same order: N, world, on the second shape.
    pub fn frictions(&self, object: tatu_object) -> Result<Vec<[f64; 3]>> {
        let frictions = service!(self.bodies.frictions);
        let numbers: Vec<f64> = self.fill(|out, cap, n| {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { frictions(self.raw, object, out, cap, n) }
        })?;
        Ok(numbers.as_chunks::<3>().0.to_vec())
    }

    /// The shortest way from any shape of a list to any of another (empty: to any other shape), no longer than `limit`
    /// if that is above 0: both ends, and the two shapes. `None`: there is none so near.
    pub fn closest(&self, a: &[tatu_object], b: &[tatu_object], limit: f64) -> Result<Option<Closest>> {
        let (mut points, mut pair) = ([0.0; 6], [0; 2]);
        let (ap, an, bp, bn) = (a.as_ptr(), a.len() as u32, b.as_ptr(), b.len() as u32);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        let status = unsafe {
            service!(self.bodies.closest)(self.raw, ap, an, bp, bn, limit, points.as_mut_ptr(), pair.as_mut_ptr())
        };
        match status {
            TATU_ERR_MISSING => Ok(None),
            status => self.check(status).map(|()| {
                let [a, b, c, d, e, f] = points;
                Some(Closest { from: [a, b, c], to: [d, e, f], pair })
            }),
        }
    }
    /// Whether the engine moves an object: dynamic shapes and joints between two bodies, once physics has run.
    pub fn is_dynamic(&self, object: tatu_object) -> Result<bool> {
        let mut yes = 0;
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.bodies.is_dynamic)(self.raw, object, &mut yes) })?;
        Ok(yes != 0)
    }
    /// Asks for a change of state, which takes effect after passes: one of `TATU_REQUEST_*`.
    pub fn request(&self, what: u32) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.session.request)(self.raw, what) })
    }
    /// The `index`-th thing that came in from outside since the start, but for what services did: its kind ("key") and
    /// its text. `None`: no more has come.
    pub fn input(&self, index: u64) -> Option<(String, String)> {
        let input = self.host.session?.input?;
        let (mut kind, mut text) = (bytes_raw(&[]), bytes_raw(&[]));
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the texts are copied at once.
        unsafe {
            let of = |s| String::from_utf8_lossy(bytes_of(s)).into_owned();
            (input(self.raw, index, &mut kind, &mut text) >= 0).then(|| (of(kind), of(text)))
        }
    }
    /// Runs one stage now, as a driver does: one of `TATU_STAGE_*`.
    pub fn run_stage(&self, stage: u32, dt: f64) -> Result {
        // SAFETY: the world is that of the running call, and what is passed lives until it returns.
        self.check(unsafe { service!(self.stage.run)(self.raw, stage, dt) })
    }
    /// The real path of a file as a script names it, if the run allows it: `TATU_FILE_READ` or `TATU_FILE_WRITE`.
    pub fn file(&self, name: &[u8], mode: u32) -> Result<Vec<u8>> {
        let mut path = bytes_raw(&[]);
        // SAFETY: the world is that of the running call, and what is passed lives until it returns; the path is copied at once.
        unsafe {
            self.check(service!(self.files.resolve)(self.raw, bytes_raw(name), mode, &mut path))?;
            Ok(bytes_of(path).to_vec())
        }
    }
    /// Writes a line to the log: `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &[u8]) {
        if let Some(write) = self.host.log.and_then(|l| l.write) {
            // SAFETY: the world is that of the running call, and what is passed lives until it returns.
            unsafe { write(self.host.raw(), self.raw, level, bytes_raw(text)) };
        }
    }
}
