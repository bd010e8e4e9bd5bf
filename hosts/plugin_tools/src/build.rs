//! `tatu plugin build`: compiles the library of a plugin.

use std::{
    ffi::OsString,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use tatu_core::{
    errors::{Error, Result},
    plugins::assets_folder,
};

use super::{assets, project::Project};
use tatu_terminal::report;

use crate::new::Lang;

#[derive(clap::Args)]
pub struct BuildArgs {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
}

/// Runs the command. The exit code is 0 on success, or 1 if the compiler failed. The compiler's messages are passed
/// through.
pub fn build(args: &BuildArgs) -> Result<ExitCode> {
    let project = Project::open(&args.folder)?;
    Ok(match build_project(&project)? {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// Builds the library; returns whether the compiler succeeded.
pub fn build_project(project: &Project) -> Result<bool> {
    fs::create_dir_all(project.build())
        .map_err(|e| failed(format!("cannot create {}: {e}", project.build().display())))?;
    let built = match project.lang {
        Lang::C | Lang::Cpp => compile(project)?,
        Lang::Rust => cargo(project)?,
    };
    if built {
        copy_assets(project)?;
        report::err!("built {}", project.library().display());
    }
    Ok(built)
}

/// Compiles all sources of the folder by one invocation of the compiler; the variables CC and CXX select another
/// compiler.
fn compile(project: &Project) -> Result<bool> {
    // The old library is replaced by a rename, because a running program may have it open.
    let new = project.build().join("new");
    let built = compile_to(project, &new, &["-O2"])?;
    if built {
        move_library(&new, &project.library())?;
    }
    Ok(built)
}

/// Compiles all sources of a project in C or C++ to this file, with further arguments of the compiler; returns whether
/// the compiler succeeded.
pub fn compile_to(project: &Project, file: &Path, more: &[&str]) -> Result<bool> {
    let (variable, suffixes, standard): (_, &[&str], _) = match project.lang {
        Lang::C => ("CC", &["c"], "-std=c11"),
        _ => ("CXX", &["cpp", "cc", "cxx"], "-std=c++17"),
    };
    let compiler = compiler_of(project.lang);
    let sources = sources(&project.folder, suffixes)?;
    let mut command = Command::new(&compiler[0]);
    command.args(&compiler[1..]).args([standard, "-Wall", "-Wextra"]).args(more);
    command.args(split_variable(if project.lang == Lang::C { "CFLAGS" } else { "CXXFLAGS" }).unwrap_or_default());
    command.arg(if cfg!(target_os = "macos") { "-dynamiclib" } else { "-shared" });
    if cfg!(unix) {
        command.args(["-fPIC", "-fvisibility=hidden"]);
    }
    command.arg("-I").arg(project.folder.join("sdk/include"));
    command.arg("-o").arg(file).args(sources);
    if cfg!(target_os = "linux") {
        command.args(["-lm", "-lpthread"]);
    }
    run(&mut command, &MissingTool { program: &compiler[0], variable, needs: "a compiler" })
}

/// Returns the program and the first arguments of the compiler for C or C++.
pub fn compiler_of(lang: Lang) -> Vec<OsString> {
    let (variable, default) = if lang == Lang::C { ("CC", "cc") } else { ("CXX", "c++") };
    split_variable(variable).filter(|w| !w.is_empty()).unwrap_or_else(|| vec![default.into()])
}

/// Runs `cargo build --release`, and copies the library to the project's folder `build`.
fn cargo(project: &Project) -> Result<bool> {
    // A target folder set in the environment takes precedence.
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| project.folder.join("target"), PathBuf::from);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(&cargo);
    command.args(["build", "--release", "--manifest-path"]).arg(project.folder.join("Cargo.toml"));
    command.arg("--target-dir").arg(&target);
    let built =
        run(&mut command, &MissingTool { program: &cargo, variable: "CARGO", needs: "Rust (https://rustup.rs)" })?;
    if built {
        let made = target.join("release").join(project.library_name());
        let new = project.build().join("new");
        fs::copy(&made, &new).map_err(|e| {
            failed(format!("cannot copy {}: {e}", made.display())).help(format!(
                "check that the package in Cargo.toml is named `tatu-{}`, and that its crate-type is \"cdylib\"",
                project.name
            ))
        })?;
        move_library(&new, &project.library())?;
    }
    Ok(built)
}

/// Returns the sources in a folder, in order of their names.
fn sources(folder: &Path, suffixes: &[&str]) -> Result<Vec<PathBuf>> {
    let read = fs::read_dir(folder).map_err(|e| failed(format!("cannot read {}: {e}", folder.display())))?;
    // Hidden files are skipped: editors and file managers create them next to sources.
    let hidden = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
    let is_source =
        |p: &PathBuf| p.extension().is_some_and(|e| suffixes.iter().any(|s| e == *s)) && p.is_file() && !hidden(p);
    let mut all: Vec<PathBuf> = read.flatten().map(|e| e.path()).filter(is_source).collect();
    all.sort();
    if all.is_empty() {
        return Err(failed(format!("there are no source files in {}", folder.display()))
            .expected(format!("files that end with .{}", suffixes.join(", ."))));
    }
    Ok(all)
}

/// What the error about a missing compiler contains.
struct MissingTool<'a> {
    program: &'a OsString,
    variable: &'a str,
    needs: &'a str,
}

/// Runs a compiler with inherited standard streams; returns whether it succeeded.
fn run(command: &mut Command, missing: &MissingTool<'_>) -> Result<bool> {
    let shown: Vec<_> = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect();
    report::err!("{} {}", missing.program.display(), shown.join(" "));
    match command.status() {
        Ok(status) => Ok(status.success()),
        Err(e) if e.kind() == ErrorKind::NotFound => {
            Err(failed(format!("there is no `{}`", missing.program.display())).help(format!(
                "install {}, or set the environment variable {} to the program to use instead",
                missing.needs, missing.variable
            )))
        }
        Err(e) => Err(failed(format!("cannot run `{}`: {e}", missing.program.display()))),
    }
}

/// Splits the value of an environment variable at white space.
fn split_variable(variable: &str) -> Option<Vec<OsString>> {
    let text = std::env::var(variable).ok()?;
    Some(text.split_whitespace().map(OsString::from).collect())
}

fn move_library(new: &Path, library: &Path) -> Result {
    fs::rename(new, library).map_err(|e| failed(format!("cannot write {}: {e}", library.display())))
}

/// Copies the project's folder `assets/` to the location beside its library where the plugin searches for it.
fn copy_assets(project: &Project) -> Result {
    let from = project.folder.join("assets");
    match assets_folder(&project.library()) {
        Some(to) if from.is_dir() => assets::replace(&from, &to)
            .map_err(|e| failed(format!("cannot copy {} to {}: {e}", from.display(), to.display()))),
        _ => Ok(()),
    }
}

fn failed(text: impl Into<String>) -> Error {
    Error::new("E612", text)
}
