/* tatu/command.h: commands that scripts, remote clients and other plugins can call. */
#ifndef TATU_COMMAND_H
#define TATU_COMMAND_H

#include "core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_COMMAND "tatu.command/draft.4"

/* ---------------------------------------------------------------- Commands -------------------------------------- */

typedef struct tatu_call tatu_call;

enum tatu_command_flag {
  TATU_COMMAND_RAW = 1,     /* arguments are not converted; declared parameters are documentation only */
  TATU_COMMAND_SIDE_BY_SIDE = 2, /* may be called by scripts that run in parallel, on several threads at once. It must use
                                  * only its arguments, immutable data of its plugin, and these services: scene.get,
                                  * get_f64, get_f64_many, pose, look, set and set_f64 of a joint's drive, bodies.twist,
                                  * readings.field, readings.describe, log, commands.find, call (of such commands),
                                  * constant, alloc */
};

/* One name of a command. */
typedef struct tatu_name {
  uint32_t size;
  uint32_t flags;            /* TATU_NAME_* of vrep.h */
  const char *name;          /* "simGetObjectHandle", "sim.getObjectHandle", "gripper.close" */
  uint32_t n_on_error;       /* number of values in `on_error` */
  uint32_t reserved;
  const tatu_value *on_error;/* with TATU_NAME_OLD_ERRORS: values returned in place of an error */
  const char *on_error_until;/* first dialect, a version such as "4.2", whose scripts receive the error again; null or
                              * beyond `size`: no such dialect. Callers without a dialect receive `on_error` */
} tatu_name;

/* How much of its documented behaviour a command implements. */
enum tatu_command_status {
  TATU_COMMAND_FULL = 0,    /* all of it */
  TATU_COMMAND_PARTIAL = 1, /* part of it; `notes` describe what is missing */
  TATU_COMMAND_STUB = 2     /* none: it accepts its arguments and returns a neutral value; the host warns once per run */
};

/* A command. Scripts, remote clients and other plugins can call it by any of its names. */
typedef struct tatu_command {
  uint32_t size;
  uint32_t flags;                    /* TATU_COMMAND_* */
  const tatu_name *const *names;     /* at least one, at most 255 */
  const tatu_param *const *params;   /* null: no parameters */
  const tatu_param *const *returns;  /* results, for documentation only; may be null */
  const char *text;                  /* what the command does, one sentence */
  const char *example;               /* a Lua script that raises an error if the command has not had its effect */
  const char *no_wait;               /* error message for a caller that cannot wait; null: a general message */
  const void *user;                  /* passed as tatu_call.user */
  /* [step] Executes the command. It may call any service, and may be called again before it returns. */
  tatu_status(TATU_CALL *call)(tatu_call *);
  uint32_t status;                   /* enum tatu_command_status; beyond `size`: TATU_COMMAND_FULL */
  uint32_t reserved;
  const char *notes;                 /* what is missing or differs, for the documentation; null: nothing */
  const char *subject;               /* one word ("joints") by which the documentation groups commands; null: none */
} tatu_command;

#ifndef __cplusplus
/* The list of names of a command that has a single name. */
#  define TATU_NAME(Name) TATU_LIST_OF(tatu_name, TATU_TABLE(tatu_name, .name = (Name)))
#endif

/* ---------------------------------------------------------------- A call ---------------------------------------- */

enum tatu_until { TATU_UNTIL_STEPS = 1, TATU_UNTIL_TIME = 2, TATU_UNTIL_SIGNAL = 3, TATU_UNTIL_POLL = 4,
                  TATU_UNTIL_WAKE = 5 };

/* Functions of the host for use within a running call. */
typedef struct tatu_call_api {
  uint32_t size;
  uint32_t reserved;
  /* [step] Allocates memory that lives until the caller has read the results. Null if the world's arena is full. */
  void *(TATU_CALL *alloc)(tatu_call *, uint64_t bytes);
  /* [step] Suspends the command, which must then return TATU_WAIT. The command is called again, with `resume` and
   * without arguments, as `until` specifies: STEPS: `value` steps later; TIME: at simulation time `value`, s; SIGNAL:
   * when the signal `name` exists; POLL: in each step; WAKE: when a thread of the plugin has delivered a result, see
   * `ticket`. `resume`, which must not be 0, is a number that the command chooses to identify the wait. Returns
   * TATU_WAIT, so that a command can end with `return call->api->wait(...)`. If the caller cannot wait, sets the error
   * and returns TATU_ERR_BUSY. */
  tatu_status(TATU_CALL *wait)(tatu_call *, uint32_t until, double value, tatu_str name, uint64_t resume);
  /* [step] For work on one of the plugin's own threads: gets a ticket with which that thread delivers its result, once,
   * to `commands.wake`. Then start the thread and return `wait(TATU_UNTIL_WAKE)`. If the ticket is 0, this is a replay
   * and the result is in the input log: wait as well, but do not start a thread. */
  tatu_status(TATU_CALL *ticket)(tatu_call *, uint64_t *);
  /* [step] Gets the result that ended the wait, in the call that follows the wait; valid until that call returns.
   * TATU_ERR_GONE: the result was lost, because the run continues from a snapshot, and snapshots do not include
   * threads. */
  tatu_status(TATU_CALL *woken)(tatu_call *, tatu_str *);
} tatu_call_api;

enum tatu_caller { TATU_CALLER_HOST = 0, TATU_CALLER_SCRIPT = 1, TATU_CALLER_NATIVE = 2, TATU_CALLER_REMOTE = 3 };

/* One call to a command, a script's callback or a script's function. The caller owns it and its arrays. */
struct tatu_call {
  uint32_t size;
  uint32_t command;       /* id of the command; 0: not a command */
  uint32_t alias;         /* index of the name by which the command was called, from 0 */
  uint32_t n_args;        /* including trailing nils */
  const tatu_value *args; /* checked, converted to the declared types, with defaults; as passed for TATU_COMMAND_RAW */
  tatu_value *results;    /* the caller's buffer, for at least 16 results */
  uint32_t results_cap;   /* capacity of `results` */
  uint32_t n_results;     /* number of results written; never padded */
  tatu_world *world;
  void *self;             /* `self` of the called plugin */
  void *instance;         /* the plugin's instance in this world; null if it has none, and in parallel calls */
  void *state;            /* the instance's state block */
  const void *user;       /* tatu_command.user */
  const tatu_call_api *api;
  tatu_error *error;      /* set by a call that fails; read by its caller */
  uint64_t wait_token;    /* 0: this caller cannot wait; only script languages and services set another value */
  uint64_t resume;        /* 0: first call; otherwise the value passed to the wait that has ended */
  uint64_t caller;        /* instance id of the calling script, or 0; set by the host, like the other caller fields */
  tatu_object caller_object; /* the object that the calling script belongs to */
  tatu_object caller_script; /* the script object itself */
  tatu_str caller_dialect;   /* dialect of the calling script; empty: none */
  uint32_t caller_kind;      /* enum tatu_caller */
  uint32_t flags;            /* TATU_CALL_* bits, set by the caller */
};

enum tatu_call_flag {
  TATU_CALL_RAISE = 1, /* raise errors even where TATU_NAME_OLD_ERRORS (vrep.h) would return values instead */
  TATU_CALL_SIDE_BY_SIDE = 2 /* of a script: set by the host while scripts run in parallel */
};

/* ---- Arguments */

/* Whether argument `i` was passed and is not nil. */
TATU_INLINE int tatu_has_arg(const tatu_call *c, uint32_t i) { return i < c->n_args && c->args[i].tag != TATU_NIL; }
/* These functions return an argument of the declared type; 0 or empty if it is missing. */
TATU_INLINE double tatu_arg_float(const tatu_call *c, uint32_t i) {
  if (i >= c->n_args) return 0;
  return c->args[i].tag == TATU_F64 ? c->args[i].u.f : c->args[i].tag == TATU_I64 ? (double)c->args[i].u.i : 0;
}
TATU_INLINE int64_t tatu_arg_int(const tatu_call *c, uint32_t i) {
  if (i >= c->n_args) return 0;
  if (c->args[i].tag == TATU_F64) { /* 0 for values outside the range of int64_t, and for NaN */
    double x = c->args[i].u.f;
    return x > -9.2e18 && x < 9.2e18 ? (int64_t)x : 0;
  }
  return c->args[i].tag == TATU_I64 || c->args[i].tag == TATU_BOOL ? c->args[i].u.i : 0;
}
TATU_INLINE tatu_object tatu_arg_object(const tatu_call *c, uint32_t i) {
  if (i < c->n_args && c->args[i].tag == TATU_OBJECT) return c->args[i].u.u;
  return (tatu_object)tatu_arg_int(c, i);
}
TATU_INLINE tatu_func tatu_arg_func(const tatu_call *c, uint32_t i) {
  return i < c->n_args && c->args[i].tag == TATU_FUNC ? c->args[i].u.u : 0;
}
/* The numbers of a TATU_F64S argument, and their count; null and 0 if it is missing. */
TATU_INLINE const double *tatu_arg_floats(const tatu_call *c, uint32_t i, uint64_t *n) {
  int is = i < c->n_args && c->args[i].tag == TATU_F64S;
  *n = is ? c->args[i].u.s.len : 0;
  return is ? (const double *)c->args[i].u.s.ptr : 0;
}
/* The entries of a TATU_MAP argument, and their count; null and 0 if it is missing. */
TATU_INLINE const tatu_pair *tatu_arg_map(const tatu_call *c, uint32_t i, uint64_t *n) {
  int is = i < c->n_args && c->args[i].tag == TATU_MAP;
  *n = is ? c->args[i].u.s.len : 0;
  return is ? (const tatu_pair *)c->args[i].u.s.ptr : 0;
}
TATU_INLINE tatu_str tatu_arg_text(const tatu_call *c, uint32_t i) {
  tatu_str t = {0, 0};
  if (i < c->n_args && (c->args[i].tag == TATU_TEXT || c->args[i].tag == TATU_BYTES)) {
    t.ptr = (const char *)c->args[i].u.s.ptr;
    t.len = c->args[i].u.s.len;
  }
  return t;
}
/* The elements of a TATU_LIST argument, and their count; null and 0 if it is missing. */
TATU_INLINE const tatu_value *tatu_arg_list(const tatu_call *c, uint32_t i, uint64_t *n) {
  int is = i < c->n_args && c->args[i].tag == TATU_LIST;
  *n = is ? c->args[i].u.s.len : 0;
  return is ? (const tatu_value *)c->args[i].u.s.ptr : 0;
}

/* ---- Results */

/* Tag of a value for which the world's arena had no room. A list or map to which such a value is added also gets this
 * tag, and tatu_return then fails, so intermediate values need no check. */
#define TATU_NO_ROOM UINT32_MAX

/* Appends a result. Text, arrays, lists and maps must live until the caller has read them. Literals do; build all
 * others with the functions below, or copy them with tatu_keep. */
TATU_INLINE tatu_status tatu_return(tatu_call *c, tatu_value v) {
  if (v.tag == TATU_NO_ROOM) return tatu_fail(c->error, TATU_ERR_SPACE, "the world's arena has no room for the results");
  if (c->n_results >= c->results_cap) return tatu_fail(c->error, TATU_ERR_SPACE, "the caller's buffer is too small for the results");
  c->results[c->n_results++] = v;
  return TATU_OK;
}
/* Appends several results: return tatu_return_values(call, TATU_VALUES(a, b)); */
TATU_INLINE tatu_status tatu_return_values(tatu_call *c, const tatu_value *values, uint64_t n) {
  tatu_status status = TATU_OK;
  uint64_t i;
  for (i = 0; i < n && status >= 0; i++) status = tatu_return(c, values[i]);
  return status;
}
/* Copies bytes into memory that lives until the caller has read the results; returns null if there is no room. */
TATU_INLINE void *tatu_keep(tatu_call *c, const void *bytes, uint64_t n) {
  char *p = (char *)c->api->alloc(c, n ? n : 1);
  uint64_t i;
  if (p) for (i = 0; i < n; i++) p[i] = ((const char *)bytes)[i];
  return p;
}
/* Copies text, bytes or an array, `n` elements of `size` bytes, into memory that lives until the caller has read the
 * results, and returns it as a value. */
TATU_INLINE tatu_value tatu_copy(tatu_call *c, uint32_t tag, const void *ptr, uint64_t n, uint64_t size) {
  void *p = tatu_keep(c, ptr, n * size);
  return p ? tatu_span(tag, p, n) : tatu_span(TATU_NO_ROOM, 0, 0);
}
TATU_INLINE tatu_value tatu_copy_text(tatu_call *c, tatu_str text) { return tatu_copy(c, TATU_TEXT, text.ptr, text.len, 1); }
TATU_INLINE tatu_value tatu_copy_floats(tatu_call *c, const double *x, uint64_t n) { return tatu_copy(c, TATU_F64S, x, n, sizeof *x); }
/* An empty list, to be filled by tatu_add, and an empty map, to be filled by tatu_put. */
TATU_INLINE tatu_value tatu_list(void) { return tatu_span(TATU_LIST, 0, 0); }
TATU_INLINE tatu_value tatu_map(void) { return tatu_span(TATU_MAP, 0, 0); }
/* Returns space for one more element of `size` bytes, or null if the arena is full. The capacity is 4, and doubles
 * whenever it is used up. */
TATU_INLINE void *tatu_grow(tatu_call *c, tatu_value *v, uint64_t size) {
  uint64_t n = v->u.s.len, i;
  if (v->tag == TATU_NO_ROOM) return 0;
  if ((n & (n - 1)) == 0 && n != 1 && n != 2) {
    char *p = (char *)c->api->alloc(c, (n ? 2 * n : 4) * size);
    for (i = 0; p && i < n * size; i++) p[i] = ((const char *)v->u.s.ptr)[i];
    v->u.s.ptr = p;
  }
  if (!v->u.s.ptr) v->tag = TATU_NO_ROOM;
  return v->u.s.ptr ? (char *)v->u.s.ptr + v->u.s.len++ * size : 0;
}
/* Appends an element to a list created by tatu_list. */
TATU_INLINE void tatu_add(tatu_call *c, tatu_value *list, tatu_value element) {
  tatu_value *at = (tatu_value *)tatu_grow(c, list, sizeof element);
  if (at) *at = element;
  if (element.tag == TATU_NO_ROOM) list->tag = TATU_NO_ROOM;
}
/* Adds an entry to a map created by tatu_map. The key must live as long as the map, as a literal does. */
TATU_INLINE void tatu_put(tatu_call *c, tatu_value *map, const char *key, tatu_value value) {
  tatu_pair *at = (tatu_pair *)tatu_grow(c, map, sizeof *at);
  if (at) *at = tatu_entry(key, value);
  if (value.tag == TATU_NO_ROOM) map->tag = TATU_NO_ROOM;
}

/* ---- Failing, and calling others */

/* These functions set the error of the call, without or with a help text, and return its code. */
TATU_INLINE tatu_status tatu_call_fail(tatu_call *c, tatu_status code, const char *text) {
  return tatu_fail(c->error, code, text);
}
TATU_INLINE tatu_status tatu_call_fail_help(tatu_call *c, tatu_status code, const char *text, const char *help) {
  return tatu_fail_help(c->error, code, text, help);
}
/* Returns a frame for commands.call and commands.call_func. `cap`, the capacity of `results`, is at least 16. */
TATU_INLINE tatu_call tatu_frame(const tatu_value *args, uint32_t n_args, tatu_value *results, uint32_t cap) {
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

/* ---------------------------------------------------------------- What a plugin offers to scripts --------------- */

/* A named value for scripts. */
typedef struct tatu_constant {
  uint32_t size;
  uint32_t reserved;
  const char *name;  /* "sim_handle_self", "sim.handle_self" */
  tatu_value value;
} tatu_constant;

/* A module that the plugin provides to scripts of one language, as source text. The module named "" is run once in
 * every new script state, and returns a table that defines how scripts of this API are called (see the language's
 * page). Scripts load all other modules with `require`. */
typedef struct tatu_prelude {
  uint32_t size;
  uint32_t reserved;
  const char *language;
  const char *module;
  tatu_str text;
} tatu_prelude;

typedef struct tatu_kind_mark tatu_kind_mark; /* vrep.h */

typedef struct tatu_ext_command {
  uint32_t size;
  uint32_t reserved;
  const tatu_command *const *commands;
  const tatu_constant *const *constants; /* may be null */
  const tatu_prelude *const *preludes;   /* may be null */
  const tatu_life *per_world;            /* null: the plugin has no state per world */
  const tatu_kind_mark *const *kind_marks; /* may be null */
} tatu_ext_command;

#ifndef __cplusplus
/* Commands of a plugin, for TATU_PLUGIN: pointers to tatu_command. */
#  define TATU_COMMANDS(...) \
    TATU_OFFER(TATU_COMMAND, tatu_ext_command, .commands = TATU_LIST_OF(tatu_command, __VA_ARGS__))
/* As TATU_COMMANDS, with one instance of the plugin per world, whose life cycle is `Life`, a pointer to tatu_life. */
#  define TATU_COMMANDS_PER_WORLD(Life, ...) \
    TATU_OFFER(TATU_COMMAND, tatu_ext_command, .commands = TATU_LIST_OF(tatu_command, __VA_ARGS__), .per_world = (Life))
#endif

#ifdef __cplusplus
}
#endif
#endif
