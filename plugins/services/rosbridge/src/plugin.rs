//! The state of the plugin: interned keys of properties and of fields of readings.

use tatu_plugin_api::safe::{Call, Host, Prop};

macro_rules! props {
    ($($name:ident: $key:literal,)*) => {
        /// Interned keys of properties and of fields of readings.
        #[derive(Clone, Copy)]
        pub(crate) struct Props { pub(crate) wheels: tatu_robots_drivetrain::Props, $(pub(crate) $name: Prop,)* }
        impl Props {
            pub(crate) fn new(host: &Host) -> Self {
                Props { wheels: tatu_robots_drivetrain::Props::new(host), $($name: host.prop($key),)* }
            }
        }
    };
}
props! {
    alias: "object.alias",
    name: "object.name",
    parent: "object.parent",
    model_base: "object.model_base",
    pose: "object.pose",
    visible: "object.visible",
    dynamic: "shape.dynamic",
    respondable: "shape.respondable",
    com: "shape.com",
    mass: "shape.mass",
    inertia: "shape.inertia",
    joint_type: "joint.type",
    joint_limits: "joint.limits",
    joint_cyclic: "joint.cyclic",
    max_force: "joint.max_force",
    effort: "joint.effort",
    sensor_kind: "sensor.kind",
    measured: "sensor.measured",
    rate: "sensor.rate",
    noise: "sensor.noise",
    time: "scene.time",
    dt: "scene.dt",
    scan_distance: "range_scan.distance",
    scan_angle: "range_scan.angle",
    scan_limits: "range_scan.limits",
    scan_elevation: "range_scan.elevation",
    scan_intensity: "range_scan.intensity",
    detected: "proximity.detected",
    distance: "proximity.distance",
    fix_valid: "gps.valid",
    latitude: "gps.latitude",
    longitude: "gps.longitude",
    altitude: "gps.altitude",
    rgb: "color_image.rgb",
    depth: "depth_image.depth",
    intrinsics: "depth_image.intrinsics",
    parallel: "depth_image.parallel",
    acceleration: "imu.acceleration",
    angular_velocity: "imu.angular_velocity",
    orientation: "imu.orientation",
    magnetic_field: "magnetic_field.field",
    force: "wrench.force",
    torque: "wrench.torque",
    voltage: "battery.voltage",
    current: "battery.current",
    charge: "battery.charge",
    pressure: "pressure.pressure",
}

/// A call of one of this plugin's commands.
pub(crate) type RosCall<'a> = Call<'a, RosPlugin>;

/// The plugin, which offers the service `rosbridge` and the commands `simROS` and `simROS2`.
pub struct RosPlugin {
    pub(crate) p: Props,
}
