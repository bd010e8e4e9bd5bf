//! Tests that the types prevent misuse in safe Rust: programs that must not compile, each with the expected output of
//! the compiler.
//!
//! The output is that of the compiler in `rust-toolchain.toml`. For a new compiler, update it with
//! `TRYBUILD=overwrite cargo test -p tatu-plugin-api --test misuse`.

#[test]
fn misuse_does_not_compile() {
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
