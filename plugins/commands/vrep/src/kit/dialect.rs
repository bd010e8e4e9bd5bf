//! The V-REP version for which the calling script was written, and behaviour that depends on it.

use tatu_plugin_api::safe::Result;

use super::plugin::SharedCtx;

/// Returns the version for which the calling script was written, or the newest version if the script declares none.
pub(crate) fn version(c: &SharedCtx<'_>) -> (u32, u32) {
    version_of(c.caller_dialect())
}
pub(crate) fn version_of(dialect: &[u8]) -> (u32, u32) {
    // Fast path for the usual form `N.N`, because every version-dependent command calls this function.
    if let [major @ b'0'..=b'9', b'.', minor @ b'0'..=b'9'] = dialect {
        return (u32::from(major - b'0'), u32::from(minor - b'0'));
    }
    let number = |part: &[u8]| {
        let digits = part.trim_ascii();
        let value = |n: u32, b: &u8| b.is_ascii_digit().then(|| n * 10 + u32::from(b - b'0'));
        (1..9).contains(&digits.len()).then(|| digits.iter().try_fold(0, value)).flatten()
    };
    let mut parts = dialect.split(|b| *b == b'.').map(number);
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(major), minor) => (major, minor.unwrap_or(0)),
        _ => (4, 9),
    }
}
/// Returns whether the command was called by a flat name. Valid only for commands whose aliases are all flat.
pub(crate) fn flat(c: &SharedCtx<'_>) -> bool {
    c.alias() > 0
}
/// Returns whether the caller expects the behaviour before 4.2. For a caller without a version, this depends on the
/// name by which it called the command.
pub(crate) fn old_era(c: &SharedCtx<'_>) -> bool {
    if c.caller_dialect().is_empty() { flat(c) } else { version(c) < (4, 2) }
}
/// Finishes a setter: returns 1 to scripts written for versions before 4.2, and no value to newer ones.
pub(crate) fn finish_setter(c: &mut SharedCtx<'_>) -> Result {
    if old_era(c) {
        c.ret(1_i64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_parsed() {
        assert_eq!(version_of(b"3.2"), (3, 2));
        assert_eq!(version_of(b"2.6.11"), (2, 6));
        assert_eq!(version_of(b"4.10"), (4, 10));
        assert_eq!(version_of(b""), (4, 9));
    }
}
