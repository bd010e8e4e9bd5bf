//! Python as a script language.
//!
//! Each script runs in a process of its own, in the interpreter of the user's choice. The process runs the modules in
//! `runtime/`, which are embedded in this library; it exchanges messages with the plugin over pipes.
//!
//! - `script`: the data of a script; `load` starts its process;
//! - `calls`: calls of the host into the script; `state`: what a script saves of its state;
//! - `exchange`: asks the process, and serves its questions (`serve`) until it answers;
//! - `message`, `wire`: the protocol; `process`: the process, its limits and its end;
//! - `host`: functions of the host; `dialect`: versions of the API.
#![cfg(unix)]

mod calls;
mod dialect;
mod exchange;
mod host;
mod load;
mod message;
mod process;
mod script;
mod serve;
mod state;
mod wire;

use tatu_plugin_api::{abi::*, safe::*};

use process::{MAX_MEMORY_MB, Settings};
use script::{PERMISSION, PythonScript};

/// The plugin, which has no data; every script is an instance of the language.
struct Python;

impl Plugin for Python {
    fn start(_host: &Host) -> Result<Self> {
        Ok(Python)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.language::<PythonScript>();
    }
}

impl Language for PythonScript {
    type Plugin = Python;
    const ID: &'static str = "python";
    const TEXT: &'static str = "Python 3, in a process per script; needs `--allow python`.";
    const SUFFIXES: &'static [&'static str] = &[".py"];
    const PERMISSION: Option<&'static str> = Some(PERMISSION);

    fn create(world: &World<'_>, instance: Instance) -> Result<Self> {
        PythonScript::new(world, instance)
    }
    fn params() -> Vec<Param> {
        vec![
            Param::string("interpreter").program().optional().text(
                "The Python interpreter, by its path or its name in PATH; otherwise TATU_PYTHON, `.venv/bin/python` beside \
                 the scene, the active virtual environment, or `python3`.",
            ),
            Param::int("memory_mb").range(0.0, MAX_MEMORY_MB as f64).optional().text(
                "Limit of the data of each script's process, MB; 0: none; otherwise TATU_PYTHON_MEMORY_MB, or 2048.",
            ),
        ]
    }
    fn configure(&mut self, params: &Params<'_>) -> Result {
        self.settings = Settings {
            interpreter: params.get("interpreter")?.as_str().map(|path| path.into_owned().into()),
            memory_mb: params.get("memory_mb")?.as_i64().and_then(|mb| mb.try_into().ok()),
        };
        Ok(())
    }
    fn load(&self, text: &[u8], chunk: &str, dialect: &str) -> Result<String> {
        load::load(self, text, chunk, dialect)
    }
    fn traits(&self) -> u32 {
        TATU_SCRIPT_SILENT | TATU_SCRIPT_MODERN
    }
    fn order(&self, dialect: &str, _modern: bool) -> u32 {
        dialect::order(&self.source.borrow().orders, dialect)
    }
    fn place(&self) -> Option<Fail> {
        exchange::place(self)
    }
    fn find(&self, how: u32, name: &[u8]) -> u32 {
        calls::find(self, how, name)
    }
    fn call(&self, callable: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow> {
        calls::call(self, callable, frame, budget, used)
    }
    fn resume(
        &self,
        token: u64,
        failed: Option<Fail>,
        frame: &mut Frame<'_>,
        budget: Budget,
        used: &mut u64,
    ) -> Result<Flow> {
        calls::resume(self, token, failed, frame, budget, used)
    }
    const STATE_VERSION: u32 = state::VERSION;
    fn save(&self) -> Result<Vec<u8>> {
        state::save(self)
    }
    fn restore(&self, bytes: &[u8], version: u32) -> Result<()> {
        state::restore(self, bytes, version)
    }
    fn keep_func(&self, local: u32) -> u32 {
        self.keep(local)
    }
    fn drop_func(&self, local: u32) {
        self.drop_kept(local);
    }
    fn call_func(&self, local: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow> {
        calls::call_function(self, local, frame, budget, used)
    }
    fn knows_dialect(dialect: &str) -> Result {
        dialect::check(dialect)
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: Python,
    id: "tatu.script.python",
    name: "Python scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
