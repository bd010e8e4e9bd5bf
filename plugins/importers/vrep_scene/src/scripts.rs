//! Attaches the scripts of a file, in the dialect of their version, to their objects; and converts the custom data of
//! objects.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{
    describe::PRIVATE_PREFIX,
    dynamics::ObjectTree,
    read::{
        data::{CustomData, ScriptParameter},
        file::{FileObject, ObjectKind, VrepFile},
        script::{self, FileScript},
    },
    registrations,
    report::ImportReport,
};

/// First version whose main scripts make the same calls as those of later versions. V-REP itself does not run
/// customized main scripts of earlier versions either.
const MAIN_SCRIPTS_SINCE: u32 = 30_103;
/// Bit of a model's overrides that disables its scripts.
const SCRIPTS_OFF: i32 = 0x200;
/// Script that solves the inverse kinematics groups in each step. `IK_DIALECT` is a version with both this command and
/// callbacks.
const IK_SCRIPT: &str = "function sysCall_actuation()\n    sim.handleIkGroup(sim.handle_all_except_explicit)\nend\n";
const IK_DIALECT: &str = "4.1";
/// Languages whose scripts are run.
const RUN_LANGUAGES: &[&str] = &["lua", "python"];

/// Returns the handle of the object to which a script belongs, or -1 for the scene.
pub fn target(file: &VrepFile, s: &FileScript) -> i32 {
    match s.holder {
        Some(holder) => file.objects.iter().find(|o| o.common.id == holder).map_or(-1, |o| o.common.parent),
        None => s.owner(),
    }
}

/// Attaches all scripts to their objects; reports scripts that are not run.
pub fn attach_scripts(
    builder: &Builder<'_>,
    file: &VrepFile,
    nodes: &BTreeMap<i32, Node<'_>>,
    report: &mut ImportReport,
) -> Result {
    let off = switched_off(file);
    let version = file.header.program;
    let dialect = if version == 0 { String::new() } else { format!("{}.{}", version / 10_000, version / 100 % 100) };
    for s in &file.scripts {
        let target = target(file, s);
        let object = file.objects.iter().find(|o| o.common.id == target);
        let mut left = |what, why: &str| match object {
            Some(o) => report.add(what, why, o),
            None => report.add_count(what, why.to_owned(), 1),
        };
        if s.kind == script::MAIN {
            match s.is_default_main() {
                true => continue,
                false if version < MAIN_SCRIPTS_SINCE => {
                    left(
                        "replaced",
                        "the main script was written for a version before 3.1.3; the default main script runs instead",
                    );
                    continue;
                }
                false => {}
            }
        }
        let kind = match s.kind {
            script::MAIN => "main",
            script::CHILD if s.is_threaded() => "threaded",
            script::CHILD => "child",
            script::CUSTOMIZATION => "customization",
            other => {
                left("without", &format!("a script of the obsolete kind {other} is not run"));
                continue;
            }
        };
        if s.is_off() {
            left("kept", "a disabled script is not run");
            continue;
        }
        if off.contains_key(&target) {
            left("kept", "a script is not run, because the scripts of its model are disabled");
            continue;
        }
        let language = s.language();
        if !RUN_LANGUAGES.contains(&language.as_str()) {
            left(
                "without a script",
                &format!(
                    "the script is written in {language}, but only scripts in Lua and Python are run; its source is \
                     stored with the scene. A remote client can replace it through the service `zmq_remote`: see \
                     docs/guide/remote-clients.md"
                ),
            );
            continue;
        }
        let owner = if s.kind == script::MAIN { nodes.values().next() } else { nodes.get(&target) };
        let Some(node) = owner else {
            left("refused", "a script belongs to an object that is not in the file");
            continue;
        };
        let holder = s.holder.and_then(|h| file.objects.iter().find(|o| o.common.id == h));
        let name = holder.or(object).map_or("main script".to_owned(), |o| o.common.alias());
        node.script(&language, &dialect, kind, &name, s.code().as_bytes())?;
    }
    let has_main = file.scripts.iter().any(|s| s.kind == script::MAIN && !s.is_default_main());
    if registrations::has_implicit_ik_groups(file) && (!has_main || version < MAIN_SCRIPTS_SINCE) {
        // In V-REP, the default main script solves the groups after all other scripts have acted.
        if let Some(node) = nodes.values().next() {
            node.script("lua", IK_DIALECT, "customization", "inverse kinematics", IK_SCRIPT.as_bytes())?;
        }
    }
    scene_data(builder, file)
}

/// Returns the handles of the objects in models whose scripts are disabled.
fn switched_off(file: &VrepFile) -> BTreeMap<i32, ()> {
    let parents: BTreeMap<i32, i32> = file.objects.iter().map(|o| (o.common.id, o.common.parent)).collect();
    let bases: BTreeMap<i32, ()> = file
        .objects
        .iter()
        .filter(|o| o.common.model_base && o.common.flags.model_property & SCRIPTS_OFF != 0)
        .map(|o| (o.common.id, ()))
        .collect();
    let below = |o: &&FileObject| {
        let mut at = o.common.id;
        // There are at most as many steps as objects, because the reader rejects cycles of parents.
        for _ in 0..=parents.len() {
            if bases.contains_key(&at) {
                return true;
            }
            match parents.get(&at) {
                Some(above) => at = *above,
                None => return false,
            }
        }
        false
    };
    if bases.is_empty() { bases } else { file.objects.iter().filter(below).map(|o| (o.common.id, ())).collect() }
}

/// Returns the data to store with an object: custom data, parameters of its script, and properties that only V-REP has,
/// such as the names of the colours of a shape's parts.
pub fn data((file, tree): (&VrepFile, &ObjectTree<'_>), o: &FileObject, meant: bool, color_names: &[String]) -> Value {
    let c = &o.common;
    let mut out = tagged(&c.data);
    let own: Vec<&ScriptParameter> = file
        .scripts
        .iter()
        .filter(|s| !s.parameters.is_empty() && target(file, s) == c.id)
        .flat_map(|s| &s.parameters)
        .chain(&c.parameters)
        .collect();
    out.extend(own.iter().map(|p| (Value::text(format!("parameter.{}", p.name)), Value::text(&p.value))));
    let foreign =
        file.scripts.iter().filter(|s| !RUN_LANGUAGES.contains(&s.language().as_str()) && target(file, s) == c.id);
    out.extend(
        foreign
            .map(|s| (Value::text(format!("{PRIVATE_PREFIX}script {}", s.language())), Value::Bytes(s.text.clone()))),
    );
    if color_names.iter().any(|name| !name.is_empty()) {
        let lines = color_names.iter().map(|name| name.replace('\n', " ")).collect::<Vec<_>>().join("\n");
        out.push((Value::text(format!("{PRIVATE_PREFIX}color names")), Value::text(lines)));
    }
    for (tag, handles) in &c.references {
        // Handles are not known yet. Relative paths also remain valid in a copy of the model.
        let paths = handles.iter().map(|h| tree.path(c.id, *h).unwrap_or_default()).collect::<Vec<_>>().join("\n");
        out.push((Value::text(format!("{PRIVATE_PREFIX}paths {tag}")), Value::text(paths)));
    }
    let mut bits = |name: &str, value: i32| {
        out.push((Value::text(format!("{PRIVATE_PREFIX}{name}")), Value::text(value.to_string())))
    };
    if meant {
        bits("handle", c.id);
    }
    match &o.kind {
        ObjectKind::Proximity(s) if s.entity != -1 => bits("entity", s.entity),
        ObjectKind::Vision(s) if s.entity != -1 => bits("entity", s.entity),
        _ => {}
    }
    if c.flags.model_property != 0 {
        bits("model property", c.flags.model_property);
    }
    if let Some(special) = c.flags.special_property {
        bits("special property", special);
    }
    if c.flags.has_object_property {
        bits("object property", c.flags.object_property);
    }
    if c.size_factor != 1.0 && c.size_factor.is_finite() {
        out.push((Value::text(format!("{PRIVATE_PREFIX}scale")), Value::text(c.size_factor.to_string())));
    }
    Value::Map(out)
}

fn tagged(data: &CustomData) -> Vec<(Value, Value)> {
    let numbered = data.numbered().iter().map(|(n, bytes)| (format!("{PRIVATE_PREFIX}developer {n}"), bytes.clone()));
    let tagged = data.tagged().iter().map(|(tag, bytes)| (tag.clone(), bytes.clone()));
    tagged.chain(numbered).map(|(tag, bytes)| (Value::text(tag), Value::Bytes(bytes))).collect()
}

fn scene_data(builder: &Builder<'_>, file: &VrepFile) -> Result {
    let mut all = tagged(&file.scene_data);
    all.extend(registrations::tags(file));
    if all.is_empty() { Ok(()) } else { builder.setting("scene.data", Value::Map(all)) }
}

/// Returns whether an object only contains a script, which is attached to the parent instead.
pub fn is_holder(o: &FileObject) -> bool {
    matches!(o.kind, ObjectKind::Script)
}
