//! Changes of properties. Every change of a running world is made here: by services and scripts, by user interfaces, by
//! a reload, and by scripts that run in parallel.

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{ChangeEffect, Scene, property_table::Property};

use crate::cell::WorldCell;

fn busy<T>() -> Result<T, Refusal> {
    let text = "the running call uses the scene; set the property after that call has returned";
    Err(Refusal(TATU_ERR_BUSY, text.into()))
}

impl WorldCell {
    /// Sets a property of an object, which must not belong to its device.
    pub fn set_property(&self, slot: u32, row: Property, value: &Value) -> Result<(), Refusal> {
        let effect = {
            let Ok(mut scene) = self.state.scene.try_borrow_mut() else { return busy() };
            self.set_in_scene(&mut scene, slot, row, value)?
        };
        self.apply_effect(slot, effect)
    }

    /// Sets a property in a scene of this world, without the effects on the engine.
    pub fn set_in_scene(
        &self,
        scene: &mut Scene,
        slot: u32,
        row: Property,
        value: &Value,
    ) -> Result<ChangeEffect, Refusal> {
        if let Some(n) = self.model.document.missing_image(row, value) {
            return Err(Refusal(TATU_ERR_ARGUMENT, format!("`{}`: the scene has no image {n}", row.key())));
        }
        let effect = tatu_scene::set(scene, slot, row, value)?;
        if row == Property::TEXTURE {
            self.model.document.fill_texture(scene, slot);
        }
        Ok(effect)
    }

    /// Sets numbers of an object, if they can be set without checks that concern the whole world; see
    /// [`tatu_scene::set_numbers`].
    pub fn set_numbers(&self, slot: u32, row: Property, numbers: &[f64]) -> Option<Result<(), Refusal>> {
        let done = {
            let Ok(mut scene) = self.state.scene.try_borrow_mut() else { return Some(busy()) };
            tatu_scene::set_numbers(&mut scene, slot, row, numbers)?
        };
        Some(done.and_then(|effect| self.apply_effect(slot, effect)))
    }

    /// Applies the effect of a change to the engine and to graphs.
    pub fn apply_effect(&self, slot: u32, effect: ChangeEffect) -> Result<(), Refusal> {
        match effect {
            ChangeEffect::Moved | ChangeEffect::Motion | ChangeEffect::Drive | ChangeEffect::Surface => {
                let Ok(mut dynamics) = self.state.dynamics.try_borrow_mut() else { return busy() };
                match effect {
                    ChangeEffect::Moved | ChangeEffect::Motion => dynamics.mark_moved(slot),
                    _ => dynamics.mark_drive_changed(slot),
                }
                Ok(())
            }
            ChangeEffect::Graph => {
                let Ok(scene) = self.state.scene.try_borrow() else { return busy() };
                let Ok(mut figures) = self.devices.figures.try_borrow_mut() else { return busy() };
                figures.graphs.remove(&scene.id(slot));
                figures.graph(&scene, scene.id(slot)).map(drop)
            }
            _ => Ok(()),
        }
    }
}
