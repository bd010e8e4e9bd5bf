//! Tests of the C header against its Rust mirror: names, sizes, offsets and values, as a C compiler and rustc compute
//! them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    fs,
    path::PathBuf,
    process::Command,
};

use crate::{
    kit::*,
    plugins::mirror::{Type, types},
};

/// Types that never change within a major version of the ABI, with their sizes in bytes on 64-bit systems, computed by
/// hand from their fields.
const FROZEN_TYPES: [(&str, usize); 5] = [
    ("tatu_str", 16),        // pointer, length
    ("tatu_value", 24),      // tag, reserved, 16 bytes of payload
    ("tatu_pair", 48),       // two values
    ("tatu_field_view", 48), // pointer, length, element and three dimensions, time, sequence
    ("tatu_contact", 72),    // two objects, point, normal, force
];

/// Returns the text of the headers without comments.
fn code() -> String {
    let text = header_text(&root().join("plugin-api/include"));
    let mut parts = text.split("/*");
    let first = parts.next().unwrap().to_owned();
    parts.fold(first, |out, part| out + part.split_once("*/").unwrap().1)
}

/// Compiles a `main` that prints, preceded by the header, and returns its output split into words.
fn printed(body: &str) -> Vec<Vec<String>> {
    let place = TestFolder::new();
    let text = format!(
        "#include \"tatu.h\"\n#include \"tatu/test.h\"\n#include <stdio.h>\nint main(void) {{\n{body}return 0;\n}}\n"
    );
    place.write("print.c", &text);
    let exe = place.path().join(format!("print{}", std::env::consts::EXE_SUFFIX));
    let include = root().join("plugin-api/include");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wno-unused-function", "-I"])
            .arg(include)
            .arg(place.path().join("print.c"))
            .arg("-o")
            .arg(&exe),
    );
    let out = succeed(&mut Command::new(exe));
    out.lines().map(|l| l.split(' ').map(str::to_owned).collect()).collect()
}

#[test]
fn sizes_and_places_are_the_same() {
    let types = types();
    let mut body = String::new();
    for t in &types {
        let n = t.name;
        let _ = writeln!(body, "printf(\"{n} . 0 %zu\\n\", sizeof({n}));");
        for f in &t.fields {
            let f = f.name;
            let _ = writeln!(body, "printf(\"{n} {f} %zu %zu\\n\", offsetof({n}, {f}), sizeof((({n} *)0)->{f}));");
        }
    }
    let mut lines = printed(&body).into_iter();
    for t in &types {
        let whole = [t.name, ".", "0", &t.size.to_string()].map(str::to_owned);
        assert_eq!(lines.next().unwrap(), whole, "C, then Rust: size of {}", t.name);
        for f in &t.fields {
            let field = [t.name, f.name, &f.at.to_string(), &f.size.to_string()].map(str::to_owned);
            assert_eq!(lines.next().unwrap(), field, "C, then Rust: offset and size of {}.{}", t.name, f.name);
        }
    }
}

#[test]
fn the_payload_of_a_value_has_the_offset_of_c() {
    use tatu_plugin_api::abi::{tatu_span_t, tatu_value};
    let lines = printed(
        "printf(\"%zu %zu %zu %zu %zu\\n\", offsetof(tatu_value, u.i), offsetof(tatu_value, u.f), offsetof(tatu_value, u.u),
            offsetof(tatu_value, u.s.ptr), offsetof(tatu_value, u.s.len));\n",
    );
    let payload = core::mem::offset_of!(tatu_value, u);
    let span = [core::mem::offset_of!(tatu_span_t, ptr), core::mem::offset_of!(tatu_span_t, len)];
    let ours = [payload, payload, payload, payload + span[0], payload + span[1]].map(|n| n.to_string());
    assert_eq!(lines[0], ours);
}

#[test]
fn no_type_and_no_field_is_left_out() {
    // Definitions that only shorten C code are not part of the interface.
    const C_ONLY_TYPES: [&str; 4] = ["tatu_build", "tatu_host_api", "tatu_offer", "tatu_test_end"];
    let types = types();
    let mirrored: BTreeSet<&str> = types.iter().map(|t| t.name).collect();
    let code = code();
    let declared: BTreeSet<&str> = code
        .lines()
        .filter_map(|l| l.strip_prefix("typedef struct ").or_else(|| l.strip_prefix("struct ")))
        .filter_map(|l| l.strip_suffix(" {"))
        .filter(|name| !C_ONLY_TYPES.contains(name))
        .collect();
    assert_eq!(mirrored, declared, "rows of mirror.rs, types of the header");
    // Gaps between fields are alignment padding only.
    for t in &types {
        let mut end = 0usize;
        for f in &t.fields {
            assert_eq!(f.at, end.next_multiple_of(f.align), "{}.{}: a field is missing before it", t.name, f.name);
            end = f.at + f.size;
        }
    }
}

#[test]
fn tables_begin_with_their_size_and_have_no_tail() {
    let is_frozen = |t: &Type| FROZEN_TYPES.iter().any(|(n, _)| *n == t.name);
    let mut tables = 0;
    for t in types().iter().filter(|t| !is_frozen(t)) {
        let (first, last) = (&t.fields[0], t.fields.last().unwrap());
        assert_eq!((first.name, first.at, first.size), ("size", 0, 4), "{}", t.name);
        assert_eq!(
            last.at + last.size,
            t.size,
            "{}: padding behind `{}`, where a new field would be placed",
            t.name,
            last.name
        );
        tables += 1;
    }
    assert!(tables > 30, "{tables} tables");
}

#[test]
#[cfg(target_pointer_width = "64")]
fn frozen_types_have_their_sizes() {
    for (name, size) in FROZEN_TYPES {
        let found = types().into_iter().find(|t| t.name == name).unwrap();
        assert_eq!(found.size, size, "{name}");
        assert_ne!(found.fields[0].name, "size", "{name} is not a table");
    }
}

/// Returns the names of the constants in Rust, and their values as source text.
fn constants() -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    for file in ["frozen", "types", "ext", "host", "part"] {
        let text = fs::read_to_string(root().join(format!("plugin-api/src/abi/{file}.rs"))).unwrap();
        for line in text.lines().filter_map(|l| l.trim().strip_prefix("pub const ").filter(|l| l.starts_with("TATU_")))
        {
            let (name, rest) = line.split_once(':').unwrap();
            let value = rest.split_once(" = ").unwrap().1.trim_end_matches(';');
            let value = value.trim_start_matches("c\"").trim_end_matches('"');
            all.insert(name.to_owned(), value.to_owned());
        }
    }
    all
}

#[test]
fn constants_have_the_same_values() {
    let mut ours = constants();
    // The Rust layout is negotiated only between Rust plugins and the host, and is not part of the header.
    ours.remove("TATU_RUST_LAYOUT").unwrap();
    let mut body = String::new();
    for (name, value) in &ours {
        let is_number = value.parse::<i64>().is_ok();
        let (form, cast) = if is_number { ("%lld", "(long long)") } else { ("%s", "") };
        let _ = writeln!(body, "printf(\"{name} {form}\\n\", {cast}{name});");
    }
    let theirs: BTreeMap<String, String> = printed(&body).into_iter().map(|mut l| (l.remove(0), l.join(" "))).collect();
    assert_eq!(ours, theirs, "Rust, then C");

    // Conversely, every constant of the header exists in Rust: enum constants, and macros with a number or string.
    let code = code();
    let word = |s: &str| {
        s.trim().chars().take_while(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || *c == '_').collect::<String>()
    };
    let bodies = code.split("enum tatu_").skip(1).filter_map(|e| e.split_once('{'));
    let bodies = bodies.filter(|(name, _)| name.trim().chars().all(|c| c.is_ascii_lowercase() || c == '_'));
    let enums = bodies.flat_map(|(_, body)| body.split('}').next().unwrap().split(','));
    let defines = code.lines().filter_map(|l| l.strip_prefix("#define ")).filter(|l| {
        let value = l.split_once(' ').map_or("", |(_, v)| v.trim());
        value.starts_with('"') || value.starts_with(|c: char| c.is_ascii_digit())
    });
    let declared: BTreeSet<String> =
        enums.map(word).chain(defines.map(word)).filter(|n| n.starts_with("TATU_")).collect();
    assert_eq!(ours.into_keys().collect::<BTreeSet<_>>(), declared, "Rust, then the header");
}

/// Checks that each of the headers can be included alone and twice without a warning of the compiler.
fn each_alone(headers: &[PathBuf], compiler_name: &str, standard: &str, suffix: &str) {
    let include = root().join("plugin-api/include");
    for header in headers {
        let place = TestFolder::new();
        let line = format!("#include \"{}\"\n", header.strip_prefix(&include).unwrap().display());
        let file = format!("a.{suffix}");
        place.write(&file, &format!("{line}{line}int main(void) {{ return 0; }}\n"));
        succeed(
            Command::new(compiler(compiler_name))
                .args([standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-function", "-fsyntax-only"])
                .arg("-I")
                .arg(&include)
                .arg(place.path().join(&file)),
        );
    }
}

#[test]
fn each_header_can_be_included_by_itself() {
    each_alone(&headers(&root().join("plugin-api/include")), "cc", "-std=c11", "c");
}

/// C89 lacks `inline`, compound literals and macros with a variable number of arguments. The functions need none of them;
/// plugins in C89 fill tables and lists as variables, instead of by the macros.
#[test]
fn a_plugin_in_c89_is_loaded() {
    let place = TestFolder::scene(&format!("plugins = [\"p\"]\n{}", watcher("caller", "print(old.twice(21))")));
    let source = r#"
        #include "tatu.h"
        static tatu_status twice(tatu_call *c) { return tatu_return(c, tatu_float(2 * tatu_arg_float(c, 0))); }
        static const tatu_name name = {sizeof(tatu_name), 0, "old.twice"};
        static const tatu_name *const names[] = {&name, NULL};
        static tatu_param x;
        static const tatu_param *const params[] = {&x, NULL};
        static tatu_command command;
        static const tatu_command *const commands[] = {&command, NULL};
        static tatu_ext_command offered;
        static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
          (void)host, (void)self, (void)error;
          x.size = sizeof x, x.type = TATU_F64, x.key = "x", x.text = "Any number.";
          command.size = sizeof command, command.names = names, command.params = params, command.call = twice;
          command.text = "Doubles a number.";
          offered.size = sizeof offered, offered.commands = commands;
          return TATU_OK;
        }
        static void shutdown_nothing(void *self) { (void)self; }
        static const void *extension(void *self, const char *id) {
          (void)self;
          return tatu_str_is(tatu_text(id), TATU_COMMAND) ? &offered : NULL;
        }
        const tatu_plugin_t tatu_plugin = {sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.old", "Old",
          "1.0.0", "MIT", NULL, init, shutdown_nothing, extension};
    "#;
    place.write("old.c", source).write("p/.keep", "");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c89", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function"])
            .args(["-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["old.c", "-o", "p/libtatu_old.so"])
            .current_dir(place.path()),
    );
    assert!(place.tatu(&["run", "scene.toml", "--steps", "1"]).good().out.contains("42"));
}

#[test]
#[cfg_attr(no_cxx, ignore = "needs a C++ compiler")]
fn each_header_is_good_cpp_too() {
    let include = root().join("plugin-api/include");
    let mut all = headers(&include);
    all.push(include.join("tatu/plugin.hpp"));
    all.extend(fs::read_dir(include.join("tatu/cpp")).unwrap().map(|e| e.unwrap().path()));
    each_alone(&all, "c++", "-std=c++17", "cpp");
}

#[test]
fn the_front_page_includes_every_header_for_plugins() {
    let include = root().join("plugin-api/include");
    let front = fs::read_to_string(include.join("tatu.h")).unwrap();
    // The header for tests of plugins is not part of the contract.
    for header in headers(&include)[1..].iter().filter(|h| !h.ends_with("tatu/test.h")) {
        let line = format!("#include \"{}\"", header.strip_prefix(&include).unwrap().display());
        assert!(front.contains(&line), "tatu.h does not contain {line}");
    }
}

#[test]
fn the_host_offers_fewer_than_120_functions() {
    // Function fields of the `tatu_host_` tables, counted in the header.
    let code = code();
    let tables = code
        .split("typedef struct tatu_host_")
        .skip(1)
        .filter(|t| !t.starts_with("api"))
        .map(|t| t.split("} tatu_host_").next().unwrap());
    let count: usize = tables.map(|t| t.matches("(TATU_CALL *").count()).sum();
    assert!((1..120).contains(&count), "{count}");
}
