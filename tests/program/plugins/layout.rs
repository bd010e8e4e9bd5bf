//! Tests of the recorded layouts in `plugin-api/layout/`: fields of a released revision keep their offsets in all later
//! ones.
//!
//! There is one file per revision, with one line per type (its size) and one line per field (offset and size). Fields
//! are listed in the order of the header. `TATU_BLESS=<name>` writes the record of a new revision, or adds new fields
//! to that of a draft.

use std::{collections::BTreeMap, fmt::Write, fs, process::Command};

use crate::{
    kit::*,
    plugins::mirror::{Type, types},
};

/// The recorded layout of a type: its size, and offset and size of each field.
#[derive(Debug, Clone, PartialEq, Eq)]
struct RecordedType {
    size: usize,
    fields: Vec<(String, usize, usize)>,
}
type LayoutRecord = BTreeMap<String, RecordedType>;

fn is_table(known: &RecordedType) -> bool {
    known.fields.first().is_some_and(|(name, at, _)| name == "size" && *at == 0)
}

fn of(types: &[Type]) -> LayoutRecord {
    let fields = |t: &Type| t.fields.iter().map(|f| (f.name.to_owned(), f.at, f.size)).collect();
    types.iter().map(|t| (t.name.to_owned(), RecordedType { size: t.size, fields: fields(t) })).collect()
}

fn write(record: &LayoutRecord) -> String {
    let mut out = String::from("# Sizes and places in bytes, on 64-bit systems. Lines are added, never changed.\n");
    for (name, known) in record {
        let _ = writeln!(out, "{name} {}", known.size);
        for (field, at, size) in &known.fields {
            let _ = writeln!(out, "  {field} {at} {size}");
        }
    }
    out
}

fn read(text: &str) -> LayoutRecord {
    let mut out = LayoutRecord::new();
    let mut last = String::new();
    for line in text.lines().filter(|l| !l.starts_with('#')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        match (line.starts_with(' '), words.as_slice()) {
            (false, [name, size]) => {
                last = (*name).to_owned();
                out.insert(last.clone(), RecordedType { size: size.parse().unwrap(), fields: Vec::new() });
            }
            (true, [field, at, size]) => {
                let field = ((*field).to_owned(), at.parse().unwrap(), size.parse().unwrap());
                out.get_mut(&last).unwrap().fields.push(field);
            }
            _ => panic!("not a line of a record: {line}"),
        }
    }
    out
}

/// Returns a line for each change by which the revision `new` breaks plugins built with `old`.
fn broken(old: &LayoutRecord, new: &LayoutRecord) -> Vec<String> {
    let mut out = Vec::new();
    for (name, was) in old {
        let Some(is) = new.get(name) else {
            out.push(format!("{name} has vanished"));
            continue;
        };
        if is.size < was.size || !is_table(was) && is.size != was.size {
            out.push(format!("{name} had {} bytes and has {}", was.size, is.size));
        }
        for (i, field) in was.fields.iter().enumerate() {
            match is.fields.iter().position(|f| f.0 == field.0) {
                None => out.push(format!("{name}.{} has vanished", field.0)),
                Some(j) if (i, field) == (j, &is.fields[j]) => {}
                Some(j) => {
                    let (_, at, size) = is.fields[j];
                    out.push(format!(
                        "{name}.{} was field {i} at {} with {} bytes, is field {j} at {at} with {size}",
                        field.0, field.1, field.2
                    ));
                }
            }
        }
        for (field, at, _) in is.fields.iter().skip(was.fields.len()) {
            if *at < was.size {
                out.push(format!("{name}.{field} is new, but is within the size of older revisions"));
            }
        }
    }
    out
}

/// Returns the records, oldest first. They are sorted by name, with numbers in names compared as numbers.
fn records() -> Vec<(String, LayoutRecord)> {
    let number = |s: &str| s.trim_matches(|c: char| !c.is_ascii_digit()).parse::<u64>().unwrap_or(0);
    let folder = root().join("plugin-api/layout");
    let mut all: Vec<(String, LayoutRecord)> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|x| x == "txt"))
        .map(|p| (p.file_stem().unwrap().to_string_lossy().into_owned(), read(&fs::read_to_string(&p).unwrap())))
        .collect();
    all.sort_by_key(|(name, _)| (name.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned(), number(name)));
    all
}

#[test]
#[cfg(target_pointer_width = "64")]
fn recorded_fields_have_not_moved() {
    let now = of(&types());
    if let Ok(name) = std::env::var("TATU_BLESS") {
        let all: Vec<String> = records().iter().flat_map(|(_, old)| broken(old, &now)).collect();
        assert!(all.is_empty(), "these changes are incompatible and are not recorded:\n{}", all.join("\n"));
        fs::write(root().join(format!("plugin-api/layout/{name}.txt")), write(&now)).unwrap();
    }
    let all = records();
    for (name, old) in &all {
        let broken = broken(old, &now);
        assert!(broken.is_empty(), "plugins built with {name} would break:\n{}", broken.join("\n"));
    }
    let (name, last) = all.last().expect("there is at least one record");
    assert!(
        *last == now,
        "the ABI has new fields since {name}: record them with `TATU_BLESS={name} cargo test --test program layout::`"
    );
}

/// Returns the layout that a C compiler computes for the recorded types and fields after a change of the headers.
fn compiled(change: impl Fn(String) -> String, record: &LayoutRecord) -> LayoutRecord {
    let place = TestFolder::new();
    changed_headers(place.path(), change);
    let mut body = String::new();
    for (name, known) in record {
        let _ = writeln!(body, "printf(\"{name} %zu\\n\", sizeof({name}));");
        for (field, ..) in &known.fields {
            let _ = writeln!(
                body,
                "printf(\"  {field} %zu %zu\\n\", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));"
            );
        }
    }
    place.write(
        "print.c",
        &format!("#include \"tatu.h\"\n#include \"tatu/test.h\"\n#include <stdio.h>\nint main(void) {{\n{body}return 0;\n}}\n"),
    );
    let exe = place.path().join(format!("print{}", std::env::consts::EXE_SUFFIX));
    succeed(
        Command::new(compiler("cc")).arg("-I").arg(place.path()).arg(place.path().join("print.c")).arg("-o").arg(&exe),
    );
    let mut out = read(&succeed(&mut Command::new(exe)));
    // Fields are listed in the order of their offsets.
    out.values_mut().for_each(|known| known.fields.sort_by_key(|f| f.1));
    out
}

#[test]
#[cfg(target_pointer_width = "64")]
fn a_field_that_is_moved_resized_or_removed_is_found() {
    let now = of(&types());
    assert_eq!(broken(&now, &compiled(|text| text, &now)), Vec::<String>::new());
    // If two fields of a table are swapped, only their offsets change.
    let moved = |header: String| {
        let Some(table) = header.find("typedef struct tatu_sensor {") else { return header };
        let (before, after) = header.split_at(table);
        let mut lines: Vec<&str> = after.split_inclusive('\n').collect();
        let line = |name: &str| lines.iter().position(|l| l.trim_start().starts_with(name)).unwrap();
        let (id, text) = (line("const char *id;"), line("const char *text;"));
        lines.swap(id, text);
        format!("{before}{}", lines.concat())
    };
    let found = broken(&now, &compiled(moved, &now)).join("\n");
    assert!(found.contains("tatu_sensor.id was field 2 at 8") && found.contains("tatu_sensor.text was"), "{found}");
    assert!(!found.contains("tatu_model"), "{found}");

    // A field that shrinks, a removed field, a field inserted between others, and a field appended at the end.
    let edited = |edit: &dyn Fn(&mut RecordedType)| {
        let mut new = now.clone();
        edit(new.get_mut("tatu_budget").unwrap());
        broken(&now, &new)
    };
    assert!(edited(&|k| k.fields[3].2 = 4)[0].contains("tatu_budget.memory was field 3 at 16 with 8 bytes"));
    assert!(edited(&|k| drop(k.fields.remove(3)))[0].contains("tatu_budget.memory has vanished"));
    assert!(!edited(&|k| k.fields.insert(2, ("between".into(), 8, 8))).is_empty());
    assert!(!edited(&|k| k.fields.push(("inside".into(), 20, 4))).is_empty(), "a field in padding is accepted");
    let grown = edited(&|k| {
        k.fields.push(("more".into(), 24, 8));
        k.size = 32;
    });
    assert!(grown.is_empty(), "{grown:?}");
    let mut frozen = now.clone();
    frozen.get_mut("tatu_str").unwrap().size = 24;
    assert!(broken(&now, &frozen)[0].contains("tatu_str had 16 bytes and has 24"));
}
