//! The beams that the instance of a sensor declares.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;

use crate::{Inspector, SensorKind, border::ErrorSlot, state_block::GUARD};

/// Maximum number of rays of a sensor.
const MAX_RAYS: u32 = 1 << 24;

/// The table that an instance has filled, and copies of the arrays to which it points.
pub struct DeclaredBeams {
    /// The table.
    pub table: tatu_beams,
    /// The direction of each ray, if the beams are rays.
    pub directions: Vec<[f64; 3]>,
    /// The origin of each ray, or an empty list if all rays begin at the sensor.
    pub origins: Vec<[f64; 3]>,
}

impl SensorKind {
    /// Requests the beams of an instance with this number of targets; returns `None` if sensors of this kind have none.
    ///
    /// # Safety
    /// `data` must point to a live instance of this kind, and no borrow of its world may be active.
    pub unsafe fn request_beams(
        &self,
        data: *mut c_void,
        n_targets: u32,
        inspector: Option<&dyn Inspector>,
    ) -> Result<Option<DeclaredBeams>, String> {
        let Some(ask) = self.raw.beams else { return Ok(None) };
        let raw = tatu_beams {
            size: size_of::<tatu_beams>() as u32,
            form: TATU_BEAMS_NONE,
            count: [0, 0],
            near_m: 0.0,
            far_m: f64::INFINITY,
            dims: [0.0; 6],
            max_incidence: std::f64::consts::FRAC_PI_2,
            directions: std::ptr::null(),
            flags: 0,
            reserved: 0,
            waves: TATU_WAVES_ALL,
            reserved2: 0,
            own: [0; 4],
            without: 0,
            reserved3: 0,
            origins: std::ptr::null(),
            observed: 0,
            n_targets,
            reserved4: 0,
        };
        /// The table for the plugin, between two guards that reveal writes out of bounds.
        #[repr(C)]
        struct GuardedBeams([u64; 8], tatu_beams, [u64; 8]);
        let mut room = GuardedBeams([GUARD; 8], raw, [GUARD; 8]);
        let mut error = ErrorSlot::new();
        // SAFETY: the caller guarantees that `data` points to a live instance; `room` and `error` live until the call
        // has returned. The header declares the function as `[setup]`, so it may be called here.
        let status = unsafe { ask(data, &mut room.1, error.raw()) };
        if error.check_status(status, false) < 0 {
            return Err(error.text());
        }
        if let Some(inspector) = inspector {
            inspector.after_beams(self, &room.1);
        }
        let GuardedBeams(before, table, behind) = room;
        if before != [GUARD; 8] || behind != [GUARD; 8] {
            return Err("broke the contract: it wrote outside the table `tatu_beams`".into());
        }
        if table.form != TATU_BEAMS_RAYS {
            return Ok(Some(DeclaredBeams { table, directions: Vec::new(), origins: Vec::new() }));
        }
        if table.count[0] > MAX_RAYS {
            return Err(format!("there are {} rays; expected at most {MAX_RAYS}", table.count[0]));
        }
        if table.directions.is_null() {
            return Err("the pointer to the directions of the rays is null".into());
        }
        // SAFETY: the contract requires both to be null or to point to 3 numbers per ray that stay valid after the call.
        let [directions, origins] = unsafe { [table.directions, table.origins].map(|p| copy(p, table.count[0])) };
        Ok(Some(DeclaredBeams { table, directions, origins }))
    }
}

/// Copies the vectors of `n` rays.
///
/// # Safety
/// `first` must be null or point to 3 numbers per ray.
unsafe fn copy(first: *const f64, n: u32) -> Vec<[f64; 3]> {
    // SAFETY: the caller guarantees 3 numbers per ray, unless `first` is null.
    if first.is_null() { Vec::new() } else { unsafe { std::slice::from_raw_parts(first.cast(), n as usize) }.to_vec() }
}
