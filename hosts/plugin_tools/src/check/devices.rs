//! Tests of sensors, actuators and parts: results are finite, do not depend on the number of threads, and follow changes of
//! parameters.

use std::{
    hash::{DefaultHasher, Hasher},
    path::Path,
};

use tatu_core::{
    Reading, World,
    errors::Error,
    plugins::{ActuatorKind, ParameterSpec, SensorKind},
};
use tatu_plugin_api::{abi::*, safe::Value};

use super::{
    finding::{self, error, untested},
    judge::{judge, numbers_of},
    stage,
    subject::TestedPlugin,
};

/// Number of steps of a run.
const RUN_STEPS: usize = 12;
/// Total number of elements in readings after which a run ends early.
const MAX_ELEMENTS: u32 = 1_000_000;
/// Number of free bodies that carry one actuator each.
const BODY_COUNT: u32 = 7;
/// Maximum number of values tried per parameter.
const MAX_VALUES: usize = 4;

/// Returns the table of a device in a scene file, with lines for its placement and its parameters.
pub fn device(kind: &str, id: &str, alias: &str, place: &str, lines: &str) -> String {
    format!("\n[[object]]\nkind = \"{kind}\"\n{kind} = \"{id}\"\nalias = \"{alias}\"\n{place}{lines}")
}

/// Runs the test `readings`.
pub fn readings(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for s in subject.own_sensors() {
        let place = format!("sensor `{}`", s.id);
        let Some(lines) = stage::sensor_lines(s) else {
            untested(&place, "it is not tested: a required parameter cannot be set in a scene");
            continue;
        };
        let presets = s.presets.iter().map(|p| format!("preset = \"{}\"\n", p.id));
        for preset in std::iter::once(String::new()).chain(presets) {
            let with = if preset.is_empty() { "" } else { " with a preset" };
            finding::report_activity(&place, format!("when it measures{with}"));
            let lines = format!("{lines}{preset}");
            let scene = sensor_scene(s, |_| lines.clone());
            let one = measured(&subject, s, &scene, 1)?;
            compare(&place, &one, &measured(&subject, s, &scene, 2)?, "readings on 2 threads differ from those on 1");
            let again = "two equal runs give different readings: use the random numbers and the time of the batch";
            compare(&place, &one, &measured(&subject, s, &scene, 1)?, again);
        }
    }
    Ok(())
}

/// Returns a scene with a sensor at each place; `lines` returns the parameters of each.
pub fn sensor_scene(s: &SensorKind, lines: impl Fn(usize) -> String) -> String {
    let all = stage::SENSOR_PLACES.iter().enumerate();
    let devices: String = all.map(|(i, at)| device("sensor", &s.id, &format!("s{i}"), at, &lines(i))).collect();
    stage::scene(&devices, "")
}

/// Runs a scene; returns a line with a hash for each reading of each step.
pub fn measured(subject: &TestedPlugin, kind: &SensorKind, scene: &str, threads: usize) -> Result<Vec<String>, Error> {
    let world = subject.world(scene, &[], threads)?;
    world.start();
    let mut out = Vec::new();
    let mut elements = 0;
    for _ in 0..RUN_STEPS {
        world.step();
        for i in 0..stage::SENSOR_PLACES.len() {
            let Some(reading) = world.reading(&format!("s{i}#0")).or_else(|| world.reading(&path(&world, i))) else {
                continue;
            };
            judge(kind, &reading.fields.iter().map(|f| numbers_of(&f.value)).collect::<Vec<_>>());
            elements += reading.fields.iter().map(|f| f.dims.iter().product::<u32>()).sum::<u32>();
            out.push(format!("{}: {:016x}", reading.path, bits(&reading)));
        }
        // A few images suffice, and hashing many of them would take a long time.
        if elements > MAX_ELEMENTS {
            break;
        }
    }
    subject.report_faults(&world);
    Ok(out)
}

/// Returns a hash of all bits of a reading.
pub fn bits(reading: &Reading) -> u64 {
    let mut hasher = DefaultHasher::new();
    for f in &reading.fields {
        match &f.value {
            Value::Floats(all) => all.iter().for_each(|x| hasher.write_u64(x.to_bits())),
            other => hasher.write(format!("{other:?}").as_bytes()),
        }
    }
    hasher.finish()
}

/// Returns the path of the sensor with index `i`, which may be attached to a body or be at the top level.
pub fn path(world: &World, i: usize) -> String {
    let end = format!("/s{i}");
    world.sensors().into_iter().find(|p| p.ends_with(&end)).unwrap_or(end)
}

/// Reports the first line in which two transcripts differ.
pub fn compare(place: &str, one: &[String], other: &[String], what: &str) {
    if let Some((a, _)) = one.iter().zip(other).find(|(a, b)| a != b) {
        let whose = a.split(':').next().unwrap_or_default();
        error(place, format!("{what} ({whose})"));
    }
}

/// Runs the test `actuators`.
pub fn actuators(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for a in subject.own_actuators() {
        let place = actuator_place(a);
        let Some(lines) = actuator_lines(a) else {
            untested(&place, "it is not tested: a required parameter cannot be set in a scene");
            continue;
        };
        finding::report_activity(&place, "when it acts");
        let scene = actuator_scene(a, &lines);
        let one = acted(&subject, &scene, 1)?;
        compare(&place, &one, &acted(&subject, &scene, 2)?, "its effect on 2 threads differs from that on 1");
        compare(&place, &one, &acted(&subject, &scene, 1)?, "two equal runs have different results");
    }
    Ok(())
}

/// Returns the kind of object that an actuator is: a part is declared as one.
pub fn actuator_word(a: &ActuatorKind) -> &'static str {
    if a.part.is_some() { "part" } else { "actuator" }
}

/// Returns how findings name an actuator or a part.
pub fn actuator_place(a: &ActuatorKind) -> String {
    format!("{} `{}`", actuator_word(a), a.id)
}

pub fn actuator_lines(a: &ActuatorKind) -> Option<String> {
    let commands = a.commands.iter().filter_map(|c| {
        stage::valid_values(c).into_iter().nth(1).or(Some(Value::Float(1.0))).and_then(|v| stage::line(c, &v))
    });
    Some(stage::required(&a.params)? + &commands.collect::<String>() + stage::targets(a.raw.inputs))
}

/// Returns a scene that contains several bodies with one actuator or part each, and another one on a jointed body.
pub fn actuator_scene(a: &ActuatorKind, lines: &str) -> String {
    let (kind, id) = (actuator_word(a), a.id.as_str());
    let mut devices = String::new();
    for i in 0..BODY_COUNT {
        let at = [0.15 * f64::from(i) - 0.5, -0.8, 0.6];
        devices += &format!(
            "\n[[object]]\nkind = \"shape\"\nalias = \"b{i}\"\nsize_m = [0.1, 0.1, 0.1]\nposition_m = {at:?}\ndynamic = true\nrespondable = true\nmass_kg = 1.0\n"
        );
        devices += &device(kind, id, &format!("a{i}"), &format!("parent = \"/b{i}\"\n"), lines);
    }
    devices += &device(kind, id, "a_hinge", "parent = \"/hinge/lever\"\n", lines);
    stage::scene(&devices, "")
}

pub fn acted(subject: &TestedPlugin, scene: &str, threads: usize) -> Result<Vec<String>, Error> {
    let world = subject.world(scene, &[], threads)?;
    world.start();
    let mut out = Vec::new();
    for _ in 0..RUN_STEPS {
        world.step();
        out.extend(
            (0..BODY_COUNT)
                .map(|i| format!("/b{i}: {:?}", world.observe(&format!("/b{i}")).map(|o| (o.pose, o.twist)))),
        );
    }
    subject.report_faults(&world);
    Ok(out)
}

/// Runs the test `configure` for each sensor parameter that can be changed during a run.
pub fn configure(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    let live = |p: &&ParameterSpec| p.flags & (TATU_PARAM_REBUILDS | TATU_PARAM_READ_ONLY) == 0;
    for s in subject.own_sensors() {
        let place = format!("sensor `{}`", s.id);
        let Some(lines) = stage::sensor_lines(s) else { continue };
        for p in s.params.iter().filter(live) {
            let without: String =
                lines.lines().filter(|l| !l.starts_with(p.key.as_str())).map(|l| format!("{l}\n")).collect();
            for value in stage::valid_values(p).into_iter().skip(1).take(MAX_VALUES) {
                let Some(line) = stage::line(p, &value) else { continue };
                finding::report_activity(&place, format!("when `{}` is changed", p.key));
                let with = |lines: &str| {
                    let all = stage::SENSOR_PLACES.iter().enumerate();
                    all.map(|(i, at)| device("sensor", &s.id, &format!("s{i}"), at, lines)).collect::<String>()
                };
                let set = set_script(&s.id, p, &value);
                let from_start = configured(&subject, &stage::scene(&with(&format!("{without}{line}")), ""), "");
                let changed = configured(&subject, &stage::scene(&with(&lines), &set), &set);
                let (Ok((from_start, _)), Ok((changed, accepted))) = (from_start, changed) else { continue };
                if accepted && from_start != changed {
                    let text = format!(
                        "`configure` accepts a change of `{}`, but then its readings differ from those of a sensor created \
                         with that value",
                        p.key
                    );
                    error(&place, text);
                    break;
                }
            }
        }
    }
    Ok(())
}

/// Returns the value of a parameter as an expression in Lua.
pub fn lua_value(value: &Value) -> Option<String> {
    Some(match value {
        Value::Text(t) => format!("{:?}", String::from_utf8_lossy(t)),
        Value::Floats(f) => format!("{{{}}}", f.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")),
        Value::Float(x) => format!("{x:?}"),
        Value::Int(i) => i.to_string(),
        Value::Bool(b) => b.to_string(),
        _ => return None,
    })
}

/// Returns a script that sets a parameter of all sensors before the first measurement.
fn set_script(id: &str, p: &ParameterSpec, value: &Value) -> String {
    let value = lua_value(value).unwrap_or_else(|| "nil".into());
    let names = "{'/s0', '/s1', '/s2', '/s3', '/body/s4'}";
    format!(
        "function sysCall_init()\n  for _, name in ipairs({names}) do\n    local ok, why = pcall(tatu.set, sim.getObject(name), '{id}.{}', {value})\n    if not ok then print('@check refused ' .. why) end\n  end\nend\n",
        p.key
    )
}

/// Returns hashes of the readings after some steps, and whether the script's changes were accepted.
fn configured(subject: &TestedPlugin, scene: &str, script: &str) -> Result<(Vec<u64>, bool), Error> {
    let world = subject.world(scene, &[("check.lua", script.as_bytes())], 1)?;
    let refused = !super::commands::play(&world, 4).is_empty();
    let fields = |i: usize| world.reading(&path(&world, i)).map(|r| bits(&r));
    Ok(((0..stage::SENSOR_PLACES.len()).filter_map(fields).collect(), !refused))
}
