//! What a plugin in Rust cannot do without `unsafe`: programs that must not compile, each with the compiler's words.
//!
//! The words are those of the compiler in `rust-toolchain.toml`. With a new one,
//! `TRYBUILD=overwrite cargo test -p tatu-plugin-api --test misuse` writes them anew.

#[test]
fn misuse_does_not_compile() {
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
