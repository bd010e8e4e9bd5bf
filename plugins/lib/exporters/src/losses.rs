//! Reports what neither URDF nor MJCF holds, whatever the exporter.

use tatu_plugin_api::{
    abi::{
        TATU_KIND_ACTUATOR, TATU_KIND_GRAPH, TATU_KIND_JOINT, TATU_KIND_PART, TATU_KIND_PATH, TATU_KIND_SHAPE,
        tatu_object,
    },
    safe::Result,
};

use crate::{
    joints::{Control, JointKind, JointProperties},
    mechanism::{Mechanisms, Tie},
    objects::{Item, SceneReader},
    report::ExportReport,
};

/// Reports objects and properties that no robot format of this program holds.
pub fn report_losses(
    reader: &SceneReader<'_>,
    all: &Mechanisms,
    base: tatu_object,
    report: &mut ExportReport,
) -> Result {
    for item in &all.items {
        if !reader.world.scripts(item.id)?.is_empty() {
            report.lost("scripts are left out", &item.path);
        }
        match item.kind {
            TATU_KIND_SHAPE => shape(reader, item, report),
            TATU_KIND_JOINT => joint(reader, item, report),
            TATU_KIND_GRAPH => report.lost("graphs are left out", &item.path),
            TATU_KIND_PATH => report.lost("paths are left out", &item.path),
            TATU_KIND_ACTUATOR => report.lost("actuators that are not joints are left out", &item.path),
            TATU_KIND_PART => report.lost("parts are left out", &item.path),
            _ => {}
        }
    }
    if base == 0 && reader.world.scripts(0)?.iter().any(|script| reader.text(*script, "script.kind") == "main") {
        report.lost("scripts are left out", "the main script");
    }
    for (i, body) in all.bodies.iter().enumerate() {
        if let Tie::Joint { item, .. } = body.tie {
            match body.mass {
                None => report.note("what a joint without a shape moves is a body without mass", &all.items[item].path),
                Some(_) if body.item.is_some_and(|shape| !reader.bool(all.items[shape].id, "shape.dynamic")) => report
                    .lost(
                        "joints that are moved by setting their position are joints that forces move",
                        all.path_of(i),
                    ),
                Some(_) => {}
            }
        }
        if let Tie::Rigid { parent } = body.tie
            && matches!(&all.bodies[parent].tie, Tie::Joint { item, .. } if all.items[*item].id == parent_object(all, i))
        {
            report.lost("the second body that one joint moves is fixed to the first", all.path_of(i));
        }
        for part in &body.parts {
            if part.look.has_image && part.is_shown {
                report.lost("images on surfaces are left out", &all.items[part.item].path);
            }
        }
    }
    Ok(())
}

/// Returns the parent of the object that stands for a body.
fn parent_object(all: &Mechanisms, body: usize) -> tatu_object {
    let parent = all.bodies[body].item.and_then(|item| all.items[item].parent);
    parent.map_or(0, |parent| all.items[parent].id)
}

fn shape(reader: &SceneReader<'_>, item: &Item, report: &mut ExportReport) {
    let f64 = |key: &str| reader.f64(item.id, key);
    let vector = |key: &str| reader.array::<3>(item.id, key).unwrap_or([0.0; 3]) != [0.0; 3];
    if f64("shape.restitution") != 0.0 {
        report.lost("restitution (`restitution`) is left out", &item.path);
    }
    if vector("shape.surface_velocity") {
        report.lost("moving surfaces (`surface_velocity_m_s`) are left out", &item.path);
    }
    if vector("shape.friction_axis") {
        report.lost("friction that depends on the direction (`friction_axis`) is left out", &item.path);
    }
    if !reader.text(item.id, "shape.material").is_empty() {
        report.lost("materials, with their friction by pair (`material`, `friction_pairs`), are left out", &item.path);
    }
    if f64("shape.linear_damping") != 0.0 || f64("shape.angular_damping") != 0.0 {
        report.lost("damping of shapes (`linear_damping`, `angular_damping`) is left out", &item.path);
    }
    if vector("shape.initial_velocity") || vector("shape.initial_angular_velocity") {
        report.lost("initial velocities are left out", &item.path);
    }
    let is_plane = reader.text(item.id, "shape.primitive") == "plane";
    let is_seen = reader.bool(item.id, "object.visible");
    if is_seen && !is_plane && !reader.bool(item.id, "shape.detectable") {
        report.lost("shapes that sensors do not detect (`detectable = false`) are detected", &item.path);
    }
}

fn joint(reader: &SceneReader<'_>, item: &Item, report: &mut ExportReport) {
    let joint = JointProperties::read(reader, item.id);
    let f64 = |key: &str| reader.f64(item.id, key);
    if f64("joint.lead") != 0.0 && joint.kind == JointKind::Revolute {
        report.lost("screws (`lead_m`) are left out: the joint only turns", &item.path);
    }
    if f64("joint.no_load_speed") != 0.0 && joint.has_motor() {
        report.lost("the loss of torque with speed (`no_load_speed`) is left out", &item.path);
    }
    if !reader.get(item.id, "joint.gains").is_empty() && joint.control == Control::Position {
        report.lost("gains of position control (`gains`) are left out", &item.path);
    }
    if !reader.get(item.id, "joint.follow_curve").is_empty() {
        report.lost("joints that follow a curve (`follow_curve`) are not coupled", &item.path);
    }
    if joint.control == Control::Callback && joint.is_dynamic {
        report.lost("joints that a script drives (`control = \"callback\"`) are not driven", &item.path);
    }
}
