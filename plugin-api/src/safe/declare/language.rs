//! Script languages.

use std::{
    ffi::{CString, c_char, c_void},
    sync::{Arc, Mutex},
};

use crate::abi::*;
use crate::safe::{
    Fail, Host, Instance, Param, Params, Plugin, Result, ValueRef, World,
    call::frame::CallFrame,
    declare::plugin::StartedPlugin,
    entry::{
        life::{self, InstanceInfo, InstanceLife},
        panics,
    },
    value::{fail::bytes_of, list_cache::cached_list, table_arena::TableArena},
};

/// Limits for one call to a script; 0 means no limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Maximum number of instructions of the language's virtual machine.
    pub instructions: u64,
    /// Maximum size of the script's state, bytes.
    pub memory: u64,
}

/// The outcome of a call into a script.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// The call returned.
    Done,
    /// The call is suspended in a command that waits; the host will call `resume` with the token of that wait.
    Waiting,
}

/// The frame of a call into a script: arguments and results.
pub struct Frame<'a> {
    raw: CallFrame<'a>,
    host: &'a Host,
}

impl<'a> Frame<'a> {
    /// Returns the frame in the form of the ABI.
    pub fn raw(&mut self) -> *mut tatu_call {
        self.raw.ptr()
    }
    /// Returns the world in which the script runs.
    pub fn world(&self) -> World<'a> {
        World::of(self.raw.world, self.host)
    }
    /// Returns the arguments.
    pub fn args(&self) -> &'a [ValueRef<'a>] {
        self.raw.args
    }
    /// Adds a result.
    ///
    /// # Safety
    /// Everything that `value` points to must stay valid until the caller has read it.
    pub unsafe fn push(&mut self, value: tatu_value) -> Result {
        let full = || Fail::with_code(TATU_ERR_SPACE, "the caller's buffer is too small for the results");
        // SAFETY: the caller guarantees the same.
        unsafe { self.raw.push(value) }.then_some(()).ok_or_else(full)
    }
    /// Allocates memory that is aligned to 8 bytes and valid until the caller has read the results. Returns null if
    /// there is not enough memory.
    pub fn alloc(&mut self, bytes: usize) -> *mut u8 {
        self.raw.alloc(bytes)
    }
}

/// A script language. There is one value per script.
pub trait Language: Sized + 'static {
    /// The plugin that offers this language.
    type Plugin: Plugin;
    /// Id of the language, such as "lua".
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;
    /// Suffixes of its files, such as ".lua".
    const SUFFIXES: &'static [&'static str];
    /// The permission that the user must grant (`--allow WORD`) before a script of the language is loaded, or `None` if
    /// scripts cannot reach anything outside the run.
    const PERMISSION: Option<&'static str> = None;

    /// Creates the state of a script, without its source. Storing the world for later calls requires `unsafe`; see
    /// [`World::new`].
    fn create(world: &World<'_>, instance: Instance) -> Result<Self>;
    /// Declares the settings of the language, such as the interpreter of its scripts. Users set them with `--language
    /// ID:KEY=VALUE`, scenes in `[language.ID]`.
    fn params() -> Vec<Param> {
        Vec::new()
    }
    /// Receives the values of [`params`](Self::params), once, before [`load`](Self::load).
    fn configure(&mut self, params: &Params<'_>) -> Result {
        let _ = params;
        Ok(())
    }
    /// Loads the source, whose name in messages is `chunk`. If `dialect` is empty, it is determined from the source.
    /// Returns the dialect in use.
    fn load(&self, text: &[u8], chunk: &str, dialect: &str) -> Result<String>;
    /// Returns the `TATU_SCRIPT_*` bits of a script whose source is loaded.
    fn traits(&self) -> u32 {
        0
    }
    /// Returns the order in which scripts are called, `TATU_ORDER_*`, in a world whose scene specifies this dialect; if
    /// the dialect is empty, `_modern` states whether the world has scripts with `TATU_SCRIPT_MODERN`. 0 means deepest
    /// first.
    fn order(&self, _dialect: &str, _modern: bool) -> u32 {
        0
    }
    /// Returns the position of the script while a command that it called runs: file, line and traceback, as in an
    /// error.
    fn place(&self) -> Option<Fail> {
        None
    }
    /// Returns a number by which `call` identifies a callback or function, or 0 if the script does not define it. `how`
    /// is one of `TATU_FIND_*`.
    fn find(&self, how: u32, name: &[u8]) -> u32;
    /// Calls a function by the number that `find` returned; `used` receives the number of instructions executed.
    fn call(&self, callable: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow>;
    /// Continues a call that was suspended in a waiting command. The frame's arguments are the results of that command,
    /// unless it failed.
    fn resume(
        &self,
        token: u64,
        failed: Option<Fail>,
        frame: &mut Frame<'_>,
        budget: Budget,
        used: &mut u64,
    ) -> Result<Flow>;
    /// Version of the data that [`Language::save`] writes; increase it when the format of the data changes.
    const STATE_VERSION: u32 = 0;
    /// Saves the state of the script for a snapshot. The script continues afterwards, so its state must not change. An
    /// error states the variable that cannot be saved.
    fn save(&self) -> Result<Vec<u8>> {
        Err(Fail::unsupported("this language cannot save the state of a script"))
    }
    /// Restores data that version `version` of `save` wrote. The source has been loaded, but has not run yet.
    fn restore(&self, bytes: &[u8], version: u32) -> Result<()> {
        let _ = (bytes, version);
        Err(Fail::unsupported("this language cannot restore the state of a script"))
    }
    /// Retains a function whose id is valid only during the current call. Returns its permanent id, or 0 if the
    /// function no longer exists.
    fn keep_func(&self, local: u32) -> u32;
    /// Releases a function by the id that `keep_func` returned.
    fn drop_func(&self, local: u32);
    /// Calls a function by its id, which is valid only during the current call or was returned by `keep_func`.
    fn call_func(&self, local: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow>;
    /// Checks that the language supports a dialect that a scene specifies; the error lists the supported dialects. By
    /// default, all dialects are accepted.
    fn knows_dialect(_dialect: &str) -> Result {
        Ok(())
    }
}

struct ScriptInstance<L> {
    language: L,
    host: Host,
    /// The dialect that was returned to the host, which may read it while the instance lives.
    dialect: Mutex<CString>,
}

/// The key of the cached list of a language's parameters.
struct LanguageParams<L>(L);

fn params_of<L: Language>() -> Arc<[Param]> {
    cached_list::<LanguageParams<L>, _>(L::params)
}

impl<L: Language> InstanceLife for ScriptInstance<L> {
    type Plugin = L::Plugin;
    const STATE_VERSION: u32 = L::STATE_VERSION;

    fn create(started: &StartedPlugin<L::Plugin>, info: &InstanceInfo<'_>) -> Result<Self> {
        let mut language = L::create(&info.world, info.instance)?;
        language.configure(&Params::new(info.params, &params_of::<L>()))?;
        Ok(ScriptInstance { language, host: started.host, dialect: Mutex::default() })
    }
    fn save(&self) -> Result<Vec<u8>> {
        self.language.save()
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        self.language.restore(bytes, version)
    }
}

/// Calls a function of the script on behalf of a host function that cannot return an error.
///
/// # Safety
/// `data` must have been created by `create` for this language, and be alive.
unsafe fn with_script<L: Language, T: Default>(data: *mut c_void, ask: impl FnOnce(&L) -> T) -> T {
    // SAFETY: the caller guarantees that `data` points to a live `ScriptInstance<L>`.
    let script = unsafe { &life::instance_at::<ScriptInstance<L>>(data).language };
    panics::quiet(|| ask(script))
}

pub(crate) fn table<L: Language>(keep: &mut TableArena, flags: u32) -> *const tatu_language {
    let params: Vec<_> = params_of::<L>().iter().map(|p| p.to_table(keep)).collect();
    let raw = tatu_language {
        size: size_of::<tatu_language>() as u32,
        flags,
        id: keep.text(L::ID),
        text: keep.text(L::TEXT),
        suffixes: keep.texts(L::SUFFIXES),
        life: keep.table(life::table::<ScriptInstance<L>>(0)),
        load: Some(load::<L>),
        find: Some(find::<L>),
        call: Some(call::<L>),
        resume: Some(resume::<L>),
        keep_func: Some(keep_func::<L>),
        drop_func: Some(drop_func::<L>),
        call_func: Some(call_func::<L>),
        knows_dialect: Some(knows_dialect::<L>),
        traits: Some(traits::<L>),
        order: Some(order::<L>),
        place: Some(place::<L>),
        permission: L::PERMISSION.map_or(std::ptr::null(), |word| keep.text(word)),
        params: if params.is_empty() { std::ptr::null() } else { keep.list(params) },
    };
    keep.table(raw)
}

unsafe extern "C" fn knows_dialect<L: Language>(
    _: *mut c_void,
    dialect: tatu_str,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `dialect` points to text that the host keeps valid during the call.
        let dialect = String::from_utf8_lossy(unsafe { bytes_of(dialect) });
        L::knows_dialect(&dialect)?;
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn load<L: Language>(
    data: *mut c_void,
    text: tatu_str,
    chunk: tatu_str,
    dialect: tatu_str,
    chosen: *mut tatu_str,
    error: *mut tatu_error,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `data` was created by `create` and is live; the host keeps the texts valid during the call.
        let (data, text, chunk, dialect) = unsafe {
            (life::instance_at::<ScriptInstance<L>>(data), bytes_of(text), bytes_of(chunk), bytes_of(dialect))
        };
        let (chunk, dialect) = (String::from_utf8_lossy(chunk), String::from_utf8_lossy(dialect));
        let result = CString::new(data.language.load(text, &chunk, &dialect)?).unwrap_or_default();
        let len = result.as_bytes().len() as u64;
        let mut kept = data.dialect.lock().map_err(|_| Fail::new("an earlier load of this script panicked"))?;
        *kept = result;
        // SAFETY: `chosen` is valid for a write. The text is stored in `data` until the next call to `load` or the end
        // of the instance.
        unsafe { *chosen = tatu_str { ptr: kept.as_ptr().cast::<c_char>(), len } };
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn traits<L: Language>(data: *mut c_void) -> u32 {
    // SAFETY: the host passes the `data` that `create` made, while it is live.
    unsafe { with_script(data, L::traits) }
}

unsafe extern "C" fn order<L: Language>(data: *mut c_void, dialect: tatu_str, modern: u32) -> u32 {
    // SAFETY: the host passes the `data` that `create` made, while it is live, and keeps the text valid during the
    // call.
    unsafe { with_script(data, |script: &L| script.order(&Lent::new(dialect).text(), modern != 0)) }
}

unsafe extern "C" fn place<L: Language>(data: *mut c_void, error: *mut tatu_error) {
    // SAFETY: the host passes the `data` that `create` made, while it is live, and null or a live error object.
    unsafe {
        if let Some(place) = with_script(data, L::place) {
            place.write(error);
        }
    }
}

unsafe extern "C" fn find<L: Language>(data: *mut c_void, how: u32, name: tatu_str) -> u32 {
    // SAFETY: the host passes the `data` that `create` made, while it is live, and keeps the name valid during the
    // call.
    unsafe { with_script(data, |script: &L| script.find(how, bytes_of(name))) }
}

/// Calls `f` with the script, and with the frame, the budget and the instruction counter that the host passed.
fn enter<L: Language>(
    data: *mut c_void,
    frame: *mut tatu_call,
    budget: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
    f: impl FnOnce(&L, &mut Frame<'_>, Budget, &mut u64) -> Result<Flow>,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: `data` was created by `create` and is live; the host passes a frame, a budget and a counter that are
        // valid during the call.
        let (data, raw, budget, used) =
            unsafe { (life::instance_at::<ScriptInstance<L>>(data), CallFrame::at(frame), &*budget, &mut *used) };
        let budget = Budget { instructions: budget.instructions, memory: budget.memory };
        let flow = f(&data.language, &mut Frame { raw, host: &data.host }, budget, used)?;
        Ok(if flow == Flow::Waiting { TATU_WAIT } else { TATU_OK })
    })
}

unsafe extern "C" fn call<L: Language>(
    data: *mut c_void,
    callable: u32,
    frame: *mut tatu_call,
    budget: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    enter(data, frame, budget, used, error, |l: &L, f, b, u| l.call(callable, f, b, u))
}

unsafe extern "C" fn resume<L: Language>(
    data: *mut c_void,
    token: u64,
    failed: tatu_status,
    frame: *mut tatu_call,
    budget: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    enter(data, frame, budget, used, error, |l: &L, f, b, u| {
        // The frame's error is that of the command that waited.
        let failed = (failed < 0).then(|| f.raw.fail(failed));
        l.resume(token, failed, f, b, u)
    })
}

unsafe extern "C" fn keep_func<L: Language>(data: *mut c_void, local: u32) -> u32 {
    // SAFETY: the host passes the `data` that `create` made, while it is live.
    unsafe { with_script(data, |script: &L| script.keep_func(local)) }
}

unsafe extern "C" fn drop_func<L: Language>(data: *mut c_void, local: u32) {
    // SAFETY: the host passes the `data` that `create` made, while it is live.
    unsafe { with_script(data, |script: &L| script.drop_func(local)) };
}

unsafe extern "C" fn call_func<L: Language>(
    data: *mut c_void,
    local: u32,
    frame: *mut tatu_call,
    budget: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    enter(data, frame, budget, used, error, |l: &L, f, b, u| l.call_func(local, f, b, u))
}
