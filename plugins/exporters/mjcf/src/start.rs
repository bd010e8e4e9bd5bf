//! The keyframe: the positions of joints and free bodies in the scene, and the controls.

use nalgebra::Isometry3;
use tatu_exporters_common::{Export, JointKind, Mechanisms, Tie, XmlWriter, numbers};
use tatu_plugin_api::safe::Result;

use crate::drives::Drives;

/// Name of the keyframe.
const HOME: &str = "home";

/// Writes the keyframe, unless it would be what the file states anyway. `order` lists bodies as they are written.
pub fn write_keyframe(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    order: &[usize],
    drives: &Drives,
    export: &Export<'_>,
) -> Result {
    let mut positions = Vec::new();
    let mut is_default = true;
    for body in order {
        let of = &all.bodies[*body];
        match &of.tie {
            Tie::Free => {
                let item = of.item.map_or(0, |item| all.items[item].id);
                let [x, y, z, i, j, k, w] = export.reader.world.pose(item, 0)?;
                let now = tatu_exporters_common::pose_of([x, y, z, i, j, k, w]);
                is_default &= is_near(&now, &of.pose);
                positions.extend([x, y, z, w, i, j, k]);
            }
            Tie::Joint { joint, .. } if joint.kind == JointKind::Spherical => {
                let [x, y, z, w] = joint.rotation;
                is_default &= [x, y, z] == [0.0; 3];
                positions.extend([w, x, y, z]);
            }
            Tie::Joint { joint, .. } => {
                is_default &= joint.position == 0.0;
                positions.push(joint.position);
            }
            Tie::World | Tie::Rigid { .. } => {}
        }
    }
    let controls: Vec<f64> = drives.actuators.iter().map(|a| a.control).collect();
    if is_default && controls.iter().all(|c| *c == 0.0) {
        return Ok(());
    }
    xml.begin("keyframe", &[]);
    let mut attributes = vec![("name", HOME.to_owned()), ("qpos", numbers(positions))];
    if !controls.is_empty() {
        attributes.push(("ctrl", numbers(controls)));
    }
    xml.empty("key", &attributes);
    xml.end();
    Ok(())
}

fn is_near(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-12 && a.rotation.angle_to(&b.rotation) < 1e-12
}
