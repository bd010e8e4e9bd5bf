//! The functions of the host that scripts use.

use std::ffi::{CStr, c_char};

use tatu_plugin_api::{abi::*, safe::*};

/// Functions of the host's command service.
#[derive(Clone, Copy)]
pub(crate) struct CommandService {
    find: extern "C" fn(WorldRef<'_>, Lent<'_>, Option<&mut u32>) -> u32,
    count: extern "C" fn(WorldRef<'_>) -> u32,
    describe: extern "C" fn(WorldRef<'_>, u32) -> *const tatu_command,
    is_name_space: extern "C" fn(WorldRef<'_>, Lent<'_>) -> u32,
    pub call: unsafe extern "C" fn(WorldRef<'_>, *mut tatu_call) -> tatu_status,
    pub call_func: unsafe extern "C" fn(WorldRef<'_>, tatu_func, *mut tatu_call) -> tatu_status,
    generation: extern "C" fn(WorldRef<'_>) -> u64,
    constant: for<'a> extern "C" fn(WorldRef<'a>, Lent<'_>, Option<&mut ValueRef<'a>>) -> tatu_status,
    prelude: for<'a> extern "C" fn(
        WorldRef<'a>,
        LentCStr<'_>,
        u32,
        Option<&mut Lent<'a>>,
        Option<&mut Lent<'a>>,
    ) -> tatu_status,
    mark: extern "C" fn(WorldRef<'_>) -> u64,
    release: unsafe extern "C" fn(WorldRef<'_>, u64),
}

/// What a name stands for.
pub(crate) enum Meaning<'a> {
    Nothing,
    /// A command: id << 8 | alias.
    Command(u32),
    Constant(ValueRef<'a>),
    NameSpace,
}

impl CommandService {
    /// Returns the functions of the host, or `None` if the host lacks one of them.
    pub fn of(host: &Host) -> Option<CommandService> {
        let t = host.commands_table()?;
        Some(CommandService {
            find: t.find?,
            count: t.count?,
            describe: t.describe?,
            is_name_space: t.is_name_space?,
            call: t.call?,
            call_func: t.call_func?,
            generation: t.generation?,
            constant: t.constant?,
            prelude: t.prelude?,
            mark: t.mark?,
            release: t.release?,
        })
    }

    /// Returns what a name stands for.
    pub fn meaning<'a>(&self, world: WorldRef<'a>, name: &[u8]) -> Meaning<'a> {
        let (mut alias, mut constant) = (0, ValueRef::NIL);
        match (self.find)(world, name.into(), Some(&mut alias)) {
            0 if (self.constant)(world, name.into(), Some(&mut constant)) == TATU_OK => Meaning::Constant(constant),
            0 if (self.is_name_space)(world, name.into()) != 0 => Meaning::NameSpace,
            0 => Meaning::Nothing,
            id => Meaning::Command(id << 8 | alias & 0xFF),
        }
    }

    pub fn generation(&self, world: WorldRef<'_>) -> u64 {
        (self.generation)(world)
    }

    /// Returns the modules that plugins provide for scripts of this language: names and texts.
    pub fn preludes<'a>(&self, world: WorldRef<'a>) -> impl Iterator<Item = (&'a [u8], &'a [u8])> {
        let next = self.prelude;
        (0..).map_while(move |index| {
            let (mut module, mut text) = (Lent::EMPTY, Lent::EMPTY);
            let status = next(world, c"python".into(), index, Some(&mut module), Some(&mut text));
            (status == TATU_OK).then(|| (module.bytes(), text.bytes()))
        })
    }

    /// Returns the name of a command that is most similar to `name`, if any is similar enough.
    pub fn nearest(&self, world: WorldRef<'_>, name: &str) -> Option<String> {
        const MAX_COMPARED: usize = 100;
        if name.len() > MAX_COMPARED {
            return None;
        }
        let lower = name.to_lowercase();
        let names = (1..=(self.count)(world)).flat_map(|id| self.names(world, id));
        let near = names.filter(|n| n.len() <= MAX_COMPARED).map(|n| {
            let distance = strsim::damerau_levenshtein(&lower, &n.to_lowercase());
            (distance, n)
        });
        near.filter(|(distance, n)| *distance <= 1 + n.len().max(name.len()) / 5).min().map(|(_, n)| n)
    }

    /// Returns the declaration of a command as the documentation of a Python function.
    pub fn describe(&self, world: WorldRef<'_>, id: u32) -> String {
        // SAFETY: the host returns null or a declaration of its own, which lives as long as the host, with
        // null-terminated lists and strings.
        unsafe {
            let Some(command) = (self.describe)(world, id).as_ref() else { return String::new() };
            let names = |list: *const *const tatu_param| {
                let all = items(list).map(|p| text((*p).key));
                all.collect::<Vec<_>>().join(", ")
            };
            let name = items(command.names).next().map_or(String::new(), |n| text((*n).name));
            let returns = names(command.returns);
            let arrow = if returns.is_empty() { String::new() } else { format!(" -> {returns}") };
            format!("{name}({}){arrow}\n\n{}", names(command.params), text(command.text))
        }
    }

    fn names(&self, world: WorldRef<'_>, id: u32) -> Vec<String> {
        // SAFETY: as in `describe`.
        unsafe {
            let command = (self.describe)(world, id).as_ref();
            command.map_or(Vec::new(), |command| items(command.names).map(|n| text((*n).name)).collect())
        }
    }

    /// Calls `f`, and then releases what was allocated in the world's arena meanwhile.
    pub fn released<T>(&self, world: WorldRef<'_>, f: impl FnOnce() -> T) -> T {
        let mark = (self.mark)(world);
        let result = f();
        // SAFETY: the callers copy what they need of the arena within `f`.
        unsafe { (self.release)(world, mark) };
        result
    }
}

/// Returns the elements of a null-terminated list.
///
/// # Safety
/// `list` must be null or such a list, which lives as long as the iterator.
unsafe fn items<T>(list: *const *const T) -> impl Iterator<Item = *const T> {
    // SAFETY: the caller guarantees a terminator, and nothing is read after it.
    (0..).map_while(move |i| unsafe {
        let item = if list.is_null() { std::ptr::null() } else { *list.add(i) };
        (!item.is_null()).then_some(item)
    })
}

/// Returns a text of the host.
///
/// # Safety
/// `text` must be null or a null-terminated string.
unsafe fn text(text: *const c_char) -> String {
    // SAFETY: the caller guarantees the same.
    if text.is_null() { String::new() } else { unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned() }
}
