//! The settings in `<compiler>`: units, conventions for angles, folders, and how masses are found.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use tatu_plugin_api::safe::Result;

use crate::{attributes::Attributes, xml::Element};

/// The settings. Several elements are merged; the last value applies to the whole file.
pub struct Compiler {
    pub degrees: bool,
    euler_sequence: [char; 3],
    pub mesh_folder: String,
    pub texture_folder: String,
    pub strip_path: bool,
    pub auto_limits: bool,
    /// Whether masses come from geoms: always, never, or only without `<inertial>`.
    pub inertia_from_geoms: Option<bool>,
    /// Groups of geoms that have a mass.
    pub mass_groups: [f64; 2],
    pub balance_inertia: bool,
    pub total_mass: Option<f64>,
    pub least_mass: f64,
    pub least_inertia: f64,
    pub discards_visuals: bool,
}

impl Compiler {
    pub fn read(root: &Element) -> Result<Self> {
        let mut merged = Element {
            name: "compiler".into(),
            attributes: Vec::new(),
            children: Vec::new(),
            place: root.place.clone(),
        };
        for element in root.named("compiler") {
            merged.place = element.place.clone();
            for (name, value) in &element.attributes {
                merged.attributes.retain(|(n, _)| n != name);
                merged.attributes.push((name.clone(), value.clone()));
            }
        }
        let a = Attributes::new(&merged, None);
        if a.text("coordinate").is_some_and(|c| c != "local") {
            return Err(a.invalid("coordinate", "`local`; convert the file with an older version of MuJoCo"));
        }
        let degrees = match a.text("angle").as_deref() {
            None | Some("degree") => true,
            Some("radian") => false,
            Some(_) => return Err(a.invalid("angle", "`degree` or `radian`")),
        };
        let sequence: Vec<char> = a.text("eulerseq").unwrap_or_else(|| "xyz".into()).chars().collect();
        let euler_sequence = match <[char; 3]>::try_from(sequence) {
            Ok(s) if s.iter().all(|c| "xyzXYZ".contains(*c)) => s,
            _ => return Err(a.invalid("eulerseq", "three letters of xyzXYZ")),
        };
        let folder = |name: &str| a.text(name).or_else(|| a.text("assetdir")).unwrap_or_default().replace('\\', "/");
        Ok(Compiler {
            degrees,
            euler_sequence,
            mesh_folder: folder("meshdir"),
            texture_folder: folder("texturedir"),
            strip_path: a.switch("strippath")?.unwrap_or(false),
            auto_limits: a.switch("autolimits")?.unwrap_or(true),
            inertia_from_geoms: a.switch("inertiafromgeom")?,
            mass_groups: a.array("inertiagrouprange")?.unwrap_or([0.0, 5.0]),
            balance_inertia: a.switch("balanceinertia")?.unwrap_or(false),
            total_mass: Some(a.number("settotalmass", -1.0)?).filter(|m| *m > 0.0),
            least_mass: a.positive("boundmass", 0.0)?,
            least_inertia: a.positive("boundinertia", 0.0)?,
            discards_visuals: a.switch("discardvisual")?.unwrap_or(false),
        })
    }

    /// Converts an angle to rad.
    pub fn angle(&self, x: f64) -> f64 {
        if self.degrees { x * PI / 180.0 } else { x }
    }

    /// Returns the pose that an element specifies by its position and any form of orientation.
    pub fn pose(&self, a: &Attributes<'_>) -> Result<Isometry3<f64>> {
        let at = a.array::<3>("pos")?.unwrap_or_default();
        Ok(Isometry3::from_parts(Translation3::from(Vector3::from(at)), self.orientation(a)?))
    }

    fn orientation(&self, a: &Attributes<'_>) -> Result<UnitQuaternion<f64>> {
        let direction = |name: &str, v: [f64; 3]| {
            Unit::try_new(Vector3::from(v), 1e-14).ok_or_else(|| a.invalid(name, "a vector that is not 0"))
        };
        if let Some([x, y, z, angle]) = a.array("axisangle")? {
            let axis = direction("axisangle", [x, y, z])?;
            return Ok(UnitQuaternion::from_axis_angle(&axis, self.angle(angle)));
        }
        if let Some(angles) = a.array("euler")? {
            return Ok(self.euler(angles));
        }
        if let Some([a1, a2, a3, b1, b2, b3]) = a.array("xyaxes")? {
            let x = direction("xyaxes", [a1, a2, a3])?.into_inner();
            let y = Vector3::new(b1, b2, b3);
            let y = direction("xyaxes", (y - x * x.dot(&y)).into())?.into_inner();
            let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
            return Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)));
        }
        if let Some(z) = a.array("zaxis")? {
            return Ok(turn_to(&direction("zaxis", z)?));
        }
        let Some(q) = a.array("quat")? else { return Ok(UnitQuaternion::identity()) };
        quaternion(q).ok_or_else(|| a.invalid("quat", "a quaternion that is not 0"))
    }

    /// Returns the rotation of Euler angles in the unit of the file. Small letters rotate about moved axes, capitals
    /// about fixed ones.
    pub fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut q = UnitQuaternion::identity();
        for (letter, angle) in self.euler_sequence.into_iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let turn = UnitQuaternion::from_axis_angle(&axis, self.angle(angle));
            q = if letter.is_ascii_lowercase() { q * turn } else { turn * q };
        }
        q
    }
}

/// Returns the rotation of a quaternion w x y z, which is normalised; `None` if it is 0.
pub fn quaternion([w, x, y, z]: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-14)
}

/// Returns the smallest rotation that turns the z axis to a direction; about x if that is -z.
pub fn turn_to(z: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    let axis = Vector3::z().cross(z);
    let sine = axis.norm();
    let angle = libm::atan2(sine, z.z);
    match Unit::try_new(axis, 1e-10) {
        Some(axis) => UnitQuaternion::from_axis_angle(&axis, angle),
        None if z.z < 0.0 => UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI),
        None => UnitQuaternion::identity(),
    }
}
