/* tatu.h: the C ABI between Tatu and its plugins, and its manual. This file documents the conventions that apply to
 * all parts of the ABI, and includes the headers of the parts.
 *
 * A plugin is a dynamic library that exports one symbol, `tatu_plugin`, a constant descriptor. The host reads it, calls
 * `init`, and then requests *extensions*: tables of what the plugin offers (commands, sensors, models, script languages
 * and more). The plugin in turn requests *services* from the host (scene, readings, bodies, commands and more). Plugins
 * have no direct access to each other; they interact through commands, readings, properties and schemas.
 *
 * `plugin-api/template/c_command/` is a complete plugin to start from. `docs/plugin-authors/scenarios.md` lists, for
 * fourteen situations, which functions are called, in which order and on which thread.
 *
 * CONVENTIONS
 *   The tag in square brackets before a function states on which threads it may be called.
 *   [setup]     one thread at a time per plugin: start, shutdown, creating and destroying instances.
 *   [step]      one thread at a time per world; different worlds may call on different threads at once.
 *   [parallel]  several threads at once, each on its own instances.
 *   [any]       any thread, any time.
 *   Pointers:   arguments are valid during the call only, unless the function's comment says otherwise.
 *   Text:       pointer and length, normally UTF-8, but not guaranteed to be valid; `const char *` is NUL-terminated.
 *               Control characters other than tab and newline are escaped when text is displayed.
 *   Names:      UTF-8 without spaces, control characters or backslashes; `a` and `a.b` cannot both be in use.
 *   Units:      metres, seconds, kilograms, radians, newtons; world frame with z up, unless a name says otherwise.
 *   Pose:       7 doubles: x y z, then the unit quaternion x y z w. Twist: 6 doubles: m/s, then rad/s.
 *
 * COMPATIBILITY
 *   Frozen types (values, readings, contacts) never change within an ABI major version; only they are used as array
 *   elements or passed by value.
 *   Tables (every struct that begins with `size`) grow at the end. Set `size` to sizeof and leave unused fields zero.
 *   Lists of tables are null-terminated arrays of pointers. A field exists only if it lies within `size` and is not
 *   null: check with TATU_HAS before calling through a table that another party filled. Tables have no tail padding.
 *   Until release 1.0 every extension and service is a draft, and is compatible only with the same draft number.
 *
 * MEMORY OF VALUES
 *   Each world has one arena, a stack. Memory from tatu_call_api.alloc and commands.alloc, and everything that results
 *   of calls point to, remains in this arena until the arena is released to an earlier mark. Only callers release
 *   memory; the host does so when its outermost call returns. A command may therefore return values that it received
 *   from a nested call, unless it has released them since. Memory is aligned to 16 bytes, arrays to their elements. An
 *   arena holds at most 256 MB at a time; `ptr` may be null when `len` is 0. Error messages are stored outside it.
 *
 * ERRORS
 *   A function that returns a negative status describes the failure in its error object. If that is empty, the host
 *   uses the error of the last failed service call, provided it has the same status: `return status;` passes it on.
 *
 * WHAT A CALL MAY USE
 *   The host tracks which call runs on which thread. A function that the running call may not use returns TATU_ERR_BUSY
 *   with a message, and the host reports a breach of contract by the plugin.
 *   measure, aim, finish, apply:                       log.write, and `random` of the batch
 *   create, destroy, configure, save, load, beams, and find, traits, order, place, keep_func, drop_func of a language:
 *                                                      functions without side effects: read, find, list, allocate
 *   all other calls that receive a world:              everything
 *   a plugin's own threads:                            log.write without a world, session.wake, session.stop,
 *                                                      commands.wake
 *   A world belongs to the thread that created it; its pointer is invalid once the world has ended.
 *
 * RULES
 *   No exception, panic or longjmp may leave a plugin function. No function may change the floating-point mode, locale
 *   or signal handlers, or end the process (exit, abort). A plugin has no mutable globals: it may be started several
 *   times in one process.
 */
#ifndef TATU_H
#define TATU_H

#include "tatu/core.h"     /* values, errors, parameters, instances, the plugin itself */

/* What a plugin may offer. */
#include "tatu/command.h"  /* commands for scripts, remote clients and other plugins */
#include "tatu/sensor.h"   /* kinds of sensors */
#include "tatu/actuator.h" /* kinds of actuators */
#include "tatu/part.h"     /* controllers that act with the world in hand */
#include "tatu/model.h"    /* models: robots and other assemblies of objects */
#include "tatu/importer.h" /* file formats */
#include "tatu/script.h"   /* script languages */
#include "tatu/service.h"  /* components that run beside worlds: remote APIs, bridges, views */
#include "tatu/event.h"    /* events that the plugin publishes */

/* What the host offers. */
#include "tatu/host.h"     /* scene, bodies, readings, commands, signals, events, log, files, ... */
#include "tatu/vrep.h"     /* for scripts of V-REP and CoppeliaSim */

#endif
