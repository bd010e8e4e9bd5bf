//! Properties of objects by path, for programs that drive a world: between two steps, without a plugin.

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use super::{answer::Done, properties};
use crate::{cell::WorldCell, run::World};

impl World {
    /// A property of an object by path or unique name: a row such as `joint.position`, or a parameter or command of a
    /// sensor or actuator, `<kind>.<key>`. An empty path is the world itself: `scene.time`.
    ///
    /// # Errors
    /// There is no such object or property.
    pub fn get(&self, path: &str, key: &str) -> Result<Value, Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        properties::read(cell, object, number(cell, key)).map_err(|status| why(cell, status))
    }

    /// Sets a property of an object, likewise, as a script would. It stands in no input log.
    ///
    /// # Errors
    /// There is no such object or property, the value does not fit, or a plugin refuses it.
    pub fn set(&self, path: &str, key: &str, value: &Value) -> Result<(), Refusal> {
        let cell = &**self.cell();
        let object = find(cell, path)?;
        let done: Done = properties::write(cell, object, number(cell, key), value.clone());
        done.map_err(|status| why(cell, status))?;
        cell.restore_process_state("a change by the program");
        Ok(())
    }
}

fn find(cell: &WorldCell, path: &str) -> Result<tatu_object, Refusal> {
    if path.is_empty() {
        return Ok(0);
    }
    let scene = cell.state.scene.borrow();
    if let Some(slot) = scene.find(0, path) {
        return Ok(scene.id(slot));
    }
    let near = scene.nearest(path).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    Err(Refusal(TATU_ERR_MISSING, format!("there is no object `{path}`{near}")))
}

fn number(cell: &WorldCell, key: &str) -> tatu_prop {
    cell.model.registry.host().number(key)
}

/// The sentence of the last refusal.
fn why(cell: &WorldCell, status: tatu_status) -> Refusal {
    Refusal(status, cell.run.calls.last.borrow().text())
}
