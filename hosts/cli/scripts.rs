//! Summarizes the scripts and the parts of a run.

use serde_json::{Value, json};
use tatu_core::World;

/// Returns an array of `{object, kind, era, calls, instructions}`.
pub fn summarize(world: &World) -> Value {
    let one = |s: tatu_core::ScriptSummary| {
        json!({
            "object": s.object, "kind": s.kind, "era": era(&s.dialect), "calls": s.calls,
            "instructions": s.instructions,
        })
    };
    world.scripts().into_iter().map(one).collect()
}

/// Returns an array of `{object, kind, calls, wall_s, off}`. The real time differs from run to run.
pub fn summarize_parts(world: &World) -> Value {
    let one = |p: tatu_core::PartSummary| json!({ "object": p.object, "kind": p.kind, "calls": p.calls, "wall_s": p.seconds, "off": p.off });
    world.parts().into_iter().map(one).collect()
}

/// Returns the era of a dialect: A for versions up to 3.4, B for 3.5 to 4.1, C for 4.2 and later. The era is null if
/// the dialect is unknown because the source could not be loaded.
fn era(dialect: &str) -> Value {
    let mut parts = dialect.split('.').map(|p| p.parse::<u32>().ok());
    let version = (parts.next().flatten(), parts.next().flatten().unwrap_or(0));
    match version {
        (None, _) => Value::Null,
        (Some(major), minor) if (major, minor) < (3, 5) => "A".into(),
        (Some(major), minor) if (major, minor) < (4, 2) => "B".into(),
        _ => "C".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::era;

    #[test]
    fn dialects_are_assigned_to_eras() {
        // Expected eras: tests/facts/script-api.md, section 1.
        for (dialect, letter) in
            [("2.6", "A"), ("3.4.0", "A"), ("3.5", "B"), ("4.1", "B"), ("4.2.0", "C"), ("4.10", "C")]
        {
            assert_eq!(era(dialect), letter);
        }
        assert!(era("").is_null());
    }
}
