//! Scripts in snapshots: the host's data of each script, and the state that its language saved.

use serde::{Deserialize, Serialize};
use tatu_errors::{Error, Result};

use crate::{
    cell::{CALLBACKS, InstanceImage, Script, Scripts, WaitOwner, WorldCell},
    instances::{InstanceRef, UnsavedInstance, load_instance, save_instance, saved_state_block},
};

/// A script in a snapshot.
#[derive(Serialize, Deserialize)]
pub struct ScriptImage {
    pub slot: u32,
    /// Instance id, or 0 if the script had no state.
    pub id: u64,
    pub initialised: bool,
    pub dead: bool,
    pub cleaned: bool,
    pub ended: bool,
    pub callbacks: Vec<u32>,
    pub calls: u64,
    pub instructions: u64,
    pub instance: InstanceImage,
    /// Number of calls, by callback.
    pub told: std::collections::BTreeMap<String, u64>,
}

impl Scripts {
    /// Returns the images of all scripts, and adds the scripts that could not be saved to `missed`.
    pub fn images(world: &WorldCell, missed: &mut Vec<UnsavedInstance>) -> Vec<ScriptImage> {
        let mut out = Vec::new();
        while let Some(script) = Self::nth(world, out.len()) {
            let mut captured = true;
            let instance = script.save(world).unwrap_or_else(|reason| {
                captured = false;
                let plugin = world.model.registry.scripting.languages[script.language].plugin;
                let plugin = world.model.registry.plugins[plugin].id.clone();
                missed.push(UnsavedInstance {
                    object: format!("the script of {}", script.owner_path(world)),
                    plugin,
                    reason,
                });
                InstanceImage::default()
            });
            out.push(ScriptImage {
                slot: script.slot,
                id: script.instance.id.get(),
                // If the snapshot is restored, a script whose state could not be saved starts from scratch.
                initialised: script.progress.initialised.get() && captured,
                dead: script.progress.dead.get(),
                cleaned: script.progress.cleaned.get(),
                ended: script.progress.ended.get(),
                callbacks: script.instance.callbacks.get().to_vec(),
                calls: script.counters.calls.get(),
                instructions: script.counters.instructions.get(),
                instance,
                told: script.counters.call_counts.calls(),
            });
        }
        out
    }

    /// Ends the scripts that are not in `slots`. Their `cleanup` is not called, since it was called before the
    /// snapshot.
    pub fn end_others(world: &WorldCell, slots: &[u32]) {
        let (keep, gone) = std::mem::take(&mut world.run.scripts.borrow_mut().list)
            .into_iter()
            .partition::<Vec<_>, _>(|s| slots.contains(&s.slot));
        {
            let mut scripts = world.run.scripts.borrow_mut();
            (scripts.list, scripts.sorted_at) = (keep, 0);
        }
        for script in gone {
            script.end(world);
        }
    }

    /// Restores all scripts from their images; their instances must have been created. Adds those whose state blocks
    /// were dropped to `dropped_states`, with the reason.
    pub fn load(world: &WorldCell, images: Vec<ScriptImage>, dropped_states: &mut Vec<(String, String)>) -> Result {
        for image in images {
            let Some(script) = world.run.scripts.borrow().by_slot(image.slot) else { continue };
            let refused = |why: &str| {
                let path = script.owner_path(world);
                Error::new("E503", format!("the script of {path} cannot be restored: {why}"))
                    .help("replay the run up to that step, in a new world with the same scene")
            };
            if script.instance.id.get() != image.id {
                return Err(refused("it was recreated during the run"));
            }
            if image.initialised && !image.dead {
                let life = &world.model.registry.scripting.languages[script.language].life;
                let of =
                    InstanceRef { plugin: script.plugin(world), slot: script.slot, data: script.instance.data.get() };
                let (block, dropped) = saved_state_block(life, &image.instance);
                script.instance.state.borrow_mut().copy_from_slice(&block);
                dropped_states.extend(dropped.map(|why| (format!("the script of {}", script.owner_path(world)), why)));
                load_instance(world, &of, life, &image.instance).map_err(|e| refused(&e))?;
            }
            if !image.initialised {
                world.run.calls.waits.borrow_mut().remove_of(WaitOwner::Script(image.id));
            }
            script.progress.initialised.set(image.initialised);
            script.progress.dead.set(image.dead);
            script.progress.cleaned.set(image.cleaned);
            script.progress.ended.set(image.ended);
            let mut numbers = [0; CALLBACKS.len()];
            numbers.iter_mut().zip(&image.callbacks).for_each(|(n, c)| *n = *c);
            script.instance.callbacks.set(numbers);
            world.run.callback_mask.note(&numbers);
            for (id, name) in numbers.into_iter().zip(CALLBACKS) {
                script.counters.call_counts.set_id(id, name.as_bytes());
            }
            script.counters.calls.set(image.calls);
            script.counters.instructions.set(image.instructions);
            script.counters.call_counts.restore(image.told);
        }
        Ok(())
    }
}

impl Script {
    /// Returns the state that the script's language saves. A script that is not initialised or is dead has no state.
    pub(super) fn save(&self, world: &WorldCell) -> Result<InstanceImage, String> {
        if !self.progress.initialised.get() || self.progress.dead.get() || self.instance.data.get().is_null() {
            return Ok(InstanceImage::default());
        }
        let language = &world.model.registry.scripting.languages[self.language];
        if language.life.save.is_none() {
            return Err(format!("the language `{}` cannot save the state of a script", language.id));
        }
        let of = InstanceRef { plugin: language.plugin, slot: self.slot, data: self.instance.data.get() };
        let state = self.instance.state.borrow().to_vec();
        save_instance(world, &of, &language.life, &state)
    }

    pub(super) fn owner_path(&self, world: &WorldCell) -> String {
        let scene = world.state.scene.borrow();
        scene.path(scene.get(self.slot).map_or(0, |o| o.parent))
    }
}
