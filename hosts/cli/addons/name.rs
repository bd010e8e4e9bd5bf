//! Parses the file names of add-ons, by the rules of all versions of V-REP and CoppeliaSim. Add-ons that start "by
//! name" run only if `--addon` names them:
//!
//! | file | kind | starts |
//! |---|---|---|
//! | `vrepAddOnFunc_x.lua`, `vrepAddOnFunction_x.lua`, `simAddOnFunc_x.lua` | a function: file runs once | by name |
//! | `vrepAddOnScript_x.lua`, `simAddOnScript_x.lua` | a script | automatically |
//! | `vrepAddOnScript-x.lua`, `simAddOnScript-x.lua` | a script | by name |
//! | `simAddOnX.lua`, any other name | a script | as its function `info` returns |

use super::StartMode;

/// What a file name specifies: the add-on's name, whether it is a function, and whether it starts automatically.
#[derive(Debug, PartialEq, Eq)]
pub struct ParsedName {
    pub name: String,
    pub function: bool,
    pub start: StartMode,
}

/// Parses the name of a file without its suffix.
pub fn parse(stem: &str) -> ParsedName {
    let parsed = |name: &str, function, start| ParsedName { name: name.to_owned(), function, start };
    let after = |prefix: &str| stem.strip_prefix(prefix).filter(|rest| !rest.is_empty());
    for program in ["vrep", "sim"] {
        for (kind, function) in [("Func", true), ("Function", true), ("Script", false)] {
            let by_itself = if function { StartMode::OnRequest } else { StartMode::Automatic };
            if let Some(name) = after(&format!("{program}AddOn{kind}_")) {
                return parsed(name, function, by_itself);
            }
            if let Some(name) = after(&format!("{program}AddOn{kind}-")) {
                return parsed(name, function, StartMode::OnRequest);
            }
        }
    }
    match after("simAddOn") {
        Some(name) => parsed(name, false, StartMode::ScriptDecides),
        None => parsed(stem, false, StartMode::ScriptDecides),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // The rules are in tests/facts/script-api.md, section 6.
    #[test]
    fn addon_prefixes_of_all_versions_are_parsed() {
        let is = |stem: &str, name: &str, function, start| {
            assert_eq!(parse(stem), ParsedName { name: name.into(), function, start })
        };
        is("vrepAddOnScript_logger", "logger", false, StartMode::Automatic);
        is("vrepAddOnScript-logger", "logger", false, StartMode::OnRequest);
        is("simAddOnScript-a b", "a b", false, StartMode::OnRequest);
        is("vrepAddOnFunc_snap", "snap", true, StartMode::OnRequest);
        is("vrepAddOnFunction_snap", "snap", true, StartMode::OnRequest);
        is("simAddOnStepper", "Stepper", false, StartMode::ScriptDecides);
        is("pose_logger", "pose_logger", false, StartMode::ScriptDecides);
        is("simAddOn", "simAddOn", false, StartMode::ScriptDecides);
    }
}
