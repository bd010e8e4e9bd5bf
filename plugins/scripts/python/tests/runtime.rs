//! Runs the tests of the runtime, which are written in Python, with the interpreter of the system.
#![cfg(unix)]

use std::process::Command;

#[test]
fn the_runtime_passes_its_own_tests() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/test_runtime.py");
    let done = Command::new("python3").arg("-B").arg(file).output().expect("python3 cannot be started");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
