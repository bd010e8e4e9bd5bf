//! A single script: its creation, its callbacks, the commands that wait on its behalf, and its end.

use std::rc::Rc;

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{
    Registry,
    border::{ErrorContents, ErrorSlot, raw},
    state_block::{PAST_STATE, StateBlock},
    watchdog::PluginCall,
};

use super::enter;
use crate::{
    calls::{call_command, clone_error, read_error},
    cell::{CALLBACKS, Callback, Caller, ExitRequest, Script, ScriptKind, ScriptOrder, WaitOwner, WorldCell},
    instances::to_raw_values,
};

impl Script {
    pub(super) fn is_live(&self, world: &WorldCell) -> bool {
        !self.instance.data.get().is_null()
            && !self.progress.dead.get()
            && world.borrow_part(|w| &w.state.scene).is_some_and(|s| s.get(self.slot).is_some())
    }

    /// Returns the index of the plugin of the script's language.
    pub(super) fn plugin(&self, world: &WorldCell) -> usize {
        world.model.registry.scripting.languages[self.language].plugin
    }

    pub(super) fn raw<'r>(&self, registry: &'r Registry) -> &'r tatu_language {
        &registry.scripting.languages[self.language].raw
    }

    /// Creates the script's state and loads its source. If this fails, the error is reported, and the script does not
    /// run.
    pub(super) fn begin(&self, world: &WorldCell) {
        if self.lacking_permission(world).is_some() {
            self.progress.ended.set(true);
            return self.report_withheld(world);
        }
        if let Err((status, mut error)) = self.try_begin(world, world.devices.next_instance_id()) {
            self.fail(world, status, error.raw());
        }
    }

    /// Like `begin`, but with a given instance id. If it fails, the script must not be called, and the error is
    /// returned instead of being reported.
    pub(super) fn try_begin(&self, world: &WorldCell, number: u64) -> Result<(), (tatu_status, ErrorSlot)> {
        let language = &world.model.registry.scripting.languages[self.language];
        let plugin = &world.model.registry.plugins[language.plugin];
        if let Some(word) = self.lacking_permission(world) {
            let mut error = ErrorSlot::new();
            let text = format!(
                "a script in the language `{}` needs the permission `{word}`: if you trust the scene, allow its scripts \
                 with `--allow {word}`",
                language.id
            );
            error.set(TATU_ERR_UNSUPPORTED, &text);
            return Err((TATU_ERR_UNSUPPORTED, error));
        }
        let (owner, key) = {
            let scene = world.state.scene.borrow();
            let at = scene.get(self.slot).map_or(0, |o| o.parent);
            // The number of earlier scripts of the same object makes the key unique.
            let scripts = world.run.scripts.borrow();
            let before = scripts.list.iter().take_while(|s| s.slot != self.slot);
            let number = before.filter(|s| scene.get(s.slot).is_some_and(|o| o.parent == at)).count();
            (scene.id(self.slot), format!("{}/script{number}", scene.get(at).map_or(String::new(), |o| o.name())))
        };
        let state = StateBlock::new(language.life.state_bytes);
        let values = world.model.document.language_params(&world.model.registry, self.language);
        let (params, _room) = to_raw_values(&values);
        let info = tatu_instance {
            n_params: params.len() as u32,
            params: params.as_ptr(),
            state: state.data_ptr(),
            ..world.instance_info_with_id(owner, &key, number)
        };
        self.instance.id.set(info.id);
        self.instance.state.replace(state);
        let (mut data, mut error) = (std::ptr::null_mut(), ErrorSlot::new());
        world.run.calls.caller.set(self.as_caller(world));
        // SAFETY: `create` is from a plugin that is never unloaded. `info`, `data` and `error` live until the call has
        // returned.
        let create =
            || language.life.create.map_or(TATU_ERR, |f| unsafe { f(plugin.me, &info, &mut data, error.raw()) });
        {
            // Calls of the script's commands are recorded under its owner.
            let scene = world.state.scene.borrow();
            let owner = scene.get(self.slot).map_or(0, |o| o.parent);
            world.monitor.watch.set_object_name(owner, scene.path(owner));
            world.monitor.watch.set_object_name(self.slot, scene.path(self.slot));
        }
        let status = world.call_plugin(language.plugin, PluginCall::Create, self.slot, create);
        let status = error.check_status(status, false);
        if status < 0 {
            world.run.calls.caller.set(Caller::HOST);
            error.name_plugin(status, &plugin.id, PluginCall::Create);
            return Err((status, error));
        }
        self.check_state_block(world, PluginCall::Create);
        self.instance.data.set(data);
        self.progress.initialised.set(false);
        self.progress.dead.set(false);
        self.progress.cleaned.set(false);
        self.progress.ended.set(false);
        self.progress.exit_request.set(ExitRequest::Nothing);
        self.instance.callbacks.set([0; CALLBACKS.len()]);
        self.counters.calls.set(0);
        let mut chosen = raw(&[]);
        let copy = world.model.registry.inspector.as_ref();
        let copy = copy.and_then(|i| i.copy_of_source(language.plugin, &self.text));
        let text = raw(copy.as_ref().map_or(&self.text, |c| c.bytes()));
        let (name, dialect) = (raw(self.name.as_bytes()), raw(self.wanted_dialect.as_bytes()));
        let load = || {
            // SAFETY: `data` points to the instance that `create` created. The strings, `chosen` and the error object
            // live until the call has returned.
            language.raw.load.map_or(TATU_ERR, |f| unsafe { f(data, text, name, dialect, &mut chosen, error.reset()) })
        };
        let status = world.call_plugin(language.plugin, PluginCall::ScriptLoad, self.slot, load);
        let status = error.check_status(status, false);
        world.run.calls.caller.set(Caller::HOST);
        if status < 0 {
            self.progress.dead.set(true);
            error.name_plugin(status, &plugin.id, PluginCall::ScriptLoad);
            return Err((status, error));
        }
        let is_within = |text: tatu_str| {
            text.ptr.addr() <= chosen.ptr.addr() && chosen.ptr.addr() < text.ptr.addr() + text.len as usize
        };
        if chosen.len > 0 && [text, name, dialect].into_iter().any(is_within) {
            let what = "returned a dialect in `chosen` that points into its arguments; it must own this string";
            self.report_breach(world, PluginCall::ScriptLoad, what);
        }
        self.instance.dialect.set(if chosen.ptr.is_null() { raw(&[]) } else { chosen });
        // SAFETY: `data` points to a live instance of the language, whose plugin is never unloaded.
        let traits = || language.raw.traits.map_or(0, |f| unsafe { f(data) });
        let traits = world.call_plugin_reporting(language.plugin, PluginCall::ScriptTraits, self.slot, traits);
        let known = TATU_SCRIPT_SILENT | TATU_SCRIPT_MODERN | TATU_SCRIPT_THREADED;
        if traits & !known != 0 {
            self.report_breach(
                world,
                PluginCall::ScriptTraits,
                &format!("returned the traits {traits:#x}, but only the bits {known:#x} are defined"),
            );
        }
        let traits = if traits & !known == 0 { traits } else { 0 };
        self.instance.traits.set(traits);
        self.instance.threaded.set(traits & TATU_SCRIPT_THREADED != 0);
        // SAFETY: the string is owned by the instance, which was just created and lives until the string has been
        // copied.
        *self.counters.call_counts.dialect.borrow_mut() =
            unsafe { tatu_plugins::border::text(self.instance.dialect.get()) }.into_owned();
        self.counters.call_counts.clear_ids();
        Ok(())
    }

    /// Returns the order that the script's language requires in a world with this dialect, if any.
    pub(super) fn order_of(&self, world: &WorldCell, dialect: &str, modern: bool) -> Option<ScriptOrder> {
        let order = self.raw(&world.model.registry).order?;
        // SAFETY: `self.instance.data` points to a live instance of the language, whose plugin is never unloaded. The string
        // lives until the call has returned.
        let order = || unsafe { order(self.instance.data.get(), raw(dialect.as_bytes()), modern.into()) };
        match world.call_plugin_reporting(self.plugin(world), PluginCall::ScriptOrder, self.slot, order) {
            0 => None,
            number => ScriptOrder::of(number).or_else(|| {
                self.report_breach(
                    world,
                    PluginCall::ScriptOrder,
                    &format!("returned the unknown order {number}; expected one of TATU_ORDER_*"),
                );
                None
            }),
        }
    }

    /// Adds the script's current position to a fault, while a command that the script has called is running.
    pub fn add_position(&self, world: &WorldCell, fault: &mut Fault) {
        let Some(place) = self.raw(&world.model.registry).place.filter(|_| !self.instance.data.get().is_null()) else {
            return;
        };
        let mut error = ErrorSlot::new();
        let raw = error.reset();
        // SAFETY: `self.instance.data` points to a live instance of the language, as checked above. The error object lives until
        // the call has returned.
        world.call_plugin_reporting(self.plugin(world), PluginCall::ScriptPlace, self.slot, || unsafe {
            place(self.instance.data.get(), raw)
        });
        let said = error.contents();
        (fault.file, fault.traceback) = (said.file, said.traceback);
        fault.line = Some(said.line).filter(|line| *line > 0);
    }

    /// Reports a write outside the script's state block.
    pub(super) fn check_state_block(&self, world: &WorldCell, call: PluginCall) {
        let is_whole = |block: &StateBlock| block.is_empty() || block.guards_intact();
        if self.instance.state.try_borrow().is_ok_and(|block| is_whole(&block)) {
            return;
        }
        if let Ok(mut block) = self.instance.state.try_borrow_mut() {
            block.restore_guards();
        }
        self.report_breach(world, call, PAST_STATE);
    }

    /// Reports that the script's language returned something invalid; `what` begins with a verb.
    fn report_breach(&self, world: &WorldCell, call: PluginCall, what: &str) {
        let id = &world.model.registry.plugins[self.plugin(world)].id;
        let mut fault = Fault::new(FaultKind::Plugin, format!("plugin `{id}` {what} [{}]", call.text()));
        fault.plugin = Some(id.clone());
        fault.object = world.state.scene.try_borrow().ok().and_then(|s| s.get(self.slot).map(|o| s.path(o.parent)));
        world.report(fault);
    }

    /// Calls `init`, looks up the callbacks, and starts the thread function.
    pub(super) fn initialise(self: &Rc<Self>, world: &WorldCell) {
        self.initialise_and(world, || {});
    }

    /// Like `initialise`, but calls `then` after `init` if that succeeded.
    pub(super) fn initialise_and(self: &Rc<Self>, world: &WorldCell, then: impl FnOnce()) {
        self.progress.initialised.set(true);
        let init = self.find(world, TATU_FIND_CALLBACK, b"init");
        self.callback(world, init);
        if self.is_live(world) {
            then();
        }
        self.find_callbacks(world);
        let thread = self.number(Callback::Thread);
        if thread != 0 && self.is_live(world) {
            self.callback(world, thread);
        }
    }

    pub(super) fn find_callbacks(&self, world: &WorldCell) {
        let find = |i: usize| self.find(world, TATU_FIND_CALLBACK, CALLBACKS[i].as_bytes());
        let numbers = std::array::from_fn(find);
        self.instance.callbacks.set(numbers);
        world.run.callback_mask.note(&numbers);
    }

    pub fn find(&self, world: &WorldCell, how: u32, name: &[u8]) -> u32 {
        if self.instance.data.get().is_null() || self.progress.dead.get() {
            return 0;
        }
        let (data, find) = (self.instance.data.get(), self.raw(&world.model.registry).find);
        // SAFETY: `data` points to a live instance of the language, whose plugin is never unloaded. The name lives until
        // the call has returned.
        let find = || find.map_or(0, |f| unsafe { f(data, how, raw(name)) });
        let id = world.call_plugin_reporting(self.plugin(world), PluginCall::ScriptFind, self.slot, find);
        if how == TATU_FIND_CALLBACK {
            self.counters.call_counts.set_id(id, name);
        }
        id
    }

    pub(super) fn callback(self: &Rc<Self>, world: &WorldCell, id: u32) {
        self.callback_with(world, id, &[]);
    }

    /// Calls a callback. An error is reported as a fault of this script, and the callbacks are then looked up again.
    pub(super) fn callback_with(self: &Rc<Self>, world: &WorldCell, id: u32, args: &[tatu_value]) {
        if self.is_live(world) {
            self.run_callback(world, id, args);
        }
    }

    pub(super) fn run_callback(self: &Rc<Self>, world: &WorldCell, id: u32, args: &[tatu_value]) {
        self.query_callback(world, id, args);
        self.carry_out_request(world);
    }

    /// Calls a callback, and returns its answer if it is a map.
    pub(super) fn query_callback(self: &Rc<Self>, world: &WorldCell, id: u32, args: &[tatu_value]) -> Option<Value> {
        self.query_callback_or(world, id, args, |status, error| {
            self.fail(world, status, error);
            self.find_callbacks(world);
        })
    }

    /// Like `query_callback`, but passes an error to `failed`.
    pub(super) fn query_callback_or(
        self: &Rc<Self>,
        world: &WorldCell,
        id: u32,
        args: &[tatu_value],
        failed: impl FnOnce(tatu_status, *mut tatu_error),
    ) -> Option<Value> {
        let call = self.raw(&world.model.registry).call.filter(|_| id != 0)?;
        self.counters.calls.set(self.counters.calls.get() + 1);
        self.counters.call_counts.count(id);
        let mark = world.run.calls.arena.borrow().mark();
        let mut room = enter::ResultBuffer::new();
        let mut frame = room.frame(args);
        frame.flags = if world.worker.is_some() { TATU_CALL_SIDE_BY_SIDE } else { 0 };
        // SAFETY: `data` points to the script's live instance. The frame and the error object live until the call has
        // returned.
        let status =
            enter::enter(world, self, PluginCall::ScriptCall, &mut frame, |data, frame, budget, used, error| unsafe {
                call(data, id, frame, budget, used, error)
            });
        let answer = if status < 0 {
            failed(status, frame.error);
            None
        } else {
            self.read_answer(&frame)
        };
        world.run.calls.arena.borrow_mut().release(mark);
        answer
    }

    /// Resumes the commands of this script that have finished waiting: calls them again, and passes their results to
    /// the coroutines.
    pub(super) fn resume_waits(self: &Rc<Self>, world: &WorldCell) {
        let owner = WaitOwner::Script(self.instance.id.get());
        let due = world.run.calls.waits.borrow_mut().take_due(owner, |due| world.is_condition_met(due));
        for wait in due {
            if !self.is_live(world) {
                return;
            }
            let mark = world.run.calls.arena.borrow().mark();
            let mut room = enter::ResultBuffer::new();
            let mut frame = room.frame(&[]);
            (frame.command, frame.alias, frame.wait_token) = (wait.command, wait.alias, wait.token);
            world.run.calls.caller.set(self.as_caller(world));
            world.run.calls.thread_results.resume(&wait.due);
            // SAFETY: the frame and its arrays are local and live until the call has returned.
            let status = unsafe { call_command(world, &mut frame, wait.resume) };
            world.run.calls.caller.set(Caller::HOST);
            if status != TATU_WAIT {
                self.resume(world, wait.token, status, &frame);
            }
            world.run.calls.arena.borrow_mut().release(mark);
        }
    }

    pub(super) fn resume(self: &Rc<Self>, world: &WorldCell, token: u64, failed: tatu_status, done: &tatu_call) {
        let Some(resume) = self.raw(&world.model.registry).resume else { return };
        let mut room = enter::ResultBuffer::new();
        // SAFETY: `done.results` points to `n_results` values of the command that has returned; they are valid until
        // the space for the frame's results is dropped.
        let results = unsafe { std::slice::from_raw_parts(done.results, done.n_results as usize) };
        let mut frame = room.frame(results);
        // The call below reuses the slot of the command's error object, so its contents are copied.
        let mut carried = if failed < 0 { clone_error(done.error) } else { ErrorSlot::new() };
        let carried = carried.raw();
        let status = enter::enter_with_error(
            world,
            self,
            PluginCall::ScriptResume,
            &mut frame,
            carried,
            |data, frame, budget, used, error| {
                // SAFETY: `data` points to the script's live instance. The frame and the error objects live until the
                // call has returned.
                unsafe { resume(data, token, failed.min(0), frame, budget, used, error) }
            },
        );
        if status < 0 {
            self.fail(world, status, frame.error);
            self.find_callbacks(world);
        }
        self.carry_out_request(world);
    }

    pub(super) fn end(&self, world: &WorldCell) {
        if self.instance.data.get().is_null() {
            return;
        }
        world.run.calls.waits.borrow_mut().remove_of(WaitOwner::Script(self.instance.id.get()));
        self.destroy(world);
    }

    pub(super) fn destroy(&self, world: &WorldCell) {
        let data = self.instance.data.replace(std::ptr::null_mut());
        if data.is_null() {
            return;
        }
        self.progress.initialised.set(false);
        self.instance.dialect.set(raw(&[]));
        self.instance.id.set(0);
        if let Some(destroy) = world.model.registry.scripting.languages[self.language].life.destroy {
            // SAFETY: `data` was created by `create`, from a plugin that is never unloaded. It is destroyed only once,
            // since it has been replaced with null.
            world
                .call_plugin_reporting(self.plugin(world), PluginCall::Destroy, self.slot, || unsafe { destroy(data) });
        }
    }

    pub fn as_caller(&self, world: &WorldCell) -> Caller {
        let (script, object) = match world.borrow_part(|w| &w.state.scene) {
            Some(scene) => (scene.id(self.slot), scene.id(scene.get(self.slot).map_or(0, |o| o.parent))),
            None => (0, 0),
        };
        Caller {
            kind: TATU_CALLER_SCRIPT,
            instance: self.instance.id.get(),
            object,
            script,
            dialect: self.instance.dialect.get(),
            service: 0,
        }
    }

    /// Reports an error of the script. A script that has exceeded its budget is not called again. After other errors,
    /// scripts of some dialects, and scripts that are not part of the document, are silenced.
    pub(super) fn fail(&self, world: &WorldCell, status: tatu_status, error: *const tatu_error) {
        let fault = self.fault(world, status, error);
        if status == TATU_ERR_BUDGET {
            self.progress.dead.set(true);
        } else if self.instance.traits.get() & TATU_SCRIPT_SILENT != 0 || self.kind >= ScriptKind::Addon {
            self.request_exit(ExitRequest::Silence);
        }
        world.report(fault);
    }

    pub(crate) fn fault(&self, world: &WorldCell, status: tatu_status, error: *const tatu_error) -> Fault {
        let kind = FaultKind::of(status);
        let ErrorContents { text, help, file, traceback, line } = read_error(error);
        let mut fault = Fault::new(kind, text.unwrap_or_else(|| "failed without giving a reason".into()));
        let language = &world.model.registry.plugins[self.plugin(world)].id;
        if fault.message.starts_with(&format!("plugin `{language}` ")) {
            (fault.kind, fault.code) = (FaultKind::Plugin, FaultKind::Plugin.code());
        }
        fault.script = Some(self.name.clone());
        if let Ok(scene) = world.state.scene.try_borrow() {
            // Scripts that are not part of the document have no owner.
            fault.object = scene.get(self.slot).filter(|o| o.parent != 0).map(|o| scene.path(o.parent));
        }
        (fault.help, fault.traceback) = (help, traceback);
        fault.line = (line > 0).then_some(line);
        fault.file = file.filter(|_| line > 0);
        let blame = world.run.calls.blame.borrow_mut().take();
        fault.plugin = blame.filter(|(text, _)| fault.message.contains(text.as_str())).map(|(_, plugin)| plugin);
        if fault.kind == FaultKind::Plugin && fault.plugin.is_none() {
            fault.plugin = Some(language.clone());
        }
        if status == TATU_ERR_BUDGET && fault.message.contains("instructions") {
            fault.help = Some("look for an endless loop, or increase `instructions` in [scene.budget]".into());
        }
        fault
    }
}
