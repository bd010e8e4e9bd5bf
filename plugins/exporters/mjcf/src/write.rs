//! Writes the file.

use tatu_exporters_common::{Export, Mechanisms, XmlWriter, number, numbers, report_losses};
use tatu_plugin_api::safe::{Fail, Result};

use crate::{
    attached::write_sensors,
    bodies::{BodyWriter, order},
    drives::Drives,
    geoms::Meshes,
    losses,
    masks::Masks,
    naming::Names,
    start::write_keyframe,
};

/// Returns the text of the MJCF file of a scene or an object.
pub fn mjcf(export: &mut Export<'_>) -> Result<String> {
    let all = Mechanisms::read(&export.reader, export.base)?;
    if all.items.is_empty() {
        return Err(Fail::missing("there is nothing to export: the scene has no objects"));
    }
    let tops = all.items.iter().filter(|item| item.parent.is_none()).count();
    let model = match all.items.first().filter(|_| tops == 1) {
        Some(item) => item.alias.clone(),
        None => export.name.clone(),
    };
    let order = order(&all);
    let names = Names::new(&all, &mut export.report);
    let masks = Masks::new(&all, &mut export.report);
    let gains = |item: usize| export.reader.get(all.items[item].id, "joint.gains").number(0);
    let drives = Drives::new(&all, &order, &names, &gains, &mut export.report);
    // The bodies are written first, because they determine what precedes them in the file.
    let mut bodies = XmlWriter::nested(1);
    let mut writer =
        BodyWriter { all: &all, names, masks, meshes: Meshes::default(), sensors: Vec::new(), export, balances: false };
    writer.write(&mut bodies);
    let BodyWriter { names, masks, meshes, sensors, balances, export, .. } = writer;

    let mut xml = XmlWriter::new("Written by Tatu.");
    xml.begin("mujoco", &[("model", model)]);
    let mut compiler = vec![("angle", "radian".to_owned()), ("autolimits", "true".to_owned())];
    if balances {
        compiler.push(("balanceinertia", "true".to_owned()));
    }
    xml.empty("compiler", &compiler);
    write_option(&mut xml, &drives, export);
    if !meshes.names.is_empty() {
        xml.begin("asset", &[]);
        for (file, name) in &meshes.names {
            // Bodies state their mass, so meshes need no volume.
            let attributes = [("name", name.clone()), ("file", file.clone()), ("inertia", "shell".to_owned())];
            xml.empty("mesh", &attributes);
        }
        xml.end();
    }
    xml.append(bodies);
    if !masks.excluded.is_empty() {
        xml.begin("contact", &[]);
        for [a, b] in &masks.excluded {
            xml.empty("exclude", &[("body1", names.bodies[*a].clone()), ("body2", names.bodies[*b].clone())]);
        }
        xml.end();
    }
    let loops: Vec<[&String; 2]> = all
        .loops
        .iter()
        .filter_map(|l| Some([names.sites.get(&l.dummies[0])?, names.sites.get(&l.dummies[1])?]))
        .collect();
    if drives.has_equations() || !loops.is_empty() {
        xml.begin("equality", &[]);
        drives.write_equations(&mut xml);
        for [a, b] in loops {
            xml.empty("weld", &[("site1", a.clone()), ("site2", b.clone())]);
        }
        xml.end();
    }
    drives.write_actuators(&mut xml);
    write_sensors(&mut xml, &sensors);
    write_keyframe(&mut xml, &all, &order, &drives, export)?;
    xml.end();
    report_losses(&export.reader, &all, export.base, &mut export.report)?;
    losses::report(&all, export);
    export.files = meshes.files.finish();
    Ok(xml.finish())
}

fn write_option(xml: &mut XmlWriter, drives: &Drives, export: &Export<'_>) {
    let mut option = vec![("timestep", number(export.reader.f64(0, "scene.physics_dt")))];
    if let Some(gravity) = export.reader.array::<3>(0, "scene.gravity") {
        option.push(("gravity", numbers(gravity)));
    }
    if drives.actuators.iter().any(|a| a.is_damped) {
        option.push(("integrator", "implicitfast".to_owned()));
    }
    xml.empty("option", &option);
}
