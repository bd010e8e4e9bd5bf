/* tatu/host.h: the services of the host: scene, bodies, readings, commands, signals, events, log, files and more. */
#ifndef TATU_HOST_H
#define TATU_HOST_H

#include "command.h"
#include "sensor.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Every function that takes a world is [step], and may be called from within any [step] call for that world. On failure
 * it returns a negative status; log.last_error(world) contains the message until the next failure. */

/* ---------------------------------------------------------------- Scene ----------------------------------------- */

#define TATU_HOST_SCENE "tatu.host.scene/draft.4"

/* Kinds of objects. */
enum tatu_kind {
  TATU_KIND_SHAPE = 0, TATU_KIND_JOINT = 1, TATU_KIND_DUMMY = 2, TATU_KIND_SENSOR = 3, TATU_KIND_ACTUATOR = 4,
  TATU_KIND_FORCE_SENSOR = 5, TATU_KIND_SCRIPT = 6, TATU_KIND_CAMERA = 7, TATU_KIND_LIGHT = 8, TATU_KIND_GRAPH = 9,
  TATU_KIND_PATH = 10, TATU_KIND_PART = 11
};
enum tatu_list_flag {
  TATU_LIST_CHILDREN = 1,   /* direct children only; without it, the whole tree, breadth first */
  TATU_LIST_SKIP_BASE = 2   /* the base itself is not listed */
};

/* Objects and their properties (see docs/reference/properties.md). The world itself is object 0. */
typedef struct tatu_host_scene {
  uint32_t size;
  uint32_t reserved;
  /* [any] Interns a key ("joint.position"); never fails, since the key may be declared later. */
  tatu_prop(TATU_CALL *prop)(const tatu_host *, const char *key);
  /* Reads a property. Text and arrays are valid until the current call returns. */
  tatu_status(TATU_CALL *get)(tatu_world *, tatu_object, tatu_prop, tatu_value *);
  /* Sets a property. The value changes at once. Some properties, which properties.md identifies, also rebuild bodies at
   * the next stage. */
  tatu_status(TATU_CALL *set)(tatu_world *, tatu_object, tatu_prop, const tatu_value *);
  /* Reads exactly `n` numbers, without allocation: the fastest function for poses and joints. */
  tatu_status(TATU_CALL *get_f64)(tatu_world *, tatu_object, tatu_prop, double *out, uint32_t n);
  /* Sets exactly `n` numbers. */
  tatu_status(TATU_CALL *set_f64)(tatu_world *, tatu_object, tatu_prop, const double *in, uint32_t n);
  /* As get_f64 and set_f64, for `count` objects with `n` numbers each; they stop at the first failure. */
  tatu_status(TATU_CALL *get_f64_many)(tatu_world *, const tatu_object *, uint32_t count, tatu_prop, double *out,
                                       uint32_t n);
  tatu_status(TATU_CALL *set_f64_many)(tatu_world *, const tatu_object *, uint32_t count, tatu_prop, const double *in,
                                       uint32_t n);
  /* Gets the pose of an object in the frame of another (0: the world; of a joint, the frame that moves). 7 doubles. */
  tatu_status(TATU_CALL *pose)(tatu_world *, tatu_object, tatu_object frame, double *pose);
  /* Sets the pose of an object. Its descendants move with it, and dynamic bodies are also moved in the engine. */
  tatu_status(TATU_CALL *set_pose)(tatu_world *, tatu_object, tatu_object frame, const double *pose);
  /* Gets the full id, with its generation, and the kind (enum tatu_kind) of an object. Validates a handle that a script
   * passed. */
  tatu_status(TATU_CALL *look)(tatu_world *, tatu_object, tatu_object *full, int32_t *kind);
  /* Finds an object by path ("/a/b[1]", "./b" and ":/b" from `from`) or by unique name ("b#0"). TATU_ERR_MISSING: not
   * found. */
  tatu_status(TATU_CALL *find)(tatu_world *, tatu_object from, tatu_str path, tatu_object *);
  /* Creates an object. It exists at once, and takes part in physics from the next stage. */
  tatu_status(TATU_CALL *create)(tatu_world *, const char *kind, tatu_object parent, tatu_str alias, tatu_object *);
  /* Removes objects. They can no longer be found; their children become children of their parents; their instances are
   * destroyed at the next stage. */
  tatu_status(TATU_CALL *remove)(tatu_world *, const tatu_object *, uint32_t n);
  /* Lists objects below `base` (0: all objects). `kinds` contains the bit 1 << TATU_KIND_* for each kind to list; 0:
   * all kinds. `*n` is the full count even if `cap` is smaller, which is no error. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object base, uint32_t kinds, uint32_t flags, tatu_object *out,
                               uint32_t cap, uint32_t *n);
  /* Copies `n` objects without moving them. A copy is placed below the copy of its parent, or at the top level if the
   * parent is not among `objects`. All copies get the same new suffix. `out` has room for `n` ids. Sensors, actuators
   * and scripts are copied with their current parameters and text, but in their initial state. */
  tatu_status(TATU_CALL *copy)(tatu_world *, const tatu_object *objects, uint32_t n, tatu_object *out);
  /* [step] Loads the objects, sensors, actuators and scripts of a scene file, or of a file that an importer reads, into
   * the world below `parent` (0: the world). `file` is a path from `files.resolve`, or the id of a model. `*out` is the
   * first object. World settings and a main script in the file have no effect. Errors in the file are reported as when
   * a scene is opened. */
  tatu_status(TATU_CALL *load)(tatu_world *, tatu_str file, tatu_object parent, tatu_object *out);
  /* [step] Writes an object and its descendants (0: the whole scene) as a scene file, with meshes and scripts in a
   * folder beside it. `file` is a path from `files.resolve` that ends in ".toml". */
  tatu_status(TATU_CALL *save)(tatu_world *, tatu_str file, tatu_object base);
  /* [step] Gets the declaration of the `index`-th property of an object, from 0 (object 0: of the world), as a map:
   * "key", "type" (enum tatu_tag), "count", "unit", "settable", "choices" (a list of texts), "text", and "min" and
   * "max" if they are declared. The parameters of its device follow the properties of the object itself. Valid until
   * the current call returns. TATU_ERR_MISSING, without a message: there is no property with this index. */
  tatu_status(TATU_CALL *row)(tatu_world *, tatu_object, uint32_t index, tatu_value *);
  /* [step] Gets the `index`-th model that plugins offer, from 0, as a map: "id" (for `load`), "text", "category". Valid
   * until the current call returns. TATU_ERR_MISSING, without a message: there is no model with this index. */
  tatu_status(TATU_CALL *model)(tatu_world *, uint32_t index, tatu_value *);
} tatu_host_scene;

/* ---------------------------------------------------------------- Bodies ---------------------------------------- */

#define TATU_HOST_BODIES "tatu.host.bodies/draft.4"

/* Motion and contact of bodies. Mass and inertia are properties ("shape.mass"). */
typedef struct tatu_host_bodies {
  uint32_t size;
  uint32_t reserved;
  /* Gets the velocity of any object: for dynamic shapes that of the engine, for all others the mean over the last step.
   * 6 doubles. */
  tatu_status(TATU_CALL *twist)(tatu_world *, tatu_object, double *twist);
  /* Sets the velocity of a dynamic shape. */
  tatu_status(TATU_CALL *set_twist)(tatu_world *, tatu_object, const double *twist);
  /* Applies a force (N) and a torque (N m), in the world frame, to a dynamic shape at its centre of mass during the
   * next physics step. Several calls add up. A null pointer means 0. */
  tatu_status(TATU_CALL *push)(tatu_world *, tatu_object, const double *force, const double *torque);
  /* Applies a linear impulse (N s) and an angular impulse (N m s), in the world frame, at the centre of mass. The
   * velocity changes at once. A null pointer means 0. */
  tatu_status(TATU_CALL *impulse)(tatu_world *, tatu_object, const double *linear, const double *angular);
  /* Lists the pairs of shapes in contact after the last step, those of one shape or (0) all. `*n` is the full count. */
  tatu_status(TATU_CALL *contacts)(tatu_world *, tatu_object, tatu_contact *out, uint32_t cap, uint32_t *n);
  /* Finds the shortest distance between any shape in `a` and any shape in `b`, at their current poses; if `n_b` is 0,
   * between `a` and any other shape. Objects that are not shapes are skipped. `limit` > 0: maximum distance, m. Writes
   * the end points on both shapes to `points`, 6 numbers in the world frame, and the two shapes to `pair`; overlapping
   * solids have distance 0. TATU_ERR_MISSING: no pair is within the limit. */
  tatu_status(TATU_CALL *closest)(tatu_world *, const tatu_object *a, uint32_t n_a, const tatu_object *b, uint32_t n_b,
                                  double limit, double *points, tatu_object *pair);
  /* Gets whether the engine moves the object: 1 for dynamic shapes, and for joints between two bodies, once physics has
   * run. */
  tatu_status(TATU_CALL *is_dynamic)(tatu_world *, tatu_object, uint32_t *yes);
  /* Gets the friction forces on shape[1] at the contacts that `contacts` lists, in the same order, over the last
   * physics step: 3 numbers each, world frame, N. `cap` and `n` count numbers. */
  tatu_status(TATU_CALL *frictions)(tatu_world *, tatu_object, double *out, uint32_t cap, uint32_t *n);
  /* Finds the shortest distance like `closest`, with the shapes in `a` at other poses: `poses` has 7 numbers for each of
   * them (x y z, quaternion x y z w, in the world frame). Nothing moves. Without this function, move the shapes, call
   * `closest`, and move them back. */
  tatu_status(TATU_CALL *closest_at)(tatu_world *, const tatu_object *a, const double *poses, uint32_t n_a,
                                     const tatu_object *b, uint32_t n_b, double limit, double *points,
                                     tatu_object *pair);
  /* [step] Registers two shapes for a part, whose function `contact` then decides on their contact before each physics
   * step; `b` 0: with all shapes that `a` touches. `on` 0: ends this, and restores their contact. A stop ends all
   * registrations. Pairs that are not registered cost nothing. Absent in older hosts. */
  tatu_status(TATU_CALL *hook)(tatu_world *, tatu_object part, tatu_object a, tatu_object b, uint32_t on);
} tatu_host_bodies;

/* ---------------------------------------------------------------- Readings -------------------------------------- */

#define TATU_HOST_READINGS "tatu.host.readings/draft.4"

/* Limits for a single measurement. They do not affect noise or the plugin's processing. */
typedef struct tatu_look {
  uint32_t size;
  uint32_t flags;       /* TATU_BEAMS_NO_FRONT, _NO_BACK, _OCCLUDE, in place of the sensor's own */
  tatu_object only;     /* detect only this object; 0: all */
  double far_m;         /* maximum distance from the sensor's origin, m; infinity: the sensor's range */
  double max_incidence; /* rad, in place of the sensor's own; pi/2 or more: no limit */
} tatu_look;

/* Readings of sensors. */
typedef struct tatu_host_readings {
  uint32_t size;
  uint32_t reserved;
  /* Gets one field ("proximity.distance", interned with scene.prop) of a sensor's last reading. TATU_ERR_MISSING: the
   * sensor has no such field. */
  tatu_status(TATU_CALL *field)(tatu_world *, tatu_object sensor, tatu_prop field, tatu_field_view *);
  /* Measures a sensor now, whether or not it is due. `only`: detect only this object; 0: all. */
  tatu_status(TATU_CALL *sense_now)(tatu_world *, tatu_object sensor, tatu_object only);
  /* Discards the sensor's reading: its sequence number becomes 0. */
  tatu_status(TATU_CALL *reset)(tatu_world *, tatu_object sensor);
  /* Lists the sensors that fill a schema ("proximity/1"). */
  tatu_status(TATU_CALL *list)(tatu_world *, const char *schema, tatu_object *out, uint32_t cap, uint32_t *n);
  /* Gets the declaration of the `index`-th field of a sensor, from 0, with its shape for this sensor. Its texts live as
   * long as the world. TATU_ERR_MISSING: there is no field with this index. */
  tatu_status(TATU_CALL *describe)(tatu_world *, tatu_object sensor, uint32_t index, tatu_field *);
  /* As `sense_now`, with limits that replace those of the sensor's parameters for this measurement. */
  tatu_status(TATU_CALL *look)(tatu_world *, tatu_object sensor, const tatu_look *);
} tatu_host_readings;

/* ---------------------------------------------------------------- Commands -------------------------------------- */

#define TATU_HOST_COMMANDS "tatu.host.commands/draft.4"

/* Looks up and calls the commands of all plugins. Their ids run from 1 without gaps. */
typedef struct tatu_host_commands {
  uint32_t size;
  uint32_t reserved;
  /* Returns the id of the command with this name; 0: there is none. `alias`, if not null, receives the index of the
   * name among the command's names. */
  uint32_t(TATU_CALL *find)(tatu_world *, tatu_str name, uint32_t *alias);
  /* Returns 1 if the name of any command or constant begins with `name` and a dot, else 0. */
  uint32_t(TATU_CALL *is_name_space)(tatu_world *, tatu_str name);
  /* Returns the number of commands. */
  uint32_t(TATU_CALL *count)(tatu_world *);
  /* Returns the declaration of a command: the host's own copy, which lives as long as the host. Null: there is no
   * command with this id. */
  const tatu_command *(TATU_CALL *describe)(tatu_world *, uint32_t id);
  /* Calls a command. The caller sets size, command, alias, args, n_args, results, results_cap and wait_token of the
   * frame; the host sets the rest. On failure, frame->error contains the message until the next call. Memory that the
   * results point to is valid until the caller releases the arena to an earlier mark, or its own call returns. */
  tatu_status(TATU_CALL *call)(tatu_world *, tatu_call *frame);
  /* Returns a number that increases when commands are added or removed; ids must then be looked up again. */
  uint64_t(TATU_CALL *generation)(tatu_world *);
  /* Gets the value of a named constant. TATU_ERR_MISSING: there is no such constant. */
  tatu_status(TATU_CALL *constant)(tatu_world *, tatu_str name, tatu_value *);
  /* Gets the name and text of the `index`-th prelude of a language, from 0. TATU_ERR_MISSING: there is no prelude with
   * this index. */
  tatu_status(TATU_CALL *prelude)(tatu_world *, const char *language, uint32_t index, tatu_str *module,
                                  tatu_str *text);
  /* Returns a mark: the current position in the world's arena. */
  uint64_t(TATU_CALL *mark)(tatu_world *);
  /* Allocates memory in the world's arena; null if there is no room. */
  void *(TATU_CALL *alloc)(tatu_world *, uint64_t bytes);
  /* Releases everything that was allocated in the arena since a mark. */
  void(TATU_CALL *release)(tatu_world *, uint64_t mark);
  /* Retains a function of a script beyond the call. `*kept` is valid until it is dropped or its script ends; after the
   * script has ended, it need not be dropped. Retaining a function twice returns two different ids. */
  tatu_status(TATU_CALL *retain)(tatu_world *, tatu_func, tatu_func *kept);
  /* Releases a retained function. */
  void(TATU_CALL *drop)(tatu_world *, tatu_func);
  /* Calls a script's function; the frame is as for `call`. TATU_ERR_GONE: its script has ended. */
  tatu_status(TATU_CALL *call_func)(tatu_world *, tatu_func, tatu_call *frame);
  /* Gets the name of the `index`-th constant, from 0, in the order of their names. TATU_ERR_MISSING: there is no
   * constant with this index. */
  tatu_status(TATU_CALL *constant_name)(tatu_world *, uint32_t index, tatu_str *name);
  /* [any] Delivers the result for a ticket (tatu_call_api.ticket); the bytes are copied. At the next barrier of the
   * world, the result is recorded in the input log, and the wait ends. TATU_ERR_MISSING: there is no such ticket, or it
   * has already been used. If the world has ended, the call has no effect. */
  tatu_status(TATU_CALL *wake)(const tatu_host *, uint64_t ticket, tatu_str result);
} tatu_host_commands;

/* ---------------------------------------------------------------- Signals --------------------------------------- */

#define TATU_HOST_SIGNALS "tatu.host.signals/draft.4"

/* Named values of the world. Each `kind`, a number below 256 that users choose, is a separate name space. */
typedef struct tatu_host_signals {
  uint32_t size;
  uint32_t reserved;
  /* Gets a signal. Text is valid until the current call returns. TATU_ERR_MISSING: the signal is not set. */
  tatu_status(TATU_CALL *get)(tatu_world *, uint32_t kind, tatu_str name, tatu_value *);
  /* Sets a signal. */
  tatu_status(TATU_CALL *set)(tatu_world *, uint32_t kind, tatu_str name, const tatu_value *);
  /* Removes a signal, or all signals of the kind if `name` is empty. Returns the number of signals removed. */
  uint32_t(TATU_CALL *clear)(tatu_world *, uint32_t kind, tatu_str name);
  /* Gets the name of the `index`-th signal of a kind, from 0, in the order of their names. TATU_ERR_MISSING: there is
   * no signal with this index. */
  tatu_status(TATU_CALL *name)(tatu_world *, uint32_t kind, uint32_t index, tatu_str *);
} tatu_host_signals;

/* ---------------------------------------------------------------- Events ---------------------------------------- */

#define TATU_HOST_EVENTS "tatu.host.events/draft.4"

/* Events of a world. An event consists of a name and a payload, which is a map. Events are queued in the order in which
 * they are published. They are delivered to functions of scripts, in order of subscription, before each step, after
 * each of its stages, and when the world has stopped, and to services at their next barrier. Events that handlers
 * publish are appended to the queue, and delivered in the same round. A handler that fails is reported and no longer
 * called. */
typedef struct tatu_host_events {
  uint32_t size;
  uint32_t reserved;
  /* Publishes an event. The name must contain a dot, since names without one are reserved for the host. `payload` is a
   * map; null: an empty map. */
  tatu_status(TATU_CALL *publish)(tatu_world *, tatu_str name, const tatu_value *payload);
  /* Subscribes a function to an event: `handler` is called with the payload and the name. It must be a retained
   * reference (see commands.retain), and is dropped when the subscription ends, at the latest with its script. `name`
   * is one event, or "*" as in tatu_service.events. TATU_ERR_MISSING: the name has no dot, and is not declared. */
  tatu_status(TATU_CALL *subscribe)(tatu_world *, tatu_str name, tatu_func handler, uint64_t *id);
  /* Ends a subscription. TATU_ERR_MISSING: there is no subscription with this id. */
  tatu_status(TATU_CALL *unsubscribe)(tatu_world *, uint64_t id);
  /* Returns 1 if an event has subscribers, else 0; its payload then need not be gathered. */
  uint32_t(TATU_CALL *wanted)(tatu_world *, tatu_str name);
  /* Gets name and description of the `index`-th declared event, from 0. TATU_ERR_MISSING: there is no event with this
   * index. */
  tatu_status(TATU_CALL *declared)(tatu_world *, uint32_t index, tatu_str *name, tatu_str *text);
} tatu_host_events;

/* ---------------------------------------------------------------- Log ------------------------------------------- */

#define TATU_HOST_LOG "tatu.host.log/draft.4"

enum tatu_log_level {
  TATU_LOG_ERROR = 1, TATU_LOG_WARNING = 2, TATU_LOG_INFO = 3, TATU_LOG_DEBUG = 4,
  TATU_LOG_STATUS = 5, /* a line for the status bar: output of scripts for the user; recorded in traces */
  TATU_LOG_CLEAR = 6,  /* clears the status bar */
  TATU_LOG_CONSOLE = 7,      /* prints on a console, verbatim: its title, NUL, the text; recorded in traces only */
  TATU_LOG_CONSOLE_CLEAR = 8 /* clears the console with this title; recorded in traces only */
};

typedef struct tatu_host_log {
  uint32_t size;
  uint32_t reserved;
  /* [any] Writes one line, attributed to the plugin to which the first argument belongs. The world may be null. */
  void(TATU_CALL *write)(const tatu_host *, tatu_world *, uint32_t level, tatu_str text);
  /* [step] Returns the error of the last service call that failed; never null. */
  const tatu_error *(TATU_CALL *last_error)(tatu_world *);
} tatu_host_log;

/* ---------------------------------------------------------------- Files ----------------------------------------- */

#define TATU_HOST_FILES "tatu.host.files/draft.4"

enum tatu_file_mode {
  TATU_FILE_READ = 1,
  TATU_FILE_WRITE = 2,   /* creates or truncates the file */
  /* for `open` only: */
  TATU_FILE_APPEND = 4,  /* in place of WRITE: appends to the file, and creates it if it does not exist */
  TATU_FILE_UPDATE = 8,  /* with WRITE: the file must exist, and is not truncated */
  TATU_FILE_NEW = 16,    /* with WRITE: the file must not exist */
  TATU_FILE_FOLDERS = 32 /* with WRITE or APPEND: creates missing folders */
};

/* Access to files in the folders that the run allows. */
typedef struct tatu_host_files {
  uint32_t size;
  uint32_t reserved;
  /* Gets the path of a file whose name a script passed, if the file is in an allowed folder: to read, the scene's
   * folder or the working folder; to write, the working folder. The path is valid until the current call returns, and
   * is meant for functions that require one; a plugin that reads or writes the file itself must use `open`. */
  tatu_status(TATU_CALL *resolve)(tatu_world *, tatu_str name, uint32_t mode, tatu_str *path);
  /* [step] Opens a regular file in the allowed folders; `mode` is a sum of TATU_FILE_*. The caller owns `*file`, a file
   * descriptor (POSIX, close-on-exec) or a HANDLE (Windows), and must close it. The folders are those at the time when
   * the world was created, so they cannot be left through a changed working folder, `..` or links. TATU_ERR_MISSING:
   * there is no such file. TATU_ERR: a link points outside, or the file is a folder, pipe, socket or device; the
   * message states its path. */
  tatu_status(TATU_CALL *open)(tatu_world *, tatu_str name, uint32_t mode, int64_t *file);
} tatu_host_files;

/* ---------------------------------------------------------------- Session --------------------------------------- */

#define TATU_HOST_SESSION "tatu.host.session/draft.4"

enum tatu_request { TATU_REQUEST_STOP = 1, TATU_REQUEST_PAUSE = 2, TATU_REQUEST_START = 3, TATU_REQUEST_QUIT = 4 };
enum tatu_run_state { TATU_STOPPED = 0, TATU_RUNNING = 1, TATU_PAUSED = 2 };

/* Values of the property `scene.phase`. A stop that is requested between two passes takes effect after three more: an
 * ordinary one, STOPPING and LAST. A pause takes effect after two: an ordinary one and LAST_BEFORE_PAUSE. Time advances
 * in each of them. */
enum tatu_phase {
  TATU_PHASE_STOPPED = 0,
  TATU_PHASE_FIRST = 1,
  TATU_PHASE_RUNNING = 2,
  TATU_PHASE_LAST_BEFORE_PAUSE = 3,
  TATU_PHASE_PAUSED = 4,
  TATU_PHASE_FIRST_AFTER_PAUSE = 5,
  TATU_PHASE_STOPPING = 6,
  TATU_PHASE_LAST = 7
};

/* The worlds of a session, their life cycle and their inputs. */
typedef struct tatu_host_session {
  uint32_t size;
  uint32_t reserved;
  /* Requests a change of state, enum tatu_request, which takes effect after the pass: see enum tatu_phase. While the
   * world is stopped or paused, a start takes effect at once, unless a script requests it. A stop releases all
   * holds. */
  tatu_status(TATU_CALL *request)(tatu_world *, uint32_t what);
  /* [any] Wakes a session that waits at its barrier. */
  void(TATU_CALL *wake)(tatu_session *);
  /* Lists the session's worlds. `*n` is the full count. */
  tatu_status(TATU_CALL *worlds)(tatu_session *, tatu_world **out, uint32_t cap, uint32_t *n);
  /* [step] In a service's barrier, sets the client on whose behalf the following calls are made: a number that the
   * service chooses, which is recorded in the input log with each call. */
  tatu_status(TATU_CALL *client)(tatu_world *, uint64_t client);
  /* [step] Returns the state of a world: TATU_STOPPED, TATU_RUNNING or TATU_PAUSED. */
  uint32_t(TATU_CALL *state)(tatu_world *);
  /* [step] Gets the `index`-th external input since the start, from 0; calls by services are not included. For a key
   * press, for instance, `kind` is "key" and `text` its character or name. Kinds and texts are a convention between
   * those that add inputs and those that read them. Both are valid until the current call returns. TATU_ERR_MISSING,
   * without a message: there is no input with this index yet. */
  tatu_status(TATU_CALL *input)(tatu_world *, uint64_t index, tatu_str *kind, tatu_str *text);
  /* [step] Adds an external input: see `input`. The input log records this call. */
  tatu_status(TATU_CALL *put_in)(tatu_world *, tatu_str kind, tatu_str text);
  /* [step] Requests that the program open another scene once this world has stopped. `file` is a path from
   * `files.resolve`; empty: reopen this scene from its file. TATU_ERR_UNSUPPORTED: the program can run only one scene.
   * If the file cannot be opened, the call fails with the reason, and this world continues. A start that is requested
   * afterwards applies to the new scene. */
  tatu_status(TATU_CALL *open)(tatu_world *, tatu_str file);
  /* [step] Gets a recorded observation. What a plugin reads from an external source during a step, such as
   * a socket or a clock, is an input of the run, so the plugin must call this function first. In a replay it returns
   * the next text of this kind in the input log, and the plugin must not access the source. TATU_ERR_MISSING, without a
   * message: this is not a replay; read the source, and pass the result to `observe`. TATU_ERR_GONE: the log contains
   * no further text of this kind. The text is valid until the current call returns. */
  tatu_status(TATU_CALL *observed)(tatu_world *, tatu_str kind, tatu_str *text);
  /* [step] Records an observation in the input log: see `observed`. */
  tatu_status(TATU_CALL *observe)(tatu_world *, tatu_str kind, tatu_str text);
  /* [step] Returns nonzero once the run must end. While waiting for something external, poll this every 50 ms and give
   * up once it is nonzero; the host does not treat a call that polls as one that never returns. */
  uint32_t(TATU_CALL *interrupted)(tatu_world *);
  /* [step] Within a call to a service, creates a reference to a function of a client, to be passed to commands
   * (TATU_FUNC). It can be retained like a function of a script. When it is called, the host calls
   * tatu_service.call_func with `local`, a number that the service chooses. */
  tatu_status(TATU_CALL *function)(tatu_world *, uint32_t local, tatu_func *func);
  /* [any] Asks the running script to return, because a client wants to stop the run. A script that does not return
   * within a second is ended. The request for the stop itself follows in the service's turn. Absent in older hosts, in
   * which a script is ended only by its budget. */
  void(TATU_CALL *stop)(tatu_session *);
  /* [step] For script languages: returns nonzero once the running script must return, because it has not done so within
   * a second after a stop was requested from outside. Ask at least every few milliseconds, and then end the call with
   * TATU_ERR_BUDGET. Absent in older hosts, in which no script must return early. */
  uint32_t(TATU_CALL *must_return)(tatu_world *);
} tatu_host_session;

/* ---------------------------------------------------------------- Stages ---------------------------------------- */

#define TATU_HOST_STAGE "tatu.host.stage/draft.4"

enum tatu_stage { TATU_STAGE_ACTUATE = 1, TATU_STAGE_PHYSICS = 2, TATU_STAGE_SENSE = 3, TATU_STAGE_REACT = 4, TATU_STAGE_CLEAN = 5 };

/* Stages, for drivers: a script of kind "main", or a plugin that it calls, runs the stages of a step itself, each any
 * number of times. At the end of the step, time advances by the sum of the durations of its physics stages. */
typedef struct tatu_host_stage {
  uint32_t size;
  uint32_t reserved;
  /* Runs one stage now. If this stage is already running, fails with the chain of calls. TATU_STAGE_CLEAN calls the
   * clean-up callbacks of the scripts of the run, each once; it has an effect only in the last pass. */
  tatu_status(TATU_CALL *run)(tatu_world *, uint32_t stage, double dt);
} tatu_host_stage;

/* ---------------------------------------------------------------- Scripts --------------------------------------- */

#define TATU_HOST_SCRIPTS "tatu.host.scripts/draft.4"

/* Scripts of the world. A script is itself an object, of kind TATU_KIND_SCRIPT, and belongs to another object. */
typedef struct tatu_host_scripts {
  uint32_t size;
  uint32_t reserved;
  /* Lists the scripts of an object; 0: of all objects. `*n` is the full count. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object owner, tatu_object *out, uint32_t cap, uint32_t *n);
  /* Calls a function of a script by its name. */
  tatu_status(TATU_CALL *call)(tatu_world *, tatu_object script, tatu_str function, tatu_call *frame);
  /* Calls a callback in all scripts that define it, except in the script `except`; results are discarded. */
  tatu_status(TATU_CALL *broadcast)(tatu_world *, tatu_str callback, const tatu_value *args, uint32_t n_args,
                                    tatu_object except);
  /* Gets the options with which a script was started from outside: a map of texts, empty for all other scripts. Valid
   * until the current call returns. */
  tatu_status(TATU_CALL *options)(tatu_world *, tatu_object script, tatu_value *);
  /* Adds a script to an object of a live world. `language` is the id of a language; `dialect` may be empty; `kind` is
   * "child", "threaded" or "customization". During a run, the script starts in the next stage, after all others. A stop
   * removes the scripts that were added since the start. */
  tatu_status(TATU_CALL *add)(tatu_world *, tatu_object owner, tatu_str language, tatu_str dialect, tatu_str kind,
                              tatu_str name, tatu_str text, tatu_object *out);
  /* Calls the child scripts of all objects below `above`, in order and with these arguments, in place of a stage that
   * is running: it calls the scripts that have not been called in this stage yet, and the stage does not call them
   * again. `stage` is TATU_STAGE_ACTUATE or TATU_STAGE_REACT; if that stage is not running, no script is called. `*n`
   * is the number of scripts called. */
  tatu_status(TATU_CALL *call_below)(tatu_world *, tatu_object above, uint32_t stage, const tatu_value *args,
                                     uint32_t n_args, uint32_t *n);
  /* [step] Gets the text of a script, as bytes. Valid until the current call returns. */
  tatu_status(TATU_CALL *text)(tatu_world *, tatu_object script, tatu_value *);
  /* [step] Replaces the text of a script. Variables that contain numbers, texts or tables keep their values if the new
   * text also defines them. If the text cannot be loaded, fails and changes nothing. Not allowed while the script
   * itself is running. */
  tatu_status(TATU_CALL *change)(tatu_world *, tatu_object script, tatu_str text);
} tatu_host_scripts;

/* ---------------------------------------------------------------- Figures --------------------------------------- */

#define TATU_HOST_FIGURES "tatu.host.figures/draft.4"

enum tatu_figure {
  TATU_FIGURE_STREAM = 1,  /* of a graph: a number over time. Keys: name, unit, color, of, data, transform, factor, offset, window, hidden */
  TATU_FIGURE_CURVE = 2,   /* of a graph: one stream over another. Keys: name, unit, color, x, y, z (a stream's name or a number) */
  TATU_FIGURE_COPY = 3,    /* of a graph: a fixed copy of a curve. Keys: name, curve (its number) */
  TATU_FIGURE_DRAWING = 4  /* of the world: items in space. Keys: form, size, color, parent, capacity, cyclic, tolerance, persistent, extra */
};

/* Figures: streams and curves of graphs (objects of kind graph), and drawings, for which `graph` is 0. Their ids count
 * from 1 within each graph, and among the drawings. `keys` are maps with the keys of scene files, in SI units and
 * radians. Figures have no effect on objects. Graphs are cleared when a run starts, and keep their data when it
 * stops. */
typedef struct tatu_host_figures {
  uint32_t size;
  uint32_t reserved;
  /* Adds a figure; `what` is one of enum tatu_figure, and `keys` a map of its keys. */
  tatu_status(TATU_CALL *add)(tatu_world *, tatu_object graph, uint32_t what, const tatu_value *keys, int64_t *id);
  /* Changes the given keys of a stream or, if `keys` is null, removes a stream, curve or drawing. TATU_ERR_MISSING: the
   * figure does not exist. */
  tatu_status(TATU_CALL *change)(tatu_world *, tatu_object graph, int64_t id, const tatu_value *keys);
  /* Appends the next sample to a stream (`n` is 1), or adds items to a drawing: numbers in the world frame, "stride"
   * per item. If `n` is 0, clears a drawing or, with `id` 0, a whole graph. `*taken` is the number of samples or items
   * that were accepted. */
  tatu_status(TATU_CALL *put)(tatu_world *, tatu_object graph, int64_t id, const double *numbers, uint64_t n,
                              uint64_t *taken);
  /* Samples all streams of a graph, at this time in s. If `graph` is 0, samples all graphs that record
   * automatically. */
  tatu_status(TATU_CALL *record)(tatu_world *, tatu_object graph, double time);
  /* Lists the ids of all figures of one kind (TATU_FIGURE_STREAM, _CURVE or _DRAWING), in order of creation. `*n` is
   * the full count. */
  tatu_status(TATU_CALL *list)(tatu_world *, tatu_object graph, uint32_t what, int64_t *out, uint32_t cap, uint32_t *n);
  /* Gets a figure as a map of its keys and "figure" (TATU_FIGURE_*). If `numbers` is not 0, the map also contains the
   * data, as arrays of double: "times" and "values" of a stream (NaN: missing), "points" of a curve with "dims"
   * coordinates each, "items" of a drawing with "stride" numbers each. Valid until the current call returns. */
  tatu_status(TATU_CALL *get)(tatu_world *, tatu_object graph, int64_t id, uint32_t numbers, tatu_value *);
  /* [step] Gets the `index`-th visible part of a shape, from 0, as a map: "form" (box, sphere, cylinder, capsule, plane
   * or mesh), "size" (full extents, m; none for a plane), "pose" (7 numbers, in the shape's frame), "color", "opacity",
   * and for a mesh "points" (x y z) and "triangles" (three point indices) in the part's frame. A part with a texture has
   * "texture", a map of "image" (a hash of its pixels) and the keys of the property `shape.texture`, with the pose in
   * the part's frame; if its mapping is "mesh", the part has "coordinates", the position of each point in the image.
   * Valid until the current call returns. TATU_ERR_MISSING, without a message: there is no part with this index. */
  tatu_status(TATU_CALL *part)(tatu_world *, tatu_object shape, uint32_t index, tatu_value *);
  /* [step] Gets the image on the `index`-th part of a shape (see `part`) as a map: "columns", "rows", and "rgba", 4
   * bytes per pixel, top row first. Valid until the current call returns. TATU_ERR_MISSING, without a message: the part
   * has no image. Absent in hosts without images. */
  tatu_status(TATU_CALL *image)(tatu_world *, tatu_object shape, uint32_t index, tatu_value *);
} tatu_host_figures;

/* ---------------------------------------------------------------- Edits ----------------------------------------- */

#define TATU_HOST_EDITS "tatu.host.edits/draft.4"

enum tatu_open {
  TATU_OPEN_FILE = 0,
  TATU_OPEN_NEW = 1,      /* a new scene of this name, which must not exist; its file is written when it is saved */
  TATU_OPEN_RECOVERED = 2 /* with the content of the recovery copy beside the file, as unsaved edits */
};
enum tatu_save {
  TATU_SAVE_OVER = 1 /* overwrite the file even if it has changed on disk since it was opened */
};

/* Edits: changes that a person makes to the scene, which can be undone. An edit consists of everything that functions
 * and commands change between `begin` and `end`. Undoing it restores the whole state before it: objects with their
 * handles, names, order, links and scripts. Edits made while the simulation runs cannot be undone: a stop reverts them
 * together with the effects of the run, except for the texts of scripts, and the edits from before the run can then be
 * undone again. */
typedef struct tatu_host_edits {
  uint32_t size;
  uint32_t reserved;
  /* [step] Begins an edit. `label` describes it in words that can follow "Undo" ("Move cup"). Consecutive edits with
   * the same label and the same `merge` become one edit, unless `merge` is empty. An edit that begins within another
   * edit is part of it. */
  tatu_status(TATU_CALL *begin)(tatu_world *, tatu_str label, tatu_str merge);
  /* [step] Ends the edit. If `keep` is 0, reverts it, unless it was made during a run or was merged. */
  tatu_status(TATU_CALL *end)(tatu_world *, uint32_t keep);
  /* [step] Undoes the last edit or, if `redo` is not 0, redoes the last edit that was undone. `*label`, its label, is
   * valid until the current call returns. TATU_ERR_MISSING, without a message: there is no such edit. Fails during a
   * run, and while a script is running. */
  tatu_status(TATU_CALL *step_back)(tatu_world *, uint32_t redo, tatu_str *label);
  /* [step] Gets the state of the edits as a map: "undo" and "redo" (lists of labels, the next one last), "unsaved"
   * (whether the scene differs from its file), "revision" (a number that identifies the state), "file" (the path of the
   * scene), "on_disk" (whether the file exists), "recovery" (when a copy with unsaved edits was written beside the
   * file, Unix time in s; nil: there is no copy). Valid until the current call returns. */
  tatu_status(TATU_CALL *state)(tatu_world *, tatu_value *);
  /* [step] Saves the scene in its stopped state. If `file` is empty, writes the scene's own file, and leaves all text
   * in it that the edits do not affect unchanged; only services and programs may do so. Otherwise `file` is a path from
   * `files.resolve` that ends in ".toml", and becomes the scene's file. `flags`: TATU_SAVE_*. */
  tatu_status(TATU_CALL *save)(tatu_world *, tatu_str file, uint32_t flags);
  /* [step] Writes a recovery copy beside the scene's file, if there are edits since the last copy. If `discard` is not
   * 0, removes the copy instead. Saving the scene also removes it. */
  tatu_status(TATU_CALL *copy)(tatu_world *, uint32_t discard);
  /* [step] As `session.open`; `how` is one of enum tatu_open. */
  tatu_status(TATU_CALL *open)(tatu_world *, tatu_str file, uint32_t how);
  /* [step] Adds the objects that a text in the format of scene files describes, below `parent` (0: the world): see
   * `scene.load`. File names in the text are relative to the scene's folder. `*out` is the first object. */
  tatu_status(TATU_CALL *add)(tatu_world *, tatu_str text, tatu_object parent, tatu_object *out);
  /* [step] Gets the `index`-th kind of device that plugins offer, from 0, as a map: "object" (sensor or actuator), "id"
   * (its name in scene files), "text". Valid until the current call returns. TATU_ERR_MISSING, without a message: there
   * is no kind with this index. */
  tatu_status(TATU_CALL *kind)(tatu_world *, uint32_t index, tatu_value *);
} tatu_host_edits;

/* ---------------------------------------------------------------- Using the services ---------------------------- */

#ifndef __cplusplus
/* The services that a plugin requires: .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_LOG). The functions in their
 * tables can then be called without TATU_HAS, but the plugin requires a host that is at least as new as this header. */
#  define TATU_NEED_SCENE TATU_NEED(tatu_host_scene, TATU_HOST_SCENE)
#  define TATU_NEED_BODIES TATU_NEED(tatu_host_bodies, TATU_HOST_BODIES)
#  define TATU_NEED_READINGS TATU_NEED(tatu_host_readings, TATU_HOST_READINGS)
#  define TATU_NEED_COMMANDS TATU_NEED(tatu_host_commands, TATU_HOST_COMMANDS)
#  define TATU_NEED_SIGNALS TATU_NEED(tatu_host_signals, TATU_HOST_SIGNALS)
#  define TATU_NEED_EVENTS TATU_NEED(tatu_host_events, TATU_HOST_EVENTS)
#  define TATU_NEED_LOG TATU_NEED(tatu_host_log, TATU_HOST_LOG)
#  define TATU_NEED_FILES TATU_NEED(tatu_host_files, TATU_HOST_FILES)
#  define TATU_NEED_SESSION TATU_NEED(tatu_host_session, TATU_HOST_SESSION)
#  define TATU_NEED_STAGE TATU_NEED(tatu_host_stage, TATU_HOST_STAGE)
#  define TATU_NEED_SCRIPTS TATU_NEED(tatu_host_scripts, TATU_HOST_SCRIPTS)
#  define TATU_NEED_FIGURES TATU_NEED(tatu_host_figures, TATU_HOST_FIGURES)
#  define TATU_NEED_EDITS TATU_NEED(tatu_host_edits, TATU_HOST_EDITS)
#endif

/* The tables of the host's services. The table of a service that the host does not offer is null, which cannot happen
 * for services in the plugin's `needs`, except optional ones. */
typedef struct tatu_host_api {
  const tatu_host *host;
  const tatu_host_scene *scene;
  const tatu_host_bodies *bodies;
  const tatu_host_readings *readings;
  const tatu_host_commands *commands;
  const tatu_host_signals *signals;
  const tatu_host_events *events;
  const tatu_host_log *log;
  const tatu_host_files *files;
  const tatu_host_session *session;
  const tatu_host_stage *stage;
  const tatu_host_scripts *scripts;
  const tatu_host_figures *figures;
  const tatu_host_edits *edits;
} tatu_host_api;

/* Returns the tables of all services; for use in `init`. */
TATU_INLINE tatu_host_api tatu_host_api_of(const tatu_host *host) {
  tatu_host_api api;
  api.host = host;
  api.scene = (const tatu_host_scene *)host->service(host, TATU_HOST_SCENE);
  api.bodies = (const tatu_host_bodies *)host->service(host, TATU_HOST_BODIES);
  api.readings = (const tatu_host_readings *)host->service(host, TATU_HOST_READINGS);
  api.commands = (const tatu_host_commands *)host->service(host, TATU_HOST_COMMANDS);
  api.signals = (const tatu_host_signals *)host->service(host, TATU_HOST_SIGNALS);
  api.events = (const tatu_host_events *)host->service(host, TATU_HOST_EVENTS);
  api.log = (const tatu_host_log *)host->service(host, TATU_HOST_LOG);
  api.files = (const tatu_host_files *)host->service(host, TATU_HOST_FILES);
  api.session = (const tatu_host_session *)host->service(host, TATU_HOST_SESSION);
  api.stage = (const tatu_host_stage *)host->service(host, TATU_HOST_STAGE);
  api.scripts = (const tatu_host_scripts *)host->service(host, TATU_HOST_SCRIPTS);
  api.figures = (const tatu_host_figures *)host->service(host, TATU_HOST_FIGURES);
  api.edits = (const tatu_host_edits *)host->service(host, TATU_HOST_EDITS);
  return api;
}
/* `init` for a plugin whose `self` consists only of these tables, a `const tatu_host_api *`. Its `shutdown` is
 * tatu_delete. */
TATU_INLINE tatu_status TATU_CALL tatu_init_host_api(const tatu_host *host, void **self, tatu_error *error) {
  tatu_host_api *api = (tatu_host_api *)tatu_new(sizeof *api, self, error);
  if (api) *api = tatu_host_api_of(host);
  return api ? TATU_OK : TATU_ERR_SPACE;
}

/* Returns the simulation time of a world, s. Requires the service `scene`. */
TATU_INLINE double tatu_time(const tatu_host_api *api, tatu_world *world) {
  double time = 0;
  api->scene->get_f64(world, 0, api->scene->prop(api->host, "scene.time"), &time, 1);
  return time;
}
/* Writes a line to the log. Requires the service `log`. */
TATU_INLINE void tatu_log(const tatu_host_api *api, tatu_world *world, uint32_t level, const char *text) {
  api->log->write(api->host, world, level, tatu_text(text));
}
/* Whether the arena had room for all values: see TATU_NO_ROOM. */
TATU_INLINE int tatu_all_made(const tatu_value *values, uint32_t n) {
  while (n && values[n - 1].tag != TATU_NO_ROOM) n--;
  return n == 0;
}
/* Calls a function of a script with arguments (TATU_VALUES); `*result` is its first result, or nil. If the function
 * fails, so does this call, with the function's error. `error` may be null, as in the callbacks of a service that have
 * none: then log.last_error(world) has the text. Requires the service `commands`. */
TATU_INLINE tatu_status tatu_call_func(const tatu_host_api *api, tatu_world *world, tatu_error *error, tatu_func func,
                                         const tatu_value *args, uint32_t n_args, tatu_value *result) {
  tatu_value results[16];
  tatu_call frame = tatu_frame(args, n_args, results, 16);
  tatu_status status;
  *result = tatu_nil();
  if (!tatu_all_made(args, n_args)) return tatu_fail(error, TATU_ERR_SPACE, "no room for the arguments");
  status = api->commands->call_func(world, func, &frame);
  if (status >= 0 && frame.n_results) *result = results[0];
  return status < 0 ? tatu_fail_as(error, status, frame.error) : status;
}
/* Calls a command by its name; otherwise as tatu_call_func. */
TATU_INLINE tatu_status tatu_call_command(const tatu_host_api *api, tatu_world *world, tatu_error *error,
                                            const char *name, const tatu_value *args, uint32_t n_args,
                                            tatu_value *result) {
  tatu_value results[16];
  tatu_call frame = tatu_frame(args, n_args, results, 16);
  tatu_status status;
  *result = tatu_nil();
  if (!tatu_all_made(args, n_args)) return tatu_fail(error, TATU_ERR_SPACE, "no room for the arguments");
  frame.command = api->commands->find(world, tatu_text(name), &frame.alias);
  if (!frame.command && error)
    return tatu_fail_help(error, TATU_ERR_UNKNOWN, "no plugin offers the command to be called", name);
  status = api->commands->call(world, &frame);
  if (status >= 0 && frame.n_results) *result = results[0];
  return status < 0 ? tatu_fail_as(error, status, frame.error) : status;
}

#ifdef __cplusplus
}
#endif
#endif
