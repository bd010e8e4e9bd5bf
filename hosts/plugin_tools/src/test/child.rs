//! Runs one test in C or C++ in this process, which `tatu plugin test` starts for each test. Reports are written to a
//! file line by line, so that those before a crash are not lost.

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
use tatu_terminal::Watchdog;

#[derive(clap::Args)]
pub struct RunTestArgs {
    /// The library with the tests.
    pub library: PathBuf,
    /// The name of the test; if it is omitted, the names of all tests are listed.
    #[arg(long)]
    pub name: Option<String>,
    /// The file to which the report is written.
    #[arg(long)]
    pub report: PathBuf,
    /// The folder with the scene files of the tests.
    #[arg(long)]
    pub files: PathBuf,
    /// A plugin, or a folder with plugins; may be given several times.
    #[arg(long = "plugin")]
    pub plugins: Vec<PathBuf>,
}

/// Runs a test. The exit code is 0 if the test has finished; its result is in the report.
pub fn run_test(args: &RunTestArgs) -> Result<ExitCode> {
    run(args).map(|()| ExitCode::SUCCESS)
}

fn failed(text: String) -> Error {
    Error::new("E621", text)
}

fn run(args: &RunTestArgs) -> Result {
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
    // Plugin calls are recorded, so that the report of a crash names the plugin.
    tatuhost::set_call_watches(Watchdog::start(0.0, false).watches);
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
    // SAFETY: the function is that of the test, and the context is valid until it returns.
    unsafe { run(test) };
    // SAFETY: the context is still valid; its world is null or one that the test left open.
    let closed = unsafe { tatuhost::TABLE.close.map_or(TATU_OK, |close| close((*test).world)) };
    if closed < 0 {
        // SAFETY: the text belongs to the host and is valid until the next call.
        let why = unsafe { tatuhost::TABLE.last_error.map(|last| Lent::new(last()).text().into_owned()) };
        write(&mut file, &json!({ "file": "", "line": 0, "text": why.unwrap_or_default() }))?;
    }
    write(&mut file, &json!("end"))
}

/// Opens a library; returns its tests with their names.
fn cases(path: &Path) -> Result<Vec<(String, &'static tatu_test_case)>> {
    // SAFETY: the user requested to run this library's tests, which includes running its constructors.
    let library = unsafe { Library::new(path) };
    let library = library.map_err(|e| {
        let reason = std::error::Error::source(&e).map_or(String::new(), |s| format!(": {s}"));
        failed(format!("cannot open {}: {e}{reason}", path.display()))
            .help("tests must not link to the plugin; they use it through scenes and commands")
    })?;
    // SAFETY: by the contract, the symbol is a constant of this type.
    let list = unsafe { library.get::<*const tatu_test_list>(b"tatu_tests\0").map(|s| s.try_as_raw_ptr()) };
    let list = list.ok().flatten().map(|p| p.cast::<tatu_test_list>().cast_const());
    // The library is never unloaded, since it contains the code of the tests.
    std::mem::forget(library);
    let list = list.ok_or_else(|| {
        failed(format!("{} exports no `tatu_tests`", path.display()))
            .help("list the tests of the file at its end: TATU_TESTS(first, second);")
    })?;
    let mut all = Vec::new();
    // SAFETY: the list is a constant of the library; its cases end with null, and their names are NUL-terminated.
    unsafe {
        if (*list).abi_major != TATU_ABI_MAJOR || ((*list).size as usize) < size_of::<tatu_test_list>() {
            return Err(failed(format!("{} was built with the header of a different version of Tatu", path.display())));
        }
        let mut next = (*list).cases;
        while let Some(case) = (*next).as_ref() {
            all.push((CStr::from_ptr(case.name).to_string_lossy().into_owned(), case));
            next = next.add(1);
        }
    }
    Ok(all)
}

/// Callback of the test header for a failed check: writes it to the report.
unsafe extern "C" fn note(test: *mut tatu_test, file: *const c_char, line: u32, text: *const c_char) {
    let read = |text: *const c_char| match text.is_null() {
        true => String::new(),
        // SAFETY: by the contract, the text is NUL-terminated.
        false => unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned(),
    };
    // SAFETY: `test` is the context that this process passed to the test.
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
