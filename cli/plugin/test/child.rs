//! One test in C or C++, in this process: what `tatu plugin test` starts for each. What it reports goes to a file, a line
//! each, so that all before a crash is kept.

use std::{
    ffi::{CStr, CString, c_char},
    fs::File,
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
};

use libloading::Library;
use serde_json::{Value, json};
use tatu_core::errors::{Error, Result};
use tatu_plugin_api::abi::*;

use crate::watchdog::Watchdog;

#[derive(clap::Args)]
pub struct RunTest {
    /// The library with the tests.
    pub library: PathBuf,
    /// The test; none: their names are listed.
    #[arg(long)]
    pub name: Option<String>,
    /// Where the report goes.
    #[arg(long)]
    pub report: PathBuf,
    /// Where the files of its scenes lie.
    #[arg(long)]
    pub files: PathBuf,
    /// A plugin, or a folder with such.
    #[arg(long = "plugin")]
    pub plugins: Vec<PathBuf>,
}

/// Exit code 0: the test has run to its end, and the report tells what came of it.
pub fn run_test(args: &RunTest) -> Result<ExitCode> {
    run(args).map(|()| ExitCode::SUCCESS)
}

fn failed(text: String) -> Error {
    Error::new("E621", text)
}

fn run(args: &RunTest) -> Result {
    let mut file =
        File::create(&args.report).map_err(|e| failed(format!("cannot write {}: {e}", args.report.display())))?;
    let cases = cases(&args.library)?;
    let Some(name) = &args.name else {
        let names: Vec<_> = cases.iter().map(|c| c.0.as_str()).collect();
        return write(&mut file, &json!(names));
    };
    let (_, case) = cases
        .iter()
        .find(|c| c.0 == *name)
        .ok_or_else(|| failed(format!("{} has no test `{name}`", args.library.display())))?;
    let run = case.run.ok_or_else(|| failed(format!("the test `{name}` has no function")))?;
    // So that a crash in a plugin is told as such.
    tatuhost::note_calls_in(Watchdog::start(0.0, false).watches);
    let plugins = args.plugins.iter().map(|p| text(p)).collect::<Result<Vec<_>>>()?;
    let folder = text(&args.files)?;
    let list: Vec<*const c_char> = plugins.iter().map(|p| p.as_ptr()).chain([std::ptr::null()]).collect();
    let mut test = tatu_test {
        size: size_of::<tatu_test>() as u32,
        failures: 0,
        host: &raw const tatuhost::TABLE,
        folder: folder.as_ptr(),
        plugins: list.as_ptr(),
        world: std::ptr::null_mut(),
        leave: std::ptr::null_mut(),
        ctx: (&raw mut file).cast(),
        report: Some(note),
    };
    let test: *mut tatu_test = &raw mut test;
    // SAFETY: the test's own function with a context that lives through it, on this thread.
    unsafe { run(test) };
    // SAFETY: the context again, with the world that the test left open, if it did.
    let closed = unsafe { tatuhost::TABLE.close.map_or(TATU_OK, |close| close((*test).world)) };
    if closed < 0 {
        // SAFETY: the host's text, which lives until the next call.
        let why = unsafe { tatuhost::TABLE.last_error.map(|last| Lent::new(last()).text().into_owned()) };
        write(&mut file, &json!({ "file": "", "line": 0, "text": why.unwrap_or_default() }))?;
    }
    write(&mut file, &json!("end"))
}

/// The tests of a library, by name.
fn cases(path: &Path) -> Result<Vec<(String, &'static tatu_test_case)>> {
    // SAFETY: running the constructors of a test's library is what the user asked for.
    let library = unsafe { Library::new(path) };
    let library = library.map_err(|e| {
        let reason = std::error::Error::source(&e).map_or(String::new(), |s| format!(": {s}"));
        failed(format!("cannot open {}: {e}{reason}", path.display()))
            .help("a test does not link to the plugin: it reaches it through scenes and commands")
    })?;
    // SAFETY: the symbol is a constant of this type by the contract.
    let list = unsafe { library.get::<*const tatu_test_list>(b"tatu_tests\0").map(|s| s.try_as_raw_ptr()) };
    let list = list.ok().flatten().map(|p| p.cast::<tatu_test_list>().cast_const());
    // It is never unloaded: the tests lie in it.
    std::mem::forget(library);
    let list = list.ok_or_else(|| {
        failed(format!("{} exports no `tatu_tests`", path.display()))
            .help("list the tests of the file at its end: TATU_TESTS(first, second);")
    })?;
    let mut all = Vec::new();
    // SAFETY: a constant of the library, with a list of constants that ends with null; their texts end with 0.
    unsafe {
        if (*list).abi_major != TATU_ABI_MAJOR || ((*list).size as usize) < size_of::<tatu_test_list>() {
            return Err(failed(format!("{} was built with the header of another Tatu", path.display())));
        }
        let mut next = (*list).cases;
        while let Some(case) = (*next).as_ref() {
            all.push((CStr::from_ptr(case.name).to_string_lossy().into_owned(), case));
            next = next.add(1);
        }
    }
    Ok(all)
}

/// What a check calls that does not hold.
unsafe extern "C" fn note(test: *mut tatu_test, file: *const c_char, line: u32, text: *const c_char) {
    let read = |text: *const c_char| match text.is_null() {
        true => String::new(),
        // SAFETY: by the contract a text that ends with 0.
        false => unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned(),
    };
    // SAFETY: the context that this process gave to the test.
    let Some(to) = (unsafe { (*test).ctx.cast::<File>().as_mut() }) else { return };
    let _ = write(to, &json!({ "file": read(file), "line": line, "text": read(text) }));
}

fn write(file: &mut File, value: &Value) -> Result {
    writeln!(file, "{value}").map_err(|e| failed(format!("cannot write the report: {e}")))
}

fn text(path: &Path) -> Result<CString> {
    let text = path.to_str().and_then(|text| CString::new(text).ok());
    text.ok_or_else(|| failed(format!("the path {} is not UTF-8", path.display())))
}
