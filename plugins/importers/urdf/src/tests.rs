//! Tests with malformed files: any bytes must result in a robot or an error.

use proptest::prelude::*;

use super::*;

const ROBOT: &[u8] = include_bytes!("../robot.urdf");

/// Runs the importer up to the creation of objects, and returns the number of bodies.
fn bodies(bytes: &[u8]) -> Result<usize> {
    let text = std::str::from_utf8(bytes).map_err(|_| Fail::new("not text"))?;
    Ok(BodyTree::new(&read::file(text, &Findings::default())?.robot)?.bodies.len())
}

/// Returns a chain of links; `joint` is the type of its joints.
fn chain(links: usize, joint: &str) -> String {
    let mut out = String::from("<robot name=\"chain\"><link name=\"l0\"/>");
    for i in 1..links {
        out += &format!(
            "\n<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"{joint}\"><parent link=\"l{}\"/><child link=\"l{i}\"/></joint>",
            i - 1
        );
    }
    out + "</robot>"
}

#[test]
fn example_robot_has_three_bodies() {
    assert_eq!(bodies(ROBOT).unwrap(), 3);
    assert!(Urdf::sniff(ROBOT) > 50 && Urdf::sniff(b"<sdf><robot/></sdf>") == 0 && Urdf::sniff(b"format = 1") == 0);
    assert!(Urdf::sniff(b"\xEF\xBB\xBF<?xml version='1.0'?><!-- <a> --><robot>") > 50);
}

#[test]
fn truncated_file_is_an_error() {
    let end = ROBOT.windows(8).rposition(|w| w == b"</robot>").unwrap() + 8;
    for n in (0..end).step_by(64).chain(end - 20..end) {
        let e = bodies(&ROBOT[..n]).expect_err("a truncated file is an error");
        assert!(!e.text().is_empty() && !e.text().contains("panic"), "{n}: {e}");
    }
}

#[test]
fn nesting_and_joint_chains_are_limited() {
    assert_eq!(bodies(chain(200, "continuous").as_bytes()).unwrap(), 200);
    assert_eq!(bodies(chain(200, "fixed").as_bytes()).unwrap(), 1);
    let e = bodies(chain(1000, "fixed").as_bytes()).unwrap_err();
    assert!(e.text().contains("longer than 256"), "{e}");
    let deep = format!("<robot>{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    assert!(bodies(deep.as_bytes()).unwrap_err().text().contains("64 levels deep"));
    let doctype = "<!DOCTYPE r [<!ENTITY a \"aaaa\">]><robot name=\"&a;\"><link name=\"x\"/></robot>";
    assert!(bodies(doctype.as_bytes()).unwrap_err().text().contains("document type"));
}

#[test]
fn loops_and_separate_trees_are_errors() {
    let with = |joints: &[(&str, &str)], links: &[&str]| {
        let links: String = links.iter().map(|l| format!("<link name=\"{l}\"/>")).collect();
        let joint = |(i, (p, c)): (usize, &(&str, &str))| {
            format!("<joint name=\"j{i}\" type=\"fixed\"><parent link=\"{p}\"/><child link=\"{c}\"/></joint>")
        };
        let joints: String = joints.iter().enumerate().map(joint).collect();
        bodies(format!("<robot name=\"r\">{links}{joints}</robot>").as_bytes())
    };
    let fails = |r: Result<usize>, word: &str| {
        let e = r.unwrap_err();
        assert!(e.text().contains(word) && e.place().is_some_and(|(_, l)| l == 1), "{e}");
    };
    fails(with(&[("a", "b"), ("b", "a")], &["a", "b"]), "loop");
    fails(with(&[("a", "b"), ("b", "a")], &["a", "b", "c"]), "form a loop");
    fails(with(&[("a", "a")], &["a"]), "to itself");
    fails(with(&[], &["a", "b"]), "is not connected");
    fails(with(&[("a", "c"), ("b", "c")], &["a", "b", "c"]), "two parent joints");
    fails(with(&[("a", "x")], &["a"]), "`x`");
    fails(with(&[], &[]), "no links");
}

proptest! {
    #[test]
    fn any_bytes_are_answered(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = bodies(&bytes);
    }

    /// A valid robot with one changed byte results in a robot or an error.
    #[test]
    fn any_change_is_answered(at in 0..ROBOT.len(), to in 32u8..127) {
        let mut bytes = ROBOT.to_vec();
        bytes[at] = to;
        let _ = bodies(&bytes);
    }
}
