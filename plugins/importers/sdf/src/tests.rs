//! Tests with malformed files: any bytes must result in models or an error.

use proptest::prelude::*;

use super::*;

const ROVER: &str = include_str!("../rover.sdf");

/// Reads a text without its includes, up to the poses of all links. Returns the number of links.
fn count_links(text: &str) -> Result<usize> {
    let findings = Findings::default();
    let root = xml::parse(text, 0)?;
    let draft = model::FileDraft::new(root.child("world").unwrap_or(&root), &findings)?;
    draft.links.iter().try_for_each(|link| draft.frames.world(link.frame).map(drop))?;
    Ok(draft.links.len())
}

/// Returns a model with links in a row, of which each is joined to the one before.
fn chain(links: usize) -> String {
    let link = |i: usize| {
        let joint =
            format!("<joint name='j{i}' type='fixed'><parent>l{}</parent><child>l{i}</child></joint>", i.max(1) - 1);
        format!(
            "<link name='l{i}'><pose relative_to='l{}'/></link>{}",
            (i + 1) % links,
            if i > 0 { joint } else { String::new() }
        )
    };
    format!("<sdf version='1.9'><model name='m'>{}</model></sdf>", (0..links).map(link).collect::<String>())
}

#[test]
fn the_example_has_three_links() {
    assert_eq!(count_links(ROVER).unwrap(), 3);
    assert!(Sdf::sniff(ROVER.as_bytes()) > 80 && Sdf::sniff(b"<robot><sdf/></robot>") == 0);
    assert!(Sdf::sniff(b"\n <?xml version='1.0'?><!-- --a -- --><sdf version='1.6'>") > 50);
    assert_eq!([&b"format = 1"[..], b"", b"<mujoco/>"].map(Sdf::sniff), [0; 3]);
}

#[test]
fn hostile_files_are_errors() {
    let fails = |text: &str, word: &str| {
        let e = count_links(text).unwrap_err();
        assert!(e.text().contains(word) && e.place().is_some(), "{e}");
    };
    fails(&chain(100), "poses depend on each other");
    fails(&format!("<sdf>{}{}</sdf>", "<a>".repeat(100_000), "</a>".repeat(100_000)), "64 levels deep");
    fails("<!DOCTYPE s [<!ENTITY a 'aaaa'>]><sdf>&a;</sdf>", "document type");
    fails(&format!("<sdf {}/>", (0..300).map(|i| format!("a{i}='' ")).collect::<String>()), "attributes");
    fails("<sdf><model name='m'><link name='l'><pose>1e300 0 0 0 0 0</pose></link></model></sdf>", "out of range");
    fails("<sdf><model name='m'><link name='l'><pose relative_to='x'/></link></model></sdf>", "named `x`");
    fails("<sdf><model name='m'><joint name='j'/></model></sdf>", "has no <child>");
    fails("<sdf><model name='m'><link/></model></sdf>", "a link has no name");
    fails("<sdf>", "incomplete");
}

#[test]
fn a_truncated_file_is_an_error() {
    let end = ROVER.rfind("</sdf>").unwrap() + 6;
    for n in (0..end).step_by(41).chain(end - 20..end) {
        assert!(!count_links(&ROVER[..n]).unwrap_err().text().is_empty(), "{n}");
    }
}

proptest! {
    #[test]
    fn any_text_is_answered(text in "[<>/=!?&;:' \"a-z\\n-]{0,200}") {
        let _ = count_links(&text);
    }

    /// A valid file with one changed byte results in models or an error.
    #[test]
    fn any_change_is_answered(at in 0..ROVER.len(), to in 32u8..127) {
        let mut bytes = ROVER.as_bytes().to_vec();
        bytes[at] = to;
        let _ = count_links(&String::from_utf8_lossy(&bytes));
    }
}
