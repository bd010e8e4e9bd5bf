//! Sensor kinds, which declare beams and compute readings. The module `sample` defines their inputs and outputs, and
//! `sensor_table` the tables for the host.

use std::f64::consts::FRAC_PI_2;

use crate::abi::*;
use crate::safe::{
    Fail, Instance, Param, Params, Plugin, Result, SharedWorld,
    declare::plugin::Change,
    value::{
        field::Field,
        sample::{Readout, Sample},
        table_arena::TableArena,
    },
};

/// The form of the beams. Volumes and images start at the sensor's origin and point along its +z axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// No beams, as for sensors of motion, force or contact.
    None,
    /// Rays along these unit vectors, in the sensor's frame.
    Rays(Vec<[f64; 3]>),
    /// A volume with a spherical far end.
    Cone {
        /// Half of the opening angle, rad, 0 to pi.
        half_angle: f64,
    },
    /// A volume of one of the other forms: `TATU_BEAMS_PYRAMID`, `_CYLINDER` or `_DISC`.
    Volume {
        /// Form of the volume, `TATU_BEAMS_*`.
        form: u32,
        /// Dimensions of the volume; `enum tatu_beam_form` in `tatu/sensor.h` lists them for each form.
        dims: [f64; 6],
    },
    /// A pinhole image with square pixels.
    Image {
        /// Number of columns.
        columns: u32,
        /// Number of rows.
        rows: u32,
        /// Angle between the left and the right edge of the image, rad.
        horizontal_angle: f64,
    },
    /// An orthographic image with square pixels.
    Parallel {
        /// Number of columns.
        columns: u32,
        /// Number of rows.
        rows: u32,
        /// Distance from the left to the right edge of the image, m.
        width: f64,
    },
}

/// The beams of a sensor: their form, their range, and what they detect.
#[derive(Debug, Clone, PartialEq)]
pub struct Beams {
    /// Form of the beams.
    pub form: Form,
    /// Minimum distance that is detected, m.
    pub near: f64,
    /// Maximum distance that is detected, m.
    pub far: f64,
    /// Maximum angle between line of sight and surface normal, rad; pi/2 means no limit.
    pub max_incidence: f64,
    /// Whether beams ignore objects of the sensor's own model.
    pub skip_own_model: bool,
    /// Whether front faces, and back faces, are detected.
    pub faces: (bool, bool),
    /// Whether visible objects are detected, as by a camera, instead of detectable ones.
    pub visible: bool,
    /// Dimensions to which [`TATU_DIM_OWN`] + k refers in the shape of a field; if dimension k is 0, the field is
    /// empty.
    pub own: [u32; 4],
    /// Inputs of the kind that this instance does not need, a bitwise OR of `TATU_IN_*`; they are 0 in its pixels.
    pub without: u32,
    /// Whether the nearest point in a volume is detected only if no surface is between it and the sensor.
    pub occlude: bool,
    /// Physical kind of the beams: a bitwise OR of `TATU_WAVES_*`.
    pub waves: u32,
    /// Whether [`Sensor::aim`] sets the origins and directions of the rays before each cast.
    pub aimed: bool,
    /// Origins of rays in the sensor's frame, m, one per ray; empty: all start at the sensor's origin.
    pub origins: Vec<[f64; 3]>,
    /// The observed joint, shape or force sensor; 0: the nearest of each kind at or above the sensor.
    pub observed: tatu_object,
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
            origins: Vec::new(),
            observed: 0,
        }
    }
}

/// Named settings of a kind of sensor or part, such as those of a device that can be bought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// Id of the preset, such as "hokuyo_urg_04lx".
    pub id: &'static str,
    /// Description, one sentence, with the source of the values.
    pub text: &'static str,
    /// The settings, as the lines of TOML that a scene file would contain for the object, including the noise of a sensor.
    pub settings: &'static str,
}

impl Preset {
    pub(crate) fn to_table(self, keep: &mut TableArena) -> *const tatu_preset {
        let raw = tatu_preset {
            size: size_of::<tatu_preset>() as u32,
            reserved: 0,
            id: keep.text(self.id),
            text: keep.text(self.text),
            settings: keep.text(self.settings),
        };
        keep.table(raw)
    }
}

/// A kind of sensor. There is one value per sensor in a world.
pub trait Sensor: Sized + Send + Sync + 'static {
    /// The plugin that offers this kind of sensor.
    type Plugin: Plugin;
    /// Id of the kind of sensor in scene files, such as "proximity".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// The schemas that its fields fill, such as "proximity/1".
    const SCHEMAS: &'static [&'static str];
    /// Inputs that `measure` requires: a bitwise OR of `TATU_IN_*`.
    const INPUTS: u32;

    /// Whether it is measured after each physics step, instead of at the end of a step of the world; for sensors of
    /// motion, force and contact, which have no beams.
    const EVERY_PHYSICS_STEP: bool = false;

    /// Declares the parameters of this kind of sensor.
    fn params() -> Vec<Param>;
    /// Declares the fields of readings, which `measure` fills.
    fn fields() -> Vec<Field>;
    /// The presets of this kind of sensor.
    const PRESETS: &'static [Preset] = &[];
    /// Creates an instance. `world` is read-only.
    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self>;
    /// Applies new values of parameters to a live instance; `changed` has a bit for each of the first 64 parameters, in
    /// the order of declaration. The host then requests the beams again. If this fails, the old values remain in
    /// effect. Not called for parameters with [`Param::rebuilds`]. A snapshot of a run in which a parameter was changed
    /// is restored by replay.
    fn configure(&mut self, params: &Params<'_>, changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Returns the sensor's beams.
    fn beams(&self) -> Result<Beams>;
    /// Returns the beams of a sensor with this number of targets, for kinds with `TATU_IN_TARGETS`. Called again when the
    /// number changes. By default the beams do not depend on it.
    fn beams_for(&self, n_targets: usize) -> Result<Beams> {
        let _ = n_targets;
        self.beams()
    }
    /// Number of values in [`Readout::state`], which persist between measurements of an instance. The host stores them,
    /// so they are part of snapshots and survive a reload. They are 0 initially and after a reset.
    const STATE: usize = 0;
    /// Version of these values and of the data that [`Sensor::save`] writes; increase it when their meaning changes.
    const STATE_VERSION: u32 = 0;
    /// Saves, for a snapshot, all data other than parameters, [`Sensor::STATE`] and the beams that affects readings.
    /// Most sensors have no such data.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Restores data that version `version` of `save` wrote, in a sensor created with the same parameters.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this sensor cannot restore a saved state")) }
    }
    /// Computes a reading from the inputs. Must not block. Different instances may be called on different threads at
    /// once.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result;
    /// Sets origin (m) and unit direction of each ray, in the sensor's frame, before the rays are cast. Called for
    /// instances for which [`Beams::aimed`] is set. Rays and hits are not available in `sample` yet.
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let _ = (sample, rays);
        Ok(())
    }
    /// Recomputes fields that are derived from others, after declared noise has been applied to those. Otherwise like
    /// [`Sensor::measure`]. Called only if there is noise, so `measure` must also fill derived fields.
    fn finish(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let _ = (sample, out);
        Ok(())
    }
}
