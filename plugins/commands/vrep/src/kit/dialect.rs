//! Which version the calling script was written for, and what differs by it.

use tatu_plugin_api::safe::Result;

use super::plugin::Shared;

/// The version whose manners the calling script was written for; without one, the newest.
pub(crate) fn version(c: &Shared<'_>) -> (u32, u32) {
    version_of(c.caller_dialect())
}
pub(crate) fn version_of(dialect: &[u8]) -> (u32, u32) {
    // Bytes, not a text: each call asks that makes a difference between versions. This is how they mostly look.
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
/// Whether the command was called by a flat name; for commands that have no other names than `sim.x` and flat ones.
pub(crate) fn flat(c: &Shared<'_>) -> bool {
    c.alias() > 0
}
/// Whether the caller expects what scripts of before 4.2 got; who has no version, by the name that was called.
pub(crate) fn old_era(c: &Shared<'_>) -> bool {
    if c.caller_dialect().is_empty() { flat(c) } else { version(c) < (4, 2) }
}
/// A setter has done its work: 1 in the old days, nothing since.
pub(crate) fn done(c: &mut Shared<'_>) -> Result {
    if old_era(c) {
        c.ret(1_i64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dialects() {
        assert_eq!(version_of(b"3.2"), (3, 2));
        assert_eq!(version_of(b"2.6.11"), (2, 6));
        assert_eq!(version_of(b"4.10"), (4, 10));
        assert_eq!(version_of(b""), (4, 9));
    }
}
