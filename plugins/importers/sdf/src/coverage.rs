//! Reports elements that the importer does not read, so that nothing is lost in silence.
//!
//! What concerns only Gazebo's window, its solver's effort or its topics is not reported.

use std::collections::BTreeMap;

use tatu_importers_robots::Element;

/// Elements whose content is read elsewhere as a whole, or has no meaning here.
const WHOLE: [&str; 23] = [
    "plugin",
    "gui",
    "scene",
    "physics",
    "state",
    "magnetic_field",
    "audio",
    "geometry",
    "material",
    "meta",
    "camera",
    "ray",
    "lidar",
    "imu",
    "gps",
    "navsat",
    "magnetometer",
    "air_pressure",
    "spot",
    "attenuation",
    "spherical_coordinates",
    "dynamics",
    "inertia",
];

/// The elements that are read, or that need no counterpart, by the element around them.
const READ: [(&str, &str); 17] = [
    ("sdf", "model world light"),
    ("gazebo", "model world light"),
    (
        "world",
        "model light frame joint gravity physics scene gui plugin magnetic_field spherical_coordinates state audio",
    ),
    ("model", "link joint model frame pose static self_collide plugin allow_auto_disable enable_wind gripper"),
    (
        "link",
        "pose inertial visual collision sensor light gravity kinematic self_collide enable_wind must_be_base_link \
         velocity_decay",
    ),
    ("inertial", "mass pose inertia density"),
    ("visual", "pose geometry material transparency cast_shadows laser_retro plugin meta visibility_flags lighting"),
    ("collision", "pose geometry surface laser_retro max_contacts density"),
    ("surface", "friction bounce contact"),
    ("friction", "ode"),
    ("ode", "mu mu2 fdir1"),
    ("bounce", "restitution_coefficient"),
    (
        "joint",
        "pose parent child axis axis2 thread_pitch screw_thread_pitch physics sensor gearbox_ratio \
         gearbox_reference_body",
    ),
    ("axis", "xyz limit dynamics mimic use_parent_model_frame"),
    ("axis2", "xyz limit dynamics mimic use_parent_model_frame"),
    ("limit", "lower upper effort velocity"),
    ("light", "pose diffuse specular direction spot attenuation cast_shadows intensity light_on visualize range"),
];

/// Elements that change the motion but have no counterpart, with what is said of them.
const TOLD: [(&str, &str, &str); 7] = [
    ("world", "state", "the state of the world is left out: models are where the file places them"),
    ("link", "self_collide", "models decide whether their links collide with each other, not links"),
    ("model", "enable_wind", "there is no wind"),
    ("link", "enable_wind", "there is no wind"),
    ("link", "velocity_decay", "bodies lose no speed by themselves"),
    ("surface", "contact", "the stiffness of contacts is that of the scene"),
    ("model", "gripper", "objects are not attached to grippers"),
];

/// Counts what is not read.
#[derive(Default)]
pub struct Coverage {
    unread: BTreeMap<String, usize>,
    told: BTreeMap<&'static str, usize>,
}

impl Coverage {
    /// Adds what is not read in an element and those in it.
    pub fn add(&mut self, element: &Element) {
        let around = element.name.as_str();
        let Some((_, read)) = READ.iter().find(|(name, _)| *name == around) else { return };
        for child in &element.children {
            let name = child.name.as_str();
            let told = TOLD.iter().find(|(outer, inner, _)| *outer == around && *inner == name);
            if let Some((.., text)) = told.filter(|_| is_set(child)) {
                *self.told.entry(text).or_default() += 1;
            }
            if !read.split_whitespace().any(|known| known == name) {
                *self.unread.entry(format!("<{name}> in <{around}>")).or_default() += 1;
            } else if !WHOLE.contains(&name) {
                self.add(child);
            }
        }
    }

    /// Returns the sentences about what was found.
    pub fn sentences(&self) -> Vec<String> {
        let told = self.told.iter().map(|(text, count)| format!("{text} ({count} elements of the file)"));
        let list: Vec<String> = self.unread.iter().map(|(name, count)| format!("{count} x {name}")).collect();
        let unread = (!list.is_empty()).then(|| format!("elements that are not read: {}", list.join(", ")));
        told.chain(unread).collect()
    }
}

/// Returns whether an element states anything but "no".
fn is_set(element: &Element) -> bool {
    let text = element.text.trim();
    !element.children.is_empty() || !(text.is_empty() || matches!(text, "false" | "0"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xml::parse;

    #[test]
    fn elements_without_a_reader_are_counted() {
        let text = "<sdf><model><link><battery/><battery/><enable_wind>1</enable_wind><visual><geometry><x/></geometry>\
                    </visual></link><enable_wind>false</enable_wind><road/></model></sdf>";
        let mut coverage = Coverage::default();
        coverage.add(&parse(text, 0).unwrap());
        let wanted = [
            "there is no wind (1 elements of the file)",
            "elements that are not read: 2 x <battery> in <link>, 1 x <road> in <model>",
        ];
        assert_eq!(coverage.sentences(), wanted);
    }
}
