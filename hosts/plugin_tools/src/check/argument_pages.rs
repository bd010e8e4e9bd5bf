//! Copies of the arguments of commands, in memory before guard pages.

use std::ffi::c_void;

use tatu_core::plugins::{CommandEntry, guarded_copy::GuardedCopy};
use tatu_plugin_api::{abi::*, safe::ValueRef};

/// Copies of arguments in memory before guard pages, for the duration of a call.
#[derive(Default)]
pub struct GuardedPages(Vec<GuardedCopy>);

impl GuardedPages {
    fn add_copy(&mut self, bytes: &[u8], label: &str) -> *const c_void {
        let guarded = GuardedCopy::new(bytes, label);
        let first = guarded.first().cast();
        self.0.push(guarded);
        first
    }

    pub fn arguments(&mut self, command: &CommandEntry, args: &[ValueRef<'_>]) -> *const tatu_value {
        let moved: Vec<tatu_value> = args
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let key = command.params.get(i).map_or("", |p| p.key.as_str());
                self.value(*a, &format!("its argument {} `{key}`", i + 1), 0)
            })
            .collect();
        self.add_copy(bytes_of(&moved), "the array of its arguments, which does not contain omitted ones").cast()
    }

    /// Copies a value so that its spans end directly before guard pages. Spans that are empty, or nested more than 32
    /// levels deep, become null pointers.
    fn value(&mut self, v: ValueRef<'_>, label: &str, depth: u32) -> tatu_value {
        let mut out = v.raw();
        if !is_span(v.tag()) {
            return out;
        }
        let ptr = if v.is_empty() || depth > 32 {
            std::ptr::null()
        } else if let Some(items) = v.list() {
            let all: Vec<tatu_value> =
                items.iter().map(|e| self.value(*e, &format!("an element of {label}"), depth + 1)).collect();
            self.add_copy(bytes_of(&all), label)
        } else if let Some(pairs) = v.map() {
            let pair = |[key, value]: &[ValueRef<'_>; 2]| tatu_pair {
                key: self.value(*key, &format!("a key of {label}"), depth + 1),
                value: self.value(*value, &format!("an entry of {label}"), depth + 1),
            };
            let all: Vec<tatu_pair> = pairs.iter().map(pair).collect();
            self.add_copy(bytes_of(&all), label)
        } else {
            self.add_copy(v.span_bytes(), label)
        };
        out.u.s = tatu_span_t { ptr, len: v.len() as u64 };
        out
    }
}

fn bytes_of<T>(all: &[T]) -> &[u8] {
    // SAFETY: values and pairs of the ABI have no padding, and live as long as the slice.
    unsafe { std::slice::from_raw_parts(all.as_ptr().cast(), size_of_val(all)) }
}

fn is_span(tag: u32) -> bool {
    (TATU_TEXT..=TATU_MAP).contains(&tag)
}

/// Describes arguments for findings.
pub fn list(args: &[ValueRef<'_>]) -> String {
    let words: Vec<String> = args.iter().map(|v| shown(*v)).collect();
    words.join(", ")
}

fn shown(v: ValueRef<'_>) -> String {
    match (v.tag(), v.len()) {
        (TATU_NIL, _) => "nil".into(),
        (TATU_BOOL, _) => v.truthy().to_string(),
        (TATU_I64, _) => v.as_i64().unwrap_or_default().to_string(),
        (TATU_F64, _) => format!("{:?}", v.as_f64().unwrap_or_default()),
        (TATU_TEXT | TATU_BYTES, 0..=40) => format!("\"{}\"", v.as_bytes().unwrap_or_default().escape_ascii()),
        (TATU_TEXT | TATU_BYTES, n) => format!("a text of {n} bytes"),
        (TATU_LIST, n) => format!("a list of {n}"),
        (TATU_MAP, n) => format!("a map of {n}"),
        (TATU_FUNC, _) => "a function".into(),
        (TATU_OBJECT, _) => format!("object {}", tatu_slot(v.as_object().unwrap_or_default())),
        (_, n) => format!("an array of {n}"),
    }
}
