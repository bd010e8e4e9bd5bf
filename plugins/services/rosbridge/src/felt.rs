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
pub enum Felt {
    /// Acceleration, angular velocity and orientation.
    Motion,
    /// Magnetic field.
    Field,
    /// Force and torque.
    Load,
    /// The state of a battery.
    Battery,
    /// Air pressure.
    Pressure,
}

/// Reads fields of the last reading of a sensor.
struct Fields<'a>(&'a Turn<'a>, tatu_object);

impl Fields<'_> {
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

impl Felt {
    /// All quantities.
    pub const ALL: [Felt; 5] = [Felt::Motion, Felt::Field, Felt::Load, Felt::Battery, Felt::Pressure];

    /// Returns the last part of the name of the topic, and the type of its messages.
    pub fn topic(self) -> (&'static str, &'static str) {
        match self {
            Felt::Motion => ("imu", "sensor_msgs/Imu"),
            Felt::Field => ("magnetic_field", "sensor_msgs/MagneticField"),
            Felt::Load => ("wrench", "geometry_msgs/WrenchStamped"),
            Felt::Battery => ("battery", "sensor_msgs/BatteryState"),
            Felt::Pressure => ("fluid_pressure", "sensor_msgs/FluidPressure"),
        }
    }

    /// Returns a field of readings that only sensors of this quantity have.
    pub fn field(self, p: &Props) -> Prop {
        match self {
            Felt::Motion => p.acceleration,
            Felt::Field => p.magnetic_field,
            Felt::Load => p.force,
            Felt::Battery => p.voltage,
            Felt::Pressure => p.pressure,
        }
    }

    /// Returns the message of a sensor. `header` builds the header of the message from the time of the reading, s.
    pub fn message(self, turn: &Turn<'_>, p: &Props, id: tatu_object, header: impl Fn(f64) -> Value) -> Result<Value> {
        let header = ("header", header(turn.reading(id, self.field(p))?.time()));
        let of = Fields(turn, id);
        Ok(match self {
            Felt::Motion => {
                let [x, y, z, w] = of.numbers(p.orientation)?;
                keys([
                    header,
                    ("orientation", quaternion(&[0.0, 0.0, 0.0, x, y, z, w])),
                    ("angular_velocity", vector(of.numbers(p.angular_velocity)?)),
                    ("angular_velocity_covariance", covariance::of(turn, p, id, "imu.angular_velocity")),
                    ("linear_acceleration", vector(of.numbers(p.acceleration)?)),
                    ("linear_acceleration_covariance", covariance::of(turn, p, id, "imu.acceleration")),
                ])
            }
            Felt::Field => keys([
                header,
                ("magnetic_field", vector(of.numbers(p.magnetic_field)?)),
                ("magnetic_field_covariance", covariance::of(turn, p, id, "magnetic_field.field")),
            ]),
            Felt::Load => {
                let (force, torque) = (vector(of.numbers(p.force)?), vector(of.numbers(p.torque)?));
                keys([header, ("wrench", keys([("force", force), ("torque", torque)]))])
            }
            Felt::Battery => {
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
            Felt::Pressure => {
                let variance = covariance::variances(turn, p, id, "pressure.pressure")[0];
                let pressure = Value::Float(of.number(p.pressure)?);
                keys([header, ("fluid_pressure", pressure), ("variance", Value::Float(variance))])
            }
        })
    }
}
