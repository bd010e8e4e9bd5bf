//! Builds a project with the sanitizers of its compiler, for `--sanitize`.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use tatu_core::errors::{Error, Result};

use crate::{build, new::Lang, project::Project};

/// Arguments of the compiler. A sanitizer ends the process at the first error.
const FLAGS: [&str; 5] =
    ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-fno-omit-frame-pointer"];
/// Options of the sanitizers. The handlers of signals are those of the program, and leaks are found by a test.
pub const OPTIONS: [(&str, &str); 2] = [
    (
        "ASAN_OPTIONS",
        "detect_leaks=0:handle_segv=0:handle_sigbus=0:handle_abort=0:use_sigaltstack=0:verify_asan_link_order=0:\
         allocator_may_return_null=1:detect_odr_violation=0:abort_on_error=1",
    ),
    ("UBSAN_OPTIONS", "print_stacktrace=1:abort_on_error=1"),
];

/// A library that was built with sanitizers.
pub struct SanitizedLibrary {
    pub library: PathBuf,
    /// The library of the sanitizer, which must be loaded before all others.
    pub preload: PathBuf,
    _folder: tempfile::TempDir,
}

/// Builds the project in a folder with sanitizers.
pub fn build_sanitized(folder: &Path) -> Result<SanitizedLibrary> {
    let cannot = |text: String| Error::new("E102", format!("`--sanitize` is not possible: {text}"));
    let project = Project::open(folder)?;
    if project.lang == Lang::Rust {
        let error = cannot("it builds projects in C and C++ only".to_owned());
        return Err(error.help("for Rust, use `cargo +nightly` with -Zsanitizer, or Miri"));
    }
    let made = tempfile::tempdir().map_err(|e| cannot(format!("no folder can be created: {e}")))?;
    let library = made.path().join(project.library_name());
    let compiler = build::compiler_of(project.lang);
    let is_clang = output(Command::new(&compiler[0]).arg("--version")).is_some_and(|v| v.contains("clang"));
    let mut flags = FLAGS.to_vec();
    if is_clang {
        flags.push("-shared-libasan");
    }
    if !build::compile_to(&project, &library, &flags)? {
        return Err(cannot("the compiler failed, see above".to_owned()));
    }
    let name = if is_clang { format!("libclang_rt.asan-{}.so", std::env::consts::ARCH) } else { "libasan.so".into() };
    let found = output(Command::new(&compiler[0]).arg(format!("-print-file-name={name}"))).map(PathBuf::from);
    let preload = found.filter(|f| f.is_absolute() && f.is_file()).ok_or_else(|| {
        cannot(format!("the compiler has no library {name}")).help("install the sanitizers of the compiler")
    })?;
    Ok(SanitizedLibrary { library, preload, _folder: made })
}

fn output(command: &mut Command) -> Option<String> {
    let ran = command.output().ok().filter(|ran| ran.status.success())?;
    Some(String::from_utf8_lossy(&ran.stdout).trim().to_owned())
}

/// Returns the error that a sanitizer printed, with the place in the source.
pub fn error_in(lines: &[String]) -> Option<String> {
    let (at, line) =
        lines.iter().enumerate().find(|(_, l)| l.contains("AddressSanitizer:") || l.contains("runtime error:"))?;
    if let Some((place, what)) = line.split_once(": runtime error: ") {
        let place = place.rsplit('/').next().unwrap_or(place);
        return Some(format!("{what} ({place})"));
    }
    let what = line.split_once("AddressSanitizer: ")?.1;
    let what = what.split(" on address").next().unwrap_or(what);
    // The first frame with a line of a source file.
    let frame = lines[at..].iter().find_map(|l| {
        let (_, name) = l.trim_start().strip_prefix('#')?.split_once(" in ")?;
        let (function, place) = name.split_once(' ')?;
        let file = place.rsplit('/').next()?;
        file.contains(':').then(|| format!("{function}, {file}"))
    });
    Some(match frame {
        Some(frame) => format!("{what} ({frame})"),
        None => what.to_owned(),
    })
}
