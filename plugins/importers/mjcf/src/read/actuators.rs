//! Reads actuators. All kinds are shortcuts for one general form, and the defaults of all kinds change one record.

use tatu_plugin_api::safe::Result;

use super::{Reader, Source};
use crate::{
    attributes::Attributes,
    defaults::MAIN,
    model::{Actuator, Transmission},
    xml::Element,
};

/// The general form of an actuator.
#[derive(Clone)]
struct GeneralForm {
    gear: [f64; 6],
    gain_is_affine: bool,
    gain: [f64; 10],
    bias_is_affine: bool,
    bias: [f64; 10],
    damping_ratio: Option<f64>,
    /// Kind of dynamics, if there are any.
    dynamics: Option<String>,
    force_range: ([f64; 2], Option<bool>),
    control_range: ([f64; 2], Option<bool>),
    inherit_range: f64,
}

impl Default for GeneralForm {
    fn default() -> Self {
        let mut gain = [0.0; 10];
        gain[0] = 1.0;
        GeneralForm {
            gear: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            gain_is_affine: false,
            gain,
            bias_is_affine: false,
            bias: [0.0; 10],
            damping_ratio: None,
            dynamics: None,
            force_range: ([0.0; 2], None),
            control_range: ([0.0; 2], None),
            inherit_range: 0.0,
        }
    }
}

impl GeneralForm {
    /// Applies the attributes of an element, of a default or of an actuator. Returns false if its kind has no such form.
    fn apply(&mut self, element: &Element) -> Result<bool> {
        let a = Attributes::new(element, None);
        self.gear = a.partial("gear", self.gear)?;
        for (name, limited, to) in [
            ("forcerange", "forcelimited", &mut self.force_range),
            ("ctrlrange", "ctrllimited", &mut self.control_range),
        ] {
            to.0 = a.array(name)?.unwrap_or(to.0);
            if a.has(limited) {
                to.1 = a.switch(limited)?;
            }
        }
        self.inherit_range = a.number("inheritrange", self.inherit_range)?;
        let fixed = |form: &mut GeneralForm, gain: f64, bias: Option<[f64; 3]>| {
            (form.gain_is_affine, form.bias_is_affine) = (false, bias.is_some());
            form.gain[0] = gain;
            form.bias[..3].copy_from_slice(&bias.unwrap_or_default());
        };
        match element.name.as_str() {
            "general" => {
                self.gain = a.partial("gainprm", self.gain)?;
                self.bias = a.partial("biasprm", self.bias)?;
                match a.text("gaintype").as_deref() {
                    None => {}
                    Some("fixed") => self.gain_is_affine = false,
                    Some("affine") => self.gain_is_affine = true,
                    Some(_) => return Ok(false),
                }
                match a.text("biastype").as_deref() {
                    None => {}
                    Some("none") => self.bias_is_affine = false,
                    Some("affine") => self.bias_is_affine = true,
                    Some(_) => return Ok(false),
                }
                match a.text("dyntype").as_deref() {
                    None => {}
                    Some("none") => self.dynamics = None,
                    Some(other) => self.dynamics = Some(other.to_owned()),
                }
            }
            "motor" => {
                fixed(self, 1.0, None);
                self.dynamics = None;
            }
            "position" | "intvelocity" => {
                let kp = a.positive("kp", self.gain[0])?;
                let own = a.numbers("kv")?.and_then(|kv| kv.first().copied());
                let ratio = a.numbers("dampratio")?.and_then(|r| r.first().copied());
                let kept = if self.bias_is_affine { self.bias[2] } else { 0.0 };
                if own.is_some() {
                    self.damping_ratio = None;
                }
                self.damping_ratio = ratio.filter(|r| *r > 0.0).or(self.damping_ratio);
                fixed(self, kp, Some([0.0, -kp, own.map_or(kept, |kv| -kv)]));
                if element.name == "intvelocity" {
                    self.dynamics = Some("integrator".into());
                } else if a.has("timeconst") {
                    self.dynamics =
                        Some("filterexact".into()).filter(|_| a.number("timeconst", 0.0).unwrap_or(0.0) > 0.0);
                }
            }
            "velocity" => {
                let kv = a.positive("kv", self.gain[0])?;
                fixed(self, kv, Some([0.0, 0.0, -kv]));
                self.dynamics = None;
            }
            "damper" => {
                self.gain_is_affine = true;
                self.gain[..3].copy_from_slice(&[0.0, 0.0, -a.positive("kv", 0.0)?]);
                self.bias_is_affine = false;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// Returns a range if it applies: if it is stated to, or without a statement, if it is not 0 0.
fn range((range, limited): ([f64; 2], Option<bool>), auto_limits: bool) -> Option<[f64; 2]> {
    let applies = limited.unwrap_or(auto_limits && range != [0.0, 0.0]);
    (applies && range[0] <= range[1]).then_some(range)
}

impl Reader<'_, '_> {
    pub(super) fn actuators(&mut self, source: &Source) -> Result {
        for element in source.root.section("actuator") {
            self.count_part(element)?;
            let class = source.defaults.class(element.attribute("class").unwrap_or(MAIN), element)?;
            let mut form = GeneralForm::default();
            for default in &class.actuators {
                form.apply(default)?;
            }
            let named = form.apply(element)?;
            let a = Attributes::new(element, None);
            let on = |name: &str| element.attribute(name).map(|n| source.named(n));
            let on = match (on("joint").or_else(|| on("jointinparent")), on("tendon")) {
                (Some(joint), _) => Some(Transmission::Joint(joint)),
                (None, Some(tendon)) => Some(Transmission::Tendon(tendon)),
                _ => None,
            };
            let unsupported = !named || form.gain_is_affine;
            let (on, omitted) = match on {
                Some(on) => (on, unsupported),
                None => (Transmission::Joint(String::new()), true),
            };
            if omitted {
                let what = if unsupported {
                    format!("actuators of the kind <{}>", element.name)
                } else {
                    "actuators at sites and bodies".into()
                };
                self.report.warn(&element.place, format!("{what} are omitted, or their gain depends on the state"));
            } else if let Some(dynamics) = &form.dynamics {
                self.report.warn(
                    &element.place,
                    format!("the dynamics `{dynamics}` of actuators are omitted: controls act at once"),
                );
            }
            let auto = source.compiler.auto_limits;
            self.model.actuators.push(Actuator {
                on,
                gear: form.gear[0],
                gain: if omitted { 0.0 } else { form.gain[0] },
                bias: if form.bias_is_affine && !omitted {
                    [form.bias[0], form.bias[1], form.bias[2]]
                } else {
                    [0.0; 3]
                },
                damping_ratio: form.damping_ratio.filter(|_| form.bias_is_affine && !omitted),
                force_range: range(form.force_range, auto),
                control_range: range(form.control_range, auto),
                place: a.element.place.clone(),
            });
        }
        Ok(())
    }
}
