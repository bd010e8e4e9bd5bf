//! Gathers the contents of a wheel besides the module: the plugins, the library with which plugins are tested, scenes,
//! models and add-ons, and the declarations of commands for type checkers. Does nothing unless maturin builds a wheel.
//!
//! A build script has no access to the plugin libraries of the same build. Therefore it runs a separate cargo process
//! with a separate target folder to build them. If `TATU_WHEEL_PLUGINS` is the path of a folder that contains a program
//! and its plugins, those are copied instead; they may have been built for an older system.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process::Command,
};

type Result<T = ()> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result {
    println!("cargo::rerun-if-env-changed=TATU_WHEEL_PLUGINS");
    if env::var_os("CARGO_FEATURE_WHEEL").is_none() {
        return Ok(());
    }
    let own = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let root = own.ancestors().nth(2).ok_or("the package is not in a folder of the workspace")?.to_owned();
    let hosts = ["hosts/cli", "hosts/embed", "hosts/render", "hosts/testhost"];
    let others = ["engine", "core", "plugin-api", "plugins", "scenes", "models", "addons", "Cargo.lock"];
    for part in hosts.iter().chain(&others) {
        println!("cargo::rerun-if-changed={}", root.join(part).display());
    }
    let built = match env::var_os("TATU_WHEEL_PLUGINS") {
        Some(folder) => PathBuf::from(folder),
        None => build(&root)?,
    };
    let package = own.join("tatu_sim");
    for folder in ["plugins", "scenes", "models", "addons"] {
        let folder = package.join(folder);
        if folder.is_dir() {
            fs::remove_dir_all(&folder)?;
        }
    }
    plugins(&root, &built, &package.join("plugins"))?;
    // The library with which plugins are tested is beside the program.
    copy_library(&built, "libtatuhost.so", &package)?;
    for folder in ["scenes", "models", "addons"] {
        copy_tree(&root.join(folder), &package.join(folder))?;
    }
    stubs(&built, &package)
}

/// Builds the program and its plugins; returns the folder of the program.
fn build(root: &Path) -> Result<PathBuf> {
    let target = root.join("target/wheel");
    let mut command = Command::new(env::var("CARGO")?);
    command.current_dir(root).args(["build", "--release", "-p", "tatu"]).arg("--target-dir").arg(&target);
    // Variables that the outer cargo sets for build scripts must not affect the inner cargo.
    for (name, _) in env::vars_os() {
        let name = name.to_string_lossy().into_owned();
        let is_for_script = ["CARGO_FEATURE_", "CARGO_CFG_", "CARGO_PKG_", "CARGO_MANIFEST_", "DEP_"];
        let is_for_script = is_for_script.iter().any(|start| name.starts_with(start));
        if is_for_script
            || ["TARGET", "OUT_DIR", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"].contains(&name.as_str())
        {
            command.env_remove(name);
        }
    }
    match command.status()?.success() {
        true => Ok(target.join("release")),
        false => Err("the plugins could not be built; see the messages above".into()),
    }
}

/// Copies the libraries of the plugins that belong to the program.
fn plugins(root: &Path, built: &Path, to: &Path) -> Result {
    let manifest = fs::read_to_string(root.join("Cargo.toml"))?;
    let names = manifest.lines().filter_map(|line| {
        let (name, rest) = line.split_once(" = { path = \"plugins/")?;
        rest.contains('"')
            .then(|| format!("libtatu_{}.so", name.strip_prefix("tatu-").unwrap_or(name).replace('-', "_")))
    });
    fs::create_dir_all(to)?;
    names.into_iter().try_for_each(|name| copy_library(built, &name, to))
}

fn copy_library(built: &Path, name: &str, to: &Path) -> Result {
    let places = [built.join("deps").join(name), built.join(name)];
    let from = places.iter().find(|p| p.is_file());
    let from = from.ok_or_else(|| format!("{} has no {name}", built.display()))?;
    fs::copy(from, to.join(name))?;
    Ok(())
}

/// Copies a folder of the repository, without hidden files and files that programs have generated.
fn copy_tree(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let path = entry?.path();
        let Some(name) = path.file_name() else { continue };
        let shown = name.to_string_lossy();
        if shown.starts_with('.') || shown == "__pycache__" || shown.contains(".recovery") {
            continue;
        }
        match path.is_dir() {
            true => copy_tree(&path, &to.join(name))?,
            false => drop(fs::copy(&path, to.join(name))?),
        }
    }
    Ok(())
}

/// Writes the declarations of commands, for type checkers and editors.
fn stubs(built: &Path, package: &Path) -> Result {
    let program = built.join("tatu");
    let out =
        Command::new(&program).args(["generate", "python"]).env("TATU_PLUGIN_PATH", package.join("plugins")).output();
    let out = out.map_err(|e| format!("cannot start {}: {e}", program.display()))?;
    if !out.status.success() {
        return Err(format!("{} generate python: {}", program.display(), String::from_utf8_lossy(&out.stderr)).into());
    }
    fs::write(package.join("_commands.pyi"), out.stdout)?;
    Ok(())
}
