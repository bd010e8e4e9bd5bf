// A Tatu plugin in one C file: commands for scripts. Copy it, and change the places numbered (1) to (5).
//
// Build: cc -std=c11 -shared -fPIC -I../../include -o libtatu_c_command.so c_command.c
// Try:   TATU_PLUGIN_PATH=. tatu list commands
//
// The host uses the file from the bottom up: `tatu_plugin`, then `init`, `extension`, the tables of section 4, and
// finally the commands of section 3. Everything that begins with tatu_ is documented in the header.

#include "tatu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- (1) Who you are -----------------------------------

#define PLUGIN_ID "org.example.c_command" // unique: reversed domain and a name; scenes and messages use it
#define PLUGIN_NAME "Example commands in C"
#define PLUGIN_VERSION "0.1.0"
#define PLUGIN_LICENCE "MIT"
#define PREFIX "example." // starts the names of all commands; choose one that no other plugin uses

// ---------------------------------------------------------------- (2) What you keep ---------------------------------

// The plugin. There is one per host, shared by all worlds and their threads, so it does not change after `init`.
typedef struct plugin {
  const tatu_host *host;
  const tatu_host_commands *commands;
  const tatu_host_bodies *bodies;
  const tatu_host_scene *scene;
  const tatu_host_log *log; // may be null: it is an optional need
} plugin;

// The instance. There is one per world; it contains what can be looked up again (keys, ids of commands) and what cannot
// be saved.
typedef struct instance {
  tatu_prop time_key;          // the key of the property "scene.time"
  uint64_t generation;         // of the registered commands when `read_sensor` was looked up
  uint32_t read_sensor;        // the id of simReadProximitySensor, 0 if no plugin offers it
  uint32_t alias;              // the index of that name among the names of the command
  tatu_func kept;              // the function that example.later was given; 0: none
} instance;

// The state. There is one per world, in memory of the host, which saves, restores and zeroes it with the world. It must
// contain plain numbers only, no pointers.
typedef struct state {
  int64_t count;
} state;

// ---------------------------------------------------------------- Helpers: keep them unchanged ----------------------

// Passes the error of a nested call or of a service on to the caller. `why` can be null.
static tatu_status pass_on(tatu_call *call, tatu_status status, const tatu_error *why) {
  if (why == call->error) return status;
  if (!TATU_HAS(why, code)) return tatu_call_fail(call, status, "refused by the host without a reason");
  call->error->say(call->error, status, why->text);
  if (why->help.len) call->error->add(call->error, TATU_PART_HELP, why->help, 0);
  if (why->file.len) call->error->add(call->error, TATU_PART_FILE, why->file, why->line);
  if (why->traceback.len) call->error->add(call->error, TATU_PART_TRACEBACK, why->traceback, 0);
  return status;
}

// Fails with the error that a service of the host has reported.
static tatu_status refused(tatu_call *call, tatu_status status) {
  const plugin *self = call->self;
  return pass_on(call, status, TATU_HAS(self->log, last_error) ? self->log->last_error(call->world) : NULL);
}

// The frame of a nested call with room for ROOM results; the host fills in the rest. Its wait_token is 0, so the called
// function cannot wait.
#define ROOM 16
static tatu_call new_frame(const tatu_value *args, uint32_t n_args, tatu_value *results) {
  tatu_call frame = {
      .size = sizeof frame, .args = args, .n_args = n_args, .results = results, .results_cap = ROOM};
  return frame;
}

// Returns the values of argument `i`, which is declared as F64S, and stores their count in `n`.
static const double *numbers(const tatu_call *call, uint32_t i, uint64_t *n) {
  *n = call->args[i].u.s.len;
  return call->args[i].u.s.ptr;
}

// Returns one entry of a map.
static tatu_pair entry(const char *key, tatu_value value) {
  tatu_pair pair = {tatu_string(key), value};
  return pair;
}

// ---------------------------------------------------------------- (3) The commands ----------------------------------
// The host has checked the count and the types of the arguments against the tables of section 4.

// example.describe(number, text, table, function): arguments of several types, a callback, and a table as result.
static tatu_status TATU_CALL describe(tatu_call *call) {
  const plugin *self = call->self;
  double number = tatu_arg_float(call, 0);
  tatu_str text = tatu_arg_text(call, 1);
  uint64_t n;
  const double *table = numbers(call, 2, &n);
  tatu_func function = call->args[3].u.u;

  // Results must not point into the arguments, so everything is copied.
  double sum = 0;
  double *scaled = tatu_keep(call, table, n * sizeof *table);
  char *name = tatu_keep(call, text.ptr, text.len);
  tatu_pair *map = call->api->alloc(call, 4 * sizeof *map);
  if (!scaled || !name || !map) return tatu_call_fail(call, TATU_ERR_SPACE, "no room for the results");
  for (uint64_t i = 0; i < n; i++) {
    sum += table[i];
    scaled[i] *= number;
  }

  // Calls the script's function with the sum and keeps its first result.
  tatu_value results[ROOM] = {{0}};
  tatu_value argument = tatu_float(sum);
  tatu_call frame = new_frame(&argument, 1, results);
  tatu_status status = self->commands->call_func(call->world, function, &frame);
  if (status < 0) return pass_on(call, status, frame.error);
  // A result of a nested call can be returned directly if nothing has been released since.
  tatu_value called = frame.n_results ? frame.results[0] : tatu_nil();

  // The results are a table and the count of the numbers.
  map[0] = entry("name", tatu_span(TATU_TEXT, name, text.len));
  map[1] = entry("scaled", tatu_span(TATU_F64S, scaled, n));
  map[2] = entry("sum", tatu_float(sum));
  map[3] = entry("called", called);
  if ((status = tatu_return(call, tatu_span(TATU_MAP, map, 4))) < 0) return status;
  return tatu_return(call, tatu_int((int64_t)n));
}

// example.nextStep(): waits for the next step. The host calls this function twice, the second time with `resume` set.
static tatu_status TATU_CALL next_step(tatu_call *call) {
  const plugin *self = call->self;
  const instance *here = call->instance;
  if (!call->resume) {
    tatu_status status = call->api->wait(call, TATU_UNTIL_STEPS, 1, tatu_text(""), 1);
    return status < 0 ? status : TATU_WAIT; // if the caller cannot wait, the host reports an error
  }
  double time;
  tatu_status status = self->scene->get_f64(call->world, 0, here->time_key, &time, 1);
  return status < 0 ? refused(call, status) : tatu_return(call, tatu_float(time));
}

// example.refuse(text): fails. An error consists of a code, a sentence on the cause, and a hint on what to do.
static tatu_status TATU_CALL refuse(tatu_call *call) {
  call->error->say(call->error, TATU_ERR_ARGUMENT, tatu_arg_text(call, 0));
  call->error->add(call->error, TATU_PART_HELP, tatu_text("call example.count() instead, which never fails"), 0);
  return TATU_ERR_ARGUMENT;
}

// Pushes a body during the next physics step. Services accept the handles that scripts use.
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

// Returns the id of the command that reads a sensor, or 0 if no plugin offers it. The command is looked up again only
// when commands have been added or removed.
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

  // The results point into the world's arena, behind `mark`, and are valid until that part is released below.
  tatu_value results[ROOM] = {{0}};
  tatu_value argument = tatu_int(tatu_arg_int(call, 0));
  tatu_call frame = new_frame(&argument, 1, results);
  frame.command = found;
  frame.alias = ((instance *)call->instance)->alias;
  uint64_t mark = self->commands->mark(call->world);
  tatu_status status = self->commands->call(call->world, &frame);

  // The helpers for arguments can also read results. These are 1 and the distance, or only 0 (nothing detected) or -1
  // (not measured yet).
  tatu_call answer = {.args = frame.results, .n_args = status < 0 ? 0 : frame.n_results};
  int seen = tatu_arg_int(&answer, 0) == 1 && tatu_has_arg(&answer, 1);
  double distance = tatu_arg_float(&answer, 1);
  self->commands->release(call->world, mark);
  if (status < 0) return pass_on(call, status, frame.error);

  // Pushes if the object is near, and returns whether it did. The distance is returned only if something was detected.
  int is_near = seen && distance < tatu_arg_float(call, 2);
  if (is_near && (status = push_body(call, tatu_arg_int(call, 1), force)) < 0) return status;
  if ((status = tatu_return(call, tatu_int(is_near))) < 0) return status;
  return seen ? tatu_return(call, tatu_float(distance)) : TATU_OK;
}

// example.count(): uses the state. Each world has its own count, which restarts at 1 when the world is reset.
static tatu_status TATU_CALL count(tatu_call *call) {
  state *kept = call->state;
  return tatu_return(call, tatu_int(++kept->count));
}

// example.later(function): keeps a function. Without `retain` it would be invalid after this call.
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

// example.fire(): calls the kept function and releases it. `kept` is cleared first because the function may itself call
// example.later.
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

// One parameter or result. If both bounds are 0, the value is not limited.
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

// A list of parameters or results. The empty list is `NONE`.
#define LIST(...) (const tatu_param *const[]) { __VA_ARGS__, NULL }
#define NONE (const tatu_param *const[]) { NULL }

// A command with a single name.
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

// Without the first three the plugin is not loaded. The log is optional; it provides the host's error messages.
static const tatu_need *const needs[] = {
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_COMMANDS},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_BODIES},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_SCENE},
    &(const tatu_need){.size = sizeof(tatu_need), .id = TATU_HOST_LOG, .optional = 1},
    NULL,
};

// Starts the plugin: stores the tables of the services and checks that they contain all functions that it calls.
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

// Creates the instance of a new world.
static tatu_status TATU_CALL begin_world(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  const plugin *of = self;
  instance *made = calloc(1, sizeof *made);
  (void)given; // holds the world and the state block
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->time_key = of->scene->prop(of->host, "scene.time");
  made->generation = UINT64_MAX; // matches no generation, so the first use looks the command up
  *data = made;
  return TATU_OK;
}

// Frees the instance of a world. The functions of the world's scripts have already been released.
static void TATU_CALL end_world(void *data) { free(data); }

// Called when a snapshot is taken. The host saves the state itself; a kept function cannot be saved.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  const instance *here = data;
  (void)writer; // nothing else to write
  return here->kept ? tatu_fail(error, TATU_ERR_UNSUPPORTED, "a function waits for example.fire") : TATU_OK;
}

// Functions that create, save and destroy the data of each world
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

// Returns the tables that the plugin offers: only commands.
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_COMMAND) == 0 ? &command_extension : NULL;
}

// The only symbol that the library exports
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
