//! Converts keys, given by character, name or number, to the key codes of V-REP's messages.

/// Names of special keys and their codes.
const NAMED_KEYS: &[(&str, i64)] = &[
    ("space", 32),
    ("tab", 2000),
    ("enter", 2001),
    ("return", 2001),
    ("backspace", 2002),
    ("delete", 2003),
    ("up", 2007),
    ("down", 2008),
    ("left", 2009),
    ("right", 2010),
    ("esc", 2011),
    ("escape", 2011),
];

/// Keys that have a separate code in combination with Ctrl.
const CTRL_KEYS: &[(&str, i64)] = &[
    ("x", 2004),
    ("c", 2005),
    ("v", 2006),
    ("y", 2012),
    ("z", 2013),
    ("s", 2014),
    ("o", 2015),
    ("a", 2016),
    ("w", 2017),
    ("q", 2018),
    ("n", 2019),
    ("space", 2020),
    ("d", 2021),
    ("g", 2022),
    ("e", 2023),
    ("b", 2024),
];

const CTRL: i64 = 1;
const SHIFT: i64 = 2;

/// Returns the code of a key and its modifiers (1 is Ctrl, 2 is Shift): "s", "S", "up", "ctrl+s", "shift+up", "2007".
pub(crate) fn code(key: &str) -> Option<(i64, i64)> {
    let (mut name, mut held) = (key, 0);
    while let Some((with, rest)) = name.split_once('+').filter(|(_, rest)| !rest.is_empty()) {
        held |= match with.to_ascii_lowercase().as_str() {
            "ctrl" => CTRL,
            "shift" => SHIFT,
            _ => return None,
        };
        name = rest;
    }
    let find = |list: &[(&str, i64)]| {
        let lower = name.to_ascii_lowercase();
        list.iter().find(|(n, _)| *n == lower).map(|(_, code)| *code)
    };
    let mut chars = name.chars();
    let code = match (chars.next(), chars.next()) {
        _ if held & CTRL != 0 => find(CTRL_KEYS).or_else(|| find(NAMED_KEYS))?,
        // The code is the code point of the character that the key produces.
        (Some(c), None) => i64::from(u32::from(c)),
        _ => find(NAMED_KEYS).or_else(|| name.parse().ok().filter(|n| *n >= 0))?,
    };
    Some((code, held))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected codes: tests/facts/script-api.md, section 5.
    #[test]
    fn keys_are_converted_to_codes_and_modifiers() {
        for (key, wanted) in [
            ("s", Some((115, 0))),
            ("S", Some((83, 0))),
            ("w", Some((119, 0))),
            ("5", Some((53, 0))),
            ("+", Some((43, 0))),
            ("space", Some((32, 0))),
            ("up", Some((2007, 0))),
            ("Down", Some((2008, 0))),
            ("2010", Some((2010, 0))),
            ("ctrl+s", Some((2014, CTRL))),
            ("shift+left", Some((2009, SHIFT))),
            ("ctrl+shift+a", Some((2016, CTRL | SHIFT))),
            ("nokey", None),
            ("alt+x", None),
            ("", None),
        ] {
            assert_eq!(code(key), wanted, "{key}");
        }
    }
}
