//! Builds the messages of IMUs, magnetometers, force sensors, batteries and barometers.

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Prop, Result, Turn, Value, keys},
};

use crate::{
    covariance,
    plugin::Props,
    poses::{quaternion, vector},
};

/// Value of `power_supply_status` in `sensor_msgs/BatteryState`: the battery is being discharged.
const DISCHARGING: i64 = 2;

/// The quantity that a sensor measures, for sensors with a single message type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimpleReading {
    /// Acceleration, angular velocity and orientation.
    Motion,
    /// The magnetic field.
    Field,
    /// A force and a torque.
    Load,
    /// The state of a battery.
    Battery,
    /// The air pressure.
    Pressure,
}

/// Reads fields of the last reading of a sensor.
struct ReadingFields<'a>(&'a Turn<'a>, tatu_object);

impl ReadingFields<'_> {
    /// Returns the elements of a field, or zeros if it has too few.
    fn numbers<const N: usize>(&self, field: Prop) -> Result<[f64; N]> {
        let reading = self.0.reading(self.1, field)?;
        Ok(reading.f64s().first_chunk().copied().unwrap_or([0.0; N]))
    }
    /// Returns the single element of a field.
    fn number(&self, field: Prop) -> Result<f64> {
        Ok(self.numbers::<1>(field)?[0])
    }
}

impl SimpleReading {
    /// All quantities.
    pub const ALL: [SimpleReading; 5] = [
        SimpleReading::Motion,
        SimpleReading::Field,
        SimpleReading::Load,
        SimpleReading::Battery,
        SimpleReading::Pressure,
    ];

    /// Returns the last part of the name of the topic, and the type of its messages.
    pub fn topic(self) -> (&'static str, &'static str) {
        match self {
            SimpleReading::Motion => ("imu", "sensor_msgs/Imu"),
            SimpleReading::Field => ("magnetic_field", "sensor_msgs/MagneticField"),
            SimpleReading::Load => ("wrench", "geometry_msgs/WrenchStamped"),
            SimpleReading::Battery => ("battery", "sensor_msgs/BatteryState"),
            SimpleReading::Pressure => ("fluid_pressure", "sensor_msgs/FluidPressure"),
        }
    }

    /// Returns a field of readings that only sensors of this quantity have.
    pub fn field(self, p: &Props) -> Prop {
        match self {
            SimpleReading::Motion => p.acceleration,
            SimpleReading::Field => p.magnetic_field,
            SimpleReading::Load => p.force,
            SimpleReading::Battery => p.voltage,
            SimpleReading::Pressure => p.pressure,
        }
    }

    /// Returns the message of a sensor. `header` builds the header of the message from the time of the reading, s.
    pub fn message(self, turn: &Turn<'_>, p: &Props, id: tatu_object, header: impl Fn(f64) -> Value) -> Result<Value> {
        let header = ("header", header(turn.reading(id, self.field(p))?.time()));
        let of = ReadingFields(turn, id);
        Ok(match self {
            SimpleReading::Motion => {
                let [x, y, z, w] = of.numbers(p.orientation)?;
                keys([
                    header,
                    ("orientation", quaternion(&[0.0, 0.0, 0.0, x, y, z, w])),
                    ("angular_velocity", vector(of.numbers(p.angular_velocity)?)),
                    ("angular_velocity_covariance", covariance::matrix(turn, p, id, "imu.angular_velocity")),
                    ("linear_acceleration", vector(of.numbers(p.acceleration)?)),
                    ("linear_acceleration_covariance", covariance::matrix(turn, p, id, "imu.acceleration")),
                ])
            }
            SimpleReading::Field => keys([
                header,
                ("magnetic_field", vector(of.numbers(p.magnetic_field)?)),
                ("magnetic_field_covariance", covariance::matrix(turn, p, id, "magnetic_field.field")),
            ]),
            SimpleReading::Load => {
                let (force, torque) = (vector(of.numbers(p.force)?), vector(of.numbers(p.torque)?));
                keys([header, ("wrench", keys([("force", force), ("torque", torque)]))])
            }
            SimpleReading::Battery => {
                let unknown = || Value::Float(f64::NAN);
                keys([
                    header,
                    ("voltage", Value::Float(of.number(p.voltage)?)),
                    ("temperature", unknown()),
                    // In ROS, the current is negative while discharging.
                    ("current", Value::Float(-of.number(p.current)?)),
                    ("charge", unknown()),
                    ("capacity", unknown()),
                    ("design_capacity", unknown()),
                    ("percentage", Value::Float(of.number(p.charge)?)),
                    ("power_supply_status", Value::Int(DISCHARGING)),
                    ("present", Value::Bool(true)),
                ])
            }
            SimpleReading::Pressure => {
                let variance = covariance::variances(turn, p, id, "pressure.pressure")[0];
                let pressure = Value::Float(of.number(p.pressure)?);
                keys([header, ("fluid_pressure", pressure), ("variance", Value::Float(variance))])
            }
        })
    }
}
