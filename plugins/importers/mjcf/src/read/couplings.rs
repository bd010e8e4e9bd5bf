//! Reads fixed tendons, equality constraints and contact pairs.

use nalgebra::{Isometry3, Translation3, Vector3};
use tatu_plugin_api::safe::Result;

use super::{Reader, Source};
use crate::{
    attributes::Attributes,
    compiler::quaternion,
    defaults::MAIN,
    model::{Equality, Tendon},
};

impl Reader<'_, '_> {
    pub(super) fn tendons(&mut self, source: &Source) -> Result {
        for element in source.root.section("tendon") {
            self.count_part(element)?;
            if element.name != "fixed" {
                self.report.warn(&element.place, "spatial tendons are omitted");
                continue;
            }
            let a = source.defaults.attributes(element, "tendon", MAIN)?;
            for name in ["stiffness", "damping", "frictionloss", "armature"] {
                if a.number(name, 0.0)? != 0.0 {
                    self.report.warn(&element.place, format!("`{name}` of tendons is omitted"));
                }
            }
            if a.switch("limited")?.unwrap_or(source.compiler.auto_limits && a.has("range")) {
                self.report.warn(&element.place, "`range` of tendons is omitted");
            }
            let mut joints = Vec::new();
            for part in element.named("joint") {
                self.count_part(part)?;
                let a = Attributes::new(part, None);
                let joint = part.attribute("joint").ok_or_else(|| part.fail("<joint> of a tendon has no `joint`"))?;
                joints.push((source.named(joint), a.number("coef", 1.0)?));
            }
            let name = source.named(element.attribute("name").unwrap_or_default());
            self.model.tendons.push(Tendon { name, joints });
        }
        Ok(())
    }

    pub(super) fn equalities(&mut self, source: &Source) -> Result {
        for element in source.root.section("equality") {
            self.count_part(element)?;
            let a = source.defaults.attributes(element, "equality", MAIN)?;
            let place = element.place.clone();
            if a.switch("active")? == Some(false) {
                self.report.note(&place, "equality constraints that are not active are omitted");
                continue;
            }
            let name = |key: &str| element.attribute(key).map(|n| source.named(n));
            let needed =
                |key: &str| name(key).ok_or_else(|| element.fail(format!("<{}> has no `{key}`", element.name)));
            let polynomial = a.partial("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0]);
            let equality = match element.name.as_str() {
                "joint" => Equality::Joints {
                    first: needed("joint1")?,
                    second: name("joint2"),
                    polynomial: polynomial?,
                    place,
                },
                "tendon" => Equality::Tendons {
                    first: needed("tendon1")?,
                    second: name("tendon2"),
                    polynomial: polynomial?,
                    place,
                },
                "connect" | "weld" if element.attribute("site1").is_some() => Equality::Sites {
                    sites: [needed("site1")?, needed("site2")?],
                    rigid: element.name == "weld",
                    place,
                },
                "connect" => Equality::Connect {
                    bodies: [needed("body1")?, name("body2").unwrap_or_else(|| "world".into())],
                    anchor: Vector3::from(a.array::<3>("anchor")?.unwrap_or_default()),
                    place,
                },
                "weld" => {
                    // A quaternion of 0 stands for the pose of the file.
                    let relative = a.array::<7>("relpose")?.and_then(|[x, y, z, q @ ..]| {
                        Some(Isometry3::from_parts(Translation3::new(x, y, z), quaternion(q)?))
                    });
                    Equality::Weld {
                        bodies: [needed("body1")?, name("body2").unwrap_or_else(|| "world".into())],
                        relative,
                        place,
                    }
                }
                other => {
                    self.report.warn(&place, format!("equality constraints of the kind <{other}> are omitted"));
                    continue;
                }
            };
            self.model.equalities.push(equality);
        }
        Ok(())
    }

    pub(super) fn contacts(&mut self, source: &Source) -> Result {
        for element in source.root.section("contact").filter(|e| e.name == "exclude") {
            let body = |key: &str| source.named(element.attribute(key).unwrap_or_default());
            self.model.exclusions.push(["body1", "body2"].map(body));
        }
        for element in source.root.section("contact").filter(|e| e.name == "pair") {
            for key in ["geom1", "geom2"] {
                if let Some(name) = element.attribute(key) {
                    self.model.paired_geoms.insert(source.named(name));
                }
            }
            self.report.note(
                &element.place,
                "contact pairs have no properties of their own here: their geoms collide with the shapes of other \
                 mechanisms, with their own friction",
            );
        }
        Ok(())
    }
}
