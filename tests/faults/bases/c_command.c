// A Tatu plugin in one C file: commands for scripts. Copy it, and change the places numbered (1) to (5).
//
// Build: cc -std=c11 -shared -fPIC -I../../include -o libtatu_c_command.so c_command.c
// Try:   TATU_PLUGIN_PATH=. tatu list commands
//
// The file is read from the bottom up by the host: `tatu_plugin`, then `init`, `extension`, the tables of section 4,
// and at last the commands of section 3. The manual of everything named tatu_ is the header.

#include "tatu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- (1) Who you are -----------------------------------

#define PLUGIN_ID "org.example.c_command" // unique: reversed domain and a name; scenes and messages use it
#define PLUGIN_NAME "Example commands in C"
#define PLUGIN_VERSION "0.1.0"
#define PLUGIN_LICENCE "MIT"
#define PREFIX "example." // in front of all names of commands: take one that nobody else has

// ---------------------------------------------------------------- (2) What you keep ---------------------------------

// The plugin: one per host, shared by all its worlds and their threads, so nothing in it changes after `init`.
typedef struct plugin {
  const tatu_host *host;
  const tatu_host_commands *commands;
  const tatu_host_bodies *bodies;
  const tatu_host_scene *scene;
  const tatu_host_log *log; // may be null: it is an optional need
} plugin;

// The instance: one per world. Things that can be found again (keys, ids of commands) or cannot be saved.
typedef struct instance {
  tatu_prop time_key;          // the number that stands for "scene.time"
  uint64_t generation;         // of the commands when `read_sensor` was found
  uint32_t read_sensor;        // simReadProximitySensor: its id, 0 if there is none
  uint32_t alias;              // and which of the command's names that is
  tatu_func kept;              // what example.later was given; 0: nothing
} instance;

// The state: also one per world, but in the host's memory, so that it is saved, restored and zeroed with the world.
// Plain numbers only, no pointers.
typedef struct state {
  int64_t count;
} state;

// ---------------------------------------------------------------- Tools: keep them as they are ----------------------

// Passes the error of another call or a service on to the caller. `why` may be null.
static tatu_status pass_on(tatu_call *call, tatu_status status, const tatu_error *why) {
  if (why == call->error) return status;
  if (!TATU_HAS(why, code)) return tatu_call_fail(call, status, "refused by the host without a reason");
  call->error->say(call->error, status, why->text);
  if (why->help.len) call->error->add(call->error, TATU_PART_HELP, why->help, 0);
  if (why->file.len) call->error->add(call->error, TATU_PART_FILE, why->file, why->line);
  if (why->traceback.len) call->error->add(call->error, TATU_PART_TRACEBACK, why->traceback, 0);
  return status;
}

// Fails because a service of the host refused.
static tatu_status refused(tatu_call *call, tatu_status status) {
  const plugin *self = call->self;
  return pass_on(call, status, TATU_HAS(self->log, last_error) ? self->log->last_error(call->world) : NULL);
}

// The frame of a call that we make ourselves, with room for ROOM results; the host fills in the rest. Its wait_token
// is 0: what we call cannot wait.
#define ROOM 16
static tatu_call new_frame(const tatu_value *args, uint32_t n_args, tatu_value *results) {
  tatu_call frame = {
      .size = sizeof frame, .args = args, .n_args = n_args, .results = results, .results_cap = ROOM};
  return frame;
}

// The numbers of an argument that is declared as F64S.
static const double *numbers(const tatu_call *call, uint32_t i, uint64_t *n) {
  *n = call->args[i].u.s.len;
  return call->args[i].u.s.ptr;
}

// One entry of a map.
static tatu_pair entry(const char *key, tatu_value value) {
  tatu_pair pair = {tatu_string(key), value};
  return pair;
}

// ---------------------------------------------------------------- (3) The commands ----------------------------------
// The host has checked the arguments against the tables of section 4: their number and types can be relied on.

// example.describe(number, text, table, function): arguments of several types, a call back, a table as result.
static tatu_status TATU_CALL describe(tatu_call *call) {
  const plugin *self = call->self;
  double number = tatu_arg_float(call, 0);
  tatu_str text = tatu_arg_text(call, 1);
  uint64_t n;
  const double *table = numbers(call, 2, &n);
  tatu_func function = call->args[3].u.u;

  // Work: nothing that we return may point into the arguments, so all is copied.
  double sum = 0;
  double *scaled = tatu_keep(call, table, n * sizeof *table);
  char *name = tatu_keep(call, text.ptr, text.len);
  tatu_pair *map = call->api->alloc(call, 4 * sizeof *map);
  if (!scaled || !name || !map) return tatu_call_fail(call, TATU_ERR_SPACE, "no room for the results");
  for (uint64_t i = 0; i < n; i++) {
    sum += table[i];
    scaled[i] *= number;
  }

  // Call the script's function with the sum, and keep the first thing that it returns.
  tatu_value results[ROOM] = {{0}};
  tatu_value argument = tatu_float(sum);
  tatu_call frame = new_frame(&argument, 1, results);
  tatu_status status = self->commands->call_func(call->world, function, &frame);
  if (status < 0) return pass_on(call, status, frame.error);
  // What a nested call gave may be handed on, as long as nothing is released in between.
  tatu_value called = frame.n_results ? frame.results[0] : tatu_nil();

  // Results: a table, and how many numbers there were.
  map[0] = entry("name", tatu_span(TATU_TEXT, name, text.len));
  map[1] = entry("scaled", tatu_span(TATU_F64S, scaled, n));
  map[2] = entry("sum", tatu_float(sum));
  map[3] = entry("called", called);
  if ((status = tatu_return(call, tatu_span(TATU_MAP, map, 4))) < 0) return status;
  return tatu_return(call, tatu_int((int64_t)n));
}

// example.nextStep(): waits. The host calls this function twice: first to begin, later with `resume` set to go on.
static tatu_status TATU_CALL next_step(tatu_call *call) {
  const plugin *self = call->self;
  const instance *here = call->instance;
  if (!call->resume) {
    tatu_status status = call->api->wait(call, TATU_UNTIL_STEPS, 1, tatu_text(""), 1);
    return status < 0 ? status : TATU_WAIT; // refused where the caller cannot wait; the host reports that
  }
  double time;
  tatu_status status = self->scene->get_f64(call->world, 0, here->time_key, &time, 1);
  return status < 0 ? refused(call, status) : tatu_return(call, tatu_float(time));
}

// example.refuse(text): fails. Say what is wrong, add what to do, return the code.
static tatu_status TATU_CALL refuse(tatu_call *call) {
  call->error->say(call->error, TATU_ERR_ARGUMENT, tatu_arg_text(call, 0));
  call->error->add(call->error, TATU_PART_HELP, tatu_text("call example.count() instead, which never fails"), 0);
  return TATU_ERR_ARGUMENT;
}

// Pushes a body during the next physics step. Handles of scripts go to services as they are.
static tatu_status push_body(tatu_call *call, int64_t body, const double *force) {
  const plugin *self = call->self;
  tatu_status status = self->bodies->push(call->world, (tatu_object)body, force, NULL);
  return status < 0 ? refused(call, status) : TATU_OK;
}

// example.push(body, force): calls a service.
static tatu_status TATU_CALL push(tatu_call *call) {
  uint64_t n;
  return push_body(call, tatu_arg_int(call, 0), numbers(call, 1, &n));
}

// Finds the command that reads a sensor, again only when commands have come or gone. 0: there is none.
static uint32_t read_sensor_command(tatu_call *call) {
  const plugin *self = call->self;
  instance *here = call->instance;
  uint64_t generation = self->commands->generation(call->world);
  if (here->generation != generation) {
    here->read_sensor = self->commands->find(call->world, tatu_text("simReadProximitySensor"), &here->alias);
    here->generation = generation;
  }
  return here->read_sensor;
}

// example.pushWhenNear(sensor, body, distance, force): calls a command of another plugin, then a service.
static tatu_status TATU_CALL push_when_near(tatu_call *call) {
  const plugin *self = call->self;
  uint64_t n;
  const double *force = numbers(call, 3, &n);
  uint32_t found = read_sensor_command(call);
  if (!found) return tatu_call_fail(call, TATU_ERR_UNKNOWN, "no plugin offers simReadProximitySensor");

  // Call it. What its results point to lies in the world's arena from `mark` on, until we give it back.
  tatu_value results[ROOM] = {{0}};
  tatu_value argument = tatu_int(tatu_arg_int(call, 0));
  tatu_call frame = new_frame(&argument, 1, results);
  frame.command = found;
  frame.alias = ((instance *)call->instance)->alias;
  uint64_t mark = self->commands->mark(call->world);
  tatu_status status = self->commands->call(call->world, &frame);

  // The helpers that read arguments read results too: 1 and the distance, or only 0 (nothing seen) or -1 (not yet
  // measured).
  tatu_call answer = {.args = frame.results, .n_args = status < 0 ? 0 : frame.n_results};
  int seen = tatu_arg_int(&answer, 0) == 1 && tatu_has_arg(&answer, 1);
  double distance = tatu_arg_float(&answer, 1);
  self->commands->release(call->world, mark);
  if (status < 0) return pass_on(call, status, frame.error);

  // Act, and report what was done. Nothing seen: no distance.
  int is_near = seen && distance < tatu_arg_float(call, 2);
  if (is_near && (status = push_body(call, tatu_arg_int(call, 1), force)) < 0) return status;
  if ((status = tatu_return(call, tatu_int(is_near))) < 0) return status;
  return seen ? tatu_return(call, tatu_float(distance)) : TATU_OK;
}

// example.count(): uses the state. Each world counts for itself, and begins at 1 again when it is reset.
static tatu_status TATU_CALL count(tatu_call *call) {
  state *kept = call->state;
  return tatu_return(call, tatu_int(++kept->count));
}

// example.later(function): keeps a function. Without `retain` it would be gone when this call returns.
static tatu_status TATU_CALL later(tatu_call *call) {
  const plugin *self = call->self;
  instance *here = call->instance;
  tatu_func kept;
  tatu_status status = self->commands->retain(call->world, call->args[0].u.u, &kept);
  if (status < 0) return refused(call, status);
  if (here->kept) self->commands->drop(call->world, here->kept);
  here->kept = kept;
  return TATU_OK;
}

// example.fire(): calls the kept function and gives it up. It is taken out first: it may itself call example.later.
static tatu_status TATU_CALL fire(tatu_call *call) {
  const plugin *self = call->self;
  instance *here = call->instance;
  tatu_func kept = here->kept;
  if (!kept) {
    tatu_call_fail(call, TATU_ERR_MISSING, "there is no function to fire");
    call->error->add(call->error, TATU_PART_HELP, tatu_text("give one to example.later first"), 0);
    return TATU_ERR_MISSING;
  }
  here->kept = 0;
  tatu_value results[ROOM] = {{0}};
  tatu_call frame = new_frame(NULL, 0, results);
  tatu_status status = self->commands->call_func(call->world, kept, &frame); // TATU_ERR_GONE: its script has ended
  if (status < 0) pass_on(call, status, frame.error);
  self->commands->drop(call->world, kept);
  if (status < 0 || frame.n_results == 0) return status;
  return tatu_return(call, frame.results[0]);
}

// ---------------------------------------------------------------- (4) What is declared     -------------------------

// One line of a list of parameters or results. Both bounds 0: none at all.
#define PARAM_FULL(Type, Count, Key, Unit, Lowest, Highest, Text)                                                      \
  &(const tatu_param) {                                                                                                \
    .size = sizeof(tatu_param), .type = (Type), .count = (Count), .key = (Key), .unit = (Unit), .lowest = (Lowest),    \
    .highest = (Highest), .text = (Text)                                                                               \
  }
#define PARAM(Type, Key, Unit, Text) PARAM_FULL(Type, 0, Key, Unit, 0, 0, Text)
#define ANYTHING(Key, Text)                                                                                            \
  &(const tatu_param) { .size = sizeof(tatu_param), .flags = TATU_PARAM_ANY, .key = (Key), .text = (Text) }
#define VECTOR(Key, Unit, Text) PARAM_FULL(TATU_F64S, 3, Key, Unit, 0, 0, Text)
#define HANDLE(Key, Text) PARAM_FULL(TATU_I64, 0, Key, NULL, 0, 0xFFFFF, Text)

// A list of parameters or results. One without an entry is `NONE`.
#define LIST(...) (const tatu_param *const[]) { __VA_ARGS__, NULL }
#define NONE (const tatu_param *const[]) { NULL }

// A command under one name.
#define COMMAND(Call, Name, Params, Returns, Text, Example)                                                            \
  &(const tatu_command) {                                                                                              \
    .size = sizeof(tatu_command),                                                                                      \
    .names = (const tatu_name *const[]){&(const tatu_name){.size = sizeof(tatu_name), .name = PREFIX Name}, NULL},     \
    .call = (Call), .params = (Params), .returns = (Returns), .text = (Text), .example = (Example)                     \
  }

static const tatu_param *const describe_params[] = {
    PARAM(TATU_F64, "number", "m", "By what the table is multiplied."),
    PARAM(TATU_TEXT, "text", NULL, "Any text."),
    PARAM(TATU_F64S, "table", NULL, "Any number of numbers."),
    PARAM(TATU_FUNC, "function", NULL, "Is called with the sum of the table."),
    NULL,
};
static const tatu_param *const push_when_near_params[] = {
    HANDLE("sensor", "A proximity sensor."),
    HANDLE("body", "A dynamic shape."),
    PARAM(TATU_F64, "distance", "m", "Nearer than this, the body is pushed."),
    VECTOR("force", "N", "In the world's frame, at the centre of mass."),
    NULL,
};

static const tatu_command *const commands[] = {
    COMMAND(describe, "describe", describe_params,
            LIST(PARAM(TATU_MAP, "about", NULL, "name, scaled, sum and called: what the function returned."),
                 PARAM(TATU_I64, "numbers", NULL, "How many numbers the table holds.")),
            "Tells about its arguments.",
            "about, n = example.describe(2, 'arm', {1, 2, 3}, function(sum) return sum / 2 end)"),
    COMMAND(next_step, "nextStep", NONE,
            LIST(PARAM(TATU_F64, "time", "s", "Simulation time after the wait.")),
            "Waits until the next step.", "t = example.nextStep()"),
    COMMAND(refuse, "refuse", LIST(PARAM(TATU_TEXT, "text", NULL, "The message of the error.")), NONE,
            "Fails with a message.", "ok, message = pcall(example.refuse, 'not today')"),
    COMMAND(push_when_near, "pushWhenNear", push_when_near_params,
            LIST(PARAM(TATU_I64, "pushed", NULL, "1 or 0."),
                 PARAM(TATU_F64, "measured", "m", "Distance seen; absent if nothing is seen.")),
            "Pushes a body if a proximity sensor sees something near.",
            "pushed, seen = example.pushWhenNear(sensor, body, 0.5, {0, 0, 10})"),
    COMMAND(push, "push",
            LIST(HANDLE("body", "A dynamic shape."),
                 VECTOR("force", "N", "In the world's frame, at the centre of mass.")),
            NONE, "Pushes a body during the next physics step.", "example.push(body, {0, 0, 10})"),
    COMMAND(count, "count", NONE, LIST(PARAM(TATU_I64, "count", NULL, "How often, this call included.")),
            "Counts its calls in this world.", "n = example.count()"),
    COMMAND(later, "later", LIST(PARAM(TATU_FUNC, "function", NULL, "What example.fire will call.")), NONE,
            "Keeps a function for example.fire, in place of the one kept before.",
            "example.later(function() return 'now' end)"),
    COMMAND(fire, "fire", NONE,
            LIST(ANYTHING("returned", "First result of the function.")),
            "Calls the function that example.later kept, once.", "value = example.fire()"),
    NULL,
};

// ---------------------------------------------------------------- (5) What you need ---------------------------------

// Without the first three the plugin is not loaded; with the log, the host's own messages are passed on.
static const tatu_need *const needs[] = {
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_COMMANDS},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_BODIES},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_SCENE},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_LOG, .optional = 1},
    NULL,
};

// Starts the plugin: takes the tables of the services and looks whether all that is used is there.
static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  plugin *made = calloc(1, sizeof *made);
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->host = host;
  made->commands = host->service(host, TATU_HOST_COMMANDS);
  made->bodies = host->service(host, TATU_HOST_BODIES);
  made->scene = host->service(host, TATU_HOST_SCENE);
  made->log = host->service(host, TATU_HOST_LOG);
  if (!TATU_HAS(made->commands, find) || !TATU_HAS(made->commands, call) || !TATU_HAS(made->commands, generation) ||
      !TATU_HAS(made->commands, mark) || !TATU_HAS(made->commands, release) || !TATU_HAS(made->commands, retain) ||
      !TATU_HAS(made->commands, drop) || !TATU_HAS(made->commands, call_func) || !TATU_HAS(made->bodies, push) ||
      !TATU_HAS(made->scene, prop) || !TATU_HAS(made->scene, get_f64)) {
    free(made);
    return tatu_fail(error, TATU_ERR_UNSUPPORTED, "the host lacks a function that this plugin calls");
  }
  *self = made;
  return TATU_OK;
}

// Ends the plugin.
static void TATU_CALL end(void *self) { free(self); }

// A world begins: makes the instance.
static tatu_status TATU_CALL begin_world(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  const plugin *of = self;
  instance *made = calloc(1, sizeof *made);
  (void)given; // holds the world and the state block
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->time_key = of->scene->prop(of->host, "scene.time");
  made->generation = UINT64_MAX; // of no commands: they are looked up at the first use
  *data = made;
  return TATU_OK;
}

// A world ends. The functions of its scripts have ended before it.
static void TATU_CALL end_world(void *data) { free(data); }

// A snapshot is taken: the state is saved by the host, a kept function cannot be.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  const instance *here = data;
  (void)writer; // nothing else to write
  return here->kept ? tatu_fail(error, TATU_ERR_UNSUPPORTED, "a function waits for example.fire") : TATU_OK;
}

// What is made and ended with each world.
static const tatu_life per_world = {
    .size = sizeof(tatu_life),
    .state_bytes = sizeof(state),
    .create = begin_world,
    .destroy = end_world,
    .save = save,
};

static const tatu_ext_command command_extension = {
    .size = sizeof(tatu_ext_command),
    .commands = commands,
    .per_world = &per_world,
};

// What the plugin offers: commands, and nothing else.
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_COMMAND) == 0 ? &command_extension : NULL;
}

// The one thing that the library exports.
TATU_EXPORT const tatu_plugin_t tatu_plugin = {
    .size = sizeof(tatu_plugin_t),
    .abi_major = TATU_ABI_MAJOR,
    .abi_minor = TATU_ABI_MINOR,
    .id = PLUGIN_ID,
    .name = PLUGIN_NAME,
    .version = PLUGIN_VERSION,
    .licence = PLUGIN_LICENCE,
    .needs = needs,
    .init = init,
    .shutdown = end,
    .extension = extension,
};
