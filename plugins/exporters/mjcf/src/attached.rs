//! Writes what is attached to bodies: sites, cameras, lights and sensors.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Vector3};
use tatu_exporters_common::{Export, Mechanisms, Tie, XmlWriter, number, numbers};
use tatu_plugin_api::abi::{TATU_KIND_CAMERA, TATU_KIND_FORCE_SENSOR, TATU_KIND_LIGHT, TATU_KIND_SENSOR};

use crate::{
    geoms::add_pose,
    naming::{Names, has_base},
};

/// Ratio of width and height of pictures, by which the horizontal angle of view becomes the vertical one.
const ASPECT: f64 = 4.0 / 3.0;

/// Sensors, which are written after all bodies.
pub type Sensors = Vec<(&'static str, String, String)>;

/// Writes the sites, cameras and lights of a body, and collects its sensors.
pub fn write_attached(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    body: usize,
    names: &mut Names,
    sensors: &mut Sensors,
    export: &mut Export<'_>,
) {
    for frame in &all.bodies[body].frames {
        // The base of a model is the model itself.
        let is_base = frame.item == 0 && has_base(all);
        if !is_base {
            write_site(xml, names, frame.item, &frame.pose);
        }
    }
    for attached in &all.bodies[body].attached {
        let item = &all.items[attached.item];
        match item.kind {
            TATU_KIND_CAMERA => {
                // MuJoCo's cameras look along -z.
                let pose = attached.pose * Isometry3::rotation(Vector3::y() * PI);
                let half = export.reader.f64(item.id, "camera.angle") / 2.0;
                let mut attributes = vec![("name", names.views.derived(&item.alias))];
                add_pose(&mut attributes, &pose);
                attributes.push(("fovy", number((2.0 * libm::atan(libm::tan(half) / ASPECT)).to_degrees())));
                if export.reader.f64(item.id, "camera.ortho_size") > 0.0 {
                    export.report.lost("cameras with parallel projection become cameras with perspective", &item.path);
                }
                xml.empty("camera", &attributes);
            }
            TATU_KIND_LIGHT => write_light(xml, names, &attached.pose, item, export),
            TATU_KIND_SENSOR => {
                let kind = export.reader.text(item.id, "sensor.kind");
                let elements: &[&'static str] = match &*kind {
                    "imu" => &["gyro", "accelerometer"],
                    "compass" => &["magnetometer"],
                    _ => &[],
                };
                write_site(xml, names, attached.item, &attached.pose);
                if elements.is_empty() {
                    export.report.lost(
                        "sensors other than `imu` and `compass` are left out; their frames are sites",
                        &item.path,
                    );
                } else {
                    export.report.lost("settings and noise of sensors are left out", &item.path);
                }
                add_sensors(elements, attached.item, &item.alias, names, sensors);
            }
            _ => {}
        }
    }
    // MuJoCo measures what holds the body of the site.
    let tie = all.bodies[body].item.and_then(|item| all.items[item].parent);
    if let (Tie::Rigid { .. }, Some(tie)) = (&all.bodies[body].tie, tie)
        && all.items[tie].kind == TATU_KIND_FORCE_SENSOR
    {
        let pose = all.items[all.bodies[body].item.unwrap_or_default()].pose.inverse();
        write_site(xml, names, tie, &pose);
        add_sensors(&["force", "torque"], tie, &all.items[tie].alias, names, sensors);
    }
}

fn write_site(xml: &mut XmlWriter, names: &Names, item: usize, pose: &Isometry3<f64>) {
    let Some(name) = names.sites.get(&item) else { return };
    let mut attributes = vec![("name", name.clone())];
    add_pose(&mut attributes, pose);
    xml.empty("site", &attributes);
}

fn add_sensors(elements: &[&'static str], item: usize, alias: &str, names: &mut Names, sensors: &mut Sensors) {
    let Some(site) = names.sites.get(&item).cloned() else { return };
    for (i, element) in elements.iter().enumerate() {
        let wanted = if i == 0 { alias.to_owned() } else { format!("{alias}_{element}") };
        sensors.push((element, names.sensors.derived(&wanted), site.clone()));
    }
}

fn write_light(
    xml: &mut XmlWriter,
    names: &mut Names,
    pose: &Isometry3<f64>,
    item: &tatu_exporters_common::Item,
    export: &mut Export<'_>,
) {
    let form = export.reader.text(item.id, "light.form");
    let kind = match &*form {
        "directional" => "directional",
        "spot" => "spot",
        _ => "point",
    };
    let (place, along) = (pose.translation.vector, pose.rotation * Vector3::z());
    let color = export.reader.array::<3>(item.id, "light.color").unwrap_or([0.5; 3]);
    let mut attributes = vec![
        ("name", names.views.derived(&item.alias)),
        ("type", kind.to_owned()),
        ("pos", numbers([place.x, place.y, place.z])),
        ("dir", numbers([along.x, along.y, along.z])),
        ("diffuse", numbers(color)),
    ];
    if kind == "spot" {
        attributes.push(("cutoff", number(export.reader.f64(item.id, "light.angle").to_degrees())));
    }
    if !export.reader.bool(item.id, "light.on") {
        attributes.push(("active", "false".to_owned()));
    }
    xml.empty("light", &attributes);
}

/// Writes the sensors.
pub fn write_sensors(xml: &mut XmlWriter, sensors: &Sensors) {
    if sensors.is_empty() {
        return;
    }
    xml.begin("sensor", &[]);
    for (element, name, site) in sensors {
        xml.empty(element, &[("name", name.clone()), ("site", site.clone())]);
    }
    xml.end();
}
