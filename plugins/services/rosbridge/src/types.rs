//! Definitions of message types, with their names in ROS 1. The types of ROS 2 are the same, with few exceptions.

use std::{collections::BTreeMap, sync::OnceLock};

/// The public definitions of ROS, one type per line: the name of the type, then the type and name of each field in
/// order.
const TYPES: &str = "
std_msgs/Header: uint32 seq, time stamp, string frame_id
std_msgs/Empty:
std_msgs/Bool: bool data
std_msgs/Byte: uint8 data
std_msgs/Char: uint8 data
std_msgs/Int8: int8 data
std_msgs/Int16: int16 data
std_msgs/Int32: int32 data
std_msgs/Int64: int64 data
std_msgs/UInt8: uint8 data
std_msgs/UInt16: uint16 data
std_msgs/UInt32: uint32 data
std_msgs/UInt64: uint64 data
std_msgs/Float32: float32 data
std_msgs/Float64: float64 data
std_msgs/String: string data
std_msgs/Time: time data
std_msgs/Duration: duration data
std_msgs/ColorRGBA: float32 r, float32 g, float32 b, float32 a
std_msgs/MultiArrayDimension: string label, uint32 size, uint32 stride
std_msgs/MultiArrayLayout: std_msgs/MultiArrayDimension[] dim, uint32 data_offset
std_msgs/Int32MultiArray: std_msgs/MultiArrayLayout layout, int32[] data
std_msgs/UInt8MultiArray: std_msgs/MultiArrayLayout layout, uint8[] data
std_msgs/Float32MultiArray: std_msgs/MultiArrayLayout layout, float32[] data
std_msgs/Float64MultiArray: std_msgs/MultiArrayLayout layout, float64[] data
geometry_msgs/Vector3: float64 x, float64 y, float64 z
geometry_msgs/Vector3Stamped: std_msgs/Header header, geometry_msgs/Vector3 vector
geometry_msgs/Point: float64 x, float64 y, float64 z
geometry_msgs/Point32: float32 x, float32 y, float32 z
geometry_msgs/PointStamped: std_msgs/Header header, geometry_msgs/Point point
geometry_msgs/Polygon: geometry_msgs/Point32[] points
geometry_msgs/Quaternion: float64 x, float64 y, float64 z, float64 w
geometry_msgs/Pose: geometry_msgs/Point position, geometry_msgs/Quaternion orientation
geometry_msgs/Pose2D: float64 x, float64 y, float64 theta
geometry_msgs/PoseStamped: std_msgs/Header header, geometry_msgs/Pose pose
geometry_msgs/PoseArray: std_msgs/Header header, geometry_msgs/Pose[] poses
geometry_msgs/PoseWithCovariance: geometry_msgs/Pose pose, float64[36] covariance
geometry_msgs/PoseWithCovarianceStamped: std_msgs/Header header, geometry_msgs/PoseWithCovariance pose
geometry_msgs/Transform: geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation
geometry_msgs/TransformStamped: std_msgs/Header header, string child_frame_id, geometry_msgs/Transform transform
geometry_msgs/Twist: geometry_msgs/Vector3 linear, geometry_msgs/Vector3 angular
geometry_msgs/TwistStamped: std_msgs/Header header, geometry_msgs/Twist twist
geometry_msgs/TwistWithCovariance: geometry_msgs/Twist twist, float64[36] covariance
geometry_msgs/Wrench: geometry_msgs/Vector3 force, geometry_msgs/Vector3 torque
geometry_msgs/WrenchStamped: std_msgs/Header header, geometry_msgs/Wrench wrench
nav_msgs/Odometry: std_msgs/Header header, string child_frame_id, geometry_msgs/PoseWithCovariance pose, geometry_msgs/TwistWithCovariance twist
nav_msgs/Path: std_msgs/Header header, geometry_msgs/PoseStamped[] poses
nav_msgs/MapMetaData: time map_load_time, float32 resolution, uint32 width, uint32 height, geometry_msgs/Pose origin
nav_msgs/OccupancyGrid: std_msgs/Header header, nav_msgs/MapMetaData info, int8[] data
sensor_msgs/Image: std_msgs/Header header, uint32 height, uint32 width, string encoding, uint8 is_bigendian, uint32 step, uint8[] data
sensor_msgs/CompressedImage: std_msgs/Header header, string format, uint8[] data
sensor_msgs/RegionOfInterest: uint32 x_offset, uint32 y_offset, uint32 height, uint32 width, bool do_rectify
sensor_msgs/CameraInfo: std_msgs/Header header, uint32 height, uint32 width, string distortion_model, float64[] D, float64[9] K, float64[9] R, float64[12] P, uint32 binning_x, uint32 binning_y, sensor_msgs/RegionOfInterest roi
sensor_msgs/LaserScan: std_msgs/Header header, float32 angle_min, float32 angle_max, float32 angle_increment, float32 time_increment, float32 scan_time, float32 range_min, float32 range_max, float32[] ranges, float32[] intensities
sensor_msgs/PointField: string name, uint32 offset, uint8 datatype, uint32 count
sensor_msgs/PointCloud2: std_msgs/Header header, uint32 height, uint32 width, sensor_msgs/PointField[] fields, bool is_bigendian, uint32 point_step, uint32 row_step, uint8[] data, bool is_dense
sensor_msgs/Range: std_msgs/Header header, uint8 radiation_type, float32 field_of_view, float32 min_range, float32 max_range, float32 range, float32 variance
sensor_msgs/Imu: std_msgs/Header header, geometry_msgs/Quaternion orientation, float64[9] orientation_covariance, geometry_msgs/Vector3 angular_velocity, float64[9] angular_velocity_covariance, geometry_msgs/Vector3 linear_acceleration, float64[9] linear_acceleration_covariance
sensor_msgs/MagneticField: std_msgs/Header header, geometry_msgs/Vector3 magnetic_field, float64[9] magnetic_field_covariance
sensor_msgs/FluidPressure: std_msgs/Header header, float64 fluid_pressure, float64 variance
sensor_msgs/BatteryState: std_msgs/Header header, float32 voltage, float32 temperature, float32 current, float32 charge, float32 capacity, float32 design_capacity, float32 percentage, uint8 power_supply_status, uint8 power_supply_health, uint8 power_supply_technology, bool present, float32[] cell_voltage, float32[] cell_temperature, string location, string serial_number
sensor_msgs/NavSatStatus: int8 status, uint16 service
sensor_msgs/NavSatFix: std_msgs/Header header, sensor_msgs/NavSatStatus status, float64 latitude, float64 longitude, float64 altitude, float64[9] position_covariance, uint8 position_covariance_type
sensor_msgs/JointState: std_msgs/Header header, string[] name, float64[] position, float64[] velocity, float64[] effort
sensor_msgs/Joy: std_msgs/Header header, float32[] axes, int32[] buttons
tf2_msgs/TFMessage: geometry_msgs/TransformStamped[] transforms
tf/tfMessage: geometry_msgs/TransformStamped[] transforms
rosgraph_msgs/Clock: time clock
trajectory_msgs/JointTrajectoryPoint: float64[] positions, float64[] velocities, float64[] accelerations, float64[] effort, duration time_from_start
trajectory_msgs/JointTrajectory: std_msgs/Header header, string[] joint_names, trajectory_msgs/JointTrajectoryPoint[] points
std_srvs/EmptyRequest:
std_srvs/EmptyResponse:
std_srvs/SetBoolRequest: bool data
std_srvs/SetBoolResponse: bool success, string message
std_srvs/TriggerRequest:
std_srvs/TriggerResponse: bool success, string message
example_interfaces/AddTwoIntsRequest: int64 a, int64 b
example_interfaces/AddTwoIntsResponse: int64 sum
example_interfaces/FibonacciGoal: int32 order
example_interfaces/FibonacciResult: int32[] sequence
example_interfaces/FibonacciFeedback: int32[] sequence
";

/// The type of the elements of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FieldElementType {
    /// A boolean.
    Bool,
    /// An integer. The values are whether it is signed, and its size in bits.
    Int(bool, u8),
    /// A floating-point number with this size in bits.
    Float(u8),
    /// A string.
    Text,
    /// A time or duration.
    Time,
    /// A nested message of the type with this name.
    Message(String),
}

/// The number of elements of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArrayLength {
    /// A single element.
    One,
    /// An array of any length.
    Any,
    /// An array of exactly this length.
    Exactly(usize),
}

/// A field of a message type.
#[derive(Debug, Clone)]
pub struct MessageField {
    /// The name of the field in ROS 1.
    pub name: String,
    /// The type of the elements.
    pub element: FieldElementType,
    /// The number of elements.
    pub length: ArrayLength,
    /// The type of the elements as it is written in the definition.
    pub written_type: String,
}

/// Returns the fields of a type, given its name in ROS 1; `None` if the type is not supported.
pub fn fields(plain: &str) -> Option<&'static [MessageField]> {
    static ALL: OnceLock<BTreeMap<&'static str, Vec<MessageField>>> = OnceLock::new();
    let all = ALL
        .get_or_init(|| TYPES.lines().filter_map(|l| l.split_once(':')).map(|(n, f)| (n, parse_fields(f))).collect());
    all.get(plain).map(Vec::as_slice)
}

/// Parses the fields in a line of `TYPES`.
fn parse_fields(text: &'static str) -> Vec<MessageField> {
    let field = |one: &'static str| {
        let (written, name) = one.trim().split_once(' ')?;
        let (base, many) = match written.trim_end_matches(']').split_once('[') {
            Some((base, "")) => (base, ArrayLength::Any),
            Some((base, n)) => (base, ArrayLength::Exactly(n.parse().unwrap_or(0))),
            None => (written, ArrayLength::One),
        };
        let bits = |kind: &str| base.strip_prefix(kind).and_then(|b| b.parse::<u8>().ok());
        let of = match base {
            "bool" => FieldElementType::Bool,
            "string" => FieldElementType::Text,
            "time" | "duration" => FieldElementType::Time,
            _ if bits("uint").is_some() => FieldElementType::Int(false, bits("uint").unwrap_or(32)),
            _ if bits("int").is_some() => FieldElementType::Int(true, bits("int").unwrap_or(32)),
            _ if bits("float").is_some() => FieldElementType::Float(bits("float").unwrap_or(64)),
            message => FieldElementType::Message(message.to_owned()),
        };
        Some(MessageField { name: name.to_owned(), element: of, length: many, written_type: base.to_owned() })
    };
    text.split(',').filter_map(field).collect()
}

/// A version of ROS, which determines the names of types and fields and the form of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RosVersion {
    /// ROS 1: times have `secs` and `nsecs`, and headers have a sequence number.
    One,
    /// ROS 2: times have `sec` and `nanosec`.
    Two,
}

impl RosVersion {
    /// Returns the version of ROS in which a type has this name; names in ROS 2 have the form
    /// `geometry_msgs/msg/Twist`.
    pub fn of(name: &str) -> Option<RosVersion> {
        match name.matches('/').count() {
            1 => Some(RosVersion::One),
            2 => Some(RosVersion::Two),
            _ => None,
        }
    }
    /// Returns the name of a message type in this version, given its name in ROS 1.
    pub fn name(self, plain: &str) -> String {
        match (self, plain.split_once('/')) {
            (RosVersion::Two, Some((package, name))) => format!("{package}/msg/{name}"),
            _ => plain.to_owned(),
        }
    }
    /// Returns the name of a field in this version, or `None` if the field does not exist in it.
    pub fn field(self, plain: &str, name: &str) -> Option<String> {
        match (self, plain, name) {
            (RosVersion::Two, "std_msgs/Header", "seq") => None,
            (RosVersion::One, "sensor_msgs/Range", "variance") => None,
            (RosVersion::Two, "sensor_msgs/CameraInfo", _) => Some(name.to_ascii_lowercase()),
            _ => Some(name.to_owned()),
        }
    }
}

/// Converts the name of a type to its name in ROS 1.
pub fn ros1_name(name: &str) -> String {
    name.replace("/msg/", "/").replace("/srv/", "/").replace("/action/", "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_nested_message_type_is_defined() {
        for line in TYPES.lines().filter(|l| !l.is_empty()) {
            let name = line.split(':').next().unwrap();
            for field in fields(name).unwrap() {
                if let FieldElementType::Message(inner) = &field.element {
                    assert!(fields(inner).is_some(), "{name}: {inner}");
                }
            }
        }
        assert_eq!(fields("sensor_msgs/CameraInfo").unwrap()[5].length, ArrayLength::Exactly(9));
        assert_eq!(ros1_name("geometry_msgs/msg/Twist"), "geometry_msgs/Twist");
        assert_eq!(RosVersion::Two.name("geometry_msgs/Twist"), "geometry_msgs/msg/Twist");
    }
}
