//! Declarations of all commands as a stub file for Python's type checkers and editors.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
};

use tatu_core::plugins::{CommandEntry, ParameterSpec, Registry};
use tatu_plugin_api::abi::*;

const STUB_HEADER: &str = "\
from typing import Any, Dict, Mapping, Optional, Sequence, Union

import numpy as np

Numbers = Union[Sequence[float], np.ndarray]
";

/// Python's reserved words, which cannot be names of methods or parameters.
const PYTHON_KEYWORDS: &[&str] = &[
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del",
    "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal",
    "not", "or", "pass", "raise", "return", "try", "while", "with", "yield", "self",
];

/// Returns the contents of the stub file: a class for each namespace, and a class with these as its attributes.
pub fn write(registry: &Registry) -> String {
    let mut spaces: BTreeMap<&str, BTreeMap<&str, &CommandEntry>> = BTreeMap::new();
    for command in &registry.command_offers.commands {
        for name in &command.names {
            // In Python, commands without a namespace are accessible only through `call`.
            if let Some((space, short)) = name.name.split_once('.').filter(|(s, n)| is_name(s) && is_name(n)) {
                spaces.entry(space).or_default().insert(short, command);
            }
        }
    }
    let mut out = String::from(STUB_HEADER);
    for (space, commands) in &spaces {
        let _ = write!(out, "\nclass _{space}:\n");
        for (name, command) in commands {
            method(&mut out, name, command);
        }
    }
    out += "\nclass Namespaces:\n";
    for space in spaces.keys() {
        let _ = writeln!(out, "    {space}: _{space}");
    }
    out += "\ndef commands_of(native: Any) -> Dict[str, Dict[str, Any]]: ...\n";
    out
}

fn method(out: &mut String, name: &str, command: &CommandEntry) {
    let mut used = BTreeSet::new();
    let (mut args, mut optional, mut rest) = (String::new(), false, false);
    for (number, p) in command.params.iter().enumerate() {
        let name = match is_name(&p.key) && !used.contains(&p.key) {
            true => p.key.clone(),
            false => format!("arg{}", number + 1),
        };
        used.insert(name.clone());
        optional |= p.optional();
        let kind = type_of(p);
        rest = p.flags & TATU_PARAM_REST != 0;
        let _ = match (rest, optional) {
            (true, _) => write!(args, ", *{name}: {kind}"),
            (false, true) => write!(args, ", {name}: Optional[{kind}] = None"),
            (false, false) => write!(args, ", {name}: {kind}"),
        };
        if rest {
            break;
        }
    }
    // Arguments are passed by position only.
    let slash = if command.params.is_empty() || rest { "" } else { ", /" };
    let returned = match command.returns.as_slice() {
        [] => "None",
        [one] if !one.optional() => result_of(one),
        _ => "Any",
    };
    let _ = writeln!(out, "    def {name}(self{args}{slash}) -> {returned}:");
    let _ = writeln!(out, "        \"\"\"{}\"\"\"", text(command).replace('\\', "\\\\").replace("\"\"\"", "'''"));
}

/// Returns the docstring of a command, with its parameters and results.
fn text(command: &CommandEntry) -> String {
    let mut out = command.text.clone();
    for (title, all) in [("Args", &command.params), ("Returns", &command.returns)] {
        if all.is_empty() {
            continue;
        }
        let _ = write!(out, "\n\n        {title}:");
        for p in all {
            let unit = p.unit.as_ref().map_or(String::new(), |u| format!(" ({u})"));
            let _ = write!(out, "\n            {}{unit}: {}", p.key, p.text);
        }
    }
    // A quotation mark at the end would close the docstring one character early.
    if out.ends_with('"') { out + " " } else { out }
}

/// Returns a parameter's type in Python.
pub fn type_of(p: &ParameterSpec) -> &'static str {
    match p.kind {
        _ if p.flags & TATU_PARAM_ANY != 0 => "Any",
        TATU_BOOL => "bool",
        TATU_I64 | TATU_OBJECT | TATU_FUNC => "int",
        TATU_F64 => "float",
        TATU_TEXT => "Union[str, bytes]",
        TATU_BYTES => "bytes",
        TATU_F64S => "Numbers",
        TATU_LIST => "Sequence[Any]",
        TATU_MAP => "Mapping[Any, Any]",
        _ => "Any",
    }
}

fn result_of(p: &ParameterSpec) -> &'static str {
    match p.kind {
        _ if p.flags & TATU_PARAM_ANY != 0 => "Any",
        TATU_TEXT => "str",
        TATU_F64S => "np.ndarray",
        TATU_MAP => "Dict[Any, Any]",
        TATU_LIST => "Any",
        _ => type_of(p),
    }
}

fn is_name(text: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !PYTHON_KEYWORDS.contains(&text)
}
