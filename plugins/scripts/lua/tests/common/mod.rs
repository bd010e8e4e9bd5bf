//! A small host for tests, with commands, an arena, a log, files and time, which calls scripts through the ABI.
#![allow(
    unsafe_op_in_unsafe_fn,
    clippy::undocumented_unsafe_blocks,
    reason = "the test acts as the host: every pointer is its own, or was returned by the plugin"
)]
#![allow(dead_code, missing_docs, reason = "each test file uses only a part of the host")]

use std::{
    cell::{Cell, RefCell},
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use tatu_plugin_api::{abi::*, safe::*};

pub type HostCommand = fn(&TestHost, &mut tatu_call) -> tatu_status;

#[repr(C)]
pub struct ScriptError {
    pub raw: tatu_error,
    pub code: i32,
    pub text: String,
    pub help: String,
    pub file: String,
    pub line: u64,
    pub traceback: String,
}

/// The world and its services in one object. It is leaked, so that all pointers to it remain valid.
#[repr(C)]
pub struct TestHost {
    pub table: tatu_host,
    pub names: RefCell<Vec<(String, HostCommand)>>,
    pub constants: RefCell<Vec<(String, tatu_value)>>,
    pub preludes: RefCell<Vec<(String, String)>>,
    pub log: RefCell<Vec<(u32, String)>>,
    pub calls: RefCell<Vec<String>>,
    pub time: Cell<f64>,
    pub generation: Cell<u64>,
    pub folder: RefCell<String>,
    pub last_kept_func: Cell<u32>,
    pub tokens: RefCell<Vec<u64>>,
    pub script: Cell<*const TestScript>,
    arena: RefCell<Vec<Box<[u64]>>>,
    path: RefCell<String>,
    error: RefCell<Box<ScriptError>>,
    language: Cell<*const tatu_language>,
    plugin: Cell<*mut c_void>,
}

pub struct TestScript {
    pub host: &'static TestHost,
    pub data: *mut c_void,
    pub used: Cell<u64>,
    pub budget: Cell<(u64, u64)>,
    pub id: u64,
}

unsafe fn text(s: tatu_str) -> String {
    if s.len == 0 {
        return String::new();
    }
    String::from_utf8_lossy(std::slice::from_raw_parts(s.ptr.cast(), s.len as usize)).into_owned()
}

pub fn raw(s: &str) -> tatu_str {
    tatu_str { ptr: s.as_ptr().cast(), len: s.len() as u64 }
}

unsafe extern "C" fn set_error(e: *mut tatu_error, code: tatu_status, t: tatu_str) {
    let e = &mut *e.cast::<ScriptError>();
    *e = *ScriptError::new();
    e.code = code;
    e.text = text(t);
    e.raw.code = code;
    e.raw.text = raw(&e.text);
}
unsafe extern "C" fn add_error_part(e: *mut tatu_error, part: u32, t: tatu_str, line: u64) {
    let e = &mut *e.cast::<ScriptError>();
    let t = text(t);
    match part {
        TATU_PART_HELP => {
            e.help = t;
            e.raw.help = raw(&e.help);
        }
        TATU_PART_FILE => {
            e.file = t;
            e.line = line;
            e.raw.file = raw(&e.file);
            e.raw.line = line;
        }
        _ => {
            e.traceback = t;
            e.raw.traceback = raw(&e.traceback);
        }
    }
}

impl ScriptError {
    pub fn new() -> Box<ScriptError> {
        let none = tatu_str { ptr: null(), len: 0 };
        Box::new(ScriptError {
            raw: tatu_error {
                size: size_of::<tatu_error>() as u32,
                code: 0,
                ctx: null_mut(),
                say: Some(set_error),
                add: Some(add_error_part),
                text: none,
                help: none,
                file: none,
                traceback: none,
                line: 0,
            },
            code: 0,
            text: String::new(),
            help: String::new(),
            file: String::new(),
            line: 0,
            traceback: String::new(),
        })
    }
}

fn host<'a>(w: WorldRef<'a>) -> &'a TestHost {
    // SAFETY: the tests pass their `TestHost` as the world of every script, and hosts are leaked, so the pointer is
    // valid and of this type.
    unsafe { &*w.ptr().cast::<TestHost>() }
}
extern "C" fn find(w: WorldRef<'_>, name: Lent<'_>, alias: Option<&mut u32>) -> u32 {
    let (h, name) = (host(w), name.text());
    let at = h.names.borrow().iter().position(|n| n.0 == name);
    *alias.unwrap() = 3;
    at.map_or(0, |i| i as u32 + 1)
}
extern "C" fn is_name_space(w: WorldRef<'_>, name: Lent<'_>) -> u32 {
    let (h, name) = (host(w), format!("{}.", name.text()));
    let names = h.names.borrow().iter().any(|n| n.0.starts_with(&name));
    u32::from(names || h.constants.borrow().iter().any(|n| n.0.starts_with(&name)))
}
unsafe extern "C" fn call(w: WorldRef<'_>, frame: *mut tatu_call) -> tatu_status {
    let (h, frame) = (host(w), &mut *frame);
    assert_eq!(frame.alias, 3);
    let f = h.names.borrow()[frame.command as usize - 1].1;
    frame.world = w.ptr();
    frame.api = &raw const API;
    f(h, frame)
}
extern "C" fn generation(w: WorldRef<'_>) -> u64 {
    host(w).generation.get()
}
extern "C" fn constant<'a>(w: WorldRef<'a>, name: Lent<'_>, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    let name = name.text();
    match host(w).constants.borrow().iter().find(|c| c.0 == name) {
        Some(c) => {
            // SAFETY: the constants of these tests are numbers, which contain no pointer.
            *out.unwrap() = unsafe { ValueRef::new(c.1) };
            TATU_OK
        }
        None => TATU_ERR_MISSING,
    }
}
extern "C" fn prelude<'a>(
    w: WorldRef<'a>,
    language: LentCStr<'_>,
    index: u32,
    module: Option<&mut Lent<'a>>,
    out: Option<&mut Lent<'a>>,
) -> tatu_status {
    assert_eq!(language.get(), Some(c"lua"));
    match host(w).preludes.borrow().get(index as usize) {
        Some((m, t)) => {
            // SAFETY: the texts are static or owned by the host, which is leaked and does not change its preludes while
            // scripts use them.
            (*module.unwrap(), *out.unwrap()) = unsafe { (Lent::new(raw(m)), Lent::new(raw(t))) };
            TATU_OK
        }
        None => TATU_ERR_MISSING,
    }
}
extern "C" fn mark(w: WorldRef<'_>) -> u64 {
    host(w).arena.borrow().len() as u64
}
extern "C" fn alloc(w: WorldRef<'_>, bytes: u64) -> *mut c_void {
    let mut block = vec![0u64; (bytes as usize).div_ceil(8).max(1)].into_boxed_slice();
    let ptr = block.as_mut_ptr().cast();
    host(w).arena.borrow_mut().push(block);
    ptr
}
unsafe extern "C" fn release(w: WorldRef<'_>, mark: u64) {
    host(w).arena.borrow_mut().truncate(mark as usize);
}
unsafe extern "C" fn frame_alloc(frame: *mut tatu_call, bytes: u64) -> *mut c_void {
    alloc(WorldRef::new((*frame).world), bytes)
}
unsafe extern "C" fn call_func(w: WorldRef<'_>, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    let s = &*host(w).script.get();
    assert_eq!(func >> 32, s.id);
    let mut error = ScriptError::new();
    let (f, mut used) = ((*host(w).language.get()).call_func.unwrap(), 0);
    let status = f(s.data, func as u32, frame, &s.raw_budget(), &mut used, &mut error.raw);
    *host(w).error.borrow_mut() = error;
    (*frame).error = &raw mut host(w).error.borrow_mut().raw;
    status
}
static API: tatu_call_api = tatu_call_api {
    size: size_of::<tatu_call_api>() as u32,
    reserved: 0,
    alloc: Some(frame_alloc),
    wait: None,
    ticket: None,
    woken: None,
};
static COMMANDS: tatu_host_commands = tatu_host_commands {
    size: size_of::<tatu_host_commands>() as u32,
    reserved: 0,
    find: Some(find),
    is_name_space: Some(is_name_space),
    count: None,
    describe: None,
    call: Some(call),
    generation: Some(generation),
    constant: Some(constant),
    prelude: Some(prelude),
    mark: Some(mark),
    alloc: Some(alloc),
    release: Some(release),
    retain: None,
    drop: None,
    call_func: Some(call_func),
    constant_name: None,
    wake: None,
};
unsafe extern "C" fn prop(_: *const tatu_host, key: LentCStr<'_>) -> tatu_prop {
    match &*key.text() {
        "scene.clock" => 1,
        "scene.epoch" => 2,
        _ => 0,
    }
}
unsafe extern "C" fn get_f64(w: WorldRef<'_>, _: tatu_object, p: tatu_prop, out: *mut f64, _: u32) -> tatu_status {
    // The start date is the first second of 2015, UTC.
    *out = match p {
        1 => host(w).time.get(),
        2 => 1_420_070_400.0,
        _ => panic!("this host does not have the property {p}"),
    };
    TATU_OK
}
unsafe extern "C" fn write(h: *const tatu_host, _: WorldRef<'_>, level: u32, line: Lent<'_>) {
    let h = &*(*h).ctx.cast::<TestHost>();
    h.log.borrow_mut().push((level, line.text().into_owned()));
}
unsafe extern "C" fn last_error(w: WorldRef<'_>) -> *const tatu_error {
    &raw const host(w).error.borrow().raw
}
static LOG: tatu_host_log = tatu_host_log {
    size: size_of::<tatu_host_log>() as u32,
    reserved: 0,
    write: Some(write),
    last_error: Some(last_error),
};
extern "C" fn resolve<'a>(w: WorldRef<'a>, name: Lent<'_>, _: u32, out: Option<&mut Lent<'a>>) -> tatu_status {
    let (h, name) = (host(w), name.text());
    if name.contains("..") || name.starts_with('/') {
        return h.refuse(TATU_ERR_UNSUPPORTED, "outside the allowed folders");
    }
    *h.path.borrow_mut() = format!("{}/{name}", h.folder.borrow());
    // SAFETY: `h.path` keeps the text until the next call of `resolve`, and callers copy it before that.
    *out.unwrap() = unsafe { Lent::new(raw(&h.path.borrow())) };
    TATU_OK
}
extern "C" fn open(w: WorldRef<'_>, name: Lent<'_>, mode: u32, out: Option<&mut i64>) -> tatu_status {
    let mut path = Lent::EMPTY;
    let status = resolve(w, name, mode, Some(&mut path));
    if status < 0 {
        return status;
    }
    let has = |bit| mode & bit != 0;
    let mut options = std::fs::OpenOptions::new();
    options.read(has(TATU_FILE_READ)).write(has(TATU_FILE_WRITE)).append(has(TATU_FILE_APPEND));
    let makes = has(TATU_FILE_WRITE) && !has(TATU_FILE_UPDATE);
    match options.create(makes || has(TATU_FILE_APPEND)).truncate(makes).open(path.text().as_ref()) {
        Ok(file) => *out.unwrap() = std::os::fd::IntoRawFd::into_raw_fd(file).into(),
        Err(e) => return host(w).refuse(TATU_ERR_MISSING, &e.to_string()),
    }
    TATU_OK
}
static FILES: tatu_host_files = tatu_host_files {
    size: size_of::<tatu_host_files>() as u32,
    reserved: 0,
    resolve: Some(resolve),
    open: Some(open),
};
static mut SCENE: std::mem::MaybeUninit<tatu_host_scene> = std::mem::MaybeUninit::zeroed();
unsafe extern "C" fn service(_: *const tatu_host, id: *const c_char) -> *const c_void {
    match CStr::from_ptr(id) {
        id if id == TATU_HOST_COMMANDS => (&raw const COMMANDS).cast(),
        id if id == TATU_HOST_LOG => (&raw const LOG).cast(),
        id if id == TATU_HOST_FILES => (&raw const FILES).cast(),
        id if id == TATU_HOST_SCENE => (&raw const SCENE).cast(),
        _ => null(),
    }
}

impl TestHost {
    /// Returns the script that was called last.
    pub fn running(&self) -> &TestScript {
        unsafe { &*self.script.get() }
    }
    pub fn new() -> &'static TestHost {
        unsafe {
            let scene = (&raw mut SCENE).cast::<tatu_host_scene>();
            (*scene).size = size_of::<tatu_host_scene>() as u32;
            (*scene).prop = Some(prop);
            (*scene).get_f64 = Some(get_f64);
        }
        let h: &'static mut TestHost = Box::leak(Box::new(TestHost {
            table: tatu_host {
                size: size_of::<tatu_host>() as u32,
                abi_minor: 1,
                ctx: null_mut(),
                service: Some(service),
                assets: std::ptr::null(),
            },
            names: RefCell::default(),
            constants: RefCell::default(),
            preludes: RefCell::default(),
            log: RefCell::default(),
            calls: RefCell::default(),
            time: Cell::new(0.0),
            generation: Cell::new(1),
            folder: RefCell::default(),
            last_kept_func: Cell::new(0),
            tokens: RefCell::default(),
            script: Cell::new(null()),
            arena: RefCell::default(),
            path: RefCell::default(),
            error: RefCell::new(ScriptError::new()),
            language: Cell::new(null()),
            plugin: Cell::new(null_mut()),
        }));
        h.table.ctx = (&raw mut *h).cast();
        let h: &'static TestHost = h;
        let p = &tatu_scripts_lua::tatu_plugin.0;
        let mut me = null_mut();
        let mut error = ScriptError::new();
        unsafe {
            assert_eq!(p.init.unwrap()(&h.table, &mut me, &mut error.raw), TATU_OK);
            // The plugin's panic hook sends panics to the log. Remove it, so that failing tests print them.
            drop(std::panic::take_hook());
            h.plugin.set(me);
            let ext = p.extension.unwrap()(me, TATU_SCRIPT.as_ptr()).cast::<tatu_ext_script>();
            h.language.set(*(*ext).languages);
        }
        h
    }
    pub fn command(&self, name: &str, f: HostCommand) {
        self.names.borrow_mut().push((name.into(), f));
        self.generation.set(self.generation.get() + 1);
    }
    pub fn constant(&self, name: &str, value: tatu_value) {
        self.constants.borrow_mut().push((name.into(), value));
    }
    pub fn refuse(&self, code: tatu_status, t: &str) -> tatu_status {
        let mut error = ScriptError::new();
        unsafe { set_error(&mut error.raw, code, raw(t)) };
        *self.error.borrow_mut() = error;
        code
    }
    /// Fails like a command: stores a reference to the error in the frame.
    pub fn fail(&self, frame: &mut tatu_call, code: tatu_status, t: &str, help: &str) -> tatu_status {
        self.refuse(code, t);
        frame.error = &raw mut self.error.borrow_mut().raw;
        if !help.is_empty() {
            unsafe { add_error_part(frame.error, TATU_PART_HELP, raw(help), 0) };
        }
        code
    }
    pub fn lines(&self) -> Vec<String> {
        self.log.borrow().iter().map(|l| l.1.clone()).collect()
    }
    pub fn arena_blocks(&self) -> usize {
        self.arena.borrow().len()
    }
    pub fn script(&'static self, seed: u64) -> TestScript {
        let life = unsafe { &*(*self.language.get()).life };
        let info = tatu_instance {
            size: size_of::<tatu_instance>() as u32,
            n_params: 0,
            world: (&raw const *self).cast_mut().cast(),
            owner: (1 << 20) | 77,
            id: 5,
            seed,
            params: null(),
            state: null_mut(),
            session: std::ptr::null_mut(),
        };
        let (mut data, mut error) = (null_mut(), ScriptError::new());
        let status = unsafe { life.create.unwrap()(self.plugin.get(), &info, &mut data, &mut error.raw) };
        assert_eq!(status, TATU_OK, "{}", error.text);
        TestScript { host: self, data, used: Cell::new(0), budget: Cell::new((0, 0)), id: 5 }
    }
    /// Creates a script with this source.
    pub fn load(&'static self, text: &str) -> TestScript {
        let s = self.script(1);
        s.load(text, "test.lua", "").unwrap();
        s
    }
}

pub fn int(i: i64) -> tatu_value {
    tatu_value { tag: TATU_I64, reserved: 0, u: tatu_payload { i } }
}
pub fn num(f: f64) -> tatu_value {
    tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f } }
}
pub fn ret(frame: &mut tatu_call, v: tatu_value) {
    assert!(frame.n_results < frame.results_cap);
    unsafe { *frame.results.add(frame.n_results as usize) = v };
    frame.n_results += 1;
}
pub fn arg(frame: &tatu_call, i: u32) -> ValueRef<'static> {
    assert!(i < frame.n_args);
    unsafe { ValueRef::new(*frame.args.add(i as usize)) }
}

impl TestScript {
    fn lang(&self) -> &'static tatu_language {
        unsafe { &*self.host.language.get() }
    }
    fn world(&self) -> *mut tatu_world {
        (&raw const *self.host).cast_mut().cast()
    }
    pub fn raw_budget(&self) -> tatu_budget {
        let (instructions, memory) = self.budget.get();
        tatu_budget { size: size_of::<tatu_budget>() as u32, reserved: 0, instructions, memory }
    }
    pub fn load(&self, text_: &str, chunk: &str, dialect: &str) -> Result<String, Box<ScriptError>> {
        self.host.script.set(self);
        let mut error = ScriptError::new();
        let mut chosen = raw("");
        let status = unsafe {
            self.lang().load.unwrap()(self.data, raw(text_), raw(chunk), raw(dialect), &mut chosen, &mut error.raw)
        };
        if status == TATU_OK { Ok(unsafe { text(chosen) }) } else { Err(error) }
    }
    pub fn find(&self, how: u32, name: &str) -> u32 {
        unsafe { self.lang().find.unwrap()(self.data, how, raw(name)) }
    }
    fn enter(
        &self,
        args: &[Value],
        f: impl FnOnce(*mut tatu_call, *const tatu_budget, *mut u64, *mut tatu_error) -> tatu_status,
    ) -> Result<(i32, Vec<Value>), Box<ScriptError>> {
        self.host.script.set(self);
        let before = self.host.arena_blocks() as u64;
        let mut owned = Owned::default();
        let args: Vec<_> = args.iter().map(|a| owned.raw(a)).collect();
        let mut results = [int(0); 32];
        let mut error = ScriptError::new();
        let mut frame = tatu_call::empty();
        frame.size = size_of::<tatu_call>() as u32;
        frame.args = args.as_ptr();
        frame.n_args = args.len() as u32;
        frame.results = results.as_mut_ptr();
        frame.results_cap = 32;
        frame.world = self.world();
        frame.api = &raw const API;
        frame.error = &raw mut error.raw;
        let mut used = 0;
        let status = f(&mut frame, &self.raw_budget(), &mut used, &mut error.raw);
        self.used.set(used);
        let out = results[..frame.n_results as usize]
            .iter()
            .map(|v| unsafe { ValueRef::new(*v) }.to_value().unwrap())
            .collect();
        unsafe { release(WorldRef::new(self.world()), before) };
        if status < 0 {
            assert_eq!(error.code, status);
            return Err(error);
        }
        Ok((status, out))
    }
    pub fn call_id(&self, id: u32, args: &[Value]) -> Result<(i32, Vec<Value>), Box<ScriptError>> {
        self.enter(args, |frame, budget, used, error| unsafe {
            self.lang().call.unwrap()(self.data, id, frame, budget, used, error)
        })
    }
    pub fn callback(&self, name: &str, args: &[Value]) -> Result<(i32, Vec<Value>), Box<ScriptError>> {
        let id = self.find(TATU_FIND_CALLBACK, name);
        assert_ne!(id, 0, "no callback {name}");
        self.call_id(id, args)
    }
    pub fn init(&self) -> Result<Vec<Value>, Box<ScriptError>> {
        self.callback("init", &[]).map(|r| r.1)
    }
    pub fn function(&self, name: &str, args: &[Value]) -> Result<Vec<Value>, Box<ScriptError>> {
        let id = self.find(TATU_FIND_FUNCTION, name);
        assert_ne!(id, 0, "no function {name}");
        self.call_id(id, args).map(|r| r.1)
    }
    pub fn resume(
        &self,
        token: u64,
        failed: Option<&str>,
        args: &[Value],
    ) -> Result<(i32, Vec<Value>), Box<ScriptError>> {
        self.enter(args, |frame, budget, used, error| unsafe {
            let mut status = TATU_OK;
            if let Some(t) = failed {
                status = TATU_ERR_MISSING;
                set_error((*frame).error, status, raw(t));
            }
            self.lang().resume.unwrap()(self.data, token, status, frame, budget, used, error)
        })
    }
    pub fn keep(&self, local: u32) -> u32 {
        unsafe { self.lang().keep_func.unwrap()(self.data, local) }
    }
    pub fn drop_func(&self, local: u32) {
        unsafe { self.lang().drop_func.unwrap()(self.data, local) }
    }
    pub fn call_func(&self, local: u32, args: &[Value]) -> Result<(i32, Vec<Value>), Box<ScriptError>> {
        self.enter(args, |frame, budget, used, error| unsafe {
            self.lang().call_func.unwrap()(self.data, local, frame, budget, used, error)
        })
    }
    /// Saves the instance.
    pub fn save(&self) -> Result<Vec<u8>, Box<ScriptError>> {
        unsafe extern "C" fn write(w: *const tatu_writer, bytes: *const c_void, n: u64) {
            let out = &mut *(*w).ctx.cast::<Vec<u8>>();
            out.extend_from_slice(std::slice::from_raw_parts(bytes.cast(), n as usize));
        }
        let (mut out, mut error) = (Vec::<u8>::new(), ScriptError::new());
        let writer = tatu_writer {
            size: size_of::<tatu_writer>() as u32,
            reserved: 0,
            ctx: (&raw mut out).cast(),
            write: Some(write),
        };
        let status = unsafe { (*self.lang().life).save.unwrap()(self.data, &writer, &mut error.raw) };
        if status < 0 { Err(error) } else { Ok(out) }
    }
    /// Restores the instance.
    pub fn restore(&self, bytes: &[u8]) -> Result<(), Box<ScriptError>> {
        let mut error = ScriptError::new();
        let state = tatu_str { ptr: bytes.as_ptr().cast(), len: bytes.len() as u64 };
        let life = unsafe { &*self.lang().life };
        let status = unsafe { life.load.unwrap()(self.data, state, life.version, &mut error.raw) };
        if status < 0 { Err(error) } else { Ok(()) }
    }
    /// Runs a script as `init` and returns the results of its global function `f`.
    pub fn eval(&self, body: &str) -> Result<Vec<Value>, Box<ScriptError>> {
        self.load(&format!("function f(...) {body}\nend"), "test.lua", "")?;
        self.init()?;
        self.function("f", &[])
    }
}

impl Drop for TestScript {
    fn drop(&mut self) {
        let life = unsafe { &*self.lang().life };
        unsafe { life.destroy.unwrap()(self.data) };
    }
}

impl std::fmt::Debug for ScriptError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}:{}: {} ({})\n{}", self.code, self.file, self.line, self.text, self.help, self.traceback)
    }
}
