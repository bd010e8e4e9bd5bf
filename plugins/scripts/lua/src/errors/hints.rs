//! Hints for common errors, added to Lua's own messages.

use mlua_sys::*;

use crate::{stack::bytes, state::ScriptState};

/// Returns a hint for a syntax error.
pub(crate) fn syntax(message: &str) -> Option<String> {
    let opened = || {
        let (_, rest) = message.split_once("(to close '")?;
        let (what, line) = rest.split_once("' at line ")?;
        Some((what, line.split(')').next()?))
    };
    Some(if message.starts_with("'end' expected") {
        let begun =
            opened().map_or("one of these blocks".into(), |(what, line)| format!("the `{what}` of line {line}"));
        format!("every `function`, `if`, `for` and `while` needs an `end`: {begun} has none")
    } else if let (true, Some((what, line))) = (message.contains(" expected (to close '"), opened()) {
        format!("the `{what}` of line {line} is not closed")
    } else if message.starts_with("<eof> expected near 'end'") {
        "this `end` does not belong to a block".into()
    } else if message.starts_with("'then' expected") {
        if message.ends_with("near '='") {
            "values are compared with `==`; a single `=` assigns".into()
        } else {
            "a condition ends with `then`: `if x > 1 then`".into()
        }
    } else if message.starts_with("'do' expected") {
        "the head of a loop ends with `do`".into()
    } else if message.contains("near '!'") {
        "`not equal` is written `~=`, negation is written `not`".into()
    } else if message.starts_with("unfinished string") {
        "a string must end on the same line, with the same quote with which it begins".into()
    } else if message.starts_with("'=' expected") || message.starts_with("syntax error") {
        "a statement is a call, `f(x)`, or an assignment, `x = 1`: check for a misspelt word or a missing bracket"
            .into()
    } else if message.starts_with("unexpected symbol") {
        "the code before this symbol is incomplete, or the symbol is misplaced".into()
    } else {
        return None;
    })
}

/// Returns a hint for a runtime error; `near` finds a global or command with a similar name.
pub(crate) fn runtime(message: &str, near: impl Fn(&str) -> Option<String>) -> Option<String> {
    let variable = || {
        let (_, rest) = message.rsplit_once(" (")?;
        let (what, rest) = rest.split_once(" '")?;
        let name = rest.split('\'').next()?;
        matches!(what, "global" | "local" | "upvalue" | "field" | "method").then_some((what, name))
    };
    let meant = |what: &str, name: &str| {
        (what == "global").then(|| near(name)).flatten().map_or(String::new(), |n| format!("; did you mean `{n}`?"))
    };
    if message.starts_with("attempt to call a nil value") {
        let (what, name) = variable()?;
        if matches!(name, "execute" | "popen" | "loadlib") {
            return Some("scripts can start programs or load libraries only if the run allows it (`--allow`)".into());
        }
        return Some(format!("there is no function `{name}` here{}", meant(what, name)));
    }
    let nil = ["arithmetic on a nil", "index a nil", "concatenate a nil", "length of a nil", "compare "];
    if !nil.iter().any(|n| message.contains(n)) || !message.contains("nil") {
        return None;
    }
    let Some((what, name)) = variable() else {
        return Some(
            "one of the two is nil: it was never set, or the function that should have set it returned no value".into(),
        );
    };
    Some(format!(
        "`{name}` is nil: it was never set, is misspelt, or the function that should have set it returned no value{}",
        meant(what, name)
    ))
}

/// Returns the most similar name in `all`, if any is similar enough.
pub(crate) fn nearest(name: &str, all: impl Iterator<Item = String>) -> Option<String> {
    // Allow few differences in short names: `simROS` is not a misspelling of `simRMLPos`.
    let most = |known: &str| match name.len() {
        n @ ..=8 => n.div_ceil(4),
        n => 1 + n.max(known.len()) / 4,
    };
    // The comparison takes time in proportion to the product of the lengths.
    const MAX_NAME_BYTES: usize = 200;
    if name.len() > MAX_NAME_BYTES {
        return None;
    }
    all.filter(|known| known != name && known.len() <= MAX_NAME_BYTES)
        .map(|known| (strsim::damerau_levenshtein(&name.to_lowercase(), &known.to_lowercase()), known))
        .filter(|(d, known)| *d <= most(known))
        .min()
        .map(|(_, known)| known)
}

/// Returns the names of all commands.
pub(crate) fn commands(s: &ScriptState) -> Vec<String> {
    s.world().commands().into_iter().flat_map(|about| about.names).collect()
}

/// Returns the names of the script's globals.
///
/// # Safety
/// `l` must be an idle thread with three free stack slots.
pub(crate) unsafe fn globals(l: *mut lua_State) -> Vec<String> {
    let mut out = Vec::new();
    lua_pushglobaltable(l);
    lua_pushnil(l);
    while lua_next(l, -2) != 0 {
        if lua_type(l, -2) == LUA_TSTRING {
            out.push(String::from_utf8_lossy(bytes(l, -2)).into_owned());
        }
        lua_pop(l, 1);
    }
    lua_pop(l, 1);
    out.sort();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_mistakes_get_a_hint() {
        let all = || ["speed", "drive", "print"].iter().map(|s| s.to_string());
        let near = |name: &str| nearest(name, all());
        let cases = [
            ("attempt to call a nil value (global 'drvie')", "no function `drvie` here; did you mean `drive`?"),
            ("attempt to perform arithmetic on a nil value (global 'speeed')", "did you mean `speed`?"),
            ("attempt to perform arithmetic on a nil value (local 'x')", "`x` is nil"),
            ("attempt to index a nil value (field 'arm')", "`arm` is nil"),
            ("attempt to compare number with nil", "one of the two is nil"),
            ("attempt to call a nil value (field 'execute')", "--allow"),
        ];
        for (message, words) in cases {
            let hint = runtime(message, near).unwrap_or_default();
            assert!(hint.contains(words), "{message}: {hint}");
        }
        assert_eq!(runtime("no fuel", near), None);
        assert_eq!(runtime("attempt to compare two table values", near), None);
        let cases = [
            ("'end' expected (to close 'if' at line 3) near <eof>", "the `if` of line 3 has none"),
            ("'then' expected near '='", "`==`"),
            ("')' expected (to close '(' at line 2) near 'x'", "the `(` of line 2 is not closed"),
        ];
        for (message, words) in cases {
            assert!(syntax(message).unwrap_or_default().contains(words), "{message}");
        }
        assert_eq!(nearest("zzzzzz", all()), None);
        assert_eq!(nearest("simROS", ["simRMLPos".to_owned()].into_iter()), None);
    }
}
