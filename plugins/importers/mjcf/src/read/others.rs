//! Reads options, sensors and keyframes.

use tatu_plugin_api::safe::Result;

use super::{Reader, Source};
use crate::{
    attributes::Attributes,
    model::{Keyframe, Sensor},
};

impl Reader<'_, '_> {
    pub(super) fn options(&mut self, source: &Source) -> Result {
        for element in source.root.named("option") {
            let a = Attributes::new(element, None);
            if a.has("timestep") {
                self.model.timestep = Some(a.positive("timestep", 0.002)?);
            }
            self.model.gravity = a.array("gravity")?.or(self.model.gravity);
            for flag in element.named("flag") {
                if flag.attribute("gravity") == Some("disable") {
                    self.model.gravity = Some([0.0; 3]);
                }
                if flag.attribute("contact") == Some("disable") {
                    self.report
                        .warn(&flag.place, "contacts cannot be switched off: set `respondable = false` on shapes");
                }
            }
            for name in ["density", "viscosity"] {
                if a.number(name, 0.0)? != 0.0 {
                    self.report.warn(&element.place, "the fluid that `density` and `viscosity` describe is omitted");
                }
            }
        }
        Ok(())
    }

    pub(super) fn sensors(&mut self, source: &Source) -> Result {
        for element in source.root.section("sensor") {
            self.count_part(element)?;
            self.model.sensors.push(Sensor {
                kind: element.name.clone(),
                name: element.attribute("name").map(|n| source.named(n)).unwrap_or_default(),
                site: element.attribute("site").map(|n| source.named(n)).unwrap_or_default(),
                place: element.place.clone(),
            });
        }
        Ok(())
    }

    pub(super) fn keyframes(&mut self, source: &Source) -> Result {
        if source.depth > 0 {
            return Ok(());
        }
        for element in source.root.section("keyframe") {
            let a = Attributes::new(element, None);
            self.model.keyframes.push(Keyframe {
                name: element.attribute("name").unwrap_or_default().to_owned(),
                positions: a.numbers("qpos")?,
                controls: a.numbers("ctrl")?,
                place: element.place.clone(),
            });
        }
        Ok(())
    }
}
