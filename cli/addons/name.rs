//! Parses the file names of add-ons, by the rules of all versions of V-REP and CoppeliaSim. Add-ons that start "by
//! name" run only if `--addon` names them:
//!
//! | file | kind | starts |
//! |---|---|---|
//! | `vrepAddOnFunc_x.lua`, `vrepAddOnFunction_x.lua`, `simAddOnFunc_x.lua` | a function: file runs once | by name |
//! | `vrepAddOnScript_x.lua`, `simAddOnScript_x.lua` | a script | automatically |
//! | `vrepAddOnScript-x.lua`, `simAddOnScript-x.lua` | a script | by name |
//! | `simAddOnX.lua`, any other name | a script | as its function `info` returns |

use super::Start;

/// What a file name specifies: the add-on's name, whether it is a function, and whether it starts automatically.
#[derive(Debug, PartialEq, Eq)]
pub struct Told {
    pub name: String,
    pub function: bool,
    pub start: Start,
}

/// Parses the name of a file without its suffix.
pub fn of(stem: &str) -> Told {
    let told = |name: &str, function, start| Told { name: name.to_owned(), function, start };
    let after = |prefix: &str| stem.strip_prefix(prefix).filter(|rest| !rest.is_empty());
    for program in ["vrep", "sim"] {
        for (kind, function) in [("Func", true), ("Function", true), ("Script", false)] {
            let by_itself = if function { Start::ByName } else { Start::ByItself };
            if let Some(name) = after(&format!("{program}AddOn{kind}_")) {
                return told(name, function, by_itself);
            }
            if let Some(name) = after(&format!("{program}AddOn{kind}-")) {
                return told(name, function, Start::ByName);
            }
        }
    }
    match after("simAddOn") {
        Some(name) => told(name, false, Start::Asked),
        None => told(stem, false, Start::Asked),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // The rules are in tests/facts/script-api.md, section 6.
    #[test]
    fn prefixes_of_all_versions() {
        let is =
            |stem: &str, name: &str, function, start| assert_eq!(of(stem), Told { name: name.into(), function, start });
        is("vrepAddOnScript_logger", "logger", false, Start::ByItself);
        is("vrepAddOnScript-logger", "logger", false, Start::ByName);
        is("simAddOnScript-a b", "a b", false, Start::ByName);
        is("vrepAddOnFunc_snap", "snap", true, Start::ByName);
        is("vrepAddOnFunction_snap", "snap", true, Start::ByName);
        is("simAddOnStepper", "Stepper", false, Start::Asked);
        is("pose_logger", "pose_logger", false, Start::Asked);
        is("simAddOn", "simAddOn", false, Start::Asked);
    }
}
