//! Lua 5.4 as a script language, with a layer for scripts written for Lua 5.1.
//!
//! Each script has its own Lua state. It is accessed through Lua's C interface, so a command call with numbers and
//! strings as arguments does not allocate memory.
//! Start reading with `state` (data of a script) and `run` (calls from the host); `README.md` describes the environment
//! of scripts.
//!
//! Rule for the whole crate: Lua errors and yields are long jumps that skip destructors. A function called by Lua must
//! not keep a value with a destructor, or a `RefCell` guard, alive across a Lua function that may raise.
#![allow(
    unsafe_op_in_unsafe_fn,
    reason = "every function over the raw Lua interface has one contract, documented at the function"
)]

mod alloc;
mod chunk_cache;
mod convert;
mod dialect;
mod errors;
mod lexer;
mod load;
mod lua_internals;
mod lua_math;
mod run;
mod script;
mod snapshot;
mod stack;
mod state;
mod stdlib;
mod system;
mod values;

use tatu_plugin_api::{abi::TATU_LOG_ERROR, safe::*};

use run::{callbacks, entry, functions, threads, traits};
use script::LuaScript;

/// The plugin, which has no data; every script is an instance of the language.
struct Lua;

impl Plugin for Lua {
    fn start(host: &Host) -> Result<Self> {
        for problem in lua_internals::failed_checks() {
            host.log(TATU_LOG_ERROR, problem);
        }
        Ok(Lua)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.language_side_by_side::<LuaScript>();
    }
}

impl Language for LuaScript {
    type Plugin = Lua;
    const ID: &'static str = "lua";
    const TEXT: &'static str = "Lua 5.4, and Lua 5.1 for scripts of old dialects.";
    const SUFFIXES: &'static [&'static str] = &[".lua"];

    fn create(world: &World<'_>, instance: Instance) -> Result<Self> {
        LuaScript::new(world, instance)
    }
    fn load(&self, text: &[u8], chunk: &str, dialect: &str) -> Result<String> {
        load::load(self, text, chunk, dialect)
    }
    fn traits(&self) -> u32 {
        traits::traits(self)
    }
    fn order(&self, dialect: &str, modern: bool) -> u32 {
        traits::order(self, dialect, modern)
    }
    fn place(&self) -> Option<Fail> {
        errors::place(self)
    }
    fn find(&self, how: u32, name: &[u8]) -> u32 {
        callbacks::find(self, how, name)
    }
    fn call(&self, callable: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow> {
        callbacks::call(self, callable, frame, budget, used)
    }
    fn resume(
        &self,
        token: u64,
        failed: Option<Fail>,
        frame: &mut Frame<'_>,
        budget: Budget,
        used: &mut u64,
    ) -> Result<Flow> {
        threads::resume(self, token, failed, frame, budget, used)
    }
    const STATE_VERSION: u32 = snapshot::VERSION;
    fn save(&self) -> Result<Vec<u8>> {
        snapshot::save(self)
    }
    fn restore(&self, bytes: &[u8], version: u32) -> Result<()> {
        snapshot::restore(self, bytes, version)
    }
    fn keep_func(&self, local: u32) -> u32 {
        functions::keep(self, local)
    }
    fn drop_func(&self, local: u32) {
        functions::drop(self, local);
    }
    fn call_func(&self, local: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow> {
        entry::call_function(self, local, frame, budget, used)
    }
    fn knows_dialect(dialect: &str) -> Result {
        dialect::check_dialect(dialect)
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: Lua,
    id: "tatu.script.lua",
    name: "Lua scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
