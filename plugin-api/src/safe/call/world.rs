//! A world with exclusive access: objects, poses, sensors, bodies. Signals, events and calls are in `talk`; functions
//! that may be used on several threads are in `shared_world`.

use std::{ffi::CString, ops::Deref};

use crate::abi::*;
use crate::safe::{Fail, Host, Result, SharedWorld, call::shared_world::service};

/// The shortest segment between two shapes, in the world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// End on the first shape, m.
    pub from: [f64; 3],
    /// End on the second shape, m.
    pub to: [f64; 3],
    /// The shapes, in the same order.
    pub pair: [tatu_object; 2],
}

/// A contact between two shapes.
pub type Contact = tatu_contact;

/// A world to which the current call has exclusive access.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct World<'a>(SharedWorld<'a>);

impl<'a> Deref for World<'a> {
    type Target = SharedWorld<'a>;
    fn deref(&self) -> &SharedWorld<'a> {
        &self.0
    }
}

impl<'a> World<'a> {
    /// Wraps the world that the host passed in a call to the plugin.
    ///
    /// # Safety
    /// `world` must be null or a world of `host`, and `'a` must end no later than the call in which `world` was
    /// passed.
    pub unsafe fn new(world: *mut tatu_world, host: &'a Host) -> Self {
        // SAFETY: the caller guarantees the same as `WorldRef::new` requires.
        Self::of(unsafe { WorldRef::new(world) }, host)
    }
    pub(crate) fn of(world: WorldRef<'a>, host: &'a Host) -> Self {
        World(SharedWorld::new(world, host))
    }

    /// Returns a placeholder without a world, for tests with [`Host::without_services`]; all its functions fail.
    pub fn nowhere(host: &'a Host) -> Self {
        // SAFETY: a null world is allowed with any host.
        unsafe { Self::new(std::ptr::null_mut(), host) }
    }

    /// Sets the pose of an object in the frame of another, or in the world frame if `frame` is 0: x y z, then the unit
    /// quaternion x y z w.
    pub fn set_pose(&self, object: tatu_object, frame: tatu_object, pose: &[f64; 7]) -> Result {
        self.check(service!(self.scene.set_pose)(self.raw(), object, frame, Some(pose)))
    }
    /// Creates an object of a kind ("dummy") below `parent`, or at the top level if that is 0.
    pub fn create(&self, kind: &str, parent: tatu_object, alias: &str) -> Result<tatu_object> {
        let kind = CString::new(kind).unwrap_or_default();
        let mut id = 0;
        self.check(service!(self.scene.create)(
            self.raw(),
            kind.as_c_str().into(),
            parent,
            alias.into(),
            Some(&mut id),
        ))?;
        Ok(id)
    }
    /// Removes objects. Their children become children of their parents.
    pub fn remove(&self, objects: &[tatu_object]) -> Result {
        let remove = service!(self.scene.remove);
        // SAFETY: the pointer and the count are those of the slice `objects`.
        self.check(unsafe { remove(self.raw(), objects.as_ptr(), objects.len() as u32) })
    }
    /// Lists objects below `base`, or all objects if it is 0; see the header for `kinds` and `flags`.
    pub fn list(&self, base: tatu_object, kinds: u32, flags: u32) -> Result<Vec<tatu_object>> {
        let list = service!(self.scene.list);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        self.fill(|out, cap, n| unsafe { list(self.raw(), base, kinds, flags, out, cap, n) })
    }
    /// Copies objects, at the same pose; returns the copies in the same order.
    pub fn copy(&self, objects: &[tatu_object]) -> Result<Vec<tatu_object>> {
        let mut out = vec![0; objects.len()];
        let (from, n) = (objects.as_ptr(), objects.len() as u32);
        let copy = service!(self.scene.copy);
        // SAFETY: `from` points to `n` objects, and `out` has room for as many copies.
        self.check(unsafe { copy(self.raw(), from, n, out.as_mut_ptr()) })?;
        Ok(out)
    }
    /// Loads a scene file, or a file that an importer reads, below `parent`, or at the top level if that is 0, and
    /// returns its first object. `file` is a path that [`World::file`] returned, or the id of a model.
    pub fn load(&self, file: &[u8], parent: tatu_object) -> Result<tatu_object> {
        let mut out = 0;
        self.check(service!(self.scene.load)(self.raw(), file.into(), parent, Some(&mut out)))?;
        Ok(out)
    }
    /// Saves an object and all its descendants, or the whole scene if `base` is 0, as a scene file. `file` is a path
    /// that [`World::file`] returned.
    pub fn save(&self, file: &[u8], base: tatu_object) -> Result {
        self.check(service!(self.scene.save)(self.raw(), file.into(), base))
    }
    /// Returns a list that the host writes into a buffer, and enlarges the buffer if the host reports a larger count.
    pub(crate) fn fill<T: Copy + Default>(
        &self,
        call: impl Fn(*mut T, u32, Option<&mut u32>) -> tatu_status,
    ) -> Result<Vec<T>> {
        let (mut out, mut n) = (vec![T::default(); 64], 0);
        loop {
            self.check(call(out.as_mut_ptr(), out.len() as u32, Some(&mut n)))?;
            if n as usize <= out.len() {
                out.truncate(n as usize);
                return Ok(out);
            }
            out.resize(n as usize, T::default());
        }
    }
    /// Measures a sensor now. If `only` is not 0, only that object is detected.
    pub fn sense_now(&self, sensor: tatu_object, only: tatu_object) -> Result {
        self.check(service!(self.readings.sense_now)(self.raw(), sensor, only))
    }
    /// Measures a sensor now, with the limits in `look` in place of its own. The caller need not set `look.size`.
    pub fn look_through(&self, sensor: tatu_object, look: tatu_look) -> Result {
        let look = tatu_look { size: size_of::<tatu_look>() as u32, ..look };
        let look_through = service!(self.readings.look);
        // SAFETY: `look` lives during the call and is as large as its `size` states.
        self.check(unsafe { look_through(self.raw(), sensor, &look) })
    }
    /// Returns whether a script exists and outlives runs: its kind is neither "main" nor "child".
    pub fn outlives_runs(&self, script: tatu_object) -> bool {
        let kind = self.get(script, self.host().prop("script.kind"));
        script != 0 && kind.is_ok_and(|k| k.as_str().is_some_and(|k| !matches!(&*k, "main" | "child")))
    }
    /// Discards a sensor's reading, so that the sensor has none until its next measurement.
    pub fn reset_reading(&self, sensor: tatu_object) -> Result {
        self.check(service!(self.readings.reset)(self.raw(), sensor))
    }
    /// Returns the sensors that fill a schema ("proximity/1").
    pub fn sensors(&self, schema: &str) -> Result<Vec<tatu_object>> {
        let schema = CString::new(schema).unwrap_or_default();
        let list = service!(self.readings.list);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        self.fill(|out, cap, n| unsafe { list(self.raw(), schema.as_c_str().into(), out, cap, n) })
    }
    /// Sets the velocity of a dynamic shape in the world frame: linear (m/s), then angular (rad/s).
    pub fn set_twist(&self, object: tatu_object, twist: &[f64; 6]) -> Result {
        self.check(service!(self.bodies.set_twist)(self.raw(), object, Some(twist)))
    }
    /// Applies a force (N) and a torque (N m), in the world frame, to a dynamic shape at its centre of mass during the
    /// next physics step.
    pub fn push(&self, object: tatu_object, force: &[f64; 3], torque: &[f64; 3]) -> Result {
        self.check(service!(self.bodies.push)(self.raw(), object, Some(force), Some(torque)))
    }
    /// Registers two shapes for a part, or `a` with all shapes that it touches if `b` is 0; [`Part::contact`] then decides
    /// on their contact before each physics step. With `on` false, ends this.
    ///
    /// [`Part::contact`]: crate::safe::Part::contact
    pub fn hook(&self, part: tatu_object, a: tatu_object, b: tatu_object, on: bool) -> Result {
        self.check(service!(self.bodies.hook)(self.raw(), part, a, b, on.into()))
    }
    /// Returns the contacts of a shape, or of all shapes if `object` is 0, after the last step.
    pub fn contacts(&self, object: tatu_object) -> Result<Vec<Contact>> {
        let contacts = service!(self.bodies.contacts);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        self.fill(|out, cap, n| unsafe { contacts(self.raw(), object, out, cap, n) })
    }

    /// Returns the friction forces on the second shapes of the contacts that [`Self::contacts`] returns, in the same
    /// order: N, world frame.
    pub fn frictions(&self, object: tatu_object) -> Result<Vec<[f64; 3]>> {
        let frictions = service!(self.bodies.frictions);
        // SAFETY: `fill` passes a buffer with room for `cap` elements.
        let numbers: Vec<f64> = self.fill(|out, cap, n| unsafe { frictions(self.raw(), object, out, cap, n) })?;
        Ok(numbers.as_chunks::<3>().0.to_vec())
    }

    /// Returns the shortest segment from any shape in `a` to any shape in `b` or, if `b` is empty, to any other shape.
    /// Returns `None` if `limit`, in m, is above 0 and all distances exceed it.
    pub fn closest(&self, a: &[tatu_object], b: &[tatu_object], limit: f64) -> Result<Option<Closest>> {
        let (mut points, mut pair) = ([0.0; 6], [0; 2]);
        let (ap, an, bp, bn) = (a.as_ptr(), a.len() as u32, b.as_ptr(), b.len() as u32);
        let closest = service!(self.bodies.closest);
        // SAFETY: the pointers and counts are those of the slices `a` and `b`.
        let status = unsafe { closest(self.raw(), ap, an, bp, bn, limit, Some(&mut points), Some(&mut pair)) };
        let [a, b, c, d, e, f] = points;
        self.found(status, Closest { from: [a, b, c], to: [d, e, f], pair })
    }
    /// Returns the shortest segment like [`closest`](Self::closest), with the shapes in `a` at other poses: x y z, then the
    /// unit quaternion x y z w, in the world frame. Nothing moves.
    pub fn closest_at(
        &self,
        a: &[tatu_object],
        poses: &[[f64; 7]],
        b: &[tatu_object],
        limit: f64,
    ) -> Result<Option<Closest>> {
        if a.len() != poses.len() {
            return Err(Fail::argument(format!("{} poses for {} shapes", poses.len(), a.len())));
        }
        let (mut points, mut pair) = ([0.0; 6], [0; 2]);
        let (ap, pp, an, bp, bn) = (a.as_ptr(), poses.as_ptr(), a.len() as u32, b.as_ptr(), b.len() as u32);
        let closest = service!(self.bodies.closest_at);
        // SAFETY: the pointers and counts are those of the slices `a` and `b`, and `poses` is as long as `a`.
        let status = unsafe { closest(self.raw(), ap, pp, an, bp, bn, limit, Some(&mut points), Some(&mut pair)) };
        let [a, b, c, d, e, f] = points;
        self.found(status, Closest { from: [a, b, c], to: [d, e, f], pair })
    }
    /// Returns whether the engine moves an object: true for dynamic shapes, and for joints between two bodies, once
    /// physics has run.
    pub fn is_dynamic(&self, object: tatu_object) -> Result<bool> {
        let mut yes = 0;
        self.check(service!(self.bodies.is_dynamic)(self.raw(), object, Some(&mut yes)))?;
        Ok(yes != 0)
    }
    /// Requests a change of state, one of `TATU_REQUEST_*`, which takes effect after the pass.
    pub fn request(&self, what: u32) -> Result {
        self.check(service!(self.session.request)(self.raw(), what))
    }
    /// Returns the kind (such as "key") and the text of the `index`-th external input since the start, from 0, or
    /// `None` past the last one. Calls by services are not included.
    pub fn input(&self, index: u64) -> Option<(String, String)> {
        let input = self.host().session?.input?;
        let (mut kind, mut text) = (Lent::EMPTY, Lent::EMPTY);
        let found = input(self.raw(), index, Some(&mut kind), Some(&mut text)) >= 0;
        found.then(|| (kind.text().into_owned(), text.text().into_owned()))
    }
    /// Runs one stage now, as a driver does: one of `TATU_STAGE_*`.
    pub fn run_stage(&self, stage: u32, dt: f64) -> Result {
        self.check(service!(self.stage.run)(self.raw(), stage, dt))
    }
}
