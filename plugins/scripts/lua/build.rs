//! Compiles Lua from the sources in the crate `lua-src`, modified as listed in `build/charges.rs`, together with
//! `src/lua_internals.c`.
//!
//! `lua-src` can compile Lua itself but accepts no compiler flags, and flags in the variable `CFLAGS` would affect all
//! C code of the build.

#[path = "build/charges.rs"]
mod charges;

use std::{
    env,
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The version of `lua-src`, as in Cargo.toml, and the folder of Lua's sources in that crate.
const LUA_SRC: &str = "=551.0.2";
const LUA: &str = "lua-5.4.9";
const INTERNALS_C: &str = "src/lua_internals.c";
/// Headers included before every C file.
const HEADERS: [&str; 2] = ["src/lua_math.h", "src/lua_charges.h"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    // A test reads scripts that are not part of the repository; without them, it is ignored.
    println!("cargo::rustc-check-cfg=cfg(no_shared)");
    let shared = Path::new("../../../../shared/seeds/scripts");
    if shared.is_dir() {
        println!("cargo::rerun-if-changed={}", shared.display());
    } else {
        println!("cargo::rustc-cfg=no_shared");
    }
    println!("cargo::rerun-if-changed={INTERNALS_C}");
    println!("cargo::rerun-if-changed=build/charges.rs");
    let here = env::var("CARGO_MANIFEST_DIR")?;
    let lua = copy_with_charges(&lua_src_folder()?.join(LUA))?;
    let mut build = cc::Build::new();
    build.include(&lua).warnings(false).opt_level(3).file(INTERNALS_C);
    for entry in fs::read_dir(&lua)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "c") {
            build.file(path);
        }
    }
    if let Some(system) = match env::var("CARGO_CFG_TARGET_OS")?.as_str() {
        "linux" | "freebsd" | "netbsd" | "openbsd" | "dragonfly" => Some("LUA_USE_LINUX"),
        "macos" => Some("LUA_USE_MACOSX"),
        "windows" => Some("LUA_USE_WINDOWS"),
        _ => None,
    } {
        build.define(system, None);
    }
    if env::var("PROFILE")? == "debug" {
        build.define("LUA_USE_APICHECK", None);
    }
    build
        .define("LUA_COMPAT_5_3", None)
        // `src/lua_internals.rs` explains these definitions.
        .define("luai_makeseed(L)", "0x5EED")
        .define("STRCACHE_N", "1")
        .define("STRCACHE_M", "1")
        .define("strspn", "tatu_lua_strspn")
        // Fused multiply-add would produce different results on processors that support it.
        .flag_if_supported("-ffp-contract=off")
        .flag_if_supported("-fno-common");
    for header in HEADERS {
        println!("cargo::rerun-if-changed={header}");
        build.flag("-include").flag(Path::new(&here).join(header).to_string_lossy().as_ref());
    }
    build.try_compile("tatu_lua")?;
    Ok(())
}

/// Copies Lua's files and applies the edits of `CHARGES` to the copies; returns the folder of the copies.
fn copy_with_charges(lua: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let folder = Path::new(&env::var("OUT_DIR")?).join("lua");
    fs::create_dir_all(&folder)?;
    for entry in fs::read_dir(lua)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut text = fs::read_to_string(&path)?;
        for (_, before, after) in charges::CHARGES.iter().filter(|(file, ..)| *file == name) {
            if text.matches(before).count() != 1 {
                return Err(format!("{name} of {LUA} must contain this text exactly once: {before:?}").into());
            }
            text = text.replace(before, after);
        }
        fs::write(folder.join(name), text)?;
    }
    Ok(folder)
}

/// Returns the folder of `lua-src`, as reported by cargo for a generated package without other dependencies. Without a
/// network connection, cargo might be unable to resolve the whole workspace, because some dependencies may be missing.
fn lua_src_folder() -> Result<PathBuf, Box<dyn Error>> {
    let package = Path::new(&env::var("OUT_DIR")?).join("find-lua");
    fs::create_dir_all(package.join("src"))?;
    fs::write(package.join("src/lib.rs"), "")?;
    let manifest = package.join("Cargo.toml");
    let text = format!("[package]\nname = \"find-lua\"\n[dependencies]\nlua-src = \"{LUA_SRC}\"\n[workspace]\n");
    fs::write(&manifest, text)?;
    let mut cargo = Command::new(env::var("CARGO")?);
    cargo.args(["metadata", "--offline", "--format-version", "1", "--manifest-path"]).arg(&manifest);
    let answer = cargo.output()?;
    if !answer.status.success() {
        return Err(format!("cannot find lua-src {LUA_SRC}: {}", String::from_utf8_lossy(&answer.stderr)).into());
    }
    let answer: serde_json::Value = serde_json::from_slice(&answer.stdout)?;
    let packages = answer["packages"].as_array().into_iter().flatten();
    let manifest = packages.filter(|p| p["name"] == "lua-src").find_map(|p| p["manifest_path"].as_str());
    let folder = manifest.and_then(|m| Path::new(m).parent());
    Ok(folder.ok_or_else(|| format!("the output of cargo does not contain the path of lua-src {LUA_SRC}"))?.to_owned())
}
