//! Plans of beams: the rays, volume or image of a sensor, as its plugin declares them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ::tatu_beams::{Faces, Grid, ImageProjection, RayBundle, Volume};
use nalgebra::{UnitQuaternion, Vector3};
use tatu_plugin_api::abi::*;
use tatu_plugins::DeclaredBeams;

use super::targets::TargetFilter;

/// The beams of a sensor.
#[derive(Debug, PartialEq)]
pub struct BeamPlan {
    /// Form of the volume, or of a single ray.
    pub volume: Volume,
    /// Ray directions in the sensor's frame; one entry (its +z) for a volume, none for an image or a sensor without
    /// beams.
    pub directions: Vec<[f64; 3]>,
    /// For each direction, a rotation that maps +z to it.
    pub turns: Vec<UnitQuaternion<f64>>,
    /// The rays prepared for casting as a bundle, if there are enough of them.
    pub bundle: PlanBundle,
    /// The sensor's image, if it has one.
    pub image: Option<Grid>,
    /// The distances and the angle at which a beam hits.
    pub range: BeamRange,
    /// The sides of faces that can be hit.
    pub faces: Faces,
    /// Whether the sensor's own model is ignored.
    pub skip_model: bool,
    /// Additional sizes to which the dimensions of the sensor's fields refer (`TATU_DIM_OWN`).
    pub own: [u32; 4],
    /// Inputs that the sensor's kind requests but this sensor does not need, as `TATU_IN_*` flags.
    pub without: u32,
    /// Whether the sensor detects visible objects instead of detectable ones.
    pub visible: bool,
    /// Whether a volume detects a point only if no surface is between the point and the sensor.
    pub occlude: bool,
    /// Whether the plugin sets the origins and directions of the rays before each cast.
    pub aimed: bool,
    /// Origins of the rays in the sensor's frame, m; if empty, all start at the sensor's origin.
    pub origins: Vec<[f64; 3]>,
    /// Object that the sensor measures instead of the objects above it in the tree; 0 if there is no such object.
    pub observed: tatu_object,
    /// Kinds of waves of the beams, as `TATU_WAVES_*` flags, which determine the objects that the sensor detects.
    pub waves: u16,
}

/// The distances and the angle at which a beam hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamRange {
    /// Minimum distance of a hit, m.
    pub near: f64,
    /// Maximum distance of a hit, m.
    pub far: f64,
    /// Largest angle between a ray and the normal of the face that it hits, rad.
    pub max_incidence: f64,
}

impl BeamPlan {
    /// A plan without beams.
    pub const NONE: BeamPlan = BeamPlan {
        volume: Volume::Ray,
        directions: Vec::new(),
        turns: Vec::new(),
        bundle: PlanBundle::NONE,
        image: None,
        range: BeamRange { near: 0.0, far: 0.0, max_incidence: FRAC_PI_2 },
        faces: Faces::BOTH,
        skip_model: false,
        own: [0; 4],
        without: 0,
        visible: false,
        occlude: false,
        aimed: false,
        origins: Vec::new(),
        observed: 0,
        waves: u16::MAX,
    };

    /// Returns the number of beams or pixels.
    pub fn count(&self) -> usize {
        self.directions.len() + self.image.map_or(0, |i| i.columns as usize * i.rows as usize)
    }

    /// Returns the size of the memory that the image of the sensor needs while it is rendered, bytes.
    pub(super) fn image_bytes(&self) -> u64 {
        self.image.map_or(0, |i| u64::from(i.columns) * u64::from(i.rows) * BYTES_PER_PIXEL as u64)
    }

    /// Returns the actual shape of a field, given its declared shape.
    pub fn shape(&self, declared: [u32; 3]) -> [u32; 3] {
        let image = self.image.map_or((0, 0), |i| (i.rows, i.columns));
        declared.map(|d| match d {
            0 => self.count() as u32,
            TATU_DIM_ROWS => image.0,
            TATU_DIM_COLUMNS => image.1,
            d if (TATU_DIM_OWN..TATU_DIM_OWN + 4).contains(&d) => self.own[(d - TATU_DIM_OWN) as usize],
            n => n,
        })
    }

    /// Checks the beams that an instance has declared. Without any, the plan is empty.
    pub fn new(beams: Option<DeclaredBeams>) -> Result<Self, String> {
        let Some(DeclaredBeams { table: raw, directions, origins }) = beams else { return Ok(Self::NONE) };
        let (volume, directions) = match raw.form {
            TATU_BEAMS_CONE if (0.0..=PI).contains(&raw.dims[0]) => {
                (Volume::Cone { half_angle: raw.dims[0] }, vec![[0.0, 0.0, 1.0]])
            }
            TATU_BEAMS_CONE => {
                return Err(format!("the half angle of the cone is {} rad; expected 0 to pi", raw.dims[0]));
            }
            TATU_BEAMS_PYRAMID | TATU_BEAMS_CYLINDER | TATU_BEAMS_DISC => (volume(&raw)?, vec![[0.0, 0.0, 1.0]]),
            TATU_BEAMS_RAYS => (Volume::Ray, rays(directions)?),
            TATU_BEAMS_NONE | TATU_BEAMS_GRID | TATU_BEAMS_PARALLEL => (Volume::Ray, Vec::new()),
            form => {
                return Err(format!(
                    "beams of form {form} are not supported by this host; expected one of TATU_BEAMS_*"
                ));
            }
        };
        if !(raw.near_m >= 0.0 && raw.far_m >= raw.near_m) {
            return Err(format!("the beams range from {} m to {} m; expected 0 <= near <= far", raw.near_m, raw.far_m));
        }
        if !(0.0..=PI).contains(&raw.max_incidence) {
            return Err(format!("the maximum incidence is {} rad; expected 0 to pi", raw.max_incidence));
        }
        let image = image(&raw)?;
        let aimed = raw.form == TATU_BEAMS_RAYS && raw.flags & TATU_BEAMS_AIMED != 0;
        if let Some((i, o)) = origins.iter().enumerate().find(|(_, o)| !o.iter().all(|x| x.is_finite())) {
            return Err(format!("the origin of ray {i} is {o:?}; expected finite numbers"));
        }
        // All rays of a bundle have the same origin.
        let alone = aimed || !origins.is_empty();
        let bundle =
            if matches!(volume, Volume::Ray) && !alone { PlanBundle::new(&directions) } else { PlanBundle::NONE };
        Ok(BeamPlan {
            volume,
            bundle,
            turns: directions.iter().map(|d| look_along(*d)).collect(),
            directions,
            image,
            range: BeamRange { near: raw.near_m, far: raw.far_m, max_incidence: raw.max_incidence },
            faces: Faces { front: raw.flags & TATU_BEAMS_NO_FRONT == 0, back: raw.flags & TATU_BEAMS_NO_BACK == 0 },
            skip_model: raw.flags & TATU_BEAMS_SKIP_MODEL != 0,
            own: raw.own,
            without: raw.without,
            visible: raw.flags & TATU_BEAMS_VISIBLE != 0,
            occlude: raw.flags & TATU_BEAMS_OCCLUDE != 0,
            aimed,
            origins,
            observed: raw.observed,
            waves: raw.waves as u16,
        })
    }

    /// Returns the set of targets of a sensor with this plan. `choice` is the number of its selection of objects.
    pub fn target_filter(&self, choice: u32) -> TargetFilter {
        TargetFilter { visible: self.visible, waves: self.waves, choice }
    }
}

/// Returns the pyramid, cylinder or disc that a plugin declares, or an error if its sizes are invalid.
fn volume(raw: &tatu_beams) -> Result<Volume, String> {
    let [a, b, c, d, ..] = raw.dims;
    let all = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite() && *x >= 0.0);
    let volume = match raw.form {
        TATU_BEAMS_PYRAMID => {
            all(&[a, b, c, d]).then_some(Volume::Pyramid { x_near: a, y_near: b, x_far: c, y_far: d })
        }
        TATU_BEAMS_CYLINDER => all(&[a, b]).then_some(Volume::Cylinder { radius_near: a, radius_far: b }),
        _ => (all(&[a, b, c]) && a <= TAU && c <= a).then_some(Volume::Disc { angle: a, height: b, gap: c }),
    };
    volume.ok_or_else(|| {
        format!(
            "the volume of form {} has the sizes {:?}; expected sizes of at least 0, and angles of at most a full turn",
            raw.form, raw.dims
        )
    })
}

/// Checks the directions of rays.
fn rays(all: Vec<[f64; 3]>) -> Result<Vec<[f64; 3]>, String> {
    let unit = |d: &[f64; 3]| (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0).abs() < 1e-6;
    match all.iter().position(|d| !unit(d)) {
        Some(i) => Err(format!("the direction of ray {i} is {:?}; expected a unit vector", all[i])),
        None => Ok(all),
    }
}

/// Memory that an image needs per pixel, bytes: depth, colour, normal, object, and the reading.
const BYTES_PER_PIXEL: usize = 48;
/// Maximum size of an image whose memory is not checked in advance, bytes.
const UNCHECKED_IMAGE_BYTES: usize = 64 << 20;

fn image(raw: &tatu_beams) -> Result<Option<Grid>, String> {
    let [columns, rows] = raw.count;
    let view = match raw.form {
        TATU_BEAMS_GRID if raw.dims[0] > 0.0 && raw.dims[0] < PI => ImageProjection::Perspective { angle: raw.dims[0] },
        TATU_BEAMS_GRID => {
            return Err(format!(
                "the image has an angle of {} rad; expected more than 0 and less than pi",
                raw.dims[0]
            ));
        }
        TATU_BEAMS_PARALLEL if raw.dims[0] > 0.0 && raw.dims[0].is_finite() => {
            ImageProjection::Orthographic { width: raw.dims[0] }
        }
        TATU_BEAMS_PARALLEL => {
            return Err(format!("the image is {} m wide; expected a finite width greater than 0", raw.dims[0]));
        }
        _ => return Ok(None),
    };
    if columns == 0 || rows == 0 || columns > MAX_SIDE_PIXELS || rows > MAX_SIDE_PIXELS {
        return Err(format!("the image has {columns} x {rows} pixels; expected 1 to {MAX_SIDE_PIXELS} per side"));
    }
    let bytes = columns as usize * rows as usize * BYTES_PER_PIXEL;
    if bytes > UNCHECKED_IMAGE_BYTES && Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
        return Err(format!(
            "an image of {columns} x {rows} pixels needs about {} MB, which the system cannot provide; choose fewer \
             pixels, or allow the program more memory (`ulimit -v`, or the job's limit)",
            bytes >> 20
        ));
    }
    Ok(Some(Grid { columns, rows, projection: view, near: raw.near_m, far: raw.far_m }))
}

/// Maximum number of pixels along one side of an image.
const MAX_SIDE_PIXELS: u32 = 8192;

/// Returns the rotation by the smallest angle that maps +z to a direction.
pub(super) fn look_along(d: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::from(d))
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI))
}

/// The rays of a plan, prepared for casting as a bundle if there are enough of them.
#[derive(Debug, Default)]
pub struct PlanBundle(Option<RayBundle>);

/// All bundles compare equal, because a bundle is derived from the directions of its plan, which are compared as well.
impl PartialEq for PlanBundle {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl PlanBundle {
    pub const NONE: PlanBundle = PlanBundle(None);

    pub fn new(directions: &[[f64; 3]]) -> Self {
        PlanBundle((directions.len() >= MIN_BUNDLE_RAYS).then(|| RayBundle::new(directions)))
    }
    pub fn is_some(&self) -> bool {
        self.0.is_some()
    }
    pub fn get(&self) -> Option<&RayBundle> {
        self.0.as_ref()
    }
}

/// Minimum number of rays for a bundle; fewer are cast one by one.
pub(super) const MIN_BUNDLE_RAYS: usize = 8;
