//! The plugin instances of a world, and the data that they work on.

use std::{
    cell::{Cell, RefCell},
    ffi::c_void,
};

use tatu_devices::{actuators::Actuators, figures::Figures, sense::Sensing};
use tatu_plugins::state_block::StateBlock;

/// A command plugin's instance in a world.
pub(crate) struct CommandInstance {
    pub data: *mut c_void,
    pub state: StateBlock,
    pub destroy: Option<unsafe extern "C" fn(*mut c_void)>,
}

/// Plugin instances and the data they work on: sensors with their readings, actuators, graphs and drawings.
pub(crate) struct WorldDevices {
    pub sensing: RefCell<Sensing>,
    pub actuators: RefCell<Actuators>,
    pub figures: RefCell<Figures>,
    /// Instances of command plugins, indexed by plugin.
    pub instances: RefCell<Vec<Option<CommandInstance>>>,
    pub next_instance: Cell<u64>,
    next_replacement: Cell<u64>,
    /// The version of the tree at which the scripts and devices of removed objects were last ended.
    pub swept_version: Cell<u64>,
}

impl Default for WorldDevices {
    fn default() -> Self {
        WorldDevices {
            sensing: RefCell::default(),
            actuators: RefCell::default(),
            figures: RefCell::default(),
            instances: RefCell::default(),
            next_instance: Cell::new(1),
            next_replacement: Cell::new(1 << 31),
            swept_version: Cell::default(),
        }
    }
}

impl WorldDevices {
    /// Returns an id for a new instance.
    pub fn next_instance_id(&self) -> u64 {
        let id = self.next_instance.get();
        self.next_instance.set(id + 1);
        id
    }
    /// Returns an id for an instance that replaces an existing one. Such ids are in a separate range, so that a reload
    /// does not change the ids of later instances.
    pub fn next_replacement_id(&self) -> u64 {
        let id = self.next_replacement.get();
        self.next_replacement.set(id + 1);
        id
    }
    /// Returns the data and the state block of a plugin's instance in this world. Both are null in a worker, since they
    /// belong to the world's thread.
    #[inline]
    pub fn instance(&self, plugin: usize) -> (*mut c_void, *mut c_void) {
        let all = self.instances.try_borrow();
        let one = all.as_ref().ok().and_then(|all| all.get(plugin)?.as_ref());
        let none = (std::ptr::null_mut(), std::ptr::null_mut());
        one.map_or(none, |i| (i.data, i.state.data_ptr()))
    }
    /// Returns whether a plugin has stayed within the state block of its instance in this world.
    pub fn is_state_intact(&self, plugin: usize) -> bool {
        let Ok(all) = self.instances.try_borrow() else { return true };
        all.get(plugin).and_then(Option::as_ref).is_none_or(|i| i.state.guards_intact())
    }
    /// Repairs the guard of a state block after the overrun has been detected, so that it is reported only once.
    #[cold]
    pub fn repair_state_guard(&self, plugin: usize) {
        if let Ok(mut all) = self.instances.try_borrow_mut()
            && let Some(i) = all.get_mut(plugin).and_then(Option::as_mut)
        {
            i.state.restore_guards();
        }
    }
}
