//! The scripts of a world in a step: their callbacks, their functions, and the commands that wait on their behalf.
//!
//! - `life`: the life cycle, from the first pass before a run to the end of the world;
//! - `script`: one script's callbacks, and the commands that wait on its behalf; `answers`: requests in the answers of
//!   callbacks;
//! - `parallel_scripts`: scripts that run on several threads at once;
//! - `permission`: scripts that the user has not allowed to run;
//! - `enter`: the common path into a script's language, with budget, caller and errors;
//! - `reload`: replaces the source of a running script;
//! - `snapshot`: scripts in snapshots.

mod answers;
mod enter;
mod life;
mod parallel_scripts;
mod permission;
mod reload;
mod script;
mod snapshot;

use std::rc::Rc;

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{ObjectVariant, document::ScriptSpec, is_alias};

pub(crate) use answers::map_entry;
pub(crate) use enter::{ResultBuffer, call_func, call_function, drop_func, keep_func, owner_of_func};
pub(crate) use reload::{SaveResult, StateTransfer};
pub(crate) use snapshot::ScriptImage;

use crate::cell::{Callback, Script, ScriptKind, ScriptSummary, Scripts, WorldCell};

impl Scripts {
    /// Adds the scripts of the document. Each script is represented by an object, whose parent is the script's owner.
    pub fn add_from_document(world: &WorldCell, slots: &[u32]) {
        for (spec, owner) in world.model.document.objects.iter().zip(slots) {
            for s in &spec.scripts {
                Self::add(world, *owner, s);
            }
        }
    }

    /// Adds a script that belongs to an object, or to no object if `owner` is 0. Returns the slot of the script's own
    /// object, or `None` if no slot is free or its kind is unknown.
    pub fn add(world: &WorldCell, owner: u32, spec: &ScriptSpec) -> Option<u32> {
        let kind = ScriptKind::parse(&spec.kind)?;
        let local = nalgebra::Isometry3::identity();
        let mut scene = world.state.scene.try_borrow_mut().ok()?;
        // In files where scripts are objects, the name is an alias; otherwise it is the name of a source file or of the
        // owner.
        let is_owners = scene.get(owner).is_some_and(|o| o.alias() == spec.name);
        let is_own = is_alias(&spec.name) && !spec.name.contains('.') && !is_owners;
        let of_object = matches!(kind, ScriptKind::Child | ScriptKind::Customization);
        let alias = if is_own && of_object { spec.name.as_str() } else { "script" };
        let slot = scene.add(owner, alias, local, ObjectVariant::Script)?;
        drop(scene);
        let default = world.model.settings.borrow().dialect.clone();
        let script = Rc::new(Script::new(slot, kind, spec, default));
        script.progress.late.set(world.running());
        world.run.callback_mask.note_kind(kind, script.progress.late.get());
        let mut scripts = world.run.scripts.try_borrow_mut().ok()?;
        scripts.list.push(script);
        scripts.sorted_at = 0;
        scripts.seal_referees(world);
        Some(slot)
    }

    /// Returns the `i`-th script, cloned so that the list is not borrowed while the script runs.
    fn nth(world: &WorldCell, i: usize) -> Option<Rc<Script>> {
        world.run.scripts.try_borrow().ok()?.list.get(i).cloned()
    }
    /// Returns whether a script that is not part of the document could end a pause.
    pub fn any_addon_handles_pause(&self) -> bool {
        let waits = |s: &Rc<Script>| {
            s.kind >= ScriptKind::Addon && !s.progress.dead.get() && s.number(Callback::Suspended) != 0
        };
        self.list.iter().any(waits)
    }
    /// Returns whether the caller is a script whose state ends with the run.
    pub fn caller_is_of_run(world: &WorldCell) -> bool {
        let caller = world.run.calls.caller.get();
        let script = world.run.scripts.try_borrow().ok().and_then(|s| s.by_id(caller.instance));
        script.is_some_and(|s| s.kind.ends_with_run())
    }
    /// Returns whether any script that has begun defines a callback.
    pub fn any_has(world: &WorldCell, callback: Callback) -> bool {
        let has = |s: &Rc<Script>| s.progress.initialised.get() && !s.progress.dead.get() && s.number(callback) != 0;
        world.run.callback_mask.has(callback) && world.run.scripts.try_borrow().is_ok_and(|s| s.list.iter().any(has))
    }

    /// Returns the script that runs the stages itself, if the world has one.
    pub fn driver(world: &WorldCell) -> Option<Rc<Script>> {
        if !world.run.callback_mask.any_driver() {
            return None;
        }
        world.run.scripts.try_borrow().ok()?.list.iter().find(|s| s.kind == ScriptKind::Main).cloned()
    }

    /// Returns all scripts in the current calling order. Scripts that were added while the simulation was running and
    /// have not begun are last.
    fn in_order(world: &WorldCell) -> Rc<[Rc<Script>]> {
        let (Ok(mut scripts), Ok(scene)) = (world.run.scripts.try_borrow_mut(), world.state.scene.try_borrow()) else {
            return Rc::default();
        };
        if scripts.sorted_at != scene.versions.shape {
            let mut sorted = scripts.list.clone();
            crate::cell::sort(&mut sorted, &scene, scripts.order);
            (scripts.sorted, scripts.sorted_at) = (sorted.into(), scene.versions.shape);
        }
        let is_new = |s: &Rc<Script>| s.progress.late.get() && !s.progress.initialised.get();
        if !world.run.callback_mask.any_late() || !scripts.sorted.iter().any(is_new) {
            return scripts.sorted.clone();
        }
        let mut all = scripts.sorted.to_vec();
        all.sort_by_key(is_new);
        all.into()
    }

    /// Sets the calling order of the world to that of the first language that defines one.
    fn choose_order(world: &WorldCell) {
        let all = world.run.scripts.borrow().list.clone();
        let modern = all.iter().any(|s| s.instance.traits.get() & TATU_SCRIPT_MODERN != 0);
        let dialect = world.model.settings.borrow().dialect.clone();
        let (mut told, mut asked) = (None, Vec::new());
        for script in all.iter().filter(|s| s.has_loaded()) {
            if !asked.contains(&script.language) {
                asked.push(script.language);
                let order = script.order_of(world, &dialect, modern);
                told = told.or(order);
            }
        }
        let mut scripts = world.run.scripts.borrow_mut();
        (scripts.order, scripts.sorted_at) = (told.unwrap_or_default(), 0);
    }

    /// Calls `f` with all scripts except the driver, in order.
    fn each_called(world: &WorldCell, f: impl Fn(&Rc<Script>)) {
        for script in &*Self::in_order(world) {
            script.call_unless_driver(world, &f);
        }
    }

    /// Like `each_called`, but for a stage that calls a callback. Consecutive scripts that permit it run in parallel.
    fn each_in_turn(world: &WorldCell, callback: Callback, f: impl Fn(&Rc<Script>)) {
        let order = Self::in_order(world);
        let mut rest = 0..order.len();
        while let Some(i) = rest.next() {
            let beside = parallel_scripts::parallel_count(world, &order[i..]);
            if beside > 0 {
                parallel_scripts::run(world, &order[i..i + beside], callback, &f);
                rest.start = i + beside;
                continue;
            }
            order[i].call_unless_driver(world, &f);
        }
    }

    /// Calls a callback of all scripts that have begun and define it.
    fn each_has(world: &WorldCell, callback: Callback) {
        if Self::any_has(world, callback) {
            Self::each_called(world, |s| s.run_if_begun(world, callback, &[]));
        }
    }

    /// Like `each_has`, but with one argument.
    pub fn call_with_payload(world: &WorldCell, callback: Callback, payload: &Value) {
        if Self::any_has(world, callback) {
            Self::with_payload(world, payload, |payload| {
                Self::each_called(world, |s| s.run_if_begun(world, callback, &[payload]));
            });
        }
    }

    /// Notifies the scripts of sensors that the sensors have been measured, in order.
    pub fn notify_measured(world: &WorldCell, sensors: &[u32]) {
        if !Self::any_has(world, Callback::Measured) {
            return;
        }
        Self::each_called(world, |script| {
            let sensor = world.state.scene.try_borrow().ok().and_then(|scene| {
                let owner = scene.get(script.slot)?.parent;
                sensors.contains(&owner).then(|| scene.id(owner))
            });
            if let Some(sensor) = sensor {
                let payload = Value::Map(vec![(Value::text("sensor"), Value::Object(sensor))]);
                Self::with_payload(world, &payload, |p| script.run_if_begun(world, Callback::Measured, &[p]));
            }
        });
    }

    /// Calls a callback of the scripts that define it, in order or in reverse order, until a script answers with a map.
    /// An answer whose key `ignore` is true is skipped.
    pub fn first_answer(world: &WorldCell, callback: Callback, payload: &Value, last_first: bool) -> Option<Value> {
        let mut all = Self::in_order(world).to_vec();
        if last_first {
            all.reverse();
        }
        let mut answer = None;
        Self::with_payload(world, payload, |payload| {
            answer = all.iter().find_map(|script| {
                let number = script.number(callback);
                if number == 0 || !script.progress.initialised.get() || !script.is_live(world) {
                    return None;
                }
                let answer = script.query_callback(world, number, &[payload]);
                script.carry_out_request(world);
                answer.filter(|a| map_entry(a, "ignore") != Some(&Value::Bool(true)))
            });
        });
        answer
    }

    /// Calls `f` with a value in ABI form.
    fn with_payload(world: &WorldCell, payload: &Value, f: impl FnOnce(tatu_value)) {
        let mark = world.run.calls.arena.borrow().mark();
        let raw = {
            let mut arena = world.run.calls.arena.borrow_mut();
            payload.to_raw(&mut *arena)
        };
        if let Some(raw) = raw {
            f(raw);
        }
        world.run.calls.arena.borrow_mut().release(mark);
    }

    /// Calls a callback by name in all scripts that define it, except one.
    pub fn broadcast(world: &WorldCell, name: &[u8], args: &[tatu_value], except: u32) {
        for script in &*Self::in_order(world) {
            let is_called = script.slot != except && !world.run.calls.hides(script.slot);
            if is_called && script.is_live(world) && script.progress.initialised.get() {
                let id = script.find(world, TATU_FIND_CALLBACK, name);
                if id != 0 {
                    script.callback_with(world, id, args);
                }
            }
        }
    }

    /// Cleans up and ends scripts whose objects have been removed.
    pub fn end_removed(world: &WorldCell) {
        let gone: Vec<Rc<Script>> = {
            let (Ok(mut scripts), Ok(scene)) = (world.run.scripts.try_borrow_mut(), world.state.scene.try_borrow())
            else {
                return;
            };
            let is_there = |s: &Rc<Script>| matches!(scene.get(s.slot).map(|o| &o.data), Some(ObjectVariant::Script));
            if scripts.list.iter().all(is_there) {
                return;
            }
            let (keep, gone) = std::mem::take(&mut scripts.list).into_iter().partition(is_there);
            (scripts.list, scripts.sorted_at) = (keep, 0);
            gone
        };
        for script in gone {
            // The object no longer exists, but the script's state does, so that the script can close its files.
            if script.progress.initialised.get()
                && !script.progress.dead.get()
                && !script.progress.cleaned.get()
                && !script.instance.data.get().is_null()
            {
                script.run_callback(world, script.number(Callback::Cleanup), &[]);
            }
            script.end(world);
        }
    }
}

impl Scripts {
    /// Restores the scripts of the scene to those of an earlier state. Their objects must have been restored already.
    /// Unchanged scripts continue. If `texts` is false, scripts that still exist keep their present sources.
    pub fn restore(world: &WorldCell, wanted: &[(u32, ScriptSpec)], texts: bool) {
        let default = world.model.settings.borrow().dialect.clone();
        let mut replaced = Vec::new();
        {
            let mut scripts = world.run.scripts.borrow_mut();
            let old = std::mem::take(&mut scripts.list);
            let (mut there, outside): (Vec<_>, Vec<_>) = old.into_iter().partition(|s| s.kind < ScriptKind::Addon);
            for (slot, spec) in wanted {
                let Some(kind) = ScriptKind::parse(&spec.kind) else { continue };
                let known = there.iter().position(|s| s.slot == *slot).map(|at| there.remove(at));
                match known {
                    Some(same) if !texts || same.spec(same.text.to_vec()) == *spec => scripts.list.push(same),
                    other => {
                        world.run.callback_mask.note_kind(kind, false);
                        scripts.list.push(Rc::new(Script::new(*slot, kind, spec, default.clone())));
                        replaced.extend(other);
                    }
                }
            }
            replaced.extend(there);
            scripts.list.extend(outside);
            scripts.sorted_at = 0;
            scripts.seal_referees(world);
        }
        replaced.iter().for_each(|script| script.end_replaced(world));
    }

    /// Hides the referees from everything but the host, and nothing else.
    fn seal_referees(&self, world: &WorldCell) {
        let referees = self.list.iter().filter(|s| s.kind == ScriptKind::Referee);
        *world.run.calls.sealed.borrow_mut() = referees.map(|s| s.slot).collect();
    }

    /// Returns a summary of each script, in the order in which the scripts were added.
    pub fn summaries(world: &WorldCell) -> Vec<ScriptSummary> {
        let Ok(scripts) = world.run.scripts.try_borrow() else { return Vec::new() };
        scripts.list.iter().map(|s| s.summary(world)).collect()
    }
}

impl Script {
    fn summary(&self, world: &WorldCell) -> ScriptSummary {
        ScriptSummary {
            object: self.owner_path(world),
            kind: self.kind_name.clone(),
            dialect: self.counters.call_counts.dialect.borrow().clone(),
            calls: self.counters.call_counts.calls(),
            instructions: self.counters.instructions.get(),
        }
    }
}
