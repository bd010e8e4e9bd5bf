//! Finds objects by paths, and by old unique names, to which the suffix of the calling script is appended.

use std::borrow::Cow;

use crate::{kit::*, state::state};

/// Returns the unique name to which a name refers in a script with the given suffix: with suffix 2, `motor` refers to
/// `motor#2`. A name that has a suffix is unchanged, and `motor#` refers exactly to `motor`.
pub(crate) fn adjust_suffix(name: &str, suffix: i64) -> Cow<'_, str> {
    match name.find('#') {
        Some(i) if i + 1 == name.len() => name[..i].into(),
        None if suffix >= 0 => format!("{name}#{suffix}").into(),
        _ => name.into(),
    }
}

/// Splits a name into the part before its suffix and the suffix, which is -1 if there is none.
pub(crate) fn split(name: &str) -> (&str, i64) {
    name.rsplit_once('#')
        .and_then(|(base, n)| n.parse().ok().filter(|n| *n >= 0).map(|n| (base, n)))
        .unwrap_or((name, -1))
}

/// Returns the suffix that the calling script has set, by default the suffix of its object's name.
pub(crate) fn suffix(c: &Ctx<'_>) -> Result<i64> {
    if let Some(chosen) = state(c)?.script_values.suffixes.get(&c.caller_script()) {
        return Ok(*chosen);
    }
    match c.caller_object() {
        0 => Ok(-1),
        object => Ok(split(&text_of(c, object, c.plugin().p.name)?).1),
    }
}

/// Finds an object by unique name, or by path if `name` is a path.
pub(crate) fn find(c: &Ctx<'_>, name: &str) -> Result<tatu_object> {
    if is_path(name) {
        return find_path(c, name, None);
    }
    let wanted = adjust_suffix(name, suffix(c)?);
    c.world()
        .find(0, &wanted)
        .map_err(|e| if e.code() == TATU_ERR_MISSING { missing(c, &wanted, c.plugin().p.name) } else { e })
}

/// Like [`find`], but creates a missing object in a run without a scene.
pub(crate) fn find_or_create(c: &Ctx<'_>, name: &str) -> Result<tatu_object> {
    if is_path(name) {
        return find_path_or_create(c, name, None);
    }
    find(c, name).or_else(|e| {
        let below = |e: Fail| c.world().stand_in(stand_in_parent(c), &adjust_suffix(name, suffix(c)?), "").ok_or(e);
        if e.code() == TATU_ERR_MISSING { below(e) } else { Err(e) }
    })
}

/// Like [`find_path`], but creates a missing object in a run without a scene.
pub(crate) fn find_path_or_create(c: &Ctx<'_>, path: &str, base: Option<tatu_object>) -> Result<tatu_object> {
    find_path(c, path, base).or_else(|e| {
        let ask = || {
            let (at, rest) = start(c, path, base).ok()?;
            let rest = if at == 0 { rest.into() } else { format!(".{rest}") };
            c.world().stand_in(at, &rest, "")
        };
        if e.code() == TATU_ERR_MISSING { ask().ok_or(e) } else { Err(e) }
    })
}

/// Returns the object below which a missing object with a unique name is created: the base of the caller's model or, if
/// there is none, the caller's object.
fn stand_in_parent(c: &Ctx<'_>) -> tatu_object {
    let own = c.caller_object();
    match model(c, own) {
        Ok(base) if base != 0 => base,
        _ => own,
    }
}

/// Returns whether a name is a path, as opposed to a unique name, which cannot begin with `/`, `.` or `:`.
pub(crate) fn is_path(name: &str) -> bool {
    name.starts_with(['/', '.', ':'])
}

/// Finds an object by path: "/a/b", ".", "../b", ":/b", "::". Relative paths start at `base` or at the caller. Since
/// 4.7, scripts are separate objects: "." is the script, and ".." is the object to which it belongs.
pub(crate) fn find_path(c: &Ctx<'_>, path: &str, base: Option<tatu_object>) -> Result<tatu_object> {
    let (at, rest) = start(c, path, base)?;
    if rest.is_empty() && path.ends_with('/') {
        return Err(Fail::missing(format!("`{path}`: expected a name after the last `/`")));
    }
    if rest.is_empty() {
        return Ok(at);
    }
    let (rest, nth) = split_ordinal(rest);
    let found = match nth {
        Some(n) => return nth_of_alias(c, at, rest, n),
        None if at == 0 => c.world().find(0, rest),
        None => c.world().find(at, &format!(".{rest}")),
    };
    found.map_err(|e| match e.code() {
        TATU_ERR_MISSING if e.help_text().is_none() => missing(c, path, c.plugin().p.path),
        _ => e,
    })
}

/// Returns the object from which a path starts (0 for the scene), and the rest of the path.
fn start<'p>(c: &Ctx<'_>, path: &'p str, base: Option<tatu_object>) -> Result<(tatu_object, &'p str)> {
    let (steps, rest) = leading_steps(path);
    let mut at = 0;
    if !steps.is_empty() {
        at = match base {
            Some(base) => base,
            None if version(c) >= (4, 7) && steps[0] != RelativeStep::Model => c.caller_script(),
            None => c.caller_object(),
        };
        // For a caller without an object, such as a remote client, the path starts at the scene.
        if at == 0 && steps == [RelativeStep::Here] && !rest.is_empty() {
            return Ok((0, rest));
        }
        if at == 0 {
            let e = Fail::missing(format!("`{path}` is relative to the caller, which does not belong to an object"));
            at = c.world().stand_in(0, "/model", "").ok_or(e)?;
        }
    }
    for (i, step) in steps.iter().enumerate() {
        at = match step {
            RelativeStep::Here => at,
            RelativeStep::Up => parent(c, at)?,
            RelativeStep::Model => model(c, if i == 0 { at } else { parent(c, at)? })?,
        };
        // If no model contains the caller, `:/x` searches the whole scene.
        let whole = *step == RelativeStep::Model && i + 1 == steps.len() && !rest.is_empty();
        if at == 0 && !whole {
            let e = Fail::missing(format!("`{path}` refers to an object above the root of the scene"));
            at = c.world().stand_in(0, "/above", "").ok_or(e)?;
        }
    }
    // Scripts have no children, so "./x" refers to a child of the object to which the script belongs.
    if base.is_none() && at != 0 && at == c.caller_script() && !rest.is_empty() {
        at = c.caller_object();
    }
    Ok((at, rest))
}

#[derive(Debug, PartialEq, Clone, Copy)]
enum RelativeStep {
    Here,
    Up,
    Model,
}

/// Splits a path into its leading relative steps and the rest, which is empty or starts with "/".
fn leading_steps(path: &str) -> (Vec<RelativeStep>, &str) {
    let (mut steps, mut rest) = (Vec::new(), path);
    loop {
        let head = rest.split('/').next().unwrap_or_default();
        match head {
            "." => steps.push(RelativeStep::Here),
            ".." => steps.push(RelativeStep::Up),
            _ if !head.is_empty() && head.bytes().all(|b| b == b':') && steps.is_empty() => {
                steps.extend(head.bytes().map(|_| RelativeStep::Model));
            }
            _ => return (steps, rest),
        }
        rest = &rest[head.len()..];
        // Only ".." continues the relative part; everything else belongs to the rest.
        match rest.strip_prefix('/') {
            Some(next) if next.starts_with("..") => rest = next,
            Some("") => return (steps, ""),
            _ => return (steps, rest),
        }
    }
}

/// Splits "/a/b{3}" into "/a/b" and 3.
fn split_ordinal(path: &str) -> (&str, Option<usize>) {
    path.strip_suffix('}')
        .and_then(|p| p.rsplit_once('{'))
        .and_then(|(p, n)| n.parse().ok().map(|n| (p, Some(n))))
        .unwrap_or((path, None))
}

/// Finds the `n`-th object, from 0, whose alias is the last part of `path`, in breadth-first order below the object
/// that the other parts identify, or below `at` if there are no other parts.
pub(crate) fn nth_of_alias(c: &Ctx<'_>, at: tatu_object, path: &str, n: usize) -> Result<tatu_object> {
    let w = c.world();
    let (above, alias) = path.rsplit_once('/').unwrap_or(("", path));
    let base = match (above.is_empty(), at) {
        (true, _) => at,
        (false, 0) => w.find(0, above)?,
        (false, _) => w.find(at, &format!(".{above}"))?,
    };
    let mut left = n;
    for o in w.list(base, 0, if base == 0 { 0 } else { TATU_LIST_SKIP_BASE })? {
        if text_of(c, o, c.plugin().p.alias)? == alias {
            if left == 0 {
                return Ok(o);
            }
            left -= 1;
        }
    }
    Err(Fail::missing(format!("there is no object `{path}` with the index {n}")))
}

/// Returns the model base at or above an object, or 0 if there is none.
fn model(c: &Ctx<'_>, mut at: tatu_object) -> Result<tatu_object> {
    while at != 0 && !bool_of(c, at, c.plugin().p.model_base).unwrap_or(false) {
        at = parent(c, at)?;
    }
    Ok(at)
}

/// Builds the error for a missing object, which suggests the most similar names.
#[cold]
fn missing(c: &Ctx<'_>, wanted: &str, by: Prop) -> Fail {
    let fail = Fail::missing(format!("there is no object `{wanted}`"));
    let known: Vec<String> =
        c.world().list(0, 0, 0).unwrap_or_default().iter().filter_map(|o| text_of(c, *o, by).ok()).collect();
    match nearest(wanted, &known).as_slice() {
        [] => fail,
        near => fail.help(format!("did you mean {}?", near.join(" or "))),
    }
}

/// Returns up to three names that resemble `wanted`, the most similar first.
fn nearest(wanted: &str, known: &[String]) -> Vec<String> {
    // The comparison takes time in proportion to the product of the lengths.
    const MAX_NAME_BYTES: usize = 200;
    if wanted.len() > MAX_NAME_BYTES {
        return Vec::new();
    }
    let limit = (wanted.len() / 3).max(2);
    let mut near: Vec<(usize, &String)> = known
        .iter()
        .filter(|k| k.len().abs_diff(wanted.len()) <= limit)
        .map(|k| (distance(wanted.as_bytes(), k.as_bytes()), k))
        .filter(|(d, _)| *d <= limit)
        .collect();
    near.sort();
    near.iter().take(3).map(|(_, k)| format!("`{k}`")).collect()
}

/// Returns the edit distance between two names.
fn distance(a: &[u8], b: &[u8]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let change = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = change.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffix_of_the_script_is_applied_to_names() {
        assert_eq!(adjust_suffix("motor", -1), "motor");
        assert_eq!(adjust_suffix("motor", 0), "motor#0");
        assert_eq!(adjust_suffix("motor", 2), "motor#2");
        assert_eq!(adjust_suffix("motor#5", 2), "motor#5");
        assert_eq!(adjust_suffix("motor#", 2), "motor");
        assert_eq!(adjust_suffix("motor#", -1), "motor");
    }

    #[test]
    fn suffixes_are_split() {
        assert_eq!(split("a#42"), ("a", 42));
        assert_eq!(split("a"), ("a", -1));
        assert_eq!(split("a#"), ("a#", -1));
        assert_eq!(split("a#b"), ("a#b", -1));
    }

    #[test]
    fn paths_are_split_into_steps_and_ordinals() {
        use RelativeStep::*;
        assert_eq!(leading_steps("/a/b"), (vec![], "/a/b"));
        assert_eq!(leading_steps("."), (vec![Here], ""));
        assert_eq!(leading_steps("./b"), (vec![Here], "/b"));
        assert_eq!(leading_steps(".."), (vec![Up], ""));
        assert_eq!(leading_steps("../"), (vec![Up], ""));
        assert_eq!(leading_steps("../../b"), (vec![Up, Up], "/b"));
        assert_eq!(leading_steps(":/b"), (vec![Model], "/b"));
        assert_eq!(leading_steps("::"), (vec![Model, Model], ""));
        assert_eq!(split_ordinal("/a{3}"), ("/a", Some(3)));
        assert_eq!(split_ordinal("/a[3]"), ("/a[3]", None));
    }

    #[test]
    fn similar_names_are_suggested() {
        let known = ["leftMotor", "rightMotor", "box"].map(String::from);
        assert_eq!(nearest("leftMotro", &known), ["`leftMotor`"]);
        assert!(nearest("completelyElse", &known).is_empty());
        assert_eq!(distance(b"kitten", b"sitting"), 3);
    }
}
