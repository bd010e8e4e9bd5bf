//! The wheel drive of a robot, as data for remote clients and views. The core does not use it, except to check that its
//! joints exist.

use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_plugin_api::safe::Value;

use crate::graph::{CheckedMap, map};

/// Keys of the table that describes a drive, with their units.
pub const KEYS: &[(&str, &str)] = &[
    ("type", ""),
    ("joints", ""),
    ("steering", ""),
    ("radius", "m"),
    ("track", "m"),
    ("wheelbase", "m"),
    ("axle", "m"),
    ("angles", "rad"),
];

/// Description of a robot's wheel drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WheelDrive {
    form: WheelDriveType,
    /// Paths of the driven joints, relative to the object. A leading `-` marks a joint whose positive rotation drives
    /// the robot backwards.
    joints: Vec<String>,
    /// Paths of the steering joints: left and right alternating, or a single one in the middle.
    steering: Vec<String>,
    radius: f64,
    track: f64,
    wheelbase: f64,
    /// Distance of the driven axle, or of the centre of all wheels, ahead of the object's origin, m.
    axle: f64,
    /// Angular positions of the wheels about the centre, rad.
    angles: Vec<f64>,
}

/// Types of wheel drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum WheelDriveType {
    /// Left and right wheels turn at different speeds.
    Differential,
    /// Front wheels steer, rear wheels drive.
    Ackermann,
    /// Wheels with rollers; the robot can move in any direction.
    Omni,
}

impl WheelDriveType {
    const NAMES: [&str; 3] = ["differential", "ackermann", "omni"];
}

impl WheelDrive {
    /// Returns the paths of all joints of the drive, relative to its object, without leading `-`.
    pub fn joint_paths(&self) -> impl Iterator<Item = &str> {
        self.joints.iter().chain(&self.steering).map(|p| p.strip_prefix('-').unwrap_or(p))
    }

    /// Parses the table of a drive; returns `None` if the table is empty.
    pub fn from_value(value: &Value) -> Result<Option<Self>, Refusal> {
        if matches!(value, Value::Map(entries) if entries.is_empty()) {
            return Ok(None);
        }
        let known: Vec<&str> = KEYS.iter().map(|(k, _)| *k).collect();
        let keys = CheckedMap::new("a drive", value, &known)?;
        let name = keys.text("type")?;
        let Some(n) = WheelDriveType::NAMES.iter().position(|f| *f == name) else {
            return keys.invalid_value("type", &format!("one of {}", WheelDriveType::NAMES.join(", ")));
        };
        let form = [WheelDriveType::Differential, WheelDriveType::Ackermann, WheelDriveType::Omni][n];
        let (joints, steering, angles) = (keys.texts("joints")?, keys.texts("steering")?, keys.numbers("angles")?);
        let length = |key: &'static str, needed: bool| match keys.number(key)? {
            Some(x) if x > 0.0 => Ok(x),
            None if !needed => Ok(0.0),
            _ => keys.invalid_value(key, &format!("a length above 0, in metres, for a drive of type {name}")),
        };
        // Without angles, an omnidirectional drive has four mecanum wheels; with angles, the wheels are on a circle
        // whose diameter is the track.
        let mecanum = form == WheelDriveType::Omni && angles.is_empty();
        let drive = WheelDrive {
            radius: length("radius", true)?,
            track: length("track", true)?,
            wheelbase: length("wheelbase", form == WheelDriveType::Ackermann || mecanum)?,
            axle: keys.number("axle")?.unwrap_or(0.0),
            form,
            joints,
            steering,
            angles,
        };
        let paired = |all: &[String]| !all.is_empty() && all.len().is_multiple_of(2);
        let single = |all: &[String]| all.len() == 1;
        match form {
            WheelDriveType::Differential if !paired(&drive.joints) => {
                keys.invalid_value("joints", "a non-empty list of paths, left and right alternating")
            }
            WheelDriveType::Ackermann if !paired(&drive.joints) && !single(&drive.joints) => keys.invalid_value(
                "joints",
                "a list of one path, or of an even number of paths, left and right alternating",
            ),
            WheelDriveType::Ackermann if !paired(&drive.steering) && !single(&drive.steering) => keys.invalid_value(
                "steering",
                "a list of one path, or of an even number of paths, left and right alternating",
            ),
            WheelDriveType::Omni if mecanum && drive.joints.len() != 4 => keys
                .invalid_value("joints", "four paths, front left, front right, rear left, rear right, or set `angles`"),
            WheelDriveType::Omni
                if !mecanum && (drive.joints.len() != drive.angles.len() || drive.joints.len() < 3) =>
            {
                keys.invalid_value("angles", "a list of angles, one for each of at least three joints")
            }
            _ => Ok(Some(drive)),
        }
    }
    /// Returns the drive as a table, which is empty if there is no drive.
    pub fn to_value(drive: Option<&WheelDrive>) -> Value {
        let Some(d) = drive else { return Value::Map(Vec::new()) };
        let texts = |all: &[String]| Value::List(all.iter().map(Value::text).collect());
        let mut entries =
            vec![("type", Value::text(WheelDriveType::NAMES[d.form as usize])), ("joints", texts(&d.joints))];
        if !d.steering.is_empty() {
            entries.push(("steering", texts(&d.steering)));
        }
        entries.extend([("radius", Value::Float(d.radius)), ("track", Value::Float(d.track))]);
        if d.wheelbase > 0.0 {
            entries.push(("wheelbase", Value::Float(d.wheelbase)));
        }
        if d.axle != 0.0 {
            entries.push(("axle", Value::Float(d.axle)));
        }
        if !d.angles.is_empty() {
            entries.push(("angles", Value::Floats(d.angles.clone())));
        }
        map(entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(entries: &[(&'static str, Value)]) -> Value {
        map(entries.iter().cloned())
    }

    #[test]
    fn drive_round_trips_and_invalid_drives_are_refused() {
        let paths = |all: &[&str]| Value::List(all.iter().map(|p| Value::text(*p)).collect());
        let pair = paths(&["left", "-right"]);
        let good = table(&[
            ("type", Value::text("differential")),
            ("joints", pair.clone()),
            ("radius", Value::Float(0.1)),
            ("track", Value::Float(0.3)),
        ]);
        let read = WheelDrive::from_value(&good).unwrap();
        assert_eq!(WheelDrive::to_value(read.as_ref()), good);
        assert_eq!(WheelDrive::from_value(&table(&[])).unwrap(), None);
        let with = |key: &str, value: Value| {
            let Value::Map(mut entries) = good.clone() else { unreachable!() };
            entries.retain(|(k, _)| *k != Value::text(key));
            entries.push((Value::text(key), value));
            WheelDrive::from_value(&Value::Map(entries)).unwrap_err().1
        };
        assert!(with("type", Value::text("legs")).contains("one of differential, ackermann, omni"));
        assert!(with("joints", paths(&["left"])).contains("left and right alternating"));
        assert!(with("radius", Value::Float(0.0)).contains("above 0"));
        assert!(with("type", Value::text("ackermann")).contains("`wheelbase`"));
        assert!(with("raduis", Value::Float(1.0)).contains("did you mean `radius`?"));
    }
}
