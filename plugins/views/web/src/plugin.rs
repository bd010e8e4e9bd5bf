//! The state of the plugin: interned keys of properties and of fields of readings.

use tatu_plugin_api::safe::{Host, Prop};

macro_rules! props {
    ($($name:ident: $key:literal,)*) => {
        /// Interned keys of properties and of fields of readings.
        #[derive(Clone, Copy)]
        pub struct Props { $(pub $name: Prop,)* }
        impl Props {
            /// Interns all keys.
            pub fn new(host: &Host) -> Self {
                Props { $($name: host.prop($key),)* }
            }
        }
    };
}
props! {
    alias: "object.alias",
    kind: "object.kind",
    parent: "object.parent",
    pose: "object.pose",
    visible: "object.visible",
    layer: "object.layer",
    model_base: "object.model_base",
    data: "object.data",
    primitive: "shape.primitive",
    size: "shape.size",
    mesh: "shape.mesh",
    parts: "shape.parts",
    color: "shape.color",
    opacity: "shape.opacity",
    part_colors: "shape.part_colors",
    part_opacities: "shape.part_opacities",
    respondable: "shape.respondable",
    dynamic: "shape.dynamic",
    inertia: "shape.inertia",
    com: "shape.com",
    mass: "shape.mass",
    joint_type: "joint.type",
    joint_position: "joint.position",
    joint_rotation: "joint.rotation",
    joint_lead: "joint.lead",
    joint_limits: "joint.limits",
    joint_cyclic: "joint.cyclic",
    sensor_kind: "sensor.kind",
    script_name: "script.name",
    script_kind: "script.kind",
    script_language: "script.language",
    points: "path.points",
    closed: "path.closed",
    time: "scene.time",
    dt: "scene.dt",
    file: "scene.file",
    notes: "scene.notes",
    scene_data: "scene.data",
    detected: "proximity.detected",
    distance: "proximity.distance",
    point: "proximity.point",
    scan_distance: "range_scan.distance",
    scan_angle: "range_scan.angle",
    scan_elevation: "range_scan.elevation",
    scan_limits: "range_scan.limits",
    depth: "depth_image.depth",
    depth_limits: "depth_image.limits",
    rgb: "color_image.rgb",
    gps: "gps.position",
}

/// The plugin, which offers the services `web` and `film`.
pub struct WebPage {
    pub(crate) p: Props,
}
