/* tatu/core.h: declarations that every plugin uses: values, errors, parameters, instances, and the plugin itself. */
#ifndef TATU_CORE_H
#define TATU_CORE_H

#include <math.h>   /* HUGE_VAL: no bound */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

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
#define TATU_ABI_MINOR 9 /* increased whenever a table grows; checked only against tatu_need.minor */

/* Functions of these headers: C89 has no `inline`. */
#if defined __cplusplus || (defined __STDC_VERSION__ && __STDC_VERSION__ >= 199901L)
#  define TATU_INLINE static inline
#elif defined __GNUC__
#  define TATU_INLINE static __inline__
#else
#  define TATU_INLINE static
#endif

/* Offset of the end of a field in its table, in bytes. */
#define TATU_END(t, f) ((size_t)((const char *)(&(t)->f + 1) - (const char *)(t)))
/* Whether a table that another party filled includes this scalar or pointer field, with a value other than 0. */
#define TATU_HAS(t, f) ((t) && TATU_END(t, f) <= (t)->size && (t)->f)
/* Whether a table that another party filled includes this field, whatever its value: for struct fields, and for scalars
 * for which 0 is a valid value. */
#define TATU_KNOWS(t, f) ((t) && TATU_END(t, f) <= (t)->size)

/* ---------------------------------------------------------------- Declaring tables ------------------------------ */

/* Macros for tables and lists as compound literals, in C; C++ has tatu/plugin.hpp. At file scope they are constants:
 *
 *   static const tatu_sensor lamp = {.size = sizeof(tatu_sensor), .id = "lamp",
 *     .params = TATU_PARAMS(TATU_PARAM(TATU_F64, "range", "m", "Maximum range.", TATU_RANGE(0.1, 20))), ...};
 *   TATU_PLUGIN(TATU_SENSORS(&lamp), .id = "org.example.lamp", .name = "Lamp", .version = "1.0.0", .licence = "MIT");
 *
 * Within a function, such a table lives until the end of the block. A macro whose last argument is a text accepts
 * further fields after it, by name. */
#ifndef __cplusplus
/* A pointer to a table with these fields; the macro sets `size`. */
#  define TATU_TABLE(Type, ...) (&(const Type){.size = sizeof(Type), __VA_ARGS__})
/* A null-terminated list of pointers to tables, and a null-terminated list of texts. */
#  define TATU_LIST_OF(Type, ...) ((const Type *const[]){__VA_ARGS__, NULL})
#  define TATU_TEXTS(...) ((const char *const[]){__VA_ARGS__, NULL})
/* An array of values as two arguments, pointer and count: for a list, several results or the arguments of a call. Valid
 * within the block. */
#  define TATU_VALUES(...) \
    ((const tatu_value[]){__VA_ARGS__}), (uint32_t)(sizeof((const tatu_value[]){__VA_ARGS__}) / sizeof(tatu_value))
/* An array of map entries, built by tatu_entry, as two arguments, pointer and count. Valid within the block. */
#  define TATU_ENTRIES(...) \
    ((const tatu_pair[]){__VA_ARGS__}), (uint32_t)(sizeof((const tatu_pair[]){__VA_ARGS__}) / sizeof(tatu_pair))
#endif

/* ---------------------------------------------------------------- Values ---------------------------------------- */

/* The types of this section are frozen. */

/* Text or bytes: not NUL-terminated. */
typedef struct tatu_str {
  const char *ptr;
  uint64_t len;
} tatu_str;

/* An object of a world: generation << 20 | slot. 0: no object, or the world itself. Scripts receive only the slot, as
 * the handle. Generation 0 means "whatever is in that slot now" and is meant for handles passed by a script. */
typedef uint64_t tatu_object;
#define TATU_SLOT_BITS 1048575 /* 20 */
#define TATU_SLOT(o) ((uint32_t)((o) & TATU_SLOT_BITS))

/* A script's function: instance id << 32 | local id. An argument is valid during the call, a result until the script
 * is entered again; see commands.retain. */
typedef uint64_t tatu_func;
typedef uint32_t tatu_prop; /* interned key of a property ("joint.position") or field ("proximity.distance") */

/* Tags of a value. */
enum tatu_tag {
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
 *   {'a', 2}, {{1}, {2}}                         LIST: a table with keys 1 to n and any other values
 *   {a = 1}, {[2] = 1}                           MAP: a table with any other key
 *   {}                                           LIST of 0
 *   a function                                   FUNC
 * An argument of declared type is converted to that type, or the call fails before the command runs: for TATU_F64 an
 * integer becomes F64, for TATU_F64S {1, 2} becomes F64S, for TATU_LIST every table with keys 1 to n becomes LIST, for
 * TATU_MAP every table becomes MAP ({'a'} has the key 1), and {} becomes an empty value of the declared type. */
typedef struct tatu_value {
  uint32_t tag;      /* enum tatu_tag */
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

typedef struct tatu_world tatu_world;     /* a world: opaque */
typedef struct tatu_session tatu_session; /* a session: opaque */

/* A text literal or NUL-terminated string as tatu_str. */
TATU_INLINE tatu_str tatu_text(const char *s) {
  tatu_str t = {s, 0};
  while (s && s[t.len]) t.len++;
  return t;
}

/* Constructors of values. */
TATU_INLINE tatu_value tatu_nil(void) { tatu_value v = {TATU_NIL, 0, {0}}; return v; }
TATU_INLINE tatu_value tatu_bool(int x) { tatu_value v = {TATU_BOOL, 0, {0}}; v.u.i = x != 0; return v; }
TATU_INLINE tatu_value tatu_int(int64_t x) { tatu_value v = {TATU_I64, 0, {0}}; v.u.i = x; return v; }
TATU_INLINE tatu_value tatu_float(double x) { tatu_value v = {TATU_F64, 0, {0}}; v.u.f = x; return v; }
TATU_INLINE tatu_value tatu_string(const char *s) {
  tatu_value v = {TATU_TEXT, 0, {0}};
  tatu_str t = tatu_text(s);
  v.u.s.ptr = t.ptr;
  v.u.s.len = t.len;
  return v;
}
TATU_INLINE tatu_value tatu_span(uint32_t tag, const void *ptr, uint64_t len) {
  tatu_value v = {0, 0, {0}};
  v.tag = tag;
  v.u.s.ptr = ptr;
  v.u.s.len = len;
  return v;
}

/* An object as a value; scripts receive its handle. */
TATU_INLINE tatu_value tatu_handle(tatu_object x) { tatu_value v = {TATU_OBJECT, 0, {0}}; v.u.u = x; return v; }
/* A list, a map, and one entry of a map. They point to the caller's memory and do not copy it: see TATU_VALUES and
 * TATU_ENTRIES. */
TATU_INLINE tatu_value tatu_list_of(const tatu_value *values, uint64_t n) { return tatu_span(TATU_LIST, values, n); }
TATU_INLINE tatu_value tatu_map_of(const tatu_pair *entries, uint64_t n) { return tatu_span(TATU_MAP, entries, n); }
TATU_INLINE tatu_pair tatu_entry(const char *key, tatu_value value) {
  tatu_pair p;
  p.key = tatu_string(key);
  p.value = value;
  return p;
}
/* Whether a text is equal to a NUL-terminated string. */
TATU_INLINE int tatu_str_is(tatu_str a, const char *b) {
  uint64_t i;
  for (i = 0; i < a.len && b[i] && a.ptr[i] == b[i]; i++) {}
  return i == a.len && !b[i];
}
/* Converts an F64 or I64 value to a double; 0 for values of all other types. */
TATU_INLINE double tatu_to_float(tatu_value v) {
  return v.tag == TATU_F64 ? v.u.f : v.tag == TATU_I64 ? (double)v.u.i : 0;
}
/* The value of a map's entry with a text key; null if there is no such entry, or the value is not a map. */
TATU_INLINE const tatu_value *tatu_map_get(const tatu_value *map, const char *key) {
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

/* ---------------------------------------------------------------- Errors ---------------------------------------- */

typedef int32_t tatu_status; /* 0: done; 1: waiting; negative: one of the errors below */
enum tatu_status_code {
  TATU_OK = 0,
  TATU_WAIT = 1,              /* the command will finish later; see tatu_call_api.wait */
  TATU_ERR = -1,              /* failed; see the message */
  TATU_ERR_ARGUMENT = -2,     /* an argument has the wrong type, count, size or range */
  TATU_ERR_MISSING = -3,      /* there is no object, field, property or file with that name */
  TATU_ERR_GONE = -4,         /* an object, script or result existed, but has been removed or has ended */
  TATU_ERR_UNSUPPORTED = -5,  /* recognized, but not supported here */
  TATU_ERR_UNKNOWN = -6,      /* there is no command with that name */
  TATU_ERR_SCRIPT = -7,       /* a script raised an error */
  TATU_ERR_BUDGET = -8,       /* a script exceeded its instruction limit; it is not called again */
  TATU_ERR_PANIC = -9,        /* a plugin panicked; the panic was caught */
  TATU_ERR_BUSY = -10,        /* not allowed from within the running call */
  TATU_ERR_SPACE = -11,       /* a buffer is too small; the needed count is returned */
  TATU_ERR_PHYSICS = -12,     /* the physics engine lost a body */
  TATU_ERR_MEMORY = -13       /* a script exceeded its memory limit; it may continue if it uses less */
};

typedef struct tatu_error tatu_error;

/* An error, owned by the host. A plugin writes it only through `say` and `add`, which copy their arguments; the host
 * adds plugin, instance and call. The other fields are read-only. */
struct tatu_error {
  uint32_t size;
  int32_t code; /* TATU_OK while the error is empty */
  void *ctx;    /* private to the host */
  /* [any] Sets the error: a negative code, and one sentence that states what is wrong, where, and what was expected.
   * Text beyond 16 KiB is cut off, here and in `add`. */
  void(TATU_CALL *say)(tatu_error *, tatu_status code, tatu_str text);
  /* [any] Adds a part: enum tatu_error_part; `line` counts from 1 and is used with TATU_PART_FILE. */
  void(TATU_CALL *add)(tatu_error *, uint32_t part, tatu_str text, uint64_t line);
  tatu_str text;      /* what went wrong */
  tatu_str help;      /* what to do */
  tatu_str file;      /* where, if in a file or script */
  tatu_str traceback; /* the script's call stack, innermost first */
  uint64_t line;      /* in `file`; 0: none */
};
enum tatu_error_part { TATU_PART_HELP = 1, TATU_PART_FILE = 2, TATU_PART_TRACEBACK = 3 };

/* Sets an error and returns its code: `return tatu_fail(error, TATU_ERR, "...");`. */
TATU_INLINE tatu_status tatu_fail(tatu_error *e, tatu_status code, const char *text) {
  if (TATU_HAS(e, say)) e->say(e, code, tatu_text(text));
  return code;
}

/* As tatu_fail, with a help text that states what to do instead. */
TATU_INLINE tatu_status tatu_fail_help(tatu_error *e, tatu_status code, const char *text, const char *help) {
  if (TATU_HAS(e, say)) e->say(e, code, tatu_text(text));
  if (TATU_HAS(e, add)) e->add(e, TATU_PART_HELP, tatu_text(help), 0);
  return code;
}
/* As tatu_fail, with the position of the error, for importers and languages. An empty file name stands for the source
 * itself. */
TATU_INLINE tatu_status tatu_fail_line(tatu_error *e, tatu_status code, const char *text, tatu_str file, uint64_t line) {
  if (TATU_HAS(e, say)) e->say(e, code, tatu_text(text));
  if (TATU_HAS(e, add)) e->add(e, TATU_PART_FILE, file, line);
  return code;
}
/* Copies the error of a command or function that was called (its frame.error) to the caller's error, and returns the
 * code. */
TATU_INLINE tatu_status tatu_fail_as(tatu_error *e, tatu_status code, const tatu_error *why) {
  if (why == e || !TATU_HAS(e, say)) return code;
  if (!TATU_HAS(why, code)) return tatu_fail(e, code, "the call failed without an error message");
  e->say(e, code, why->text);
  if (why->help.len) e->add(e, TATU_PART_HELP, why->help, 0);
  if (why->file.len) e->add(e, TATU_PART_FILE, why->file, why->line);
  if (why->traceback.len) e->add(e, TATU_PART_TRACEBACK, why->traceback, 0);
  return code;
}

/* ---------------------------------------------------------------- Parameters ------------------------------------ */

enum tatu_param_flag {
  /* of a sensor or actuator: */
  TATU_PARAM_REBUILDS = 1, /* a change destroys the instance and creates a new one */
  TATU_PARAM_READ_ONLY = 2,
  TATU_PARAM_OPTIONAL = 4, /* of a command: may be omitted or nil; the command then receives the default, or nil */
  TATU_PARAM_REST = 8,     /* of a command, last parameter only: accepts all remaining arguments */
  TATU_PARAM_ANY = 16,     /* any type; `type` is ignored */
  TATU_PARAM_PROGRAM = 32  /* of a language, TATU_TEXT: a program, by its name or its path. A relative path with a folder
                            * is passed as an absolute one: relative to the scene file that states it, otherwise to the
                            * working folder */
};

/* Declaration of a parameter (of an instance, model, import or command), of a result of a command, or of a field of an
 * event. Scene files append the unit to the key: with unit "m", `range` is written `range_m`; with unit "rad", `angle`
 * is written `angle_deg`, in degrees. The suffix is the unit in lower case, with `_` for `/`, and without `^` and the
 * spaces of products: with unit "m/s^2", `accel` is written `accel_m_s2`, and with "N m", `torque_nm`. Only "kg m^2" keeps
 * its space, as `_kg_m2`. Any other unit is a text for people, without a suffix.
 * Values that cross the ABI are always in SI units and radians. A parameter of type TATU_OBJECT also accepts a script's
 * handle, and passes it as an object of generation 0; the service that receives it checks whether the object exists.
 *
 * Units with a suffix:
 *   "m" "_m", "rad" "_deg" or "_rad", "s" "_s", "kg" "_kg", "Hz" "_hz", "N" "_n", "N m" "_nm", "N s" "_ns", "m/s"
 *   "_m_s", "rad/s" "_deg_s" or "_rad_s", "m/s^2" "_m_s2", "rad/s^2" "_deg_s2" or "_rad_s2", "m/s^3" "_m_s3", "rad/s^3"
 *   "_deg_s3" or "_rad_s3", "m^2" "_m2", "m^3" "_m3", "kg m^2" "_kg_m2", "kg/m^3" "_kg_m3", "N m/rad" "_nm_rad", "N/m"
 *   "_n_m", "N m s/rad" "_nms_rad", "N s/m" "_ns_m", "N m/A" "_nm_a", "V s/rad" "_vs_rad", "J" "_j", "W" "_w", "V" "_v",
 *   "A" "_a", "A s" "_as", "ohm" "_ohm", "F" "_f", "H" "_h", "K" "_k", "Pa" "_pa", "T" "_t", "lx" "_lx", "cd" "_cd",
 *   "dB" "_db", "1". */
typedef struct tatu_param {
  uint32_t size;
  uint32_t type;       /* TATU_BOOL, I64, F64, TEXT, BYTES, F64S, LIST, MAP, FUNC or OBJECT */
  uint32_t count;      /* number of array elements; 0: any */
  uint32_t flags;      /* sum of TATU_PARAM_* */
  const char *key;     /* "range" */
  const char *unit;    /* an SI unit, such as "m/s^2"; null: none */
  double lowest;       /* minimum; -HUGE_VAL: no minimum. If both are 0, there are no bounds */
  double highest;      /* maximum; HUGE_VAL: no maximum */
  tatu_value fallback; /* default value; nil: the parameter is required, unless it is optional */
  const char *const *choices; /* allowed texts, null-terminated; null: any */
  const char *text;    /* one sentence */
  const struct tatu_param *const *keys; /* of a TATU_MAP: its text keys; null or beyond `size`: any. Entries are checked
                        * and converted like parameters, missing ones get their default, unknown keys are rejected */
} tatu_param;

#ifndef __cplusplus
/* Declares a parameter: type, key, unit (NULL: none), text, and further fields by name:
 *   TATU_PARAM(TATU_F64S, "goal", "m", "x and y in the world.", .count = 2) */
#  define TATU_PARAM(Type, Key, Unit, ...) \
    TATU_TABLE(tatu_param, .type = (Type), .key = (Key), .unit = (Unit), .text = __VA_ARGS__)
/* Declares a parameter that accepts a value of any type. With further flags, write TATU_TABLE(tatu_param, .flags =
 * TATU_PARAM_ANY | TATU_PARAM_OPTIONAL, ...). */
#  define TATU_PARAM_OF_ANY_TYPE(Key, ...) TATU_TABLE(tatu_param, .flags = TATU_PARAM_ANY, .key = (Key), .text = __VA_ARGS__)
/* A list of parameters. */
#  define TATU_PARAMS(...) TATU_LIST_OF(tatu_param, __VA_ARGS__)
/* Further fields: bounds and defaults. */
#  define TATU_RANGE(Lowest, Highest) .lowest = (Lowest), .highest = (Highest)
#  define TATU_AT_LEAST(Lowest) .lowest = (Lowest), .highest = HUGE_VAL
#  define TATU_DEFAULT_F64(X) .fallback = {.tag = TATU_F64, .u.f = (X)}
#  define TATU_DEFAULT_I64(X) .fallback = {.tag = TATU_I64, .u.i = (X)}
#  define TATU_DEFAULT_BOOL(X) .fallback = {.tag = TATU_BOOL, .u.i = (X)}
#  define TATU_DEFAULT_TEXT(X) .fallback = {.tag = TATU_TEXT, .u.s = {X, sizeof(X) - 1}}
#endif

/* ---------------------------------------------------------------- Instances ------------------------------------- */

/* Arguments of `create`. */
typedef struct tatu_instance {
  uint32_t size;
  uint32_t n_params;
  tatu_world *world;        /* null for a service; `create` may read properties of the world */
  tatu_object owner;        /* sensor, actuator or script object; 0 for a world instance */
  uint64_t id;              /* id of this instance, unique in its world */
  uint64_t seed;            /* derived from the scene's seed and the owner, so it is the same in every run */
  const tatu_value *params; /* in the order of declaration, defaults filled in */
  void *state;              /* state block: host-owned, zeroed, at a fixed address until destroy; null if its size is 0 */
  tatu_session *session;    /* for a service, the session that starts it; otherwise null */
} tatu_instance;

/* The host's sink for the bytes that `save` writes. */
typedef struct tatu_writer {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  void(TATU_CALL *write)(const struct tatu_writer *, const void *bytes, uint64_t n);
} tatu_writer;

/* The life cycle of instances. All functions except `create` and `destroy` may be null. These two may both be null if
 * an instance consists only of its state block, which may have 0 bytes, except in languages. Stopping or resetting a world recreates its
 * instances, but see `end_run`. */
typedef struct tatu_life {
  uint32_t size;
  uint32_t state_bytes; /* size of the state block, which has no pointers; copied by snapshots, zeroed at reset */
  /* [setup] Creates an instance, and sets `*data`, which is passed to every later call. */
  tatu_status(TATU_CALL *create)(void *self, const tatu_instance *, void **data, tatu_error *);
  /* [setup] Destroys the instance. */
  void(TATU_CALL *destroy)(void *data);
  /* [step] Applies changed parameters to a live sensor or actuator. `params` contains the values of all parameters;
   * `changed` has a bit for each of the first 64, in the order of declaration. A sensor's `beams` is called next. If
   * `configure` fails, the host retains the old values, and the caller that set the new ones receives the error. Not
   * called for parameters with TATU_PARAM_REBUILDS. Null, or TATU_ERR_UNSUPPORTED without a message: the instance is
   * recreated. */
  tatu_status(TATU_CALL *configure)(void *data, const tatu_value *params, uint32_t n, uint64_t changed, tatu_error *);
  /* [step] Writes the state that is not in the state block. TATU_ERR_UNSUPPORTED: not possible now; the message gives
   * the reason. If the function is null, an instance whose `data` is null has no further state, and any other instance
   * is reported as missing from the snapshot. */
  tatu_status(TATU_CALL *save)(void *data, const tatu_writer *, tatu_error *);
  /* [step] Restores what `save` wrote, in an instance that was created with the same parameters.
   * `version` is the writer's. If it equals that of this kind, the state block has already been restored; otherwise
   * the block is zero. When a plugin file is reloaded, the old plugin saves and the new one loads.
   * If the function fails, the instance is recreated. While a snapshot is restored, restoring fails instead. */
  tatu_status(TATU_CALL *load)(void *data, tatu_str bytes, uint32_t version, tatu_error *);
  uint32_t version; /* version of the state block and of the bytes that `save` writes; chosen by the plugin */
  uint32_t reserved;
  /* [step] Called only for the per-world instance of a command plugin, when the scripts of a run have ended, before the
   * scene is reset. Drops the data of these scripts, and retains that of scripts that outlive the run ("script.kind" is
   * neither "main" nor "child"). The instance and its state block remain: what must begin anew is reset here, through the
   * `state` that `create` received. If the function is null or fails, the instance is recreated. */
  tatu_status(TATU_CALL *end_run)(void *self, void *data, tatu_world *, tatu_error *);
} tatu_life;

/* Allocates zeroed memory for an instance, or for the `self` of a plugin, and stores its address in `*data`. If no
 * memory is left, sets the error and returns null. tatu_delete frees the memory; use it as `destroy` or `shutdown`. */
TATU_INLINE void *tatu_new(size_t size, void **data, tatu_error *error) {
  *data = calloc(1, size);
  if (!*data) tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  return *data;
}
TATU_INLINE void TATU_CALL tatu_delete(void *data) { free(data); }
/* `save` and `load` for instances that are fully determined by their parameters and state block. */
TATU_INLINE tatu_status TATU_CALL tatu_save_nothing(void *data, const tatu_writer *to, tatu_error *error) {
  (void)data, (void)to, (void)error;
  return TATU_OK;
}
TATU_INLINE tatu_status TATU_CALL tatu_load_nothing(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  (void)data, (void)version;
  return bytes.len ? tatu_fail(error, TATU_ERR_UNSUPPORTED, "the saved data cannot be restored, because this kind saves none") : TATU_OK;
}

/* ---------------------------------------------------------------- Plugin and host ------------------------------- */

typedef struct tatu_host tatu_host;

/* The host's interface to a plugin; valid from `init` to the end of `shutdown`. */
struct tatu_host {
  uint32_t size;
  uint32_t abi_minor; /* TATU_ABI_MINOR of the host */
  void *ctx;          /* private to the host */
  /* [any] Returns the table of a service ("tatu.host.scene/draft.4"), or null. Valid for the lifetime of the host. */
  const void *(TATU_CALL *service)(const tatu_host *, const char *id);
  /* The folder of the plugin's assets, `tatu_NAME.assets` beside its library `libtatu_NAME.so`: an absolute path, or
   * null if there is no such folder. Read its files in `init`, so that they cannot change during a run. */
  const char *assets;
};

/* A service that a plugin requires, or uses if present. `bytes` and `minor` state how much of the host the plugin uses;
 * functions within that size need no TATU_HAS before each call. */
typedef struct tatu_need {
  uint32_t size;
  uint32_t optional; /* 0: the plugin is not loaded without it */
  const char *id;    /* "tatu.host.scene/draft.4"; null: the host itself, of which only `minor` is checked */
  uint32_t bytes;    /* minimum size of the service's table: its sizeof, or TATU_END of the last field used; 0: any */
  uint32_t minor;    /* minimum abi_minor of the host; 0: any */
} tatu_need;

/* The descriptor that the library exports. All strings live as long as the library does. */
typedef struct tatu_plugin_t {
  uint32_t size;
  uint16_t abi_major; /* TATU_ABI_MAJOR */
  uint16_t abi_minor; /* TATU_ABI_MINOR */
  const char *id;      /* "org.example.gripper": unique; scenes and messages use it */
  const char *name;    /* name for display */
  const char *version; /* "1.2.0" */
  const char *licence; /* SPDX, "MIT" */
  const tatu_need *const *needs; /* null, or a null-terminated list */
  /* [setup] Starts the plugin, and sets `*self`, which may be null and is passed to every later call. It may request
   * services, but call only their [any] functions. Null: nothing to start. */
  tatu_status(TATU_CALL *init)(const tatu_host *, void **self, tatu_error *);
  /* [setup] Ends the plugin, after all its instances have been destroyed. Null: nothing to do. */
  void(TATU_CALL *shutdown)(void *self);
  /* [setup] Returns the table of an extension ("tatu.command/draft.4"), or null. The plugin owns the table, which must
   * be valid until shutdown. */
  const void *(TATU_CALL *extension)(void *self, const char *id);
} tatu_plugin_t;

extern TATU_EXPORT const tatu_plugin_t tatu_plugin;

/* One extension that a plugin offers, as listed in TATU_PLUGIN. */
typedef struct tatu_offer {
  const char *id;    /* TATU_COMMAND, TATU_SENSOR, ... */
  const void *table; /* a tatu_ext_command, tatu_ext_sensor, ... */
} tatu_offer;
TATU_INLINE const void *tatu_find_offer(const tatu_offer *offers, const char *id) {
  while (offers->id && !tatu_str_is(tatu_text(id), offers->id)) offers++;
  return offers->table;
}
#ifndef __cplusplus
/* Exports the plugin: its extensions, then the fields of tatu_plugin_t by name. The macro sets `size`, the ABI version
 * and `extension`. An extension is TATU_COMMANDS(...), TATU_SENSORS(...), TATU_ACTUATORS(...), TATU_PARTS(...),
 * TATU_MODELS(...), TATU_IMPORTERS(...), TATU_LANGUAGES(...), TATU_SERVICES(...) or TATU_EVENTS(...), each with pointers to tables;
 * several extensions are enclosed in TATU_OFFERS(...). */
#  define TATU_PLUGIN(Offers, ...)                                                             \
    static const tatu_offer tatu_offers[] = {Offers, {NULL, NULL}};                            \
    static const void *TATU_CALL tatu_extension(void *self, const char *id) {                  \
      (void)self;                                                                              \
      return tatu_find_offer(tatu_offers, id);                                                 \
    }                                                                                          \
    TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t),              \
      .abi_major = TATU_ABI_MAJOR, .abi_minor = TATU_ABI_MINOR, .extension = tatu_extension, __VA_ARGS__}
#  define TATU_OFFERS(...) __VA_ARGS__
/* One extension: its id, the type of its table, and the fields of the table. */
#  define TATU_OFFER(Id, Type, ...) {(Id), TATU_TABLE(Type, __VA_ARGS__)}
/* Requires all functions of a service, given the type of its table and its id. host.h defines a macro for each
 * service. */
#  define TATU_NEED(Type, Id) TATU_TABLE(tatu_need, .id = (Id), .bytes = sizeof(Type))
#  define TATU_NEEDS(...) TATU_LIST_OF(tatu_need, __VA_ARGS__)
#endif

/* ---------------------------------------------------------------- Readings and contacts ------------------------- */

/* The types of this section are frozen. */

/* Element types of a reading's field. */
enum tatu_elem {
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
  uint64_t len;      /* number of elements */
  uint32_t elem;     /* TATU_ELEM_* */
  uint32_t dims[3];  /* shape, outermost first; unused ones are 1 */
  double time;       /* simulation time of the reading, s */
  uint64_t sequence; /* number of measurements so far; 0: not measured yet, or reset since */
} tatu_field_view;

/* Two shapes in contact. */
typedef struct tatu_contact {
  tatu_object shape[2];
  double point[3];  /* world, m */
  double normal[3]; /* unit, from shape[0] to shape[1] */
  double force;     /* N, normal, over the last physics step */
} tatu_contact;

#ifdef __cplusplus
}
#endif
#endif
