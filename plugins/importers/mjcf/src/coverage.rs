//! Reports elements and attributes that the importer does not read, so that nothing is lost in silence.
//!
//! What concerns only MuJoCo's viewer, its memory or its solver's effort is not reported.

use crate::{defaults::ACTUATORS, report::ImportReport, xml::Element};

/// Sections without a meaning here: looks of MuJoCo's viewer, memory, and data of users.
const SILENT_SECTIONS: [&str; 6] = ["visual", "statistic", "size", "custom", "compiler", "include"];

/// Attributes that any element may have without a report: names, which are read elsewhere, and data of users.
const SILENT: [&str; 4] = ["name", "class", "user", "childclass"];

/// Attributes of the softness of constraints, which Tatu chooses itself.
const SOFTNESS: [&str; 10] = [
    "solref",
    "solimp",
    "solmix",
    "margin",
    "gap",
    "priority",
    "solreflimit",
    "solimplimit",
    "solreffriction",
    "solimpfriction",
];

/// Attributes of options that concern the solver.
const SOLVER: [&str; 21] = [
    "integrator",
    "cone",
    "impratio",
    "iterations",
    "ls_iterations",
    "noslip_iterations",
    "ccd_iterations",
    "sdf_iterations",
    "sdf_initpoints",
    "tolerance",
    "ls_tolerance",
    "noslip_tolerance",
    "ccd_tolerance",
    "solver",
    "jacobian",
    "apirate",
    "mpr_iterations",
    "mpr_tolerance",
    "o_margin",
    "o_solref",
    "o_solimp",
];

/// Attributes that change only how things look.
const LOOKS: [&str; 27] = [
    "specular",
    "shininess",
    "emission",
    "reflectance",
    "metallic",
    "roughness",
    "ambient",
    "attenuation",
    "castshadow",
    "active",
    "exponent",
    "bulbradius",
    "intensity",
    "width",
    "sites",
    "ipd",
    "resolution",
    "rgba",
    "material",
    "group",
    "target",
    "texdir",
    "mode",
    "principal",
    "principalpixel",
    "focalpixel",
    "mark",
];

/// Reports what is not read in a file.
pub fn report(root: &Element, report: &mut ImportReport) {
    for section in &root.children {
        match section.name.as_str() {
            name if SILENT_SECTIONS.contains(&name) => {}
            "option" => options(section, report),
            "worldbody" => section.children.iter().for_each(|e| body_part(e, report)),
            "default" => default(section, report),
            "asset" | "actuator" | "tendon" | "equality" | "contact" | "sensor" | "keyframe" => {
                for element in &section.children {
                    attributes(element, known(&section.name, &element.name), report);
                }
            }
            name => report.warn(&section.place, format!("<{name}> is omitted")),
        }
    }
}

fn options(section: &Element, report: &mut ImportReport) {
    for (name, _) in &section.attributes {
        match name.as_str() {
            "timestep" | "gravity" | "density" | "viscosity" | "actuatorgroupdisable" => {}
            name if SOLVER.contains(&name) => {
                report.note(&section.place, "options of MuJoCo's solver are omitted, such as `integrator` and `cone`")
            }
            name => report.warn(&section.place, format!("the option `{name}` is omitted")),
        }
    }
}

fn body_part(element: &Element, report: &mut ImportReport) {
    attributes(element, known("worldbody", &element.name), report);
    if matches!(element.name.as_str(), "body" | "frame" | "replicate") {
        element.children.iter().for_each(|e| body_part(e, report));
    }
}

fn default(section: &Element, report: &mut ImportReport) {
    for element in &section.children {
        match element.name.as_str() {
            "default" => default(element, report),
            name if ACTUATORS.contains(&name) => attributes(element, known("actuator", name), report),
            name @ ("mesh" | "material") => attributes(element, known("asset", name), report),
            "tendon" => attributes(element, known("tendon", "fixed"), report),
            "equality" | "pair" => attributes(element, Some(&[]), report),
            name => attributes(element, known("worldbody", name), report),
        }
    }
}

fn attributes(element: &Element, known: Option<&[&str]>, report: &mut ImportReport) {
    let tag = &element.name;
    let Some(known) = known else { return report.warn(&element.place, format!("<{tag}> is omitted")) };
    for (name, _) in &element.attributes {
        match name.as_str() {
            name if SILENT.contains(&name) || known.contains(&name) || is_any(known) => {}
            name if SOFTNESS.contains(&name) => report.note(
                &element.place,
                "the softness of contacts and limits (`solref`, `solimp`, `margin` and others) is omitted: see \
                 `contact_spring`",
            ),
            name if LOOKS.contains(&name) => {
                report.note(&element.place, "some attributes that concern only looks are omitted")
            }
            name => report.warn(&element.place, format!("`{name}` of <{tag}> is omitted")),
        }
    }
}

/// Returns the attributes of an element that are read, or that another message covers; `None` if the element is not
/// read.
fn known(section: &str, element: &str) -> Option<&'static [&'static str]> {
    const ACTUATOR: &[&str] = &[
        "joint",
        "jointinparent",
        "tendon",
        "site",
        "body",
        "refsite",
        "cranksite",
        "slidersite",
        "gear",
        "ctrlrange",
        "ctrllimited",
        "forcerange",
        "forcelimited",
        "inheritrange",
        "kp",
        "kv",
        "dampratio",
        "timeconst",
        "gainprm",
        "gaintype",
        "biasprm",
        "biastype",
        "dyntype",
        "dynprm",
        "actrange",
        "actlimited",
        "actdim",
        "actearly",
        "group",
    ];
    Some(match (section, element) {
        ("worldbody", "body") => &["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "mocap"],
        ("worldbody", "frame") => &["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"],
        ("worldbody", "replicate") => &["count", "offset", "euler", "sep"],
        ("worldbody", "attach") => &["model", "body", "prefix"],
        ("worldbody", "inertial") => {
            &["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "mass", "diaginertia", "fullinertia"]
        }
        ("worldbody", "freejoint") => &["group", "align"],
        ("worldbody", "joint") => &[
            "type",
            "pos",
            "axis",
            "range",
            "limited",
            "ref",
            "springref",
            "stiffness",
            "damping",
            "armature",
            "frictionloss",
            "springdamper",
            "group",
            "actuatorfrcrange",
            "actuatorfrclimited",
        ],
        ("worldbody", "geom") => &[
            "type",
            "pos",
            "quat",
            "axisangle",
            "euler",
            "xyaxes",
            "zaxis",
            "fromto",
            "size",
            "mesh",
            "hfield",
            "contype",
            "conaffinity",
            "condim",
            "group",
            "friction",
            "mass",
            "density",
            "rgba",
            "material",
            "shellinertia",
            "fitscale",
        ],
        ("worldbody", "site") => &[
            "type",
            "pos",
            "quat",
            "axisangle",
            "euler",
            "xyaxes",
            "zaxis",
            "fromto",
            "size",
            "rgba",
            "material",
            "group",
        ],
        ("worldbody", "camera") => {
            &["pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "fovy", "sensorsize", "focal", "mode"]
        }
        ("worldbody", "light") => &["pos", "dir", "directional", "type", "diffuse", "cutoff"],
        // Reported where they are read.
        ("worldbody", "composite" | "flexcomp" | "flex") => ANY,
        ("asset", "mesh") => &[
            "file",
            "scale",
            "refpos",
            "refquat",
            "inertia",
            "vertex",
            "face",
            "normal",
            "texcoord",
            "smoothnormal",
            "maxhullvert",
            "content_type",
        ],
        ("asset", "hfield") => &["file", "size", "nrow", "ncol", "elevation", "content_type"],
        ("asset", "material") => &["rgba", "texture", "texrepeat", "texuniform"],
        ("asset", "texture") => ANY,
        ("asset", "model") => &["file", "content_type"],
        ("actuator", kind) if ACTUATORS.contains(&kind) => ACTUATOR,
        ("tendon", "fixed") => {
            &["stiffness", "damping", "frictionloss", "armature", "limited", "range", "springlength", "rgba", "width"]
        }
        ("tendon", "spatial") => ANY,
        ("equality", _) => ANY,
        ("contact", "pair" | "exclude") => ANY,
        ("sensor", _) => ANY,
        ("keyframe", "key") => ANY,
        _ => return None,
    })
}

/// Stands for all attributes; see [`is_any`].
const ANY: &[&str] = &["*"];

/// Returns whether all attributes of an element are covered by other messages.
fn is_any(known: &[&str]) -> bool {
    known == ANY
}
