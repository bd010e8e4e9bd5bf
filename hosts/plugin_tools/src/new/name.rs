//! Validates names of new items, and inserts them into templates.

use tatu_core::errors::Result;

use super::choice::refused;

/// Names that are reserved in scripts: Lua's keywords, and global tables that scripts have in at least one API version.
#[rustfmt::skip]
const RESERVED_NAMES: [&str; 36] = [
    "and", "break", "do", "else", "elseif", "end", "false", "for", "function", "goto", "if", "in", "local", "nil", "not",
    "or", "repeat", "return", "then", "true", "until", "while",
    "bit32", "coroutine", "debug", "io", "math", "os", "package", "sim", "simui", "socket", "string", "table", "tatu",
    "utf8",
];
/// Maximum length of a name, in characters, because it becomes part of file names.
const MAX_NAME_CHARS: usize = 40;

/// Checks a name. Fails with E610 if it is invalid, too long or reserved.
pub fn check(name: &str) -> Result {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let starts = name.chars().next().is_some_and(|c| c.is_ascii_lowercase());
    let expected = "a letter, then letters, digits and `_`, all lower-case";
    if !starts || !name.chars().all(good) {
        let error = refused(format!("`{name}` is not a valid name")).expected(expected);
        let better = suggested_name(name);
        return Err(match better.is_empty() {
            true => error,
            false => error.help(format!("try `{better}`")),
        });
    }
    if name.len() > MAX_NAME_CHARS {
        return Err(refused(format!("the name is too long: {} characters", name.len()))
            .expected(format!("at most {MAX_NAME_CHARS} characters")));
    }
    if RESERVED_NAMES.contains(&name) {
        return Err(refused(format!("the name `{name}` is reserved in scripts"))
            .help(format!("try another, such as `my_{name}`")));
    }
    Ok(())
}

/// Returns a valid name that resembles `name`, or an empty string if there is no such name.
fn suggested_name(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => {
                // `MyRobot` becomes `my_robot`.
                if c.is_ascii_uppercase() && out.ends_with(|b: char| b.is_ascii_lowercase()) {
                    out.push('_');
                }
                out.push(c.to_ascii_lowercase());
            }
            _ if !out.is_empty() && !out.ends_with('_') => out.push('_'),
            _ => {}
        }
    }
    out.trim_start_matches(|c: char| !c.is_ascii_lowercase()).trim_end_matches('_').to_owned()
}

/// Replaces the template's name `own` in a text with `name`, both in snake case and in camel case.
pub fn replace_name(text: &str, own: &str, name: &str) -> String {
    text.replace(own, name).replace(&camel(own), &camel(name))
}

/// Converts snake case to camel case: `my_robot` to `MyRobot`.
fn camel(name: &str) -> String {
    let word = |w: &str| w[..1].to_ascii_uppercase() + &w[1..];
    name.split('_').filter(|w| !w.is_empty()).map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_and_reserved_names_are_refused() {
        for good in ["lamp", "my_robot", "a2"] {
            assert!(check(good).is_ok(), "{good}");
        }
        for (bad, better) in [("My-Robot", "my_robot"), ("MyRobot", "my_robot"), ("2wheels", "wheels"), ("a b", "a_b")]
        {
            let e = check(bad).unwrap_err();
            assert!(e.help.unwrap().contains(&format!("`{better}`")), "{bad}");
        }
        assert!(check("").is_err() && check("-").is_err() && check("end").is_err() && check(&"a".repeat(41)).is_err());
    }

    #[test]
    fn template_name_is_replaced_in_both_cases() {
        assert_eq!(replace_name("my_plugin MyPlugin", "my_plugin", "big_lamp"), "big_lamp BigLamp");
    }
}
