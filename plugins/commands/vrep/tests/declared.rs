//! Checks the declarations of the plugin through its C interface, as a host reads them; no host is needed.

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use tatu_plugin_api::abi::*;

/// A declared command.
struct DeclaredCommand {
    names: Vec<String>,
    text: String,
    example: String,
    status: u32,
    notes: String,
}

unsafe extern "C" fn no_service(_: *const tatu_host, _: *const c_char) -> *const c_void {
    null()
}

unsafe fn text(p: *const c_char) -> String {
    assert!(!p.is_null());
    // SAFETY: `p` is a string of the plugin's table and not null (checked above). The header guarantees that such
    // strings are NUL-terminated and live until `shutdown`.
    unsafe { CStr::from_ptr(p) }.to_str().unwrap().to_owned()
}

unsafe fn list<T>(p: *const *const T) -> Vec<*const T> {
    // SAFETY: `p` is a list of the plugin's table, which the header guarantees to end with a null pointer; reading
    // stops there.
    (0..).map(|i| unsafe { *p.add(i) }).take_while(|t| !t.is_null()).collect()
}

fn declared() -> (Vec<DeclaredCommand>, Vec<String>) {
    let host = tatu_host {
        size: size_of::<tatu_host>() as u32,
        abi_minor: 0,
        ctx: null_mut(),
        service: Some(no_service),
        assets: std::ptr::null(),
    };
    let plugin = &tatu_commands_vrep::tatu_plugin.0;
    let mut me = null_mut();
    // SAFETY: the calls follow the order that the header requires: `init`, `extension`, reads, `shutdown`; `host` and
    // `me` outlive them all, and nothing read is used after `shutdown`.
    unsafe {
        assert_eq!(plugin.init.unwrap()(&host, &mut me, null_mut()), TATU_OK);
        let ext = plugin.extension.unwrap()(me, TATU_COMMAND.as_ptr()).cast::<tatu_ext_command>();
        let commands = list((*ext).commands)
            .into_iter()
            .map(|c| DeclaredCommand {
                names: list((*c).names).into_iter().map(|n| text((*n).name)).collect(),
                text: text((*c).text),
                example: text((*c).example),
                status: (*c).status,
                notes: if (*c).notes.is_null() { String::new() } else { text((*c).notes) },
            })
            .collect();
        let constants = list((*ext).constants).into_iter().map(|c| text((*c).name)).collect();
        plugin.shutdown.unwrap()(me);
        (commands, constants)
    }
}

#[test]
fn names_are_unique() {
    let (commands, constants) = declared();
    let mut seen = BTreeSet::new();
    for name in commands.iter().flat_map(|c| &c.names).chain(&constants) {
        assert!(seen.insert(name), "{name} is declared twice");
    }
}

#[test]
fn every_command_has_a_description_and_example() {
    for c in declared().0 {
        let name = &c.names[0];
        assert!(c.text.ends_with('.'), "{name}: the description is not a sentence: {}", c.text);
        let stub = c.status == TATU_COMMAND_STUB;
        assert!(stub || c.example.contains(name.as_str()), "{name}: {}", c.example);
        assert!(!stub || !c.notes.is_empty(), "{name}: a stub must state why it has no effect");
    }
}

/// Checks that old names follow the rule `simAbc` -> `sim.abc`, except for the listed ones, and for names with endings
/// such as `Param`, which V-REP has abbreviated.
#[test]
fn old_names_follow_the_rule() {
    let irregular = BTreeMap::from([
        ("simJointGetForce", "sim.getJointForce"),
        ("simTransformVector", "sim.multiplyVector"),
        ("simHandleChildScript", "sim.handleChildScripts"),
        ("simIsScriptRunningInThread", "sim.isScriptExecutionThreaded"),
        ("simGetObjectUniqueIdentifier", "sim.getObjectUid"),
        ("simGetSystemTimeInMilliseconds", "sim.getSystemTimeInMs"),
        ("simRMLPos", "sim.rmlPos"),
        ("simRMLVel", "sim.rmlVel"),
        ("simRMLStep", "sim.ruckigStep"),
        ("simRMLRemove", "sim.ruckigRemove"),
        ("simRMLMoveToJointPositions", "sim.rmlMoveToJointPositions"),
        ("simRMLMoveToPosition", "sim.rmlMoveToPosition"),
        ("simGetCollisionhandle", "sim.getCollisionHandle"),
        ("simGetDistancehandle", "sim.getDistanceHandle"),
        ("simGetIkGrouphandle", "sim.getIkGroupHandle"),
        ("simGetMechanismhandle", "sim.getMechanismHandle"),
    ]);
    // Modules of plugins follow a different rule.
    for c in declared().0.into_iter().filter(|c| c.names[0].starts_with("sim.")) {
        let new = &c.names[0];
        for old in c.names.iter().filter(|n| !n.contains('.')) {
            let rest = old.strip_prefix("sim").unwrap();
            let regular = format!("sim.{}{}", rest[..1].to_lowercase(), &rest[1..]);
            let known = *new == regular
                || irregular.get(old.as_str()) == Some(&new.as_str())
                || ["Signal", "Param", "Table", "32"]
                    .iter()
                    .any(|end| new.ends_with(end) || new.ends_with(&format!("{end}eter")));
            assert!(known, "{old} -> {new}");
        }
    }
}

/// Checks that the functions called by scripts of the 2015 course exist.
#[test]
fn functions_of_the_course_exist() {
    let (commands, constants) = declared();
    let names: BTreeSet<_> = commands.iter().flat_map(|c| c.names.iter()).chain(&constants).collect();
    for wanted in [
        "simGetObjectHandle",
        "simReadProximitySensor",
        "simHandleProximitySensor",
        "simSetJointTargetVelocity",
        "simSetJointTargetPosition",
        "simSetJointPosition",
        "simSetJointForce",
        "simAddStatusbarMessage",
        "simAuxiliaryConsoleOpen",
        "simAuxiliaryConsoleShow",
        "simAuxiliaryConsolePrint",
        "simGetSimulatorMessage",
        "simSetFloatSignal",
        "simGetFloatSignal",
        "simTubeOpen",
        "simTubeWrite",
        "simPackFloats",
        "simGetObjectAssociatedWithScript",
        "simGetObjectName",
        "simGetObjectPosition",
        "simGetObjectOrientation",
        "sim_childscriptcall_initialization",
        "sim_childscriptcall_actuation",
        "sim_childscriptcall_sensing",
        "sim_childscriptcall_cleanup",
        "sim_handle_self",
        "sim_message_keypress",
    ] {
        assert!(names.iter().any(|n| *n == wanted), "{wanted}");
    }
}

/// Returns the contents of all Rust files below a folder as one string.
fn sources(folder: &std::path::Path) -> String {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    entries
        .map(|path| match path.extension() {
            _ if path.is_dir() => sources(&path),
            Some(e) if e == "rs" => std::fs::read_to_string(&path).unwrap(),
            _ => String::new(),
        })
        .collect()
}

/// Checks that a search for `"sim.getJointPosition"` finds its declaration.
#[test]
fn names_occur_literally_in_the_sources() {
    let source = sources(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let commands = declared().0;
    let names = commands.iter().flat_map(|c| &c.names).filter(|name| name.contains('.'));
    let missing: Vec<&String> = names.filter(|name| !source.contains(&format!("\"{name}\""))).collect();
    assert!(missing.is_empty(), "names that do not occur literally in the sources: {missing:?}");
}
