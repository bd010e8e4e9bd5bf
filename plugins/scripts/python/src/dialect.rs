//! Dialects: the version of CoppeliaSim for which a script was written.

use tatu_plugin_api::{abi::*, safe::*};

/// Checks that a dialect is a valid version number.
pub(crate) fn check(dialect: &str) -> Result {
    let digits = |p: &str| !p.is_empty() && p.len() < 5 && p.bytes().all(|b| b.is_ascii_digit());
    match dialect.split('.').all(digits) && dialect.split('.').count() <= 3 {
        true => Ok(()),
        false => Err(Fail::argument("the version of CoppeliaSim for which the script was written, such as \"4.9\"")),
    }
}

/// Parses a version: "4.10.1" is (4, 10).
fn version(dialect: &str) -> Option<(u32, u32)> {
    let mut parts = dialect.split('.').map(|p| p.trim().parse::<u32>().ok());
    Some((parts.next()??, parts.next().flatten().unwrap_or(0)))
}

/// Returns the `TATU_ORDER_*` value for the dialect of a scene: that of the latest version in `orders` that is not
/// newer, or 0 if the scene has no dialect.
pub(crate) fn order(orders: &[(String, String)], dialect: &str) -> u32 {
    let Some(wanted) = version(dialect) else { return 0 };
    let last = orders.iter().rev().find(|(since, _)| version(since).is_some_and(|v| v <= wanted));
    match last.map(|(_, order)| order.as_str()) {
        Some("parents_first") => TATU_ORDER_PARENTS_FIRST,
        Some("by_kind") => TATU_ORDER_BY_KIND,
        Some("deepest_first") => TATU_ORDER_DEEPEST_FIRST,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_that_of_the_latest_version_that_is_not_newer() {
        let orders = [("0", "parents_first"), ("3.6", "by_kind"), ("4.4", "deepest_first")];
        let orders = orders.map(|(since, order)| (since.to_owned(), order.to_owned()));
        for (dialect, expected) in [
            ("3.2", TATU_ORDER_PARENTS_FIRST),
            ("4.3", TATU_ORDER_BY_KIND),
            ("4.10", TATU_ORDER_DEEPEST_FIRST),
            ("", 0),
            ("modern", 0),
        ] {
            assert_eq!(order(&orders, dialect), expected, "{dialect}");
        }
    }

    #[test]
    fn dialects_that_are_not_versions_are_refused() {
        assert!(["4.6", "4.10.1", "5"].iter().all(|d| check(d).is_ok()));
        assert!(["4,6", "new", "4.x", "", "4."].iter().all(|d| check(d).is_err()));
    }
}
