//! Generates URDF descriptions of a scene's robots for clients.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
};

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn, ValueRef},
};

use crate::{
    Props,
    poses::{IDENTITY, Pose, compose, relative_pose},
    robots::{Robot, RobotScene, ros_name},
};

/// Limit of the effort (N or N m), velocity (m/s or rad/s) and position (m) of joints without such a limit, because
/// URDF requires limits. It is far above the limits of real joints.
const NO_LIMIT: f64 = 1e6;

/// Returns the description of a robot in URDF. The base and all objects below it, except sensors and other robots,
/// become links with unique names. The link `base_link` is that of `/tf`, and joints have the same names as in
/// `joint_states`. Meshes are replaced by their bounding boxes, because clients cannot read files of the program.
pub fn urdf(turn: &Turn<'_>, p: &Props, scene: &RobotScene, robot: &Robot) -> Result<String> {
    let root = format!("{}base_link", robot.prefix);
    let mut children: BTreeMap<tatu_object, Vec<tatu_object>> = BTreeMap::new();
    for &id in &scene.ids {
        if let Some(parent) = turn.get(id, p.parent)?.as_object() {
            children.entry(parent).or_default().push(id);
        }
    }
    let names = BTreeSet::from([root.clone()]);
    let mut out = UrdfWriter { turn, p, scene, robot, children, names, text: String::new() };
    let _ = writeln!(out.text, "<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n  <link name=\"{root}\"/>", robot.name);
    let base = relative_pose(&robot.base_link_pose(), &IDENTITY);
    out.object(robot.base, &root, &base)?;
    out.text += "</robot>\n";
    Ok(out.text)
}

/// Writes the description of a robot.
struct UrdfWriter<'a> {
    turn: &'a Turn<'a>,
    p: &'a Props,
    scene: &'a RobotScene,
    robot: &'a Robot,
    /// The children of each object, in the order of the tree.
    children: BTreeMap<tatu_object, Vec<tatu_object>>,
    /// Names of links and joints that are in use.
    names: BTreeSet<String>,
    text: String,
}

impl UrdfWriter<'_> {
    /// Writes an object at a pose in the frame of a link, and the objects below it.
    fn object(&mut self, id: tatu_object, link: &str, at: &Pose) -> Result {
        match self.turn.look(id)?.kind {
            TATU_KIND_JOINT => return self.joint(id, link, at),
            // Frames of sensors are published in `/tf`, with the axes that ROS defines for sensors.
            TATU_KIND_SENSOR => return Ok(()),
            _ => {}
        }
        let own = self.name(id, "")?;
        let mount = self.unique_name(format!("{own}_mount"));
        self.connect(&mount, "fixed", link, &own, at, "");
        self.link(id, &own)?;
        self.write_children(id, &own)
    }

    /// Writes the objects below an object, except those of other robots.
    fn write_children(&mut self, id: tatu_object, link: &str) -> Result {
        for child in self.children.get(&id).cloned().unwrap_or_default() {
            if !self.scene.robots.iter().any(|r| r.base == child) {
                self.object(child, link, &self.turn.f64s(child, self.p.pose)?)?;
            }
        }
        Ok(())
    }

    /// Writes a joint, the link that it moves, and the objects below it.
    fn joint(&mut self, id: tatu_object, link: &str, at: &Pose) -> Result {
        let known = self.robot.joints.iter().find(|(joint, _)| *joint == id).map(|(_, name)| name.clone());
        let name = match known {
            Some(name) => name,
            None => self.name(id, "")?,
        };
        let moved = self.name(id, "_link")?;
        let kind = self.turn.get(id, self.p.joint_type)?.as_str().unwrap_or_default().into_owned();
        let limits = self.turn.get(id, self.p.joint_limits).ok().and_then(|v| v.array::<2>());
        let cyclic = self.turn.get(id, self.p.joint_cyclic).is_ok_and(|v| v.truthy());
        let effort = self.turn.f64(id, self.p.max_force).unwrap_or(NO_LIMIT).clamp(0.0, NO_LIMIT);
        let limits = limits.filter(|l| !cyclic && l.iter().all(|x| x.is_finite()));
        let more = |[low, high]: [f64; 2]| {
            let bounds = format!("lower=\"{low}\" upper=\"{high}\" effort=\"{effort}\" velocity=\"{NO_LIMIT}\"");
            format!("    <axis xyz=\"0 0 1\"/>\n    <limit {bounds}/>\n")
        };
        let (kind, more) = match (kind.as_str(), limits) {
            ("revolute", Some(limits)) => ("revolute", more(limits)),
            ("revolute", None) => ("continuous", "    <axis xyz=\"0 0 1\"/>\n".to_owned()),
            ("prismatic", limits) => ("prismatic", more(limits.unwrap_or([-NO_LIMIT, NO_LIMIT]))),
            _ => ("floating", String::new()),
        };
        self.connect(&name, kind, link, &moved, at, &more);
        let _ = writeln!(self.text, "  <link name=\"{moved}\"/>");
        self.write_children(id, &moved)
    }

    /// Writes a joint of URDF between two links.
    fn connect(&mut self, name: &str, kind: &str, from: &str, to: &str, at: &Pose, more: &str) {
        let _ = write!(
            self.text,
            "  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{from}\"/>\n    <child link=\"{to}\"/>\n    \
             {}\n{more}  </joint>\n",
            origin(at),
        );
    }

    /// Writes the link of an object, with the visible and colliding parts of a shape.
    fn link(&mut self, id: tatu_object, name: &str) -> Result {
        if self.turn.look(id)?.kind != TATU_KIND_SHAPE {
            let _ = writeln!(self.text, "  <link name=\"{name}\"/>");
            return Ok(());
        }
        let _ = writeln!(self.text, "  <link name=\"{name}\">");
        if self.turn.get(id, self.p.dynamic)?.truthy() {
            self.inertial(id)?;
        }
        let visible = self.turn.get(id, self.p.visible)?.truthy();
        let collides = self.turn.get(id, self.p.respondable)?.truthy();
        let mut n = 0;
        while let Some(part) = self.turn.part(id, n)? {
            n += 1;
            let Some((at, shape)) = geometry(part) else { continue };
            let place = format!("      {}\n      <geometry>{shape}</geometry>\n", origin(&at));
            if visible {
                let color = part.get("color").and_then(|v| v.array::<3>()).unwrap_or([0.8; 3]);
                let [r, g, b] = color;
                let a = part.get("opacity").and_then(|v| v.as_f64()).unwrap_or(1.0);
                let paint = format!("<material name=\"{name}_{n}\"><color rgba=\"{r} {g} {b} {a}\"/></material>");
                let _ = write!(self.text, "    <visual>\n{place}      {paint}\n    </visual>\n");
            }
            if collides {
                let _ = write!(self.text, "    <collision>\n{place}    </collision>\n");
            }
        }
        self.text += "  </link>\n";
        Ok(())
    }

    /// Writes the mass and inertia of a shape.
    fn inertial(&mut self, id: tatu_object) -> Result {
        let com: [f64; 3] = self.turn.f64s(id, self.p.com)?;
        let inertia = self.turn.get(id, self.p.inertia)?.numbers().unwrap_or_default();
        let [xx, xy, xz, yy, yz, zz] = match *inertia {
            [x, y, z] => [x, 0.0, 0.0, y, 0.0, z],
            [xx, xy, xz, _, yy, yz, _, _, zz] => [xx, xy, xz, yy, yz, zz],
            _ => return Ok(()),
        };
        let mass = self.turn.f64(id, self.p.mass)?;
        let at = origin(&[com[0], com[1], com[2], 0.0, 0.0, 0.0, 1.0]);
        let _ = write!(
            self.text,
            "    <inertial>\n      {at}\n      <mass value=\"{mass}\"/>\n      <inertia ixx=\"{xx}\" ixy=\"{xy}\" \
             ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n",
        );
        Ok(())
    }

    /// Returns a unique name for a link or joint that represents an object.
    fn name(&mut self, id: tatu_object, end: &str) -> Result<String> {
        let name = ros_name(&self.turn.get(id, self.p.name)?.as_str().unwrap_or_default());
        Ok(self.unique_name(format!("{}{name}{end}", self.robot.prefix)))
    }

    /// Reserves a name, and returns it with a number appended if it is in use.
    fn unique_name(&mut self, name: String) -> String {
        let numbered = (2..).map(|n| format!("{name}_{n}"));
        let found = [name.clone()].into_iter().chain(numbered).find(|n| !self.names.contains(n)).unwrap_or(name);
        self.names.insert(found.clone());
        found
    }
}

/// Returns the pose and geometry of a part of a shape, or `None` for infinite planes. Capsules become cylinders, and
/// meshes become their bounding boxes.
fn geometry(part: ValueRef<'_>) -> Option<(Pose, String)> {
    let numbers = |key: &str| part.get(key).and_then(|v| v.numbers()).unwrap_or_default();
    let mut at: Pose = numbers("pose").first_chunk().copied()?;
    let form = part.get("form")?.as_str()?;
    let sized = |size: [f64; 3]| format!("<box size=\"{} {} {}\"/>", size[0], size[1], size[2]);
    let size: Option<[f64; 3]> = numbers("size").first_chunk().copied();
    Some(match (&*form, size) {
        ("plane", _) => return None,
        ("sphere", Some([x, ..])) => (at, format!("<sphere radius=\"{}\"/>", x / 2.0)),
        ("cylinder" | "capsule", Some([x, _, z])) => (at, format!("<cylinder radius=\"{}\" length=\"{z}\"/>", x / 2.0)),
        ("mesh", _) => {
            let points = numbers("points");
            let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
            for point in points.chunks_exact(3) {
                for k in 0..3 {
                    (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k]));
                }
            }
            let middle: [f64; 3] = std::array::from_fn(|k| (low[k] + high[k]) / 2.0);
            at = compose(&at, &[middle[0], middle[1], middle[2], 0.0, 0.0, 0.0, 1.0]);
            (at, sized(std::array::from_fn(|k| high[k] - low[k])))
        }
        (_, Some(size)) => (at, sized(size)),
        _ => return None,
    })
}

/// Formats a pose as an origin of URDF. `rpy` contains the rotations about the fixed axes x, y and z, in this order,
/// rad.
fn origin(at: &Pose) -> String {
    let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(at[6], at[3], at[4], at[5]));
    let (roll, pitch, yaw) = q.euler_angles();
    format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", at[0], at[1], at[2])
}
