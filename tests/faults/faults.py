#!/usr/bin/env python3
"""Creates the faulty plugins listed in README.md.

faults.py list                      names of the faults
faults.py make NAME|all OUT         writes OUT/NAME/ with the changed source, and builds it
faults.py make none OUT             the same for the unchanged plugins
faults.py check                     compares the changes, expected.json and README.md with each other and the header

C and C++ are built by $CC and $CXX, or cc and c++. Rust is written as a crate, and built only with --rust.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from classes import FAULTS as FAULTS_BY_CLASS

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
API = ROOT / "plugin-api"

# The plugins without faults: those of this repository, and those that only show a fault. If one of the former is
# changed, `check` names the faults whose text it no longer contains.
BASES = {
    "c_command": API / "template/c_command/c_command.c",
    "cpp_command": API / "template/cpp_command/cpp_command.cpp",
    "rust_sensor": API / "template/rust_sensor/src/lib.rs",
    "thruster": ROOT / "plugins/actuators/thruster/src/thruster.rs",
    **{name: ROOT / f"tests/outside/{name}/{name}.c" for name in ["cart", "counter", "fleet", "lamp"]},
    "guard": ROOT / "tests/outside/guard/guard.cpp",
    **{name: ROOT / f"tests/outside/{name}/src/lib.rs" for name in ["compass", "tally"]},
    **{name: HERE / f"bases/{name}.c" for name in ["murmur", "notes", "points", "puff", "speckle"]},
}

# Name, plugin, and replacements. Each replaced text must occur exactly once. Most faults are a single replacement;
# those that need an #include or affect two places have more.
FAULTS = [
    # ---- descriptor and tables
    ("size_forgotten", "fleet", [(
        'arrive_command = {\n  .size = sizeof(tatu_command), .names',
        'arrive_command = {\n  .names',
    )]),
    ("licence_not_spdx", "counter", [('.licence = "MIT"', '.licence = "free for non-commercial use"')]),
    ("extension_id_misspelt", "cart", [(
        'TATU_PLUGIN(TATU_MODELS(&cart),',
        '#undef TATU_MODEL\n#define TATU_MODEL "tatu.models/draft.4"\nTATU_PLUGIN(TATU_MODELS(&cart),',
    )]),
    ("need_too_small", "fleet", [(
        'TATU_NEEDS(TATU_NEED_SCENE,',
        'TATU_NEEDS(TATU_TABLE(tatu_need, .id = TATU_HOST_SCENE, .bytes = offsetof(tatu_host_scene, get)),',
    )]),
    # ---- parameters
    ("default_out_of_range", "cart", [('TATU_DEFAULT_F64(0.1)', 'TATU_DEFAULT_F64(0.05)')]),
    ("default_not_a_choice", "puff", [('.u.s = {"direct", 6}', '.u.s = {"immediate", 9}')]),
    ("unit_unknown", "compass", [(
        'Param::float("dead_angle")\n                .unit("rad")',
        'Param::float("dead_angle")\n                .unit("radians")',
    )]),
    ("text_missing", "thruster", [(
        '.default(0.0).text("Requested force along +z, limited to `max_force`.")',
        '.default(0.0)',
    )]),
    ("optional_nil_crashes", "notes", [('if (tatu_has_arg(call, 2)) memcpy(made->place', 'memcpy(made->place')]),
    # ---- instances
    ("configure_ignored", "lamp", [('  take(data, params);\n', '  (void)data;\n')]),
    ("state_holds_pointer", "c_command", [(
        '''  state *kept = call->state;
  return tatu_return(call, tatu_int(++kept->count));''',
        '''  state **kept = call->state; // allocated at the first call
  if (!*kept && !(*kept = calloc(1, sizeof **kept))) return tatu_call_fail(call, TATU_ERR, "out of memory");
  return tatu_return(call, tatu_int(++(*kept)->count));''',
    )]),
    ("save_forgets", "tally", [(
        '''        let waits = world.waits.borrow();
        number(&mut out, waits.len() as u64);
        for (word, (name, count)) in waits.iter() {
            number(&mut out, *word);
            text(&mut out, name);
            number(&mut out, *count as u64);
        }
''',
        '''        number(&mut out, 0); // no waiting calls
''',
    )]),
    ("load_ignores_version", "notes", [(
        '  if (version != 2) return tatu_fail(error, TATU_ERR_UNSUPPORTED, "only notes of version 2 can be read");\n',
        '  (void)version;\n',
    )]),
    ("load_frees_instance", "notes", [(
        'return tatu_fail(error, TATU_ERR, "the saved notes end within a note");',
        'return destroy(data), tatu_fail(error, TATU_ERR, "the saved notes end within a note");',
    )]),
    # ---- errors
    ("error_without_message", "c_command", [(
        'return tatu_call_fail_help(call, TATU_ERR_MISSING, "there is no function to fire", '
        '"pass one to example.later first");',
        'return TATU_ERR_MISSING;',
    )]),
    ("message_without_error", "notes", [(
        '  if (!it) return tatu_call_fail(call, TATU_ERR_MISSING, "there is no note of that name");\n',
        '''  if (!it) {
    tatu_call_fail(call, TATU_ERR_MISSING, "there is no note of that name");
    return TATU_OK;
  }
''',
    )]),
    # ---- commands
    ("command_twice", "cpp_command", [(
        'offer(tatu::command(PREFIX "map", map)',
        'offer(tatu::command(PREFIX "describe", describe).text("Describes its arguments."));\n'
        '    offer(tatu::command(PREFIX "map", map)',
    )]),
    ("example_does_not_compile", "guard", [(
        '''"assert(guard.number('1.5') == 1.5)"''',
        '''"assert(guard.number('1.5') = 1.5)"''',
    )]),
    ("writes_arguments", "notes", [(
        '  tatu_str name = tatu_arg_text(call, 0), text = tatu_arg_text(call, 1);\n  double time;\n',
        '''  tatu_str name = tatu_arg_text(call, 0), text = tatu_arg_text(call, 1);
  double time;
  if (name.len) ((char *)name.ptr)[name.len] = 0; // terminates the name
''',
    )]),
    ("text_as_c_string", "guard", [(
        'given.len ? std::string(given.ptr, given.len) : std::string()',
        'given.len ? std::string(given.ptr) : std::string()',
    )]),
    ("text_must_be_utf8", "tally", [(
        '''                let (name, n) = (c.bytes(0)?, c.i64(1)?);
                let mut counts''',
        '''                let (name, n) = (c.bytes(0)?, c.i64(1)?);
                let name = std::str::from_utf8(name).expect("names are UTF-8").as_bytes();
                let mut counts''',
    )]),
    ("empty_table_crashes", "fleet", [(
        '  const tatu_value *handles = tatu_arg_list(call, 0, &n);\n',
        '''  const tatu_value *handles = tatu_arg_list(call, 0, &n);
  if (handles[0].tag == TATU_TEXT) return tatu_call_fail(call, TATU_ERR_ARGUMENT, "`handles`: expected numbers");
''',
    )]),
    # ---- rules for all calls
    ("global_counter", "c_command", [(
        '''  state *kept = call->state;
  return tatu_return(call, tatu_int(++kept->count));''',
        '''  static int64_t calls;
  return tatu_return(call, tatu_int(++calls));''',
    )]),
    ("wall_clock", "notes", [
        ('#include <string.h>\n', '#include <string.h>\n#include <time.h>\n'),
        (
            '  made->time = time;\n',
            '''  struct timespec now;
  timespec_get(&now, TIME_UTC);
  made->time = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
''',
        ),
    ]),
    ("exception_leaves", "guard", [(
        '  return border(call->error, [call] { Command(*call); });\n',
        '  Command(*call);\n  return TATU_OK;\n',
    )]),
    ("rounding_mode", "speckle", [
        ('#include <math.h>\n', '#include <fenv.h>\n#include <math.h>\n'),
        (
            '      distance[k] = floor(seen[k] * 1000) / 1000;\n',
            '      fesetround(FE_DOWNWARD);\n      distance[k] = rint(seen[k] * 1000) / 1000;\n',
        ),
    ]),
    ("signal_handler", "counter", [
        ('#include <stdio.h>\n', '#include <signal.h>\n#include <stdio.h>\n'),
        ('  *data = it;\n', '  signal(SIGTERM, SIG_IGN); // continue to count\n  *data = it;\n'),
    ]),
    ("exit_on_bad_input", "points", [(
        '  tatu_fail(error, TATU_ERR_ARGUMENT, why);\n',
        '''  fprintf(stderr, "points: line %llu: %s\\n", (unsigned long long)line, why);
  exit(1);
''',
    )]),
    # ---- sensors
    ("field_overrun", "speckle", [(
        '    *age = batch->time - ',
        '    hit[it->rays] = -1; // end marker\n    *age = batch->time - ',
    )]),
    ("field_width", "lamp", [(
        'TATU_FIELD(TATU_ELEM_F64, "lamp.level"',
        'TATU_FIELD(TATU_ELEM_F32, "lamp.level"',
    )]),
    ("infinite_reading", "lamp", [('if (!isfinite(way)) continue;', 'if (!(way > 0)) continue;')]),
    ("rand", "speckle", [(
        '    batch->random->uniform(batch->random, i, 0, it->rays, luck);\n',
        '    for (uint32_t k = 0; k < it->rays; k++) luck[k] = rand() / (RAND_MAX + 1.0);\n',
    )]),
    ("measure_uses_service", "speckle", [('    *age = batch->time - ', '    *age = now(it) - ')]),
    ("directions_on_stack", "lamp", [(
        '  tatu_rays(out, 1, it->ahead, it->range);\n',
        '''  double ahead[3] = {it->ahead[0], it->ahead[1], it->ahead[2]};
  tatu_rays(out, 1, ahead, it->range);
''',
    )]),
    ("schema_incomplete", "rust_sensor", [
        ('        NORMAL: f64 = Field::new("proximity.normal").elements(3).unit("1");\n', ''),
        ('            out.slice(Self::NORMAL).copy_from_slice(&sample.normals()[0]);\n', ''),
    ]),
    # ---- actuators
    ("wrench_stride", "puff", [('batch->wrench + 6 * (size_t)i', 'batch->wrench + 7 * (size_t)i')]),
    # ---- models
    ("model_below_floor", "cart", [('set3(&p, base, "position", 0, 0, r);', 'set3(&p, base, "position", 0, 0, 0);')]),
    # ---- languages
    ("dialect_not_owned", "murmur", [(
        '  *chosen = tatu_text(it->loud ? "loud" : "plain");\n',
        '  *chosen = dialect.len ? dialect : tatu_text("plain");\n',
    )]),
    # ---- services
    ("barrier_blocks", "counter", [
        ('#include <string.h>\n', '#include <string.h>\n#include <threads.h>\n#include <time.h>\n'),
        (
            '  it->counted->steps++;\n',
            '  thrd_sleep(&(struct timespec){.tv_sec = 2}, NULL); // slow enough to read\n  it->counted->steps++;\n',
        ),
    ]),
    ("thread_calls_world", "counter", [
        ('#include <string.h>\n', '#include <string.h>\n#include <threads.h>\n'),
        (
            '// Called before each step except those that follow a stop, and also',
            '''// Publishes the count on a separate thread.
typedef struct {
  service *it;
  tatu_world *world;
  tatu_error *error;
} job;
static int show_count(void *given) {
  const job *of = given;
  tatu_value show[2] = {tatu_string("ticks"), tatu_int(of->it->counted->steps)};
  return command(of->it, of->world, "sim.setInt32Signal", show, 2, of->error);
}

// Called before each step except those that follow a stop, and also''',
        ),
        (
            '''  tatu_value show[2] = {tatu_string("ticks"), tatu_int(it->counted->steps)};
  tatu_status status = command(it, world, "sim.setInt32Signal", show, 2, error);
''',
            '''  job shown = {it, world, error};
  thrd_t helper;
  tatu_status status = TATU_GO;
  if (thrd_create(&helper, show_count, &shown) != thrd_success) return tatu_fail(error, TATU_ERR, "no thread");
  thrd_join(helper, &status);
''',
        ),
    ]),
]

FAULTS += [(name, base, edits) for name, _, base, edits in FAULTS_BY_CLASS]


def changed(name, base, edits):
    """Returns the source of a base with the replacements applied."""
    source = BASES[base].read_text()
    for old, new in edits:
        if source.count(old) != 1:
            sys.exit(f"{name}: {BASES[base]} has this text {source.count(old)} times, not once:\n{old}")
        source = source.replace(old, new)
    return source


def run(command, **kwargs):
    print("+", " ".join(map(str, command)), flush=True)
    if subprocess.run(command, **kwargs).returncode != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}")


def make_c(name, base, source, folder):
    """Builds a plugin from a single file with one compiler call, as described in plugin-api/README.md."""
    cpp = BASES[base].suffix == ".cpp"
    file = folder / f"{name}{BASES[base].suffix}"
    file.write_text(source)
    compiler = os.environ.get("CXX", "c++") if cpp else os.environ.get("CC", "cc")
    flags = ["-std=c++17", "-fvisibility=hidden"] if cpp else ["-std=c11"]
    run([compiler, *flags, "-g", "-shared", "-fPIC", "-I", API / "include", "-o", folder / f"libtatu_{name}.so", file, "-lm"])


def make_rust(name, base, source, folder, out, build):
    """Writes a crate outside of the workspace, with the dependencies of the base."""
    crate = next(p for p in BASES[base].parents if (p / "Cargo.toml").exists())
    shutil.copytree(crate / "src", folder / "src", dirs_exist_ok=True)
    (folder / BASES[base].relative_to(crate)).write_text(source)
    shared = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["dependencies"]
    lines = []
    for key in tomllib.loads((crate / "Cargo.toml").read_text())["dependencies"]:
        lines.append(f'{key} = {{ path = "{API}" }}' if key == "tatu-plugin-api" else f"{key} = {json.dumps(shared[key])}")
    (folder / "Cargo.toml").write_text(
        f'[package]\nname = "tatu-{name}"\nversion = "0.1.0"\nedition = "2024"\n\n'
        '[lib]\ncrate-type = ["cdylib"]\n\n[workspace]\n\n[dependencies]\n' + "\n".join(lines) + "\n"
    )
    shutil.copy(ROOT / "Cargo.lock", folder / "Cargo.lock")
    if build:
        target = out / "target"
        run(["cargo", "build", "--quiet"], cwd=folder, env={**os.environ, "CARGO_TARGET_DIR": str(target), "CARGO_PROFILE_DEV_DEBUG": "0"})
        shutil.copy(target / "debug" / f"libtatu_{name}.so", folder)


def make(what, out, rust):
    if what == "none":
        plans = [(base, base, []) for base in BASES]
    else:
        plans = [fault for fault in FAULTS if what in ("all", fault[0])]
    if not plans:
        sys.exit(f"no fault has the name `{what}`; see faults.py list")
    for name, base, edits in plans:
        source = changed(name, base, edits)
        folder = out / name
        folder.mkdir(parents=True, exist_ok=True)
        if BASES[base].suffix == ".rs":
            make_rust(name, base, source, folder, out, rust)
        else:
            make_c(name, base, source, folder)


def check():
    expected = json.loads((HERE / "expected.json").read_text())
    readme = (HERE / "README.md").read_text()
    headers = [API / "include/tatu.h", *sorted((API / "include/tatu").glob("*.h"))]
    rules = "".join(header.read_text() for header in headers), (API / "README.md").read_text()
    wrong = []
    if [(e["name"], e["plugin"]) for e in expected] != [(name, base) for name, base, _ in FAULTS]:
        wrong.append("expected.json must list the faults of faults.py in the same order")
    first = [e["rule"] for e in expected if "class" not in e]
    if len(set(first)) != len(first):
        wrong.append("two faults have one rule")
    for number, (e, (name, base, edits)) in enumerate(zip(expected, FAULTS), 1):
        changed(name, base, edits)
        if not any(e["rule"] in line for line in rules[e["section"] == "README"].splitlines()):
            wrong.append(f"{name}: no line has the words: {e['rule']}")
        if f"| {number} | `{name}` |" not in readme or e["rule"] not in readme:
            wrong.append(f"{name}: README.md lacks it, or its rule")
    sys.exit("\n".join(wrong) if wrong else 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("list")
    commands.add_parser("check")
    making = commands.add_parser("make")
    making.add_argument("what", metavar="NAME|all|none")
    making.add_argument("out", metavar="OUT", type=Path)
    making.add_argument("--rust", action="store_true", help="build what is in Rust, too")
    given = parser.parse_args()
    if given.command == "list":
        print("\n".join(name for name, _, _ in FAULTS))
    elif given.command == "check":
        check()
    else:
        make(given.what, given.out.resolve(), given.rust)


if __name__ == "__main__":
    main()
