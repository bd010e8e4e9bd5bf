//! Sensor kinds: beams and a measurement. Its inputs and outputs are in `sample`, the tables for the host in
//! `sensor_table`.

use std::f64::consts::FRAC_PI_2;

use crate::abi::*;
use crate::safe::{
    Fail, Instance, Param, Params, Plugin, Result, SharedWorld,
    declare::plugin::Change,
    value::{
        field::Field,
        sample::{Readout, Sample},
    },
};

/// Form of the beams; they start at the sensor's origin and point along its +z.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// None: the sensor measures its own motion only.
    None,
    /// Rays along these unit vectors, in the sensor's frame.
    Rays(Vec<[f64; 3]>),
    /// A volume with a spherical far end; half of the opening angle, rad, 0 to pi.
    Cone {
        /// Half of the opening angle, rad.
        half_angle: f64,
    },
    /// Another volume, `TATU_BEAMS_PYRAMID`, `_CYLINDER` or `_DISC`, with its numbers as in `tatu.h`.
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
    /// Nothing nearer is detected, m.
    pub near: f64,
    /// Nothing farther is detected, m.
    pub far: f64,
    /// Greatest angle between line of sight and surface normal, rad; pi/2: no limit.
    pub max_incidence: f64,
    /// Objects of the sensor's own model are not detected.
    pub skip_own_model: bool,
    /// Whether front faces, and back faces, are detected.
    pub faces: (bool, bool),
    /// Visible objects are detected, as by a camera, instead of detectable ones.
    pub visible: bool,
    /// Numbers that [`TATU_DIM_OWN`] stands for in shapes of fields; 0: there is no such field.
    pub own: [u32; 4],
    /// `TATU_IN_*`: inputs that this one does not need; they are 0 or absent.
    pub without: u32,
    /// A point that a volume finds counts only if nothing lies between it and the sensor.
    pub occlude: bool,
    /// Their physical nature: a sum of `TATU_WAVES_*`.
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

/// A preset: `(id, one sentence with the source of the numbers, lines of TOML as in a scene)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// "hokuyo_urg_04lx"
    pub id: &'static str,
    /// One sentence, with the source of the numbers.
    pub text: &'static str,
    /// The lines as in the object of the sensor in a scene, including its noise.
    pub settings: &'static str,
}

/// A kind of sensor. One value per sensor in a world.
pub trait Sensor: Sized + Send + Sync + 'static {
    /// The plugin that offers it.
    type Plugin: Plugin;
    /// The name in scene files: "proximity".
    const ID: &'static str;
    /// One sentence.
    const TEXT: &'static str;
    /// The schema of its readings: "proximity/1".
    const SCHEMAS: &'static [&'static str];
    /// The inputs that it needs: a sum of `TATU_IN_*`.
    const INPUTS: u32;

    /// Its parameters.
    fn params() -> Vec<Param>;
    /// The fields that it fills.
    fn fields() -> Vec<Field>;
    /// Presets.
    const PRESETS: &'static [Preset] = &[];
    /// Creates one. `world` is read-only.
    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self>;
    /// Takes new values of live parameters (a snapshot of a run in which one was changed is restored by replay):
    /// `changed` has a bit for each, in the order of declaration. It is then asked for its beams. After an error the
    /// old values stay in effect. A parameter with [`Param::rebuilds`] is never passed here.
    fn configure(&mut self, params: &Params<'_>, changed: u64) -> Result<Change> {
        let _ = (params, changed);
        Ok(Change::Rebuild)
    }
    /// Its beams.
    fn beams(&self) -> Result<Beams>;
    /// Numbers that each instance keeps between measurements: [`Readout::state`]. The host stores them, so that they
    /// are in snapshots and go through a reload; they are zero at first and after a reset.
    const STATE: usize = 0;
    /// Version of these numbers and of what [`Sensor::save`] writes; increase it when their meaning changes.
    const STATE_VERSION: u32 = 0;
    /// What a reading depends on besides parameters, [`Sensor::STATE`] and the beams, for a snapshot. Most sensors have
    /// nothing of the kind.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Restores what `save` of `version` wrote, into a sensor created with the same parameters.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("it does not restore state")) }
    }
    /// Computes a reading from the beams. Must not block; runs on several threads.
    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result;
    /// Moves and turns rays of instances whose [`Beams::aimed`] asks for it, before they are cast: origin (m) and unit
    /// direction of each, in the sensor's frame. The rays and hits of the sample are not available yet.
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let _ = (sample, rays);
        Ok(())
    }
    /// Makes fields that depend on others consistent, after the noise that a scene declares. As
    /// [`Sensor::measure`], but the fields are as the noise left them. Not called without noise, so
    /// `measure` fills all fields.
    fn finish(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let _ = (sample, out);
        Ok(())
    }
}
