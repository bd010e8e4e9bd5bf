//! What a plugin in Rust cannot do without `unsafe`: programs that must not compile, each with what the compiler says.
//!
//! Its words change from version to version: with another compiler than the one below only a line tells that nothing was
//! tried. `TRYBUILD=overwrite cargo test -p tatu-plugin-api --test misuse` writes the words of a new one.

use std::process::Command;

/// The compiler whose words are recorded.
const COMPILER: &str = "rustc 1.95.";

#[test]
fn misuse_does_not_compile() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let told = Command::new(rustc).arg("--version").output().map(|out| out.stdout).unwrap_or_default();
    let told = String::from_utf8_lossy(&told);
    if !told.starts_with(COMPILER) && std::env::var_os("TRYBUILD").is_none() {
        eprintln!("not tried: the words are those of {COMPILER}, and this is {told}");
        return;
    }
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
