//! The functions of the host's command service that scripts use.

use tatu_plugin_api::{abi::*, safe::*};

/// Functions of the host's command service.
#[derive(Clone, Copy)]
pub(crate) struct CommandService {
    find: extern "C" fn(WorldRef<'_>, Lent<'_>, Option<&mut u32>) -> u32,
    pub is_name_space: extern "C" fn(WorldRef<'_>, Lent<'_>) -> u32,
    pub call: unsafe extern "C" fn(WorldRef<'_>, *mut tatu_call) -> tatu_status,
    pub generation: extern "C" fn(WorldRef<'_>) -> u64,
    pub constant: for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, Option<&mut ValueRef<'a>>) -> tatu_status,
    pub mark: extern "C" fn(WorldRef<'_>) -> u64,
    pub alloc: extern "C" fn(WorldRef<'_>, u64) -> *mut std::ffi::c_void,
    pub release: unsafe extern "C" fn(WorldRef<'_>, u64),
    pub call_func: unsafe extern "C" fn(WorldRef<'_>, tatu_func, *mut tatu_call) -> tatu_status,
}

impl CommandService {
    /// Returns the functions of the host, or `None` if the host lacks one of them.
    pub fn of(host: &Host) -> Option<CommandService> {
        let t = host.commands_table()?;
        Some(CommandService {
            find: t.find?,
            is_name_space: t.is_name_space?,
            call: t.call?,
            generation: t.generation?,
            constant: t.constant?,
            mark: t.mark?,
            alloc: t.alloc?,
            release: t.release?,
            call_func: t.call_func?,
        })
    }
    /// Returns the id and alias of a command name as id << 8 | alias, the format stored in bound functions, or 0 if
    /// there is no such command. A command has at most 255 names.
    pub fn number(&self, world: WorldRef<'_>, name: &[u8]) -> u32 {
        let mut alias = 0;
        match (self.find)(world, name.into(), Some(&mut alias)) {
            0 => 0,
            id => id << 8 | alias,
        }
    }
}
