//! Dialects: the version of V-REP or CoppeliaSim for which a script was written.

use tatu_plugin_api::safe::*;

/// Checks that a dialect is a valid version number.
pub(crate) fn check_dialect(dialect: &str) -> Result {
    let digits = |p: &str| !p.is_empty() && p.len() < 5 && p.bytes().all(|b| b.is_ascii_digit());
    match dialect.split('.').all(digits) && dialect.split('.').count() <= 3 {
        true => Ok(()),
        false => Err(Fail::argument(
            "the version of V-REP for which the script was written, such as \"3.2\" (before 4.2: Lua 5.1, \
             scripts continue after errors) or \"4.9\" (Lua 5.4)",
        )),
    }
}

/// Parses a version: "4.10.1" is (4, 10).
pub(crate) fn version(dialect: &str) -> Option<(u32, u32)> {
    let mut parts = dialect.split('.').map(|p| p.trim().parse::<u32>().ok());
    Some((parts.next()??, parts.next().flatten().unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dialect_versions_are_compared_and_checked() {
        assert!(version("3.2") < version("4.2"));
        assert!(version("4.10") > version("4.2"));
        assert_eq!(version("modern"), None);
        assert!(["3.2", "4.10.1", "4"].iter().all(|d| check_dialect(d).is_ok()));
        assert!(["3,2", "modern", "3.x", "", "3.", "1.2.3.4"].iter().all(|d| check_dialect(d).is_err()));
    }
}
