//! Writes the file.

use nalgebra::Isometry3;
use tatu_exporters_common::{
    Attached, Export, MassProperties, Mechanisms, MeshFiles, NameSpace, Part, XmlWriter, number, numbers, report_losses,
};
use tatu_plugin_api::safe::Result;

use crate::{
    geometry::{Materials, PlacedPart, write_part},
    joints::{JointNames, write_fixed, write_joint},
    losses,
    robot::{Link, Robot, WORLD},
};

/// Smallest difference of frictions that is reported.
const FRICTION_TOLERANCE: f64 = 1e-9;

/// Returns the text of the URDF file of a robot.
pub fn urdf(export: &mut Export<'_>) -> Result<String> {
    let all = Mechanisms::read(&export.reader, export.base)?;
    let mut robot = Robot::choose(&all, export)?;
    let mut meshes = MeshFiles::default();
    let mut materials = Materials::default();
    for link in &robot.links {
        let shown = all.bodies[link.body].parts.iter().filter(|p| p.is_shown);
        shown.for_each(|part| materials.add(part.look.rgba));
    }
    let mut xml = XmlWriter::new("Written by Tatu.");
    let name = NameSpace::default().name(&robot.name);
    xml.begin("robot", &[("name", name)]);
    materials.write(&mut xml);
    let mut joints = JointNames::new(&all, &robot);
    if robot.is_fixed {
        xml.empty("link", &[("name", WORLD.to_owned())]);
        let root = &robot.links[0];
        let joint = joints.names.derived("world_joint");
        write_fixed(&mut xml, &joint, WORLD, &root.name, &root.origin);
    } else if robot.links[0].origin != Isometry3::identity() {
        let path = all.path_of(robot.links[0].body);
        export.report.note("URDF does not place robots: where the robot is in the scene is left out", path);
    }
    for link in 0..robot.links.len() {
        write_joint(&mut xml, &all, &mut robot, link, &mut joints, export);
        write_link(&mut xml, &all, &robot, link, (&materials, &mut meshes), export);
        write_frames(&mut xml, &all, &mut robot, link, &mut joints);
        write_friction(&mut xml, &all, &robot, link, export);
        if robot.links[link].below != Isometry3::identity() {
            let path = all.path_of(robot.links[link].body);
            export.report.note("frames of links lie at their joints: those of shapes elsewhere are moved there", path);
        }
    }
    xml.end();
    report_losses(&export.reader, &all, export.base, &mut export.report)?;
    losses::report(&all, &robot, export);
    for change in robot.names.changes() {
        export.report.note("names of links must differ", &change);
    }
    for change in joints.names.changes() {
        export.report.note("names of joints must differ", &change);
    }
    export.files = meshes.finish();
    Ok(xml.finish())
}

fn write_link(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    robot: &Robot,
    link: usize,
    (materials, meshes): (&Materials, &mut MeshFiles),
    export: &mut Export<'_>,
) {
    let link = &robot.links[link];
    let body = &all.bodies[link.body];
    xml.begin("link", &[("name", link.name.clone())]);
    if let Some(MassProperties { mass, com, inertia: i }) = &body.mass {
        let com = link.below * nalgebra::Point3::from(*com);
        xml.begin("inertial", &[]);
        xml.empty("origin", &[("xyz", numbers([com.x, com.y, com.z]))]);
        xml.empty("mass", &[("value", number(*mass))]);
        let moments = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
        let moments = moments.map(|(name, row, column)| (name, number((i[(row, column)] + i[(column, row)]) / 2.0)));
        xml.empty("inertia", &moments);
        xml.end();
    }
    fn placed<'a>(all: &'a Mechanisms, link: &Link, part: &'a Part) -> PlacedPart<'a> {
        let item = &all.items[part.item];
        PlacedPart { part, pose: link.below * part.pose, alias: &item.alias, path: &item.path }
    }
    for part in body.parts.iter().filter(|p| p.is_shown) {
        write_part(xml, &placed(all, link, part), Some(materials), meshes, &mut export.report);
    }
    for part in body.parts.iter().filter(|p| p.surface.is_some()) {
        write_part(xml, &placed(all, link, part), None, meshes, &mut export.report);
    }
    xml.end();
}

/// Writes dummies, and the frames of sensors, as links without mass.
fn write_frames(xml: &mut XmlWriter, all: &Mechanisms, robot: &mut Robot, link: usize, joints: &mut JointNames) {
    let (parent, below, body) = (robot.links[link].name.clone(), robot.links[link].below, robot.links[link].body);
    let body = &all.bodies[body];
    let dummies = body.frames.iter().filter(|f| !robot.root_frames.contains(&f.item)).map(|f| (f.item, f.pose));
    let others = body.attached.iter().map(|Attached { item, pose }| (*item, *pose));
    let frames: Vec<(usize, Isometry3<f64>)> = dummies.chain(others).collect();
    for (item, pose) in frames {
        let name = robot.names.name(&all.items[item].alias);
        let joint = joints.names.derived(&format!("{name}_fixed"));
        write_fixed(xml, &joint, &parent, &name, &(below * pose));
        xml.empty("link", &[("name", name)]);
    }
}

/// Writes the friction of a link for Gazebo.
fn write_friction(xml: &mut XmlWriter, all: &Mechanisms, robot: &Robot, link: usize, export: &mut Export<'_>) {
    let link = &robot.links[link];
    let frictions = all.bodies[link.body].parts.iter().filter_map(|p| Some((p.item, p.surface?.friction)));
    let frictions: Vec<(usize, f64)> = frictions.collect();
    let Some((_, first)) = frictions.first().copied() else { return };
    if let Some((item, _)) = frictions.iter().find(|(_, f)| (f - first).abs() > FRICTION_TOLERANCE) {
        export.report.lost("a link has one friction: that of its first form applies to all", &all.items[*item].path);
    }
    xml.begin("gazebo", &[("reference", link.name.clone())]);
    xml.text("mu1", &number(first));
    xml.text("mu2", &number(first));
    xml.end();
}
