//! Reports what URDF does not hold.

use tatu_exporters_common::{Export, Mechanisms, Surface, Tie};
use tatu_plugin_api::abi::{TATU_KIND_CAMERA, TATU_KIND_FORCE_SENSOR, TATU_KIND_LIGHT, TATU_KIND_SENSOR};

use crate::robot::Robot;

/// Reports what is no part of the robot, and what has no counterpart.
pub fn report(all: &Mechanisms, robot: &Robot, export: &mut Export<'_>) {
    for (b, body) in all.bodies.iter().enumerate() {
        let is_link = robot.link_of[b].is_some();
        if !is_link {
            if b == 0 {
                for part in &body.parts {
                    export.report.lost("shapes that are fixed to the world are left out", &all.items[part.item].path);
                }
                for frame in body.frames.iter().filter(|f| all.items[f.item].children.is_empty()) {
                    export.report.lost("dummies outside the robot are left out", &all.items[frame.item].path);
                }
            } else if matches!(body.tie, Tie::World | Tie::Free) {
                export.report.lost("other bodies, with what they carry, are left out", all.path_of(b));
            }
        }
        for attached in &body.attached {
            let text = match all.items[attached.item].kind {
                TATU_KIND_SENSOR => "sensors are left out, with their noise",
                TATU_KIND_FORCE_SENSOR => "force sensors are left out: what they carry is fixed",
                TATU_KIND_CAMERA => "cameras are left out",
                TATU_KIND_LIGHT => "lights are left out",
                _ => continue,
            };
            let text = if is_link { format!("{text}; their frames are links") } else { text.to_owned() };
            export.report.lost(text, &all.items[attached.item].path);
        }
        for part in body.parts.iter().filter(|_| is_link) {
            if let Some(Surface { rolling, spinning, mask, .. }) = part.surface {
                let path = &all.items[part.item].path;
                if rolling != 0.0 || spinning != 0.0 {
                    export.report.lost("friction against rolling and spinning is left out", path);
                }
                if mask >> 8 != 0xFF || !matches!(mask & 0xFF, 0 | 0xFF) {
                    export.report.lost("masks of collisions (`respondable_mask`) are left out", path);
                }
            }
        }
    }
    for pair in &all.loops {
        let [a, _] = pair.dummies;
        if robot.link_of[all.body_of[a]].is_some() {
            export.report.lost("URDF has no loops: linked dummies are not connected", &all.items[a].path);
        }
    }
}
