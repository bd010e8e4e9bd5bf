//! Helpers of all host functions, which look up the world, check arguments, refuse calls and lend memory.

use tatu_plugin_api::{abi::*, safe::Value};

use crate::cell::{CallStack, HostFunction, WorldCell};

/// The parts of the world that every host function uses: the message of a refusal, and memory to lend.
///
/// A function that does not call plugins receives a separate context, which consists of an `AnswerContext` and the
/// parts of the world that it uses; see [`with_context`]. A function that can call a plugin receives the whole world.
#[derive(Clone, Copy)]
pub(super) struct AnswerContext<'a> {
    pub calls: &'a CallStack,
    /// Whether the call is on a thread that runs scripts in parallel.
    pub in_parallel: bool,
}

impl<'a> From<&'a WorldCell> for AnswerContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        AnswerContext { calls: &world.run.calls, in_parallel: world.worker.is_some() }
    }
}

/// The result of a host function. If it is an error, the function was refused with this status.
pub(super) type HostResult = Result<(), tatu_status>;

/// Calls `f` with a world, if the function is allowed during the running call and the call is not on a thread that runs
/// scripts in parallel.
pub(super) fn on_world<'a>(
    world: WorldRef<'a>,
    function: HostFunction,
    f: impl FnOnce(&'a WorldCell) -> HostResult,
) -> tatu_status {
    on_world_or_worker(world, function, |world| match world.worker {
        None => f(world),
        Some(_) => Err(busy(world)),
    })
}

/// Like `on_world`, but for a function that parallel scripts may use as well.
#[inline]
pub(super) fn on_world_or_worker<'a>(
    world: WorldRef<'a>,
    function: HostFunction,
    f: impl FnOnce(&'a WorldCell) -> HostResult,
) -> tatu_status {
    WorldCell::admit(world, function).and_then(f).err().unwrap_or(TATU_OK)
}

/// Calls `f` with a context, which contains the parts of the world that the function uses.
pub(super) fn with_context<'a, C: From<&'a WorldCell>>(
    world: WorldRef<'a>,
    function: HostFunction,
    f: impl FnOnce(C) -> HostResult,
) -> tatu_status {
    on_world(world, function, |world| f(world.into()))
}

/// Returns the world for a function that does not return a status, or `None` if the function is refused.
pub(super) fn world_or_worker<'a>(world: WorldRef<'a>, function: HostFunction) -> Option<&'a WorldCell> {
    WorldCell::admit(world, function).ok()
}

/// Like `world_or_worker`, but also returns `None` on a thread that runs scripts in parallel.
pub(super) fn world_only<'a>(world: WorldRef<'a>, function: HostFunction) -> Option<&'a WorldCell> {
    world_or_worker(world, function).filter(|cell| cell.worker.is_none())
}

/// Returns a pointer argument as a reference, and refuses null. The message describes the argument as `what`.
#[inline]
pub(super) fn require<'a, T>(
    answer: impl Into<AnswerContext<'a>>,
    what: &str,
    given: Option<T>,
) -> Result<T, tatu_status> {
    given.ok_or_else(|| refuse_null(answer, what))
}

#[cold]
pub(super) fn refuse_null<'a>(answer: impl Into<AnswerContext<'a>>, what: &str) -> tatu_status {
    answer.into().calls.refuse(TATU_ERR_ARGUMENT, &format!("expected {what}, found null"))
}

/// Checks that the pointer to an array is not null.
pub(super) fn require_array<'a, T>(answer: impl Into<AnswerContext<'a>>, what: &str, pointer: *const T) -> HostResult {
    match pointer.is_null() {
        false => Ok(()),
        true => Err(refuse_null(answer, what)),
    }
}

/// Returns the array of `n` elements that a caller passes, and refuses null unless `n` is 0.
///
/// # Safety
/// `pointer` must be null or point to `n` elements that remain valid and unchanged for `'a`.
pub(super) unsafe fn input_slice<'a, T>(
    answer: impl Into<AnswerContext<'a>>,
    what: &str,
    pointer: *const T,
    n: u32,
) -> Result<&'a [T], tatu_status> {
    if n == 0 {
        return Ok(&[]);
    }
    require_array(answer, what, pointer)?;
    // SAFETY: the pointer is not null, so the caller guarantees that it points to `n` elements that remain valid and
    // unchanged for `'a`.
    Ok(unsafe { std::slice::from_raw_parts(pointer, n as usize) })
}

/// Like `input_slice`, but for an array to write to.
///
/// # Safety
/// As for [`input_slice`]; in addition, nothing else may use the elements during the call.
pub(super) unsafe fn output_slice<'a, T>(
    answer: impl Into<AnswerContext<'a>>,
    what: &str,
    pointer: *mut T,
    n: u32,
) -> Result<&'a mut [T], tatu_status> {
    if n == 0 {
        return Ok(&mut []);
    }
    require_array(answer, what, pointer)?;
    // SAFETY: the pointer is not null, so the caller guarantees that it points to `n` elements that remain valid and
    // are not aliased for `'a`.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n as usize) })
}

/// Checks that a frame has the full size, and that its arrays are not null unless they are empty.
#[inline]
pub(super) fn require_frame<'a>(answer: impl Into<AnswerContext<'a>>, frame: *const tatu_call) -> HostResult {
    // SAFETY: `frame` is null or points to a frame that is valid during the call and begins with its size; a reference
    // to all fields is made only if the size includes them.
    let (size, whole) = unsafe {
        let size = frame.cast::<u32>().as_ref().map(|size| *size as usize);
        (size, size.is_some_and(|size| size >= size_of::<tatu_call>()).then(|| &*frame))
    };
    match whole {
        Some(f) if (f.n_args == 0 || !f.args.is_null()) && (f.results_cap == 0 || !f.results.is_null()) => Ok(()),
        _ => Err(refuse_frame(answer, size, whole.is_some())),
    }
}

#[cold]
fn refuse_frame<'a>(answer: impl Into<AnswerContext<'a>>, size: Option<usize>, whole: bool) -> tatu_status {
    let text = match (size, whole) {
        (None, _) => "expected a frame, found null",
        (_, false) => "the size of the frame does not match any version of `tatu_call`",
        (_, true) => "expected arrays for the arguments and the results, found null",
    };
    answer.into().calls.refuse(TATU_ERR_ARGUMENT, text)
}

pub(super) fn status_to_result(status: tatu_status) -> HostResult {
    if status == TATU_OK { Ok(()) } else { Err(status) }
}

/// Refuses a call because a caller further up the stack has borrowed a part of the world.
pub(super) fn busy<'a>(answer: impl Into<AnswerContext<'a>>) -> tatu_status {
    let answer = answer.into();
    let text = match answer.in_parallel {
        false => {
            "the running call uses a part of the world that this function needs; use it after that call has returned"
        }
        true => "a script that runs in parallel with others (`side_by_side`) cannot call this function",
    };
    answer.calls.refuse(TATU_ERR_BUSY, text)
}

/// Returns the slot of an object given by a caller, or refuses the call.
pub(super) fn slot<'a>(
    answer: impl Into<AnswerContext<'a>>,
    scene: &tatu_scene::Scene,
    object: tatu_object,
) -> Result<u32, tatu_status> {
    let answer = answer.into();
    let n = tatu_slot(object);
    if answer.calls.hides(n) {
        return Err(answer.calls.refuse(TATU_ERR_MISSING, &format!("there is no object {n}")));
    }
    scene.resolve(object).map_err(|last| match last {
        Some(name) => answer.calls.refuse(TATU_ERR_GONE, &format!("object {n} (formerly `{name}`) has been removed")),
        None if object == 0 => answer.calls.refuse(TATU_ERR_MISSING, "the world itself is not an object of the scene"),
        None => answer.calls.refuse(TATU_ERR_MISSING, &format!("there is no object {n}")),
    })
}

/// Copies as many elements of a list as fit to a caller's array, and writes the length of the list to `n`.
///
/// # Safety
/// `out` must be null or have room for `cap` elements.
pub(super) unsafe fn fill<T: Copy>(all: &[T], out: *mut T, cap: u32, n: Option<&mut u32>) -> HostResult {
    if !out.is_null() {
        // SAFETY: the caller guarantees that `out` points to `cap` elements that are valid during the call; they do not
        // overlap the host's list.
        unsafe { std::ptr::copy_nonoverlapping(all.as_ptr(), out, all.len().min(cap as usize)) };
    }
    if let Some(n) = n {
        *n = all.len() as u32;
    }
    Ok(())
}

/// Copies a string to the world's arena, where it is valid until the plugin's call returns.
pub(super) fn lend<'a>(answer: impl Into<AnswerContext<'a>>, text: &[u8]) -> Result<Lent<'a>, tatu_status> {
    let answer = answer.into();
    let mut arena = answer.calls.arena.try_borrow_mut().map_err(|_| busy(answer))?;
    let room = arena.store(text);
    if room.is_null() {
        return Err(TATU_ERR_SPACE);
    }
    // SAFETY: `room` points to `text.len()` bytes in the arena, which stay allocated until the plugin's call returns or
    // releases a mark.
    Ok(unsafe { Lent::new(tatu_str { ptr: room.cast(), len: text.len() as u64 }) })
}

/// Copies a value to the world's arena, where it is valid until the plugin's call returns, and writes its ABI form to
/// `out`.
pub(super) fn write_value<'a>(
    answer: impl Into<AnswerContext<'a>>,
    value: &Value,
    out: Option<&mut ValueRef<'a>>,
) -> HostResult {
    let answer = answer.into();
    let Ok(mut arena) = answer.calls.arena.try_borrow_mut() else { return Err(busy(answer)) };
    let out = require(answer, "a pointer for the value", out)?;
    match value.to_raw(&mut *arena) {
        Some(raw) => {
            // SAFETY: `raw` points into the arena, which stays allocated until the plugin's call returns or releases a
            // mark.
            *out = unsafe { ValueRef::new(raw) };
            Ok(())
        }
        None => Err(answer.calls.refuse(TATU_ERR_SPACE, "not enough memory for the value")),
    }
}
