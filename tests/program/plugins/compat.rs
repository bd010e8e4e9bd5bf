//! Tests of compatibility: plugins that were built with frozen copies of the contract or with a later contract run on
//! this host.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::kit::*;

/// Returns the folders of the frozen copies.
fn revisions() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(root().join("tests/compat"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.join("tatu.h").is_file())
        .collect();
    all.sort();
    assert!(!all.is_empty());
    all
}

fn name(revision: &Path) -> String {
    revision.file_name().unwrap().to_string_lossy().into_owned()
}

/// Compiles a plugin with the headers in the folder `include`.
fn compile(source: &Path, include: &Path, to: &Path) {
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-shared", "-fPIC", "-fvisibility=hidden", "-I"])
            .arg(include)
            .arg("-o")
            .args([to, source]),
    );
}

/// Calls both commands of an old plugin, and measures a wall 0.5 m ahead with its sensor.
fn works(place: &TestFolder, prefix: &str) {
    let script = format!(
        "function sysCall_init()
            assert({prefix}.twice(21) == 42 and {prefix}.twice(0.5) == 1)
            assert({prefix}.count() == 2)
            local ok, why = pcall({prefix}.twice, 'much')
            assert(not ok and tostring(why):find('number'), why)
        end"
    );
    place.write(
        "scene.toml",
        &format!(
            "format = 1\n[scene]\nplugins = [\"mine\"]\n{}[[object]]\nkind = \"sensor\"\nsensor = \"{prefix}_eye\"\nalias = \"eye\"\nrange_m = 1.5\n{}",
            cuboid("wall", [1.0, 1.0, 0.2], [0.0, 0.0, 0.6], ""),
            watcher("caller", &script)
        ),
    );
    let line = &place.trace(&["/eye"], &["--steps", "3"])[2];
    let seen = line.sensor("/eye", &format!("{prefix}.distance"));
    assert!((seen - 0.5).abs() < 1e-12, "{seen}");
    let done = place.run(&["--steps", "1"]).good();
    assert!(!done.err.contains("warning"), "{}", done.err);
}

/// Returns the draft number in the ids of a frozen copy.
fn draft(revision: &Path) -> u32 {
    let header = header_text(revision);
    let id = header.split("#define TATU_COMMAND \"tatu.command/draft.").nth(1).unwrap();
    id.split('"').next().unwrap().parse().unwrap()
}

fn ours() -> u32 {
    draft(&root().join("plugin-api/include"))
}

/// Checks that the plugin works if its draft is that of this host. Otherwise it must be refused with an error that
/// names both drafts, and must not affect anything else.
fn works_or_is_refused(place: &TestFolder, revision: &Path, prefix: &str) {
    if draft(revision) == ours() {
        return works(place, prefix);
    }
    place.write("scene.toml", &format!("format = 1\n[scene]\nplugins = [\"mine\"]\n{}", watcher("d", "")));
    let told = format!("built for draft {} of `tatu.", draft(revision));
    let done = place.run(&["--steps", "1"]).good();
    // A plugin that needs a service is not loaded. Any other plugin is loaded, but its extensions are not used.
    done.reports(&[&told, &format!("this host has draft {}", ours()), "rebuild it"]);
}

#[test]
fn an_older_plugin_in_c_works_or_is_refused_by_its_draft() {
    for revision in revisions() {
        let place = TestFolder::new();
        fs::create_dir(place.path().join("mine")).unwrap();
        compile(&revision.join("plugin.c"), &revision, &place.path().join("mine").join(library("tatu_old")));
        works_or_is_refused(&place, &revision, "oldc");
    }
}

#[test]
fn an_older_plugin_that_needs_no_service_works_or_is_refused_by_its_draft() {
    for revision in revisions() {
        let place = TestFolder::new();
        fs::create_dir(place.path().join("mine")).unwrap();
        let mut text = fs::read_to_string(revision.join("plugin.c")).unwrap();
        let without = [
            (".needs = needs, ", ""),
            (
                "TATU_HAS(scene, find) ? TATU_OK : tatu_fail(error, TATU_ERR, \"this host has no scene\")",
                "(void)scene, (void)error, TATU_OK",
            ),
        ];
        for (from, to) in without {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        place.write("plugin.c", &text);
        let to = place.path().join("mine").join(library("tatu_old"));
        compile(&place.path().join("plugin.c"), &revision, &to);
        works_or_is_refused(&place, &revision, "oldc");
    }
}

#[test]
fn a_plugin_of_this_draft_works() {
    let place = TestFolder::new();
    fs::create_dir(place.path().join("mine")).unwrap();
    let to = place.path().join("mine").join(library("tatu_now"));
    compile(&root().join("tests/compat/plugin.c"), &root().join("plugin-api/include"), &to);
    works(&place, "oldc");
}

#[test]
fn every_frozen_copy_of_this_draft_has_its_record() {
    for revision in revisions().into_iter().filter(|r| draft(r) == ours()) {
        let record = root().join(format!("plugin-api/layout/{}.txt", name(&revision)));
        assert!(record.is_file(), "{} is missing", record.display());
    }
}

#[test]
fn an_unmet_need_is_reported_with_its_size_and_version() {
    let old = fs::read_to_string(root().join("tests/compat/plugin.c")).unwrap();
    for (need, told) in [
        (".bytes = 100000", "it needs 100000 bytes of `tatu.host.scene/draft.4`"),
        (".minor = 99", "it needs minor version 99 of the ABI"),
    ] {
        let place = TestFolder::new();
        let more = format!(".size = sizeof(tatu_need), {need}");
        place.write("mine/plugin.c", &old.replacen(".size = sizeof(tatu_need)", &more, 1));
        let to = place.path().join("mine").join(library("tatu_greedy"));
        compile(&place.path().join("mine/plugin.c"), &root().join("plugin-api/include"), &to);
        place.write("scene.toml", &format!("format = 1\n[scene]\nplugins = [\"mine\"]\n{}", watcher("d", "")));
        place.run(&["--steps", "1"]).good().reports(&["E301", told, "it is older than the plugin"]);
    }
}

/// Writes the headers of a fictitious later release, which adds a field at the end of tables of both sides, an
/// extension, a service, and a type that these use.
fn write_future_headers(to: &Path) {
    let tables = [
        ("tatu_plugin_t", "const char *(TATU_CALL *motto)(void *self);"),
        ("tatu_param", "const char *tooltip;"),
        ("tatu_life", "tatu_status(TATU_CALL *sleep)(void *data, tatu_error *);"),
        ("tatu_name", "const char *since;"),
        ("tatu_command", "tatu_status(TATU_CALL *preview)(tatu_call *);"),
        ("tatu_ext_command", "const char *const *topics;"),
        ("tatu_field", "const char *colour_map;"),
        ("tatu_sensor", "const char *icon;"),
        ("tatu_ext_sensor", "const char *const *groups;"),
        ("tatu_instance", "const char *nickname;"),
        ("tatu_sensor_batch", "const double *temperature;"),
        ("tatu_call_api", "void(TATU_CALL *progress)(tatu_call *, double);"),
        ("tatu_host_scene", "tatu_status(TATU_CALL *teleport)(tatu_world *, tatu_object);"),
    ];
    let host = "  const void *(TATU_CALL *service)(const tatu_host *, const char *id);\n";
    let include = root().join("plugin-api/include");
    let all = header_text(&include);
    for text in tables.iter().map(|(table, _)| format!("}} {table};")).chain([host.to_owned()]) {
        assert_eq!(all.matches(&text).count(), 1, "{text}");
    }
    changed_headers(to, |mut text| {
        for (table, field) in tables {
            let end = format!("}} {table};");
            text = text.replace(&end, &format!("  {field}\n{end}"));
        }
        text = text.replace(host, &format!("{host}  const char *(TATU_CALL *weather)(const tatu_host *);\n"));
        text.replace("#define TATU_ABI_MINOR 8", "#define TATU_ABI_MINOR 9")
    });
    let more = "#include \"core.h\"
#define TATU_HOLOGRAM \"tatu.hologram/draft.4\"
typedef struct tatu_ext_hologram { uint32_t size; uint32_t reserved; const char *colour; } tatu_ext_hologram;
#define TATU_HOST_DREAMS \"tatu.host.dreams/draft.4\"
typedef struct tatu_host_dreams { uint32_t size; uint32_t reserved; void(TATU_CALL *dream)(tatu_world *); } tatu_host_dreams;
";
    fs::write(to.join("tatu/hologram.h"), more).unwrap();
    let front = fs::read_to_string(to.join("tatu.h")).unwrap();
    let (before, after) = front.split_at(front.rfind("#endif").unwrap());
    fs::write(to.join("tatu.h"), format!("{before}#include \"tatu/hologram.h\"\n{after}")).unwrap();
}

/// Returns the source of a plugin for that release. It fills in the new fields of its tables and uses those of the
/// host.
fn future_plugin() -> String {
    let old = fs::read_to_string(root().join("tests/compat/plugin.c")).unwrap();
    let replaced = |text: String, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    };
    let mut text = old;
    for (table, field) in [
        ("tatu_plugin_t", ".motto = motto"),
        ("tatu_param", ".tooltip = \"new\""),
        ("tatu_life", ".sleep = sleep_now"),
        ("tatu_name", ".since = \"2\""),
        ("tatu_command", ".preview = preview"),
        ("tatu_ext_command", ".topics = topics"),
        ("tatu_field", ".colour_map = \"new\""),
        ("tatu_sensor", ".icon = \"new\""),
        ("tatu_ext_sensor", ".groups = topics"),
    ] {
        text = replaced(text, &format!(".size = sizeof({table})"), &format!(".size = sizeof({table}), {field}"));
    }
    let before = "static const char *const topics[] = {\"new\", NULL};
static const char *motto(void *self) { (void)self; return \"new\"; }
static tatu_status sleep_now(void *data, tatu_error *e) { (void)data; (void)e; return TATU_OK; }
static tatu_status preview(tatu_call *c) { (void)c; return TATU_OK; }
static const tatu_ext_hologram hologram = {.size = sizeof(tatu_ext_hologram), .colour = \"blue\"};
static const tatu_need dreams_need = {.size = sizeof(tatu_need), .optional = 1, .id = TATU_HOST_DREAMS};

/* -- per world";
    text = replaced(text, "/* -- per world", before);
    text = replaced(text, "{&scene_need, NULL}", "{&scene_need, &dreams_need, NULL}");
    text = replaced(
        text,
        "  return NULL;\n}\nstatic const tatu_need",
        "  if (!strcmp(id, TATU_HOLOGRAM)) return &hologram;\n  return NULL;\n}\nstatic const tatu_need",
    );
    // The plugin must detect missing features of the host by TATU_HAS and TATU_KNOWS only, and then do without them.
    text = replaced(
        text,
        "  return TATU_HAS(scene, find)",
        "  if (TATU_HAS(host, weather) || TATU_HAS(scene, teleport)) return tatu_fail(error, TATU_ERR, \"claims what is not there\");
  if (host->service(host, TATU_HOST_DREAMS)) return tatu_fail(error, TATU_ERR, \"claims to dream\");
  return TATU_HAS(scene, find)",
    );
    text = replaced(
        text,
        "  if (!info->state)",
        "  if (TATU_KNOWS(info, nickname)) return tatu_fail(error, TATU_ERR, \"claims a nickname\");
  if (!info->state)",
    );
    text = replaced(
        text,
        "  for (i = 0; i < batch->n; i++) {",
        "  if (TATU_HAS(batch, temperature)) return tatu_fail(error, TATU_ERR, \"claims a temperature\");
  for (i = 0; i < batch->n; i++) {",
    );
    replaced(
        text,
        "  *(int64_t *)call->state += 1;",
        "  if (TATU_HAS(call->api, progress)) return tatu_call_fail(call, TATU_ERR, \"claims progress\");
  *(int64_t *)call->state += 1;",
    )
}

#[test]
fn a_newer_plugin_works_on_this_host_without_the_missing_services() {
    let place = TestFolder::new();
    fs::create_dir(place.path().join("mine")).unwrap();
    let next = place.path().join("next");
    write_future_headers(&next);
    place.write("next/plugin.c", &future_plugin());
    compile(&next.join("plugin.c"), &next, &place.path().join("mine").join(library("tatu_new")));
    works(&place, "oldc");
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["note: ", "can use `tatu.host.dreams/draft.4`", "the plugin runs without it"]);
}
