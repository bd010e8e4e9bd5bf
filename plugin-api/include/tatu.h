/* tatu.h: the C ABI between Tatu and its plugins, and its manual.
 *
 * A plugin is a dynamic library that exports one symbol, `tatu_plugin`, a constant descriptor. The host reads it,
 * calls `init`, and asks for *extensions*: what the plugin offers (commands, sensors, models, script languages, ...).
 * The plugin asks the host for *services*: what the host offers (scene, readings, bodies, commands, ...). Plugins
 * never see each other; they share commands, readings, properties and schemas.
 *
 * `plugin-api/template/c_command/` is a plugin to start from.
 *
 * CONVENTIONS
 *   [setup]     one thread at a time per plugin: start, shutdown, creating and destroying instances.
 *   [step]      one thread at a time per world; different worlds may call on different threads at once.
 *   [parallel]  several threads at once, each on its own instances.
 *   [any]       any thread, any time.
 *   Pointers:   arguments are valid during the call only, unless the function's comment says otherwise.
 *   Text:       pointer and length, normally UTF-8, but that is not guaranteed; `const char *` is NUL-terminated.
 *               Control characters other than tab and newline are escaped when text is displayed.
 *   Names:      UTF-8 without spaces, control characters and backslashes; `a` and `a.b` exclude each other.
 *   Units:      metres, seconds, kilograms, radians, newtons; world frame with z up, unless a name says otherwise.
 *   Pose:       7 doubles: x y z, then the unit quaternion x y z w. Twist: 6 doubles: m/s, then rad/s.
 *
 * COMPATIBILITY
 *   Frozen types (section 1) never change within an ABI major; only these are array elements or are passed by value.
 *   Tables (every struct that begins with `size`) grow at the end. Set `size` to sizeof and leave unused fields zero.
 *   Lists of tables are null-terminated arrays of pointers. A field exists only if it lies within `size` and is not
 *   null: check with TATU_HAS before calling through a table that another party filled. Tables have no tail padding.
 *   Until release 1.0 every extension and service is a draft, and a draft matches only its own number.
 *
 * MEMORY OF VALUES
 *   Each world has one arena, a stack. Memory from tatu_call_api.alloc and commands.alloc, and everything that results
 *   of calls point to, lives there until it is released to an earlier mark. Only callers release; the host does so when
 *   its outermost call returns. So a command may return values that a nested call gave it, unless it released in
 *   between. Memory is aligned to 16 bytes, arrays to their elements. An arena holds at most 256 MB at a time; `ptr`
 *   may be null when `len` is 0. Error texts are stored elsewhere.
 *
 * ERRORS
 *   A function that returns a negative status describes the failure in its error object. If that is empty, the host
 *   uses the error of the last failed service call, provided it has the same status: `return status;` passes it on.
 *
 * WHAT A CALL MAY USE
 *   The host tracks which call runs on which thread. It rejects what is not allowed there with TATU_ERR_BUSY and a
 *   message, and reports a breach of contract by the plugin.
 *   measure, aim, finish, apply:                       log.write, and `random` of the batch
 *   create, destroy, configure, save, load, beams, and find, traits, order, place, keep_func, drop_func of a language:
 *                                                      functions without side effects: read, find, list, allocate
 *   all other calls that receive a world:              everything
 *   a plugin's own threads:                            log.write without a world, session.wake
 *   A world belongs to the thread that made it; its pointer is invalid once the world has ended.
 *
 * RULES
 *   No exception, panic or longjmp may leave a plugin function. No function may change the floating-point mode, locale
 *   or signal handlers, or end the process (exit, abort). A plugin has no mutable globals: it may be started several
 *   times in one process.
 */
#ifndef TATU_H
#define TATU_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#  define TATU_EXPORT __declspec(dllexport)
#  define TATU_CALL __cdecl
#else
#  define TATU_EXPORT __attribute__((visibility("default")))
#  define TATU_CALL
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_ABI_MAJOR 0 /* must match; 0 until release 1.0 */
#define TATU_ABI_MINOR 5 /* increased whenever a table grows; checked only against tatu_need.minor */

/* End of a field within its table, bytes. */
#define TATU_END(t, f) ((size_t)((const char *)(&(t)->f + 1) - (const char *)(t)))
/* Whether whoever filled the table has this scalar or pointer field and set it. */
#define TATU_HAS(t, f) ((t) && TATU_END(t, f) <= (t)->size && (t)->f)
/* Whether whoever filled the table has this field at all: for struct fields, and for scalars where 0 has a meaning. */
#define TATU_KNOWS(t, f) ((t) && TATU_END(t, f) <= (t)->size)

/* ================================================================ 1. Frozen types ==================== */

typedef int32_t tatu_status; /* 0: done; 1: waiting; negative: one of the errors below */
enum {
  TATU_OK = 0,
  TATU_WAIT = 1,              /* the command will finish later; see tatu_call_api.wait */
  TATU_ERR = -1,              /* failed; see the message */
  TATU_ERR_ARGUMENT = -2,     /* an argument has the wrong type, count, size or range */
  TATU_ERR_MISSING = -3,      /* no object, field, property or file of that name */
  TATU_ERR_GONE = -4,         /* it existed, but has been removed or has ended */
  TATU_ERR_UNSUPPORTED = -5,  /* recognized, but not supported here */
  TATU_ERR_UNKNOWN = -6,      /* no command of that name */
  TATU_ERR_SCRIPT = -7,       /* an error raised by a script */
  TATU_ERR_BUDGET = -8,       /* a script exceeded its instruction limit: it is not called again */
  TATU_ERR_PANIC = -9,        /* a plugin panicked; the panic was caught */
  TATU_ERR_BUSY = -10,        /* not possible from within this call */
  TATU_ERR_SPACE = -11,       /* a buffer is too small; the needed count is returned */
  TATU_ERR_PHYSICS = -12,     /* the physics engine lost a body */
  TATU_ERR_MEMORY = -13       /* a script exceeded its memory limit: it may go on with less */
};

/* Text or bytes: not NUL-terminated. */
typedef struct tatu_str {
  const char *ptr;
  uint64_t len;
} tatu_str;

/* An object of a world: generation << 20 | slot. 0: none, or the world itself. Scripts see only the slot, as the
 * handle. Generation 0 means "whatever is in that slot now" and is meant for numbers passed by a script. */
typedef uint64_t tatu_object;
#define TATU_SLOT_BITS 1048575 /* 20 */
#define TATU_SLOT(o) ((uint32_t)((o) & TATU_SLOT_BITS))

/* A script's function: instance id << 32 | local id. An argument is valid during the call, a result until the script
 * is entered again; see commands.retain. */
typedef uint64_t tatu_func;
typedef uint32_t tatu_prop; /* interned key of a property ("joint.position") or field ("proximity.distance") */

/* Tags of a value. */
enum {
  TATU_NIL = 0,
  TATU_BOOL = 1,   /* u.i: 0 or 1 */
  TATU_I64 = 2,    /* u.i */
  TATU_F64 = 3,    /* u.f */
  TATU_TEXT = 4,   /* u.s: text */
  TATU_BYTES = 5,  /* u.s: any bytes */
  TATU_F64S = 6,   /* u.s: array of double; len counts elements, here and below */
  TATU_F32S = 7,   /* u.s: array of float */
  TATU_I64S = 8,   /* u.s: array of int64_t */
  TATU_I32S = 9,   /* u.s: array of int32_t */
  TATU_U8S = 10,   /* u.s: array of uint8_t, as numbers */
  TATU_LIST = 11,  /* u.s: array of tatu_value */
  TATU_MAP = 12,   /* u.s: array of tatu_pair; keys are text, numbers or booleans */
  TATU_FUNC = 13,  /* u.u: tatu_func */
  TATU_OBJECT = 14 /* u.u: tatu_object */
};

/* A value. Lists and maps nest at most 32 deep.
 *
 * Lua values where no type is declared (TATU_COMMAND_RAW, TATU_PARAM_ANY, values within lists and maps) become:
 *   nil, true, an integer, another number        NIL, BOOL, I64, F64
 *   string                                       TEXT, whatever bytes it holds
 *   {1, 2}, {1.5, 2}                             I64S, F64S: a table with keys 1 to n whose values are numbers
 *   {'a', 2}, {{1}, {2}}                         LIST: the same with other values
 *   {a = 1}, {[2] = 1}                           MAP: a table with any other key
 *   {}                                           LIST of 0
 *   a function                                   FUNC
 * An argument of declared type is converted to that type, or the call fails before the command runs: for TATU_F64 an
 * integer becomes F64, for TATU_F64S {1, 2} becomes F64S, for TATU_LIST every table with keys 1 to n becomes LIST, for
 * TATU_MAP every table becomes MAP ({'a'} has the key 1), and {} becomes an empty value of the declared type. */
typedef struct tatu_value {
  uint32_t tag;      /* one of the tags above */
  uint32_t reserved; /* 0 */
  union {
    int64_t i;
    double f;
    uint64_t u;
    struct {
      const void *ptr;
      uint64_t len;
    } s;
  } u;
} tatu_value;

/* One entry of a map. */
typedef struct tatu_pair {
  tatu_value key;
  tatu_value value;
} tatu_pair;

/* Element types of a reading's field. */
enum {
  TATU_ELEM_F64 = 1,
  TATU_ELEM_F32 = 2,
  TATU_ELEM_I32 = 3,
  TATU_ELEM_U16 = 4,
  TATU_ELEM_U8 = 5,
  TATU_ELEM_OBJECT = 6 /* tatu_object */
};

/* One field of a sensor's last reading: host-owned, valid until that sensor is next measured or removed. */
typedef struct tatu_field_view {
  const void *ptr;   /* first element */
  uint64_t len;      /* elements */
  uint32_t elem;     /* TATU_ELEM_* */
  uint32_t dims[3];  /* shape, outermost first; unused ones are 1 */
  double time;       /* simulation time of the reading, s */
  uint64_t sequence; /* how often the sensor has been measured; 0: never, or reset since */
} tatu_field_view;

/* Two shapes in contact. */
typedef struct tatu_contact {
  tatu_object shape[2];
  double point[3];  /* world, m */
  double normal[3]; /* unit, from shape[0] to shape[1] */
  double force;     /* N, normal, over the last physics step */
} tatu_contact;

typedef struct tatu_world tatu_world;     /* a world: opaque */
typedef struct tatu_session tatu_session; /* a session: opaque */

/* ================================================================ 2. Errors ========================== */

typedef struct tatu_error tatu_error;

/* An error, owned by the host. A plugin writes it only through `say` and `add`, which copy their arguments; the host
 * adds plugin, instance and call. The other fields are read-only. */
struct tatu_error {
  uint32_t size;
  int32_t code; /* TATU_OK while the error is empty */
  void *ctx;    /* the host's */
  /* [any] Sets the error: a negative code and one sentence: what, where, what was expected. Text beyond 16 KiB is cut
   * off, here and in `add`. */
  void(TATU_CALL *say)(tatu_error *, tatu_status code, tatu_str text);
  /* [any] Adds a part: TATU_PART_*; `line` counts from 1 and is used with TATU_PART_FILE. */
  void(TATU_CALL *add)(tatu_error *, uint32_t part, tatu_str text, uint64_t line);
  tatu_str text;      /* what went wrong */
  tatu_str help;      /* what to do */
  tatu_str file;      /* where, if in a file or script */
  tatu_str traceback; /* the script's call stack, innermost first */
  uint64_t line;      /* in `file`; 0: none */
};
enum { TATU_PART_HELP = 1, TATU_PART_FILE = 2, TATU_PART_TRACEBACK = 3 };

/* ================================================================ 3. Plugin and host ================= */

typedef struct tatu_host tatu_host;

/* The host as plugins see it; valid from `init` to the end of `shutdown`. */
struct tatu_host {
  uint32_t size;
  uint32_t abi_minor; /* of the host */
  void *ctx;          /* the host's */
  /* [any] The table of a service ("tatu.host.scene/draft.4"), or null. Valid for the lifetime of the host. */
  const void *(TATU_CALL *service)(const tatu_host *, const char *id);
};

/* A service that a plugin requires, or uses if present. `bytes` and `minor` state once how much of the host it uses;
 * functions within that size need no TATU_HAS before each call. */
typedef struct tatu_need {
  uint32_t size;
  uint32_t optional; /* 0: the plugin is not loaded without it */
  const char *id;    /* "tatu.host.scene/draft.4"; null: the host itself, by `minor` */
  uint32_t bytes;    /* minimum size of its table: its sizeof, or TATU_END of the last field used; 0: any */
  uint32_t minor;    /* minimum abi_minor of the host; 0: any */
} tatu_need;

/* What the library exports. All strings live as long as the library does. */
typedef struct tatu_plugin_t {
  uint32_t size;
  uint16_t abi_major; /* TATU_ABI_MAJOR */
  uint16_t abi_minor; /* TATU_ABI_MINOR */
  const char *id;      /* "org.example.gripper": unique; scenes and messages use it */
  const char *name;    /* for display */
  const char *version; /* "1.2.0" */
  const char *licence; /* SPDX, "MIT" */
  const tatu_need *const *needs; /* null, or a null-terminated list */
  /* [setup] Starts the plugin; `*self` (may be null) is passed to every later call. May get services, and call only
   * their [any] functions. Null: nothing to start. */
  tatu_status(TATU_CALL *init)(const tatu_host *, void **self, tatu_error *);
  /* [setup] Ends it, after all its instances have been destroyed. Null: nothing to do. */
  void(TATU_CALL *shutdown)(void *self);
  /* [setup] The table of an extension ("tatu.command/draft.4"), or null. Owned by the plugin until shutdown. */
  const void *(TATU_CALL *extension)(void *self, const char *id);
} tatu_plugin_t;

extern TATU_EXPORT const tatu_plugin_t tatu_plugin;

/* ================================================================ 4. Parameters and instances ======== */

enum {
  /* of a sensor or actuator: */
  TATU_PARAM_REBUILDS = 1, /* a change destroys the instance and creates a new one */
  TATU_PARAM_READ_ONLY = 2,
  TATU_PARAM_OPTIONAL = 4, /* of a command: may be omitted or nil; it is then the default, or nil without one */
  TATU_PARAM_REST = 8,     /* of a command, last parameter only: takes all remaining arguments */
  TATU_PARAM_ANY = 16      /* any type; `type` is ignored */
};

/* Declaration of a parameter of an instance, or of a parameter or result of a command. Scene files append the unit to
 * the key: with unit "m", `range` is written `range_m`; with "rad" it is written in degrees, `_deg`. Values crossing
 * the ABI are always SI and radians. A parameter of type TATU_OBJECT also accepts a script's handle, and passes it as
 * an object of generation 0; the service that receives it checks whether the object exists. */
typedef struct tatu_param {
  uint32_t size;
  uint32_t type;       /* TATU_BOOL, I64, F64, TEXT, BYTES, F64S, LIST, MAP, FUNC or OBJECT */
  uint32_t count;      /* number of array elements; 0: any */
  uint32_t flags;      /* TATU_PARAM_* */
  const char *key;     /* "range" */
  const char *unit;    /* "m", "rad", "s", "kg", "N", "N m", "m/s", "rad/s", "Hz", "1"; null: none */
  double lowest;       /* minimum; -HUGE_VAL: none. Both bounds 0: no bounds */
  double highest;      /* maximum; HUGE_VAL: none */
  tatu_value fallback; /* the default; nil: required (unless optional) */
  const char *const *choices; /* allowed texts, null-terminated; null: any */
  const char *text;    /* one sentence */
  const struct tatu_param *const *keys; /* of a TATU_MAP: its text keys; null or beyond `size`: any. Entries are checked
                        * and converted like parameters, missing ones get their default, unknown keys are rejected */
} tatu_param;

/* Arguments of `create`. */
typedef struct tatu_instance {
  uint32_t size;
  uint32_t n_params;
  tatu_world *world;        /* null for a service; its properties may be read in `create` */
  tatu_object owner;        /* sensor, actuator or script object; 0 for a world instance */
  uint64_t id;              /* of this instance, unique in its world */
  uint64_t seed;            /* derived from the scene's seed and the owner: the same in every run */
  const tatu_value *params; /* in the order of declaration, defaults filled in */
  void *state;              /* the state block: host-owned, zeroed, at a fixed address until destroy; null if it has no bytes */
  tatu_session *session;    /* of a service: the session that starts it; null for all others */
} tatu_instance;

/* Receives what `save` writes; provided by the host. */
typedef struct tatu_writer {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  void(TATU_CALL *write)(const struct tatu_writer *, const void *bytes, uint64_t n);
} tatu_writer;

/* The life cycle of instances. All functions but `create` and `destroy` may be null; so may these two, together, if the
 * instance is only its state block (not for languages). Stopping and resetting a world recreates its instances, but see
 * `end_run`. */
typedef struct tatu_life {
  uint32_t size;
  uint32_t state_bytes; /* size of the state block: without pointers; copied by snapshots, zeroed at reset */
  /* [setup] Creates an instance; `*data` is passed to every later call. */
  tatu_status(TATU_CALL *create)(void *self, const tatu_instance *, void **data, tatu_error *);
  /* [setup] Ends it. */
  void(TATU_CALL *destroy)(void *data);
  /* [step] Parameters of a live sensor or actuator changed: `params` holds all, `changed` has a bit for each of the
   * first 64, in the order of declaration. A sensor's `beams` is called next. An error restores the old values and is
   * reported to whoever set them. Not called for parameters with TATU_PARAM_REBUILDS. Null, or TATU_ERR_UNSUPPORTED
   * without a message: the instance is recreated. */
  tatu_status(TATU_CALL *configure)(void *data, const tatu_value *params, uint32_t n, uint64_t changed, tatu_error *);
  /* [step] Writes what the state block does not hold. TATU_ERR_UNSUPPORTED: not possible now; the message says why.
   * Null: an instance whose `data` is null has nothing more; any other is reported as missing from the snapshot. */
  tatu_status(TATU_CALL *save)(void *data, const tatu_writer *, tatu_error *);
  /* [step] Restores what `save` wrote into an instance made with the same parameters. `version` is the writer's; the
   * state block has already been restored if it equals the instance's own (else it is zero). After a failure the
   * instance is recreated. When a file is reloaded, `save` is the old version's and `load` the new one's. */
  tatu_status(TATU_CALL *load)(void *data, tatu_str bytes, uint32_t version, tatu_error *);
  uint32_t version; /* of the state block and of what `save` writes; numbered by the plugin */
  uint32_t reserved;
  /* [step] Only for what a command plugin keeps per world: the scripts of the run have ended, and the scene is reset
   * next. Drops what belonged to them, and keeps what belongs to scripts that outlive runs ("script.kind" is neither
   * "main" nor "child"). Null, or an error: the instance is recreated. */
  tatu_status(TATU_CALL *end_run)(void *self, void *data, tatu_world *, tatu_error *);
} tatu_life;

/* ================================================================ 5. Commands ======================== */

#define TATU_COMMAND "tatu.command/draft.4"

typedef struct tatu_call tatu_call;

enum { TATU_UNTIL_STEPS = 1, TATU_UNTIL_TIME = 2, TATU_UNTIL_SIGNAL = 3, TATU_UNTIL_POLL = 4 };

/* What a running command may ask of the host for its own call. */
typedef struct tatu_call_api {
  uint32_t size;
  uint32_t reserved;
  /* [step] Memory that lives until the caller has read the results. Null if the world's arena is full. */
  void *(TATU_CALL *alloc)(tatu_call *, uint64_t bytes);
  /* [step] Suspends the command, which then returns TATU_WAIT. It is called again, with `resume` and without arguments,
   * once `until` holds: STEPS: `value` steps later; TIME: at simulation time `value`, s; SIGNAL: when the signal `name`
   * exists; POLL: in each step. `resume` (not 0) is the command's own key to what it keeps meanwhile. Returns TATU_WAIT,
   * so `return call->api->wait(...)` works. If the caller cannot wait, sets the error and returns TATU_ERR_BUSY. */
  tatu_status(TATU_CALL *wait)(tatu_call *, uint32_t until, double value, tatu_str name, uint64_t resume);
} tatu_call_api;

enum { TATU_CALLER_HOST = 0, TATU_CALLER_SCRIPT = 1, TATU_CALLER_NATIVE = 2, TATU_CALLER_REMOTE = 3 };

/* One call of a command, a script's callback or a script's function. The caller owns it and its arrays. */
struct tatu_call {
  uint32_t size;
  uint32_t command;       /* id of the command; 0: not a command */
  uint32_t alias;         /* which of the command's names was used */
  uint32_t n_args;        /* including trailing nils */
  const tatu_value *args; /* checked, converted to the declared types, with defaults; as passed for TATU_COMMAND_RAW */
  tatu_value *results;    /* the caller's buffer for at least 16 */
  uint32_t results_cap;
  uint32_t n_results;     /* number of results; never padded */
  tatu_world *world;
  void *self;             /* of the called plugin */
  void *instance;         /* its instance in this world; null if it has none, and in parallel calls */
  void *state;            /* the instance's state block */
  const void *user;       /* tatu_command.user */
  const tatu_call_api *api;
  tatu_error *error;      /* set by a call that fails; read by its caller */
  uint64_t wait_token;    /* 0: this caller cannot wait; only script languages and services set another */
  uint64_t resume;        /* not 0: a wait has ended */
  uint64_t caller;        /* instance id of the calling script, or 0; set by the host, like all below */
  tatu_object caller_object; /* the object that the calling script belongs to */
  tatu_object caller_script; /* the script object itself */
  tatu_str caller_dialect;   /* of the calling script; empty: none */
  uint32_t caller_kind;      /* TATU_CALLER_* */
  uint32_t flags;            /* TATU_CALL_* bits, set by the caller */
};

enum {
  TATU_CALL_RAISE = 1, /* raise errors even where TATU_NAME_OLD_ERRORS would return values instead */
  TATU_CALL_SIDE_BY_SIDE = 2 /* of a script: set by the host while scripts run in parallel */
};

enum {
  TATU_COMMAND_RAW = 1,     /* arguments are not converted; declared parameters are documentation only */
  TATU_COMMAND_SIDE_BY_SIDE = 2, /* may be called by scripts that run in parallel, on several threads at once. It uses only
                                  * its arguments, immutable data of its plugin, and these services: scene.get, get_f64,
                                  * get_f64_many, pose, look, set and set_f64 of a joint's drive, bodies.twist, readings.field,
                                  * readings.describe, log, commands.find, call (of such commands), constant, alloc */
  TATU_NAME_OLD_ERRORS = 1  /* an error is logged once per place, and `on_error` is returned instead */
};

/* One name of a command. */
typedef struct tatu_name {
  uint32_t size;
  uint32_t flags;            /* TATU_NAME_* */
  const char *name;          /* "simGetObjectHandle", "sim.getObjectHandle", "gripper.close" */
  uint32_t n_on_error;       /* number of values in `on_error` */
  uint32_t reserved;
  const tatu_value *on_error;/* returned instead of an error with TATU_NAME_OLD_ERRORS */
  const char *on_error_until;/* first dialect, a version such as "4.2", for whose scripts the error is raised again;
                              * null or beyond `size`: none. Callers without a dialect get `on_error` */
} tatu_name;

/* How much of its documented behaviour a command implements. */
enum {
  TATU_COMMAND_FULL = 0,    /* all */
  TATU_COMMAND_PARTIAL = 1, /* part of it; `notes` say what is missing */
  TATU_COMMAND_STUB = 2     /* none: it accepts its arguments and returns a neutral value; the host warns once per run */
};

/* A command. Scripts, remote clients and other plugins can call it by any of its names. */
typedef struct tatu_command {
  uint32_t size;
  uint32_t flags;                    /* TATU_COMMAND_* */
  const tatu_name *const *names;     /* at least one, at most 255 */
  const tatu_param *const *params;   /* null: none */
  const tatu_param *const *returns;  /* documentation only; may be null */
  const char *text;                  /* what it does, one sentence */
  const char *example;               /* a Lua script that raises an error if the command has not had its effect */
  const char *no_wait;               /* complete message for a caller that cannot wait; null: a general one */
  const void *user;                  /* passed as tatu_call.user */
  /* [step] Runs it. May call any service; may be re-entered before it returns. */
  tatu_status(TATU_CALL *call)(tatu_call *);
  uint32_t status;                   /* TATU_COMMAND_FULL, ..._PARTIAL, ..._STUB; beyond `size`: full */
  uint32_t reserved;
  const char *notes;                 /* what is missing or differs, for the documentation; null: nothing */
  const char *subject;               /* its subject in one word, "joints", by which the documentation groups commands; null: none */
} tatu_command;

/* A named value for scripts. */
typedef struct tatu_constant {
  uint32_t size;
  uint32_t reserved;
  const char *name;  /* "sim_handle_self", "sim.handle_self" */
  tatu_value value;
} tatu_constant;

/* Source text in one script language. Module "" is run once in every new script state and returns a table that defines
 * how scripts of this API are called (see the language's page); other modules are found by `require`. */
typedef struct tatu_prelude {
  uint32_t size;
  uint32_t reserved;
  const char *language;
  const char *module;
  tatu_str text;
} tatu_prelude;

/* The last non-empty line of the text must begin with the word; otherwise some name in the text must. */
enum { TATU_MARK_LAST_LINE = 1 };

/* A word that identifies the kind of a script that is run without its scene. Kinds are "main", "child", "threaded",
 * "customization", "add-on", "module". The first mark that matches decides. */
typedef struct tatu_kind_mark {
  uint32_t size;
  uint32_t flags; /* TATU_MARK_* */
  const char *language;
  const char *kind;
  const char *word;
} tatu_kind_mark;

typedef struct tatu_ext_command {
  uint32_t size;
  uint32_t reserved;
  const tatu_command *const *commands;
  const tatu_constant *const *constants; /* may be null */
  const tatu_prelude *const *preludes;   /* may be null */
  const tatu_life *per_world;            /* null: the plugin has no state per world */
  const tatu_kind_mark *const *kind_marks; /* may be null */
} tatu_ext_command;

/* ================================================================ 6. Sensors ========================= */

#define TATU_SENSOR "tatu.sensor/draft.4"

/* Form of the beams, which start at the sensor's origin and point along its +z. */
enum {
  TATU_BEAMS_NONE = 0,
  TATU_BEAMS_RAYS = 1,     /* `count[0]` rays along `directions` */
  TATU_BEAMS_GRID = 2,     /* pinhole image: count = {columns, rows}; dims = {horizontal angle}; square pixels */
  TATU_BEAMS_CONE = 3,     /* volume with a round far end: dims = {half angle}; 0 to pi */
  TATU_BEAMS_PYRAMID = 4,  /* volume with flat ends at heights near_m and far_m (finite) along +z:
                              dims = {x near, y near, x far, y far}, their full sizes in m */
  TATU_BEAMS_CYLINDER = 5, /* the same with round ends: dims = {radius near, radius far} in m */
  TATU_BEAMS_DISC = 6,     /* volume, a flat sector around +z in the plane of x and z, with round ends: dims = {full
                              angle, up to 2 pi; height in m, centred on y = 0; full angle of a gap around +z,
                              0: none} */
  TATU_BEAMS_PARALLEL = 7  /* image of parallel rays: count = {columns, rows}; dims = {width m}; square pixels */
};
enum {
  TATU_BEAMS_NO_FRONT = 1,  /* front faces are not detected */
  TATU_BEAMS_NO_BACK = 2,   /* back faces are not detected */
  TATU_BEAMS_SKIP_MODEL = 4, /* objects of the sensor's own model are not detected */
  TATU_BEAMS_VISIBLE = 8,   /* detects visible objects, as a camera does; otherwise detectable ones */
  TATU_BEAMS_OCCLUDE = 16,  /* the nearest point in a volume counts only if no surface, front or back, at any incidence,
                             * lies between it and the sensor; otherwise nothing is detected */
  TATU_BEAMS_AIMED = 32     /* rays whose origins and directions `tatu_sensor.aim` sets before each cast */
};

/* Physical kind of the beams. A beam detects a shape if it shares a bit with "shape.detectable_mask". */
enum {
  TATU_WAVES_ULTRASONIC = 16,
  TATU_WAVES_INFRARED = 32,
  TATU_WAVES_LASER = 64,
  TATU_WAVES_INDUCTIVE = 128,
  TATU_WAVES_CAPACITIVE = 256,
  TATU_WAVES_ALL = 65535
};

/* What a sensor sends out. Filled by the plugin; `size` is set by the host. The optical axis of an image (GRID,
 * PARALLEL) is +z, with +y up and +x to the left; near_m and far_m are planes normal to it. Its pixels are ordered by
 * rows, from the bottom up, and from left to right within a row. */
typedef struct tatu_beams {
  uint32_t size;
  uint32_t form;            /* TATU_BEAMS_* */
  uint32_t count[2];
  double near_m;            /* minimum range; of a pyramid and a cylinder: the height of the near end */
  double far_m;             /* maximum range; likewise */
  double dims[6];
  double max_incidence;     /* rad between line of sight and surface normal; pi/2: no limit */
  const double *directions; /* 3 per ray, unit vectors, sensor frame; owned by the instance, valid until the next `beams` */
  uint32_t flags;
  uint32_t reserved;
  uint32_t waves;           /* sum of TATU_WAVES_*; preset to TATU_WAVES_ALL; ignored for images */
  uint32_t reserved2;
  uint32_t own[4];          /* dimensions of the instance's own, to which TATU_DIM_OWN refers in the shape of a field */
  uint32_t without;         /* TATU_IN_*: inputs of the kind that this instance does not need; they are 0 in its pixels */
  uint32_t reserved3;
} tatu_beams;

/* Inputs of `measure`. */
enum {
  TATU_IN_DISTANCE = 1, /* per beam: m, from the origin; infinity: no hit */
  TATU_IN_POINT = 2,    /* per beam: 3 doubles, sensor frame */
  TATU_IN_NORMAL = 4,   /* per beam: 3 doubles, unit, sensor frame, towards the sensor */
  TATU_IN_OBJECT = 8,   /* per beam: the object hit, 0: none */
  TATU_IN_POSE = 16,    /* per sensor: pose in the world */
  TATU_IN_TWIST = 32,   /* per sensor: twist of its mount, world frame */
  TATU_IN_COLOR = 64,   /* 3 bytes red green blue. Per pixel: shaded; per beam: of the surface, unshaded */
  TATU_IN_COSINE = 128, /* per pixel: cosine of the angle between line of sight and normal */
  TATU_IN_PRIMITIVE = 256 /* per beam: index of the triangle or face of the object */
};

/* In `dims` of a field: number of rows and of columns of the instance's image. */
#define TATU_DIM_ROWS 4294967295u
#define TATU_DIM_COLUMNS 4294967294u
/* Plus 0 to 3: index into tatu_beams.own; if the value there is 0, the field is empty for this instance. */
#define TATU_DIM_OWN 4294967280u

/* One field that a sensor kind fills, named "<schema>.<field>". */
typedef struct tatu_field {
  uint32_t size;
  uint32_t elem;       /* TATU_ELEM_* */
  uint32_t dims[3];    /* 0: the instance's number of beams or pixels; TATU_DIM_*; unused ones are 1 */
  uint32_t flags;      /* 0 */
  const char *name;    /* "proximity.distance" */
  const char *unit;
  const char *text;
  const char *valid;   /* the field of this kind that is 0 where this one holds no measurement; null: as in the schema */
  const char *nothing; /* numbers that stand for no measurement ("0", "0 0 0", "inf"), to which no noise is added; null: as in the schema */
} tatu_field;

/* Random numbers for `measure`, for effects that declared noise cannot express. A number depends only on the scene's
 * seed, the sensor, how often it has been measured, and the number's index (`first` and up), not on other sensors or the
 * order of calls. Callable from any thread during the call that received it. */
typedef struct tatu_random {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  /* `n` uniform numbers in [0, 1) for instance `i` of the batch. */
  void(TATU_CALL *uniform)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
  /* `n` normally distributed numbers: mean 0, standard deviation 1. */
  void(TATU_CALL *normal)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
} tatu_random;

/* The `n` sensors of one kind that are due. Arrays are null unless the kind declares the input. */
typedef struct tatu_sensor_batch {
  uint32_t size;
  uint32_t n;
  uint32_t n_fields;
  uint32_t reserved;
  double time;                    /* simulation time, s */
  uint64_t step;                  /* number of the step, from 0 */
  void *const *data;              /* [n] instances */
  void *const *state;             /* [n] state blocks */
  const tatu_object *sensor;      /* [n] */
  const uint64_t *first_beam;     /* [n + 1] index of each sensor's first beam in the arrays below */
  const double *distance;         /* per beam */
  const double *point;            /* per beam, 3 */
  const double *normal;           /* per beam, 3 */
  const tatu_object *object;      /* per beam */
  const double *pose;             /* [n], 7 each */
  const double *twist;            /* [n], 6 each: mean motion over the last step, from the difference of its poses */
  void *const *fields;            /* [n * n_fields] output buffers; host-owned, zeroed */
  tatu_status *status;            /* [n] TATU_OK; negative: that instance failed; it is switched off, the fault reported */
  const uint8_t *color;           /* per beam, 3: red green blue of the surface, unshaded; 0 0 0: no hit */
  const uint32_t *primitive;      /* per beam */
  const uint64_t *first_pixel;    /* [n + 1] index of each sensor's first pixel in the arrays below; null: no images */
  const float *depth;             /* per pixel: m along the sensor's +z; infinity: no hit. TATU_IN_DISTANCE */
  const uint8_t *pixel_color;     /* per pixel, 3; the sky's without a hit. TATU_IN_COLOR */
  const float *pixel_cosine;      /* per pixel, 0 to 1; 0: no hit. TATU_IN_COSINE */
  const tatu_object *pixel_object; /* per pixel; 0: no hit. TATU_IN_OBJECT */
  const tatu_random *random;
  double *const *rays;            /* [n] with TATU_BEAMS_AIMED: 6 per ray, origin (m) and unit direction; else null */
  const uint64_t *const *lengths; /* [n] the number of elements of each field, n_fields each */
} tatu_sensor_batch;

/* Named settings: the keys that a scene would write for a sensor, as lines of TOML ("range_m = 5.6"), noise included.
 * A scene selects them with `preset = "<id>"`; its own keys override them. */
typedef struct tatu_preset {
  uint32_t size;
  uint32_t reserved;
  const char *id;       /* "hokuyo_urg_04lx" */
  const char *text;     /* one sentence, with the source of the numbers */
  const char *settings;
} tatu_preset;

/* A kind of sensor. */
typedef struct tatu_sensor {
  uint32_t size;
  uint32_t inputs;                   /* TATU_IN_* */
  const char *id;                    /* "proximity": what scenes write */
  const char *text;
  const char *const *schemas;        /* "proximity/1": what readers search for */
  const tatu_param *const *params;
  const tatu_field *const *fields;
  const tatu_life *life;
  /* [setup] Gets the beams of an instance, at creation and after its parameters change. Null: none. */
  tatu_status(TATU_CALL *beams)(void *data, tatu_beams *, tatu_error *);
  /* [parallel] Turns inputs into readings. May access only data, state and fields of its instances, and call only the
   * log and the batch's `random`. A negative status switches off all instances of the batch. The host then adds the
   * noise that the scene declares, except to values that stand for no measurement (see `nothing`, `valid`). */
  tatu_status(TATU_CALL *measure)(void *self, const tatu_sensor_batch *, tatu_error *);
  const tatu_preset *const *presets; /* may be null */
  /* [parallel] Recomputes derived fields, with the same batch, after declared noise was added: latitude and longitude
   * from a position, for instance. It overwrites them, so noise is declared for the field that they derive from. Not
   * called if no sensor of the batch has noise, so `measure` must fill derived fields too. Access and status as for
   * `measure`. Null: no derived fields. */
  tatu_status(TATU_CALL *finish)(void *self, const tatu_sensor_batch *, tatu_error *);
  /* [parallel] Before the cast, if an instance's rays are TATU_BEAMS_AIMED: may change `rays`, origins and unit
   * directions in the sensor's frame, preset to the sensor's origin and the directions from `beams`; for devices that
   * move while they scan, and rays that jitter. Hits and fields are not available yet; otherwise as `measure`. */
  tatu_status(TATU_CALL *aim)(void *self, const tatu_sensor_batch *, tatu_error *);
  uint32_t flags; /* 0 */
  uint32_t reserved;
} tatu_sensor;

typedef struct tatu_ext_sensor {
  uint32_t size;
  uint32_t reserved;
  const tatu_sensor *const *kinds;
} tatu_ext_sensor;

/* ================================================================ 7. Actuators ======================= */

#define TATU_ACTUATOR "tatu.actuator/draft.4"

/* A kind's `apply` is called once each time physics advances (by one step of the world, or by what a driver asks for)
 * or, with the flag, before each engine step. A wrench acts on the nearest dynamic shape at or above the actuator, an
 * effort on the nearest joint between the actuator and that shape. Commands are properties "<kind>.<key>" of the
 * actuator's object: scenes set them like parameters, and they can be set at any time. */
enum { TATU_ACTUATOR_EVERY_SUBSTEP = 1 /* `apply` is called before each engine step */ };

/* The actuators of one kind: state of the mount and commands in, wrench or effort out. */
typedef struct tatu_actuator_batch {
  uint32_t size;
  uint32_t n;
  double time;               /* s */
  double dt;                 /* time until the next call, s */
  void *const *data;         /* [n] instances */
  void *const *state;        /* [n] state blocks */
  const tatu_object *actuator; /* [n] */
  const double *pose;        /* [n], 7 each: mount in the world */
  const double *twist;       /* [n], 6 each */
  const double *joint;       /* [n], 2 each: position and velocity of the joint it sits on; 0 without one */
  const double *const *command; /* [n] the command buffer: `n_commands` of the kind */
  double *wrench;            /* [n], 6 each: force N at the mount's origin and torque N m, world; zeroed. Acts for dt */
  double *effort;            /* [n] torque N m or force N added to the joint's; zeroed. Acts for dt */
  tatu_status *status;       /* [n] as for sensors; a number that is not finite counts as a failure */
} tatu_actuator_batch;

typedef struct tatu_actuator {
  uint32_t size;
  uint32_t flags;                    /* TATU_ACTUATOR_* */
  uint32_t n_commands;               /* numbers in the command buffer of an instance: as many as `commands` */
  uint32_t reserved;
  const char *id;
  const char *text;
  const tatu_param *const *params;
  const tatu_param *const *commands; /* what the numbers mean, each of type TATU_F64 */
  const tatu_life *life;
  /* [parallel] Turns commands into forces. Rules as for `measure`. */
  tatu_status(TATU_CALL *apply)(void *self, const tatu_actuator_batch *, tatu_error *);
} tatu_actuator;

typedef struct tatu_ext_actuator {
  uint32_t size;
  uint32_t reserved;
  const tatu_actuator *const *kinds;
} tatu_ext_actuator;

/* ================================================================ 8. Builder, models, importers ====== */

enum {
  TATU_REPORT_NOTE = 0,
  TATU_REPORT_WARNING = 1, /* the scene works, but not as the source says */
  TATU_REPORT_ERROR = 2,   /* the build fails */
  TATU_REPORT_LACK = 3     /* a part that cannot run here: the scene starts without it, and each run reports a fault;
                              hosts that do not know this value show it as a note */
};

/* Writes a document, the description of a scene by a scene file, a model or an importer. Nothing in it is live yet. */
typedef struct tatu_builder {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  /* [setup] Adds an object of a kind ("shape", "joint", "dummy", "sensor", ...) below `parent` (0: the top of what is
   * being built). Returns its number, from 1; 0: rejected, see the error of the build. */
  uint32_t(TATU_CALL *object)(const struct tatu_builder *, const char *kind, uint32_t parent, tatu_str alias);
  /* [setup] Sets a property by key, with or without the kind's prefix ("mass", "position", "color"). SI units.
   * Object 0 with a key that begins with "scene." sets a parameter of the world ("scene.dt", "scene.gravity") or its
   * free data ("scene.data"); this takes effect only if an importer's file is opened as the scene. The same holds for
   * "object.name", the unique name ("arm#0"), with the object's alias before the `#`. */
  tatu_status(TATU_CALL *set)(const struct tatu_builder *, uint32_t object, const char *key, const tatu_value *);
  /* [setup] Adds a triangle mesh, `n_points` * 3 doubles and `n_triangles` * 3 indices; returns its number, for the
   * property "mesh" of shapes; 0: rejected. Equal meshes are stored once. */
  uint64_t(TATU_CALL *mesh)(const struct tatu_builder *, const double *points, uint64_t n_points,
                            const uint32_t *triangles, uint64_t n_triangles);
  /* [setup] Adds an image, 4 bytes per pixel, top row first; returns its number; 0: rejected. */
  uint64_t(TATU_CALL *image)(const struct tatu_builder *, const uint8_t *rgba, uint32_t width, uint32_t height);
  /* [setup] Adds a script to an object. `language` may be null: by suffix; `dialect` may be null: from the text. `kind`:
   * "child", "threaded", "customization" or "main" (a scene's driver; ignored in models and in imports that are not
   * the scene itself). Returns its number; 0: rejected. */
  uint32_t(TATU_CALL *script)(const struct tatu_builder *, uint32_t owner, const char *language, const char *dialect,
                              const char *kind, tatu_str name, tatu_str text);
  /* [setup] Gives an object of kind "sensor" or "actuator" its device: a kind ("proximity"), or a schema that the kind
   * must fill ("proximity/1"). Its parameters are then set like properties. */
  tatu_status(TATU_CALL *device)(const struct tatu_builder *, uint32_t object, const char *kind_or_schema);
  /* [setup] Reports something about the source: TATU_REPORT_*; shown with the file name. */
  void(TATU_CALL *report)(const struct tatu_builder *, uint32_t severity, uint32_t object, tatu_str text);
  /* [setup] Reads a file, named relative to the folder of the source; the bytes live as long as the build. An
   * importer's source is its file, a model's is the scene. TATU_ERR_MISSING: no such file; the build can go on. Names
   * may contain `..` within the folders of the source, of the scene and (importers) of the run; leaving these fails
   * the build. */
  tatu_status(TATU_CALL *file)(const struct tatu_builder *, tatu_str relative, tatu_str *bytes);
  /* [setup] Describes the source for `tatu check FILE --json`: a map with text keys, which the importer's documentation
   * explains. Null or absent: nobody asks, so the importer need not gather it. */
  tatu_status(TATU_CALL *describe)(const struct tatu_builder *, const tatu_value *map);
} tatu_builder;

#define TATU_MODEL "tatu.model/draft.4"

/* A model: a function from parameters to objects. Object 1 of the build is the model's base. */
typedef struct tatu_model {
  uint32_t size;
  uint32_t flags;                  /* 0 */
  const char *id;                  /* "pioneer_p3dx": what scenes write */
  const char *text;
  const tatu_param *const *params;
  const char *const *slots;        /* aliases of objects to which others may be attached; null: none */
  /* [setup] Builds it, with the base placed so that the model stands on the floor z = 0. A model on wheels describes its
   * drive in the property "object.drive" of its base. */
  tatu_status(TATU_CALL *build)(void *self, const tatu_builder *, const tatu_value *params, tatu_error *);
  const char *category;            /* heading in lists: "mobile robots", "arms", "furniture"; null: none */
} tatu_model;

typedef struct tatu_ext_model {
  uint32_t size;
  uint32_t reserved;
  const tatu_model *const *models;
} tatu_ext_model;

#define TATU_IMPORTER "tatu.importer/draft.4"

/* Reads a file format into a document: for `[[import]]` in scenes, and for files opened as the scene. */
typedef struct tatu_importer {
  uint32_t size;
  uint32_t reserved;
  const char *id;
  const char *text;
  const char *const *suffixes;     /* ".urdf" */
  const tatu_param *const *params;
  /* [setup] Confidence, 0 to 100, that the importer can read a file that begins with `head`. Null: by suffix. */
  uint32_t(TATU_CALL *sniff)(void *self, tatu_str head);
  /* [setup] Reads it; object 1 of the build is the base. Malformed input causes an error, never a crash. An error gives
   * its line with TATU_PART_FILE; an empty file name there means the source itself. */
  tatu_status(TATU_CALL *load)(void *self, tatu_str bytes, const tatu_builder *, const tatu_value *params,
                               tatu_error *);
} tatu_importer;

typedef struct tatu_ext_importer {
  uint32_t size;
  uint32_t reserved;
  const tatu_importer *const *importers;
} tatu_ext_importer;

/* ================================================================ 9. Script languages ================ */

#define TATU_SCRIPT "tatu.script/draft.4"

/* Limits of one call of a script. 0: no limit. */
typedef struct tatu_budget {
  uint32_t size;
  uint32_t reserved;
  uint64_t instructions; /* of the language's virtual machine */
  uint64_t memory;       /* bytes of the script's state */
} tatu_budget;

enum {
  /* A callback of the life cycle: "init", "thread", "actuation", "sensing", "cleanup", "nonSimulation",
   * "beforeSimulation", "afterSimulation", "suspend", "suspended", "resume", "beforeStep", "dyn", "joint", "contact", or
   * "measured": for a sensor's scripts, after it was measured in the sensing stage, with a map whose `sensor` is that
   * object. It may return a map: `cmd` "cleanup" ends the script, "restart" ends it and starts it again; `skip` true
   * from "beforeStep" skips the stages of the pass, and time does not advance. */
  TATU_FIND_CALLBACK = 0,
  TATU_FIND_FUNCTION = 1  /* a function of the script, by its own name */
};

enum {
  TATU_SCRIPT_SILENT = 1,  /* after an error its clean-up is called at once, then nothing until the next start */
  TATU_SCRIPT_MODERN = 2,  /* a scene that names no dialect counts as modern if it has such a script */
  TATU_SCRIPT_THREADED = 4 /* it runs as a thread of its own and is not called in each step */
};

enum {
  TATU_LANGUAGE_SIDE_BY_SIDE = 1 /* different scripts may be called on different threads at once */
};

enum {
  TATU_ORDER_PARENTS_FIRST = 1, /* down each tree; then customization scripts */
  TATU_ORDER_BY_KIND = 2,       /* threaded child scripts, child scripts, customization scripts; each up the trees */
  TATU_ORDER_DEEPEST_FIRST = 3  /* child scripts, customization scripts; each by depth over the whole scene */
};

/* A script language. Each script is one instance with a state of its own. Its errors become a status. */
typedef struct tatu_language {
  uint32_t size;
  uint32_t flags;              /* TATU_LANGUAGE_* */
  const char *id;              /* "lua" */
  const char *text;
  const char *const *suffixes; /* ".lua" */
  const tatu_life *life;       /* the instance's owner is the script object. Its `load` is called after the one below: it
                                * restores all of the state if the text is equivalent to the writer's, else it fails.
                                * After a file change it is called again after `init`, and restores what still fits */
  /* [step] Loads the text. `chunk` is the name for messages, a file if there is one. An empty `dialect` is determined
   * from the text; the dialect in use is returned in `*chosen`, which the plugin owns. */
  tatu_status(TATU_CALL *load)(void *data, tatu_str text, tatu_str chunk, tatu_str dialect, tatu_str *chosen,
                               tatu_error *);
  /* [step] A number for something callable; 0: the script has none. The function behind it may change with each call. */
  uint32_t(TATU_CALL *find)(void *data, uint32_t how, tatu_str name);
  /* [step] Calls it with the frame's arguments; results go into the frame. TATU_WAIT: suspended in a command that
   * waits; the host calls `resume` with that wait's token. `*used` counts instructions. May be re-entered. */
  tatu_status(TATU_CALL *call)(void *data, uint32_t callable, tatu_call *frame, const tatu_budget *, uint64_t *used,
                               tatu_error *);
  /* [step] A wait has ended: `frame->args` are the results of the command that waited. If `failed` is not TATU_OK, the
   * command failed, and `frame->error` says why. Returns as `call` does. */
  tatu_status(TATU_CALL *resume)(void *data, uint64_t token, tatu_status failed, tatu_call *frame,
                                 const tatu_budget *, uint64_t *used, tatu_error *);
  /* [step] Retains a borrowed function reference: returns its permanent local id, 0 if it is gone. */
  uint32_t(TATU_CALL *keep_func)(void *data, uint32_t local);
  /* [step] Releases a retained reference. */
  void(TATU_CALL *drop_func)(void *data, uint32_t local);
  /* [step] Calls a function reference, borrowed or retained. */
  tatu_status(TATU_CALL *call_func)(void *data, uint32_t local, tatu_call *frame, const tatu_budget *, uint64_t *used,
                                    tatu_error *);
  /* [any] Whether it supports a dialect named by a scene; the error lists those it supports. Null: any is accepted. */
  tatu_status(TATU_CALL *knows_dialect)(void *self, tatu_str dialect, tatu_error *);
  /* [step] TATU_SCRIPT_* bits of a script whose text has been loaded. Null: none. */
  uint32_t(TATU_CALL *traits)(void *data);
  /* [step] The order in which a world's scripts are called, TATU_ORDER_*, if its scene names this dialect or, if that is
   * empty, if it has modern scripts (1) or none (0). Called on one loaded script. Null or 0: deepest first. */
  uint32_t(TATU_CALL *order)(void *data, tatu_str dialect, uint32_t modern);
  /* [step] The script's position while a command that it called runs, for errors that are logged and not raised: sets
   * file, line and traceback in the error object, as for a failure, or nothing. Null: not supported. */
  void(TATU_CALL *place)(void *data, tatu_error *);
} tatu_language;

typedef struct tatu_ext_script {
  uint32_t size;
  uint32_t reserved;
  const tatu_language *const *languages;
} tatu_ext_script;

/* ================================================================ 10. Services of plugins ============ */

#define TATU_SERVICE "tatu.service/draft.4"

enum { TATU_GO = 0, TATU_HOLD = 1 };

/* A component that runs beside worlds: a remote API, a bridge, a viewer, a recorder. It is created once per session,
 * while worlds come and go. It may block only in its own threads, and these may call only session.wake and log.write.
 * What it does to a world with commands.call and session.request is recorded in the input log, from which a run can be
 * replayed; what it does with other tables is not. Numeric arrays in arguments are recorded as f64 or i64. A negative
 * status from `barrier`, `event` or `resume` switches the service off and is reported once. */
typedef struct tatu_service {
  uint32_t size;
  uint32_t flags; /* 0 */
  const char *id;
  const char *text;
  const tatu_param *const *params;
  /* Its instance: `create` starts it in tatu_instance.session; `destroy` ends it and joins its threads before it returns.
   * `save` and `load` [step]: its state concerning one world, for snapshots of that world; a restored world ignores it if
   * the service is not running. `configure` is not called. */
  const tatu_life *life;
  /* [step] Before each step, and while stopped or paused, but not in the passes that follow a stop: executes what is
   * queued, never blocks, returns TATU_GO or TATU_HOLD. While any service holds, the session sleeps until session.wake,
   * at most 0.1 s, and calls all again. */
  tatu_status(TATU_CALL *barrier)(void *data, tatu_world *, uint64_t step, tatu_error *);
  /* [step] An event: name and payload, valid during the call. Delivered at the barrier: "started", "paused", "resumed",
   * "fault" (a map: code, message, and where known plugin, object, file, line); at the end "stopped". Null: it receives
   * no events. */
  tatu_status(TATU_CALL *event)(void *data, tatu_world *, tatu_str name, const tatu_value *payload, tatu_error *);
  /* [step] A command that this service called with a wait token, and that returned TATU_WAIT, has finished: its results
   * are in the frame, or `status` is negative and frame->error says why. Null: its commands cannot wait. */
  tatu_status(TATU_CALL *resume)(void *data, tatu_world *, uint64_t token, tatu_status status, const tatu_call *frame,
                                 tatu_error *);
  /* Names of the events it receives, null-terminated; "*": all but the expensive ones ("collision", "separation",
   * "contact"), which must be named. Null: the five above. */
  const char *const *events;
  /* [step] Calls a client's function that this service passed as an argument; `local` is the number given to
   * session.function. Arguments are in the frame; results go into it, in memory from commands.alloc. Only this call may
   * block for a client: simulation time stands still, so poll session.interrupted. Commands that the client calls before
   * it answers run nested in this call, and cannot wait. The results are recorded in the input log. TATU_ERR_GONE: the
   * client has disconnected. Null: the service passes no functions. */
  tatu_status(TATU_CALL *call_func)(void *data, tatu_world *, uint32_t local, tatu_call *frame);
  /* [step] The last barrier: this world ends, and its pointer with it. The world is read-only; pending requests can still
   * be answered. Null: nothing to do. */
  tatu_status(TATU_CALL *last)(void *data, tatu_world *, tatu_error *);
} tatu_service;

typedef struct tatu_ext_service {
  uint32_t size;
  uint32_t reserved;
  const tatu_service *const *services;
} tatu_ext_service;

/* ---------------------------------------------------------------- Events ------------------------------ */

#define TATU_EVENT "tatu.event/draft.4"

/* Declaration of an event, by the plugin that publishes it (host.events); `tatu list events` shows it. Names without a
 * dot belong to the host ("collision"); a plugin's begin with a name space ("gripper.closed"). */
typedef struct tatu_event {
  uint32_t size;
  uint32_t reserved;
  const char *name;
  const char *text;                /* when it is published, one sentence */
  const tatu_param *const *fields; /* of the payload, a map; null: empty */
} tatu_event;

typedef struct tatu_ext_event {
  uint32_t size;
  uint32_t reserved;
  const tatu_event *const *events;
} tatu_ext_event;

/* ================================================================ 11. What the host offers =========== */
/* Every function that takes a world is [step] and may be called from within any [step] call of that world. On failure
 * it returns a negative status; log.last_error(world) has the message until the next failure. */

/* Kinds of objects. */
enum {
  TATU_KIND_SHAPE = 0, TATU_KIND_JOINT = 1, TATU_KIND_DUMMY = 2, TATU_KIND_SENSOR = 3, TATU_KIND_ACTUATOR = 4,
  TATU_KIND_FORCE_SENSOR = 5, TATU_KIND_SCRIPT = 6, TATU_KIND_CAMERA = 7, TATU_KIND_LIGHT = 8, TATU_KIND_GRAPH = 9,
  TATU_KIND_PATH = 10
};
enum {
  TATU_LIST_CHILDREN = 1,   /* direct children only; else the whole tree, breadth first */
  TATU_LIST_SKIP_BASE = 2   /* without the object itself */
};

#define TATU_HOST_SCENE "tatu.host.scene/draft.4"

/* Objects and their properties, which docs/reference/properties.md lists. The world itself is object 0. */
typedef struct tatu_host_scene {
  uint32_t size;
  uint32_t reserved;
  /* [any] Interns a key ("joint.position"); never fails, since the key may be declared later. */
  tatu_prop(TATU_CALL *prop)(const tatu_host *, const char *key);
  /* Reads a property. Text and arrays are valid until the current call returns. */
  tatu_status(TATU_CALL *get)(tatu_world *, tatu_object, tatu_prop, tatu_value *);
  /* Sets one. Poses and values change at once; bodies are rebuilt at the next stage if the property's row says so. */
  tatu_status(TATU_CALL *set)(tatu_world *, tatu_object, tatu_prop, const tatu_value *);
  /* Reads exactly `n` numbers, without allocation: the fast way to read poses and joints. */
  tatu_status(TATU_CALL *get_f64)(tatu_world *, tatu_object, tatu_prop, double *out, uint32_t n);
  /* Sets exactly `n` numbers. */
  tatu_status(TATU_CALL *set_f64)(tatu_world *, tatu_object, tatu_prop, const double *in, uint32_t n);
  /* The same for `count` objects, `n` numbers each; stops at the first failure. */
  tatu_status(TATU_CALL *get_f64_many)(tatu_world *, const tatu_object *, uint32_t count, tatu_prop, double *out,
                                       uint32_t n);
  tatu_status(TATU_CALL *set_f64_many)(tatu_world *, const tatu_object *, uint32_t count, tatu_prop, const double *in,
                                       uint32_t n);
  /* Pose of an object in the frame of another (0: the world; a joint: its moved frame). 7 doubles. */
  tatu_status(TATU_CALL *pose)(tatu_world *, tatu_object, tatu_object frame, double *pose);
  /* Places an object; its descendants move along; dynamic bodies are moved in the engine too. */
  tatu_status(TATU_CALL *set_pose)(tatu_world *, tatu_object, tatu_object frame, const double *pose);
  /* The full id and the kind (TATU_KIND_*) of an object; validates a handle passed by a script. */
  tatu_status(TATU_CALL *look)(tatu_world *, tatu_object, tatu_object *full, int32_t *kind);
  /* Finds by path ("/a/b[1]", "./b" and ":/b" from `from`) or by unique name ("b#0"). TATU_ERR_MISSING: not found. */
  tatu_status(TATU_CALL *find)(tatu_world *, tatu_object from, tatu_str path, tatu_object *);
  /* Creates an object; it exists at once, and joins physics at the next stage. */
  tatu_status(TATU_CALL *create)(tatu_world *, const char *kind, tatu_object parent, tatu_str alias, tatu_object *);
  /* Removes objects: they can no longer be found at once; children go to the parent; instances end at the next stage. */
  tatu_status(TATU_CALL *remove)(tatu_world *, const tatu_object *, uint32_t n);
  /* Lists objects below `base` (0: all); `kinds` has bit 1 << TATU_KIND_* for each wanted kind, 0: all. `*n` is the
   * full count even if `cap` is smaller. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object base, uint32_t kinds, uint32_t flags, tatu_object *out,
                               uint32_t cap, uint32_t *n);
  /* Copies `n` objects, in place: a copy is placed below the copy of its parent, or at the top level if the parent is
   * not in the list. All get one new suffix. `out` has room for `n`. Sensors, actuators and scripts are copied with
   * their current parameters and text, and start afresh. */
  tatu_status(TATU_CALL *copy)(tatu_world *, const tatu_object *objects, uint32_t n, tatu_object *out);
  /* [step] Loads a scene file, or a file that an importer reads, into the world below `parent` (0: the world):
   * objects, sensors, actuators and scripts. `file` is a path from `files.resolve`, or the id of a model. `*out` is
   * the first object. World settings and a main script in the file have no effect. Errors in the file are those of a
   * start. */
  tatu_status(TATU_CALL *load)(tatu_world *, tatu_str file, tatu_object parent, tatu_object *out);
  /* [step] Writes an object and all below it (0: the whole scene) as a scene file, with meshes and scripts in a
   * folder beside it. `file` is a path from `files.resolve` that ends with ".toml". */
  tatu_status(TATU_CALL *save)(tatu_world *, tatu_str file, tatu_object base);
  /* [step] The `index`-th property of an object, from 0 (object 0: of the world), as a map: "key", "type" (as TATU_*
   * numbers), "count", "unit", "settable", "choices" (a list of texts), "text". Parameters of its device follow its
   * own properties. Valid until the current call returns. TATU_ERR_MISSING, without a message: past the last. */
  tatu_status(TATU_CALL *row)(tatu_world *, tatu_object, uint32_t index, tatu_value *);
  /* [step] The `index`-th model that plugins offer, from 0, as a map: "id" (for `load`), "text". Valid as that of
   * `row`. TATU_ERR_MISSING, without a message: past the last. */
  tatu_status(TATU_CALL *model)(tatu_world *, uint32_t index, tatu_value *);
} tatu_host_scene;

#define TATU_HOST_STAND_INS "tatu.host.stand_ins/draft.4"

/* Stand-ins for objects that scripts ask for and that do not exist. A run of a script without a scene creates them:
 * it is repeated, and each run uses what the previous ones have learned. Command plugins report here what was asked
 * for. In all other runs each function returns TATU_ERR_MISSING without a message, at no cost. */
typedef struct tatu_host_stand_ins {
  uint32_t size;
  uint32_t reserved;
  /* [step] Whether the run creates stand-ins: for things that are not objects. TATU_OK or TATU_ERR_MISSING. */
  tatu_status(TATU_CALL *made)(tatu_world *);
  /* [step] An object that a script named, and that does not exist: creates and returns a dummy. `name` as for
   * scene.find (a path is created part by part, a unique name below `from`). `kind`, if not null, is what it was used
   * as: see `used`. */
  tatu_status(TATU_CALL *object)(tatu_world *, tatu_object from, tatu_str name, const char *kind, tatu_object *);
  /* [step] An object was used as one of `kind`: a kind of object ("joint") or a schema ("proximity/1"). TATU_OK: it
   * is one now, so that the call can continue; in the next run it is one in any case. */
  tatu_status(TATU_CALL *used)(tatu_world *, tatu_object, const char *kind);
  /* [step] A script reached the end of the tree: it asked for the parent of an object, */
  tatu_status(TATU_CALL *parent)(tatu_world *, tatu_object);
  /* a child of it (of a kind, if that is not null), */
  tatu_status(TATU_CALL *child)(tatu_world *, tatu_object, const char *kind);
  /* or its script. This is recorded; the next run creates it if it was missed. */
  tatu_status(TATU_CALL *script)(tatu_world *, tatu_object);
  /* [step] A value that an object does not have, by name. TATU_OK: return a neutral default. */
  tatu_status(TATU_CALL *value)(tatu_world *, tatu_object, tatu_str name);
} tatu_host_stand_ins;

#define TATU_HOST_READINGS "tatu.host.readings/draft.4"

/* The limits of one measurement. Noise and the plugin's processing are unchanged. */
typedef struct tatu_look {
  uint32_t size;
  uint32_t flags;       /* TATU_BEAMS_NO_FRONT, _NO_BACK, _OCCLUDE, in place of the sensor's own */
  tatu_object only;     /* detect only this object; 0: all */
  double far_m;         /* nothing farther from the sensor's origin is detected; infinity: the sensor's range */
  double max_incidence; /* in place of the sensor's own; pi/2 or more: no limit */
} tatu_look;

/* What sensors measured. */
typedef struct tatu_host_readings {
  uint32_t size;
  uint32_t reserved;
  /* One field ("proximity.distance", interned with scene.prop) of a sensor. TATU_ERR_MISSING: it has none. */
  tatu_status(TATU_CALL *field)(tatu_world *, tatu_object sensor, tatu_prop field, tatu_field_view *);
  /* Measures with a sensor now, outside its turn. `only`: detect only this object; 0: all. */
  tatu_status(TATU_CALL *sense_now)(tatu_world *, tatu_object sensor, tatu_object only);
  /* Discards the reading: its sequence number becomes 0. */
  tatu_status(TATU_CALL *reset)(tatu_world *, tatu_object sensor);
  /* Lists the sensors that fill a schema ("proximity/1"). */
  tatu_status(TATU_CALL *list)(tatu_world *, const char *schema, tatu_object *out, uint32_t cap, uint32_t *n);
  /* The declaration of the `index`-th field of a sensor, from 0, with its shape for this sensor; its texts are valid
   * as long as the world. TATU_ERR_MISSING: past the last. */
  tatu_status(TATU_CALL *describe)(tatu_world *, tatu_object sensor, uint32_t index, tatu_field *);
  /* As `sense_now`, with limits that replace those of the sensor's parameters for this measurement. */
  tatu_status(TATU_CALL *look)(tatu_world *, tatu_object sensor, const tatu_look *);
} tatu_host_readings;

#define TATU_HOST_BODIES "tatu.host.bodies/draft.4"

/* Moving bodies. Mass and inertia are properties ("shape.mass"). */
typedef struct tatu_host_bodies {
  uint32_t size;
  uint32_t reserved;
  /* Velocity of any object: from the engine for dynamic shapes, else from the last step's motion. 6 doubles. */
  tatu_status(TATU_CALL *twist)(tatu_world *, tatu_object, double *twist);
  /* Sets the velocity of a dynamic shape. */
  tatu_status(TATU_CALL *set_twist)(tatu_world *, tatu_object, const double *twist);
  /* Applies a force N and a torque N m to a dynamic shape during the next physics step, at its centre of mass, world
   * frame. Calls add up. Null: none. */
  tatu_status(TATU_CALL *push)(tatu_world *, tatu_object, const double *force, const double *torque);
  /* Changes momentum at once: N s and N m s, world frame, at the centre of mass. Null: none. */
  tatu_status(TATU_CALL *impulse)(tatu_world *, tatu_object, const double *linear, const double *angular);
  /* Pairs of shapes in contact after the last step, of one shape or (0) of all. `*n` is the full count. */
  tatu_status(TATU_CALL *contacts)(tatu_world *, tatu_object, tatu_contact *out, uint32_t cap, uint32_t *n);
  /* The shortest distance from any shape of a list to any of another, at their current poses; `n_b` 0: to any other
   * shape. Objects that are not shapes are skipped. `limit` > 0: at most this far, m. Fills 6 numbers, both end
   * points in the world frame, and the two shapes; overlapping solids have distance 0. TATU_ERR_MISSING: none is that
   * near. */
  tatu_status(TATU_CALL *closest)(tatu_world *, const tatu_object *a, uint32_t n_a, const tatu_object *b, uint32_t n_b,
                                  double limit, double *points, tatu_object *pair);
  /* Whether the engine moves it: 1 for dynamic shapes and for joints between two bodies, once physics has run. */
  tatu_status(TATU_CALL *is_dynamic)(tatu_world *, tatu_object, uint32_t *yes);
  /* Friction at the contacts from `contacts`, in the same order: on shape[1], world frame, N, over the last physics
   * step, 3 numbers each. `cap` and `n` count numbers. */
  tatu_status(TATU_CALL *frictions)(tatu_world *, tatu_object, double *out, uint32_t cap, uint32_t *n);
} tatu_host_bodies;

#define TATU_HOST_COMMANDS "tatu.host.commands/draft.4"

/* All commands of all plugins, callable; ids run from 1 without gaps. */
typedef struct tatu_host_commands {
  uint32_t size;
  uint32_t reserved;
  /* The id of the command of a name; 0: there is none. `*alias`, if not null: the index of that name among the
   * command's names. */
  uint32_t(TATU_CALL *find)(tatu_world *, tatu_str name, uint32_t *alias);
  /* Whether `name` followed by a dot begins the name of any command or constant: 1 or 0. */
  uint32_t(TATU_CALL *is_name_space)(tatu_world *, tatu_str name);
  /* The number of commands. */
  uint32_t(TATU_CALL *count)(tatu_world *);
  /* The declaration: the host's own copy, valid as long as the host. Null: no such id. */
  const tatu_command *(TATU_CALL *describe)(tatu_world *, uint32_t id);
  /* Calls a command. Fill in of the frame: size, command, alias, args, n_args, results, results_cap, wait_token; the
   * host fills in the rest. On failure frame->error has the message until the next call. Bytes in the results are
   * valid until the caller releases to a mark, or its own call returns. */
  tatu_status(TATU_CALL *call)(tatu_world *, tatu_call *frame);
  /* Increases when commands are added or removed: look ids up again. */
  uint64_t(TATU_CALL *generation)(tatu_world *);
  /* A named constant. TATU_ERR_MISSING: none. */
  tatu_status(TATU_CALL *constant)(tatu_world *, tatu_str name, tatu_value *);
  /* The `index`-th prelude of a language, module and text. TATU_ERR_MISSING past the end. */
  tatu_status(TATU_CALL *prelude)(tatu_world *, const char *language, uint32_t index, tatu_str *module,
                                  tatu_str *text);
  /* Marks a position in the world's arena, */
  uint64_t(TATU_CALL *mark)(tatu_world *);
  /* allocates in it, */
  void *(TATU_CALL *alloc)(tatu_world *, uint64_t bytes);
  /* and releases everything allocated since a mark. */
  void(TATU_CALL *release)(tatu_world *, uint64_t mark);
  /* Retains a function of a script beyond the call: `*kept` is valid until it is dropped or its script ends; after
   * that it need not be dropped. Retaining it twice gives two ids. */
  tatu_status(TATU_CALL *retain)(tatu_world *, tatu_func, tatu_func *kept);
  /* Releases a retained function. */
  void(TATU_CALL *drop)(tatu_world *, tatu_func);
  /* Calls a script's function; frame as in `call`. TATU_ERR_GONE: its script has ended. */
  tatu_status(TATU_CALL *call_func)(tatu_world *, tatu_func, tatu_call *frame);
  /* The name of the `index`-th constant, in the order of their names. TATU_ERR_MISSING past the end. */
  tatu_status(TATU_CALL *constant_name)(tatu_world *, uint32_t index, tatu_str *name);
} tatu_host_commands;

#define TATU_HOST_SCRIPTS "tatu.host.scripts/draft.4"

/* Scripts of the world. A script is an object of kind script that belongs to an object. */
typedef struct tatu_host_scripts {
  uint32_t size;
  uint32_t reserved;
  /* The scripts of an object; 0: of all. `*n` is the full count. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object owner, tatu_object *out, uint32_t cap, uint32_t *n);
  /* Calls a function of a script by its own name. */
  tatu_status(TATU_CALL *call)(tatu_world *, tatu_object script, tatu_str function, tatu_call *frame);
  /* Calls a callback in all scripts that have it, except in `except`; results are discarded. */
  tatu_status(TATU_CALL *broadcast)(tatu_world *, tatu_str callback, const tatu_value *args, uint32_t n_args,
                                    tatu_object except);
  /* The options of a script that was started from outside: a map of texts, empty for all others. Valid until the
   * current call returns. */
  tatu_status(TATU_CALL *options)(tatu_world *, tatu_object script, tatu_value *);
  /* Adds a script to an object of a live world. `language` by its id; `dialect` may be empty; `kind` is "child",
   * "threaded" or "customization". During a run it starts in the next stage, after all others. A stop removes scripts
   * added since the start. */
  tatu_status(TATU_CALL *add)(tatu_world *, tatu_object owner, tatu_str language, tatu_str dialect, tatu_str kind,
                              tatu_str name, tatu_str text, tatu_object *out);
  /* Calls the child scripts of all objects below one, in order and with these arguments, for a stage that is running
   * now: those that have not been called in it yet. The stage does not call them again. `stage`: TATU_STAGE_ACTUATE
   * or TATU_STAGE_REACT; if it is not running, none is called. `*n`: the number of scripts called. */
  tatu_status(TATU_CALL *call_below)(tatu_world *, tatu_object above, uint32_t stage, const tatu_value *args,
                                     uint32_t n_args, uint32_t *n);
  /* [step] The text of a script, as bytes. Valid until the current call returns. */
  tatu_status(TATU_CALL *text)(tatu_world *, tatu_object script, tatu_value *);
  /* [step] Replaces the text of a script: its numbers, texts and tables are kept where the new text has them. Fails,
   * without any change, if the text cannot be loaded. Not while the script itself runs. */
  tatu_status(TATU_CALL *change)(tatu_world *, tatu_object script, tatu_str text);
} tatu_host_scripts;

#define TATU_HOST_SIGNALS "tatu.host.signals/draft.4"

/* Named values of the world, one name space per `kind` (a number of the user's choice below 256). */
typedef struct tatu_host_signals {
  uint32_t size;
  uint32_t reserved;
  /* TATU_ERR_MISSING: not set. Text is valid until the current call returns. */
  tatu_status(TATU_CALL *get)(tatu_world *, uint32_t kind, tatu_str name, tatu_value *);
  tatu_status(TATU_CALL *set)(tatu_world *, uint32_t kind, tatu_str name, const tatu_value *);
  /* Removes one, or all of the kind if `name` is empty; returns the number of signals removed. */
  uint32_t(TATU_CALL *clear)(tatu_world *, uint32_t kind, tatu_str name);
  /* The `index`-th name of a kind, in order of names. TATU_ERR_MISSING past the end. */
  tatu_status(TATU_CALL *name)(tatu_world *, uint32_t kind, uint32_t index, tatu_str *);
} tatu_host_signals;

#define TATU_HOST_EVENTS "tatu.host.events/draft.4"

/* Events of a world. An event is a name and a payload, a map. Events are queued in order and delivered to functions
 * of scripts, in order of subscription, at defined times: before a step, after each of its stages, and when the world
 * has stopped; to services at their next barrier. Events that handlers publish are appended to the queue, and
 * delivered at the same time. A handler that fails is reported and no longer called. */
typedef struct tatu_host_events {
  uint32_t size;
  uint32_t reserved;
  /* Publishes an event. Its name has a dot: those without belong to the host. `payload` is a map, or null: empty. */
  tatu_status(TATU_CALL *publish)(tatu_world *, tatu_str name, const tatu_value *payload);
  /* From now on `handler` is called with the payload and the name. It must be a retained reference: see
   * commands.retain; it is dropped when the subscription ends. `name`: one event, or "*" as in tatu_service.events.
   * TATU_ERR_MISSING: an undeclared name without a dot. The subscription ends with its script. */
  tatu_status(TATU_CALL *subscribe)(tatu_world *, tatu_str name, tatu_func handler, uint64_t *id);
  /* Ends a subscription. TATU_ERR_MISSING: no such id. */
  tatu_status(TATU_CALL *unsubscribe)(tatu_world *, uint64_t id);
  /* Whether an event has subscribers: if not, its payload need not be gathered. */
  uint32_t(TATU_CALL *wanted)(tatu_world *, tatu_str name);
  /* The `index`-th declared event, name and description. TATU_ERR_MISSING past the end. */
  tatu_status(TATU_CALL *declared)(tatu_world *, uint32_t index, tatu_str *name, tatu_str *text);
} tatu_host_events;

#define TATU_HOST_SESSION "tatu.host.session/draft.4"

enum { TATU_REQUEST_STOP = 1, TATU_REQUEST_PAUSE = 2, TATU_REQUEST_START = 3, TATU_REQUEST_QUIT = 4 };
enum { TATU_STOPPED = 0, TATU_RUNNING = 1, TATU_PAUSED = 2 };

/* Values of the property `scene.phase`. A stop requested between two passes takes effect after three: an ordinary
 * one, STOPPING, LAST. A pause takes two: an ordinary one, LAST_BEFORE_PAUSE. Time advances in each. */
enum {
  TATU_PHASE_STOPPED = 0,
  TATU_PHASE_FIRST = 1,
  TATU_PHASE_RUNNING = 2,
  TATU_PHASE_LAST_BEFORE_PAUSE = 3,
  TATU_PHASE_PAUSED = 4,
  TATU_PHASE_FIRST_AFTER_PAUSE = 5,
  TATU_PHASE_STOPPING = 6,
  TATU_PHASE_LAST = 7
};

/* Worlds and their life cycle. */
typedef struct tatu_host_session {
  uint32_t size;
  uint32_t reserved;
  /* Requests a change of state, which takes effect after the pass: see TATU_PHASE_*. A start while time stands still
   * takes effect at once, unless a script requests it. A stop releases all holds. */
  tatu_status(TATU_CALL *request)(tatu_world *, uint32_t what);
  /* [any] Wakes a session that waits at its barrier. */
  void(TATU_CALL *wake)(tatu_session *);
  /* The session's worlds. `*n` is the full count. */
  tatu_status(TATU_CALL *worlds)(tatu_session *, tatu_world **out, uint32_t cap, uint32_t *n);
  /* [step] In a service's barrier: the client on whose behalf the following calls are made, a number of the service's
   * choice. It is recorded in the input log with the call. */
  tatu_status(TATU_CALL *client)(tatu_world *, uint64_t client);
  /* [step] The state of a world: TATU_STOPPED, TATU_RUNNING or TATU_PAUSED. */
  uint32_t(TATU_CALL *state)(tatu_world *);
  /* [step] The `index`-th input from outside since the start, from 0, other than calls by services: for a key, for
   * instance, `kind` is "key" and `text` its character or name. Writers and readers of inputs agree on kinds and
   * texts. The texts are valid until the current call returns. TATU_ERR_MISSING, without a message: past the last. */
  tatu_status(TATU_CALL *input)(tatu_world *, uint64_t index, tatu_str *kind, tatu_str *text);
  /* [step] Adds an input, as if it came from outside: see `input`. The input log records this call. */
  tatu_status(TATU_CALL *put_in)(tatu_world *, tatu_str kind, tatu_str text);
  /* [step] Requests that the program open another scene, once this world has stopped. `file` is a path from
   * `files.resolve`; empty: reopen this scene from its file. TATU_ERR_UNSUPPORTED: the program runs one scene only.
   * If the file cannot be opened, the call fails with the reason, and this world continues. A start requested
   * afterwards is that of the new scene. */
  tatu_status(TATU_CALL *open)(tatu_world *, tatu_str file);
  /* [step] For plugins that read something outside during a step, a socket or a clock: the result is an input of the
   * run. Call this first: in a replay it returns what the log has at this point, of this kind, and nothing outside
   * must be accessed. TATU_ERR_MISSING, without a message: this is not a replay; read it, and pass it to `observe`.
   * TATU_ERR_GONE: the log has no more. The text is valid until the current call returns. */
  tatu_status(TATU_CALL *observed)(tatu_world *, tatu_str kind, tatu_str *text);
  /* [step] Records the result in the input log. */
  tatu_status(TATU_CALL *observe)(tatu_world *, tatu_str kind, tatu_str text);
  /* [step] Not 0: the run is to end. Poll this every 50 ms while waiting for something outside, and give up then; a
   * call that polls is not taken for one that never returns. */
  uint32_t(TATU_CALL *interrupted)(tatu_world *);
  /* [step] In a call of a service: a function of a client, as an argument for commands (TATU_FUNC). It can be
   * retained like one of a script; a call of it is passed to tatu_service.call_func with `local`, a number of the
   * service's choice. */
  tatu_status(TATU_CALL *function)(tatu_world *, uint32_t local, tatu_func *func);
} tatu_host_session;

#define TATU_HOST_STAGE "tatu.host.stage/draft.4"

enum { TATU_STAGE_ACTUATE = 1, TATU_STAGE_PHYSICS = 2, TATU_STAGE_SENSE = 3, TATU_STAGE_REACT = 4, TATU_STAGE_CLEAN = 5 };

/* For drivers: a script of kind "main", or a plugin that it calls, runs the stages of a step itself: not at all, once
 * or several times. At the end of the step, time advances by the sum of the physics stages. */
typedef struct tatu_host_stage {
  uint32_t size;
  uint32_t reserved;
  /* Runs one stage now; fails within itself, with the chain of calls. TATU_STAGE_CLEAN lets scripts of the run clean
   * up, each once; it has an effect only in the last pass. */
  tatu_status(TATU_CALL *run)(tatu_world *, uint32_t stage, double dt);
} tatu_host_stage;

#define TATU_HOST_LOG "tatu.host.log/draft.4"

enum {
  TATU_LOG_ERROR = 1, TATU_LOG_WARNING = 2, TATU_LOG_INFO = 3, TATU_LOG_DEBUG = 4,
  TATU_LOG_STATUS = 5, /* a line of the status bar: output of scripts for the user; recorded in traces */
  TATU_LOG_CLEAR = 6,  /* clears the status bar */
  TATU_LOG_CONSOLE = 7,      /* text on a console, unchanged: title, NUL, text; recorded in traces only */
  TATU_LOG_CONSOLE_CLEAR = 8 /* clears a console: its title; recorded in traces only */
};

typedef struct tatu_host_log {
  uint32_t size;
  uint32_t reserved;
  /* [any] Writes one line, attributed by the first argument. `world` may be null. */
  void(TATU_CALL *write)(const tatu_host *, tatu_world *, uint32_t level, tatu_str text);
  /* [step] The error of the last failed service call; never null. */
  const tatu_error *(TATU_CALL *last_error)(tatu_world *);
} tatu_host_log;

#define TATU_HOST_FILES "tatu.host.files/draft.4"

enum {
  TATU_FILE_READ = 1,
  TATU_FILE_WRITE = 2,   /* creates or truncates the file */
  /* for `open` only: */
  TATU_FILE_APPEND = 4,  /* creates the file, and appends to it; in place of WRITE */
  TATU_FILE_UPDATE = 8,  /* with WRITE: the file must exist, and is not truncated */
  TATU_FILE_NEW = 16,    /* with WRITE: the file must not exist */
  TATU_FILE_FOLDERS = 32 /* with WRITE or APPEND: creates missing folders */
};

/* Files, within the folders that the run allows. */
typedef struct tatu_host_files {
  uint32_t size;
  uint32_t reserved;
  /* The path of a file that a script names, if it is in an allowed folder; valid until the current call returns.
   * Reading: the scene's folder and the working folder. Writing: the working folder. For functions that take such a
   * path; to read or write the file yourself use `open`. */
  tatu_status(TATU_CALL *resolve)(tatu_world *, tatu_str name, uint32_t mode, tatu_str *path);
  /* [step] Opens a regular file below those folders: `mode` is a sum of TATU_FILE_*. The caller owns and closes
   * `*file`: a file descriptor (POSIX, close-on-exec) or a HANDLE (Windows). The folders are those at the creation of
   * the world, so a changed working folder, `..` and links do not lead outside. TATU_ERR_MISSING: no such file;
   * TATU_ERR: a link leads outside, or it is a folder, pipe, socket or device; the message has its path. */
  tatu_status(TATU_CALL *open)(tatu_world *, tatu_str name, uint32_t mode, int64_t *file);
} tatu_host_files;

#define TATU_HOST_FIGURES "tatu.host.figures/draft.4"

enum {
  TATU_FIGURE_STREAM = 1,  /* of a graph: a number over time. Keys: name, unit, color, of, data, transform, factor, offset, window, hidden */
  TATU_FIGURE_CURVE = 2,   /* of a graph: one stream over another. Keys: name, unit, color, x, y, z (a stream's name or a number) */
  TATU_FIGURE_COPY = 3,    /* of a graph: a fixed copy of a curve. Keys: name, curve (its number) */
  TATU_FIGURE_DRAWING = 4  /* of the world: items in space. Keys: form, size, color, parent, capacity, cyclic, tolerance, persistent, extra */
};

/* Figures: streams and curves of graphs (objects of kind graph), and drawings, whose `graph` is 0. They are numbered
 * from 1 in their graph or among the drawings; keys are maps as in scene files, SI units and radians. They have no
 * effect on objects. Graphs are cleared when a run starts, and keep their data when it stops. */
typedef struct tatu_host_figures {
  uint32_t size;
  uint32_t reserved;
  /* Adds one: TATU_FIGURE_*, and a map of its keys. */
  tatu_status(TATU_CALL *add)(tatu_world *, tatu_object graph, uint32_t what, const tatu_value *keys, int64_t *id);
  /* Changes keys of a stream (a map), or removes a stream, curve or drawing (null). TATU_ERR_MISSING: it does not
   * exist. */
  tatu_status(TATU_CALL *change)(tatu_world *, tatu_object graph, int64_t id, const tatu_value *keys);
  /* Appends the next sample to a stream (`n` is 1), or adds items to a drawing: numbers in the world frame, "stride"
   * of them per item. `n` 0 clears a drawing or, with `id` 0, a whole graph. `*taken`: the number of samples or items
   * accepted. */
  tatu_status(TATU_CALL *put)(tatu_world *, tatu_object graph, int64_t id, const double *numbers, uint64_t n,
                              uint64_t *taken);
  /* Makes a graph sample all its streams, at this time in s. `graph` 0: all graphs that record by themselves. */
  tatu_status(TATU_CALL *record)(tatu_world *, tatu_object graph, double time);
  /* The numbers of all of one sort (TATU_FIGURE_STREAM, _CURVE or _DRAWING), in order of creation. `*n` is the full
   * count. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object graph, uint32_t what, int64_t *out, uint32_t cap, uint32_t *n);
  /* One as a map: its keys and "figure" (TATU_FIGURE_*); with `numbers` not 0 also its data, as arrays of double:
   * "times" and "values" of a stream (NaN: missing), "points" of a curve with "dims" coordinates each, "items" of a
   * drawing with "stride" numbers each. Valid until the current call returns. */
  tatu_status(TATU_CALL *get)(tatu_world *, tatu_object graph, int64_t id, uint32_t numbers, tatu_value *);
  /* [step] The `index`-th visible part of a shape, from 0, as a map: "form" (box, sphere, cylinder, capsule, plane,
   * mesh), "size" (full extents, m; none for a plane), "pose" (7 numbers, in the shape), "color", and for a mesh
   * "points" (x y z) and "triangles" (three point indices) in the part's frame. Valid until the current call returns.
   * TATU_ERR_MISSING, without a message: past the last. */
  tatu_status(TATU_CALL *part)(tatu_world *, tatu_object shape, uint32_t index, tatu_value *);
} tatu_host_figures;

/* ================================================================ 12. Conveniences =================== */

/* A text literal or NUL-terminated string as tatu_str. */
static inline tatu_str tatu_text(const char *s) {
  tatu_str t = {s, 0};
  while (s && s[t.len]) t.len++;
  return t;
}

/* Fills an error; returns the code, so that `return tatu_fail(error, TATU_ERR, "...")` reads well. */
static inline tatu_status tatu_fail(tatu_error *e, tatu_status code, const char *text) {
  if (TATU_HAS(e, say)) e->say(e, code, tatu_text(text));
  return code;
}

/* Values. */
static inline tatu_value tatu_nil(void) { tatu_value v = {TATU_NIL, 0, {0}}; return v; }
static inline tatu_value tatu_bool(int x) { tatu_value v = {TATU_BOOL, 0, {0}}; v.u.i = x != 0; return v; }
static inline tatu_value tatu_int(int64_t x) { tatu_value v = {TATU_I64, 0, {0}}; v.u.i = x; return v; }
static inline tatu_value tatu_float(double x) { tatu_value v = {TATU_F64, 0, {0}}; v.u.f = x; return v; }
static inline tatu_value tatu_string(const char *s) {
  tatu_value v = {TATU_TEXT, 0, {0}};
  tatu_str t = tatu_text(s);
  v.u.s.ptr = t.ptr;
  v.u.s.len = t.len;
  return v;
}
static inline tatu_value tatu_span(uint32_t tag, const void *ptr, uint64_t len) {
  tatu_value v = {0, 0, {0}};
  v.tag = tag;
  v.u.s.ptr = ptr;
  v.u.s.len = len;
  return v;
}

/* Whether argument `i` was given and is not nil. */
static inline int tatu_has_arg(const tatu_call *c, uint32_t i) { return i < c->n_args && c->args[i].tag != TATU_NIL; }
/* Arguments of declared type; 0 or empty when missing. */
static inline double tatu_arg_float(const tatu_call *c, uint32_t i) {
  if (i >= c->n_args) return 0;
  return c->args[i].tag == TATU_F64 ? c->args[i].u.f : c->args[i].tag == TATU_I64 ? (double)c->args[i].u.i : 0;
}
static inline int64_t tatu_arg_int(const tatu_call *c, uint32_t i) {
  if (i >= c->n_args) return 0;
  if (c->args[i].tag == TATU_F64) { /* beyond the range of integers: 0 */
    double x = c->args[i].u.f;
    return x > -9.2e18 && x < 9.2e18 ? (int64_t)x : 0;
  }
  return c->args[i].tag == TATU_I64 || c->args[i].tag == TATU_BOOL ? c->args[i].u.i : 0;
}
static inline tatu_object tatu_arg_object(const tatu_call *c, uint32_t i) {
  if (i < c->n_args && c->args[i].tag == TATU_OBJECT) return c->args[i].u.u;
  return (tatu_object)tatu_arg_int(c, i);
}
static inline tatu_func tatu_arg_func(const tatu_call *c, uint32_t i) {
  return i < c->n_args && c->args[i].tag == TATU_FUNC ? c->args[i].u.u : 0;
}
/* The numbers of a TATU_F64S argument, and how many; null and 0 when it is missing. */
static inline const double *tatu_arg_floats(const tatu_call *c, uint32_t i, uint64_t *n) {
  int is = i < c->n_args && c->args[i].tag == TATU_F64S;
  *n = is ? c->args[i].u.s.len : 0;
  return is ? (const double *)c->args[i].u.s.ptr : 0;
}
/* The entries of a TATU_MAP argument, and how many; null and 0 when it is missing. */
static inline const tatu_pair *tatu_arg_map(const tatu_call *c, uint32_t i, uint64_t *n) {
  int is = i < c->n_args && c->args[i].tag == TATU_MAP;
  *n = is ? c->args[i].u.s.len : 0;
  return is ? (const tatu_pair *)c->args[i].u.s.ptr : 0;
}
/* The value of a text key of a map; null when there is none, or the value is no map. */
static inline const tatu_value *tatu_map_get(const tatu_value *map, const char *key) {
  tatu_str k = tatu_text(key);
  const tatu_pair *p = map && map->tag == TATU_MAP ? (const tatu_pair *)map->u.s.ptr : 0;
  uint64_t i, j, n = p ? map->u.s.len : 0;
  for (i = 0; i < n; i++) {
    const char *name = (const char *)p[i].key.u.s.ptr;
    if (p[i].key.tag != TATU_TEXT || p[i].key.u.s.len != k.len) continue;
    for (j = 0; j < k.len && name[j] == k.ptr[j]; j++) {}
    if (j == k.len) return &p[i].value;
  }
  return 0;
}
/* A result, or any value, as a number; 0 if it is none. */
static inline double tatu_to_float(tatu_value v) {
  return v.tag == TATU_F64 ? v.u.f : v.tag == TATU_I64 ? (double)v.u.i : 0;
}
/* A frame for commands.call and commands.call_func: arguments in, room for at least 16 results. */
static inline tatu_call tatu_frame(const tatu_value *args, uint32_t n_args, tatu_value *results, uint32_t cap) {
  tatu_call c;
  size_t i;
  for (i = 0; i < sizeof c; i++) ((char *)&c)[i] = 0;
  c.size = (uint32_t)sizeof c;
  c.args = args;
  c.n_args = n_args;
  c.results = results;
  c.results_cap = cap;
  return c;
}
static inline tatu_str tatu_arg_text(const tatu_call *c, uint32_t i) {
  tatu_str t = {0, 0};
  if (i < c->n_args && (c->args[i].tag == TATU_TEXT || c->args[i].tag == TATU_BYTES)) {
    t.ptr = (const char *)c->args[i].u.s.ptr;
    t.len = c->args[i].u.s.len;
  }
  return t;
}
/* Adds a result. Text, arrays, lists and maps must live until the caller has read them: use tatu_keep. */
static inline tatu_status tatu_return(tatu_call *c, tatu_value v) {
  if (c->n_results >= c->results_cap) return tatu_fail(c->error, TATU_ERR_SPACE, "too many results");
  c->results[c->n_results++] = v;
  return TATU_OK;
}
/* Copies bytes into memory that lives until the caller has read the results; null when there is no room. */
static inline void *tatu_keep(tatu_call *c, const void *bytes, uint64_t n) {
  char *p = (char *)c->api->alloc(c, n ? n : 1);
  uint64_t i;
  if (p) for (i = 0; i < n; i++) p[i] = ((const char *)bytes)[i];
  return p;
}
/* Fails the call. */
static inline tatu_status tatu_call_fail(tatu_call *c, tatu_status code, const char *text) {
  return tatu_fail(c->error, code, text);
}

#ifdef __cplusplus
}
#endif
#endif
