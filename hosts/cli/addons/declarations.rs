//! Extracts an add-on's declarations from its source, without running it.

use super::CallStyle;

/// Returns the first non-empty line of the comment at the start of a script, without comment markers; returns an
/// empty string if code comes first.
pub fn first_comment(text: &str) -> String {
    for line in text.lines().map(str::trim) {
        // Skip the byte order mark, blank lines, the shebang line, and comment lines without text.
        let line = line.trim_start_matches('\u{feff}');
        if line.is_empty() || line.starts_with("#!") {
            continue;
        }
        let Some(comment) = line.strip_prefix("--").or_else(|| line.strip_prefix('#')) else { return String::new() };
        let said = comment.trim_start_matches("[[").trim_end_matches("]]").trim_matches(['-', '=', '#', ' ', '\t']);
        if !said.is_empty() {
            return said.to_owned();
        }
    }
    String::new()
}

/// Infers from its source how a script is called. A script has the old style if it contains a name that only that style
/// uses, and no name that starts with `sysCall_`.
pub fn style(text: &str) -> CallStyle {
    let functions = text.contains("sysCall_");
    let old = text.contains("sim_call_type") || text.contains("sim_addonscriptcall_");
    if old && !functions { CallStyle::CallType } else { CallStyle::Callbacks }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_comment_line_is_extracted() {
        assert_eq!(first_comment("-- Writes poses.\n-- More."), "Writes poses.");
        assert_eq!(first_comment("#!/usr/bin/lua\n\n--------\n--  Stops a run. --\n"), "Stops a run.");
        assert_eq!(first_comment("--[[\n]]"), "");
        assert_eq!(first_comment("--[[ Draws. ]]"), "Draws.");
        assert_eq!(first_comment("x = 1 -- not this"), "");
    }

    #[test]
    fn call_style_is_inferred_from_names() {
        assert_eq!(style("if sim_call_type==sim_addonscriptcall_run then end"), CallStyle::CallType);
        assert_eq!(style("function sysCall_init() end -- was sim_call_type"), CallStyle::Callbacks);
        assert_eq!(style("print('hello')"), CallStyle::Callbacks);
    }
}
