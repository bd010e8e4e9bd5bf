//! The library was compiled under this name.

fn main() {
    println!("cargo::rustc-env=CARGO_PKG_NAME=tatu-plugin-api");
}
