//! What a plugin in Rust cannot do without `unsafe`: programs that must not compile, each with what the compiler says.
//!
//! Its words change from version to version: `TRYBUILD=overwrite cargo test -p tatu-plugin-api` writes them anew.

#[test]
fn misuse_does_not_compile() {
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
