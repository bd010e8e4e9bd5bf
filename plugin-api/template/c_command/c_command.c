// A Tatu plugin in one C file: commands for scripts. Copy it, and change the sections (1) to (4).
//
// Build: cc -std=c11 -shared -fPIC -I../../include -o libtatu_c_command.so c_command.c
// Try:   TATU_PLUGIN_PATH=. tatu list commands
//
// The host uses this file from the bottom up: TATU_PLUGIN in section 4, then the tables of section 3, and finally the
// commands of section 2. The header documents all names that begin with tatu_.

#include "tatu.h"

#define PREFIX "example." // prefix of all command names: choose one that is unique

// ---------------------------------------------------------------- (1) Stored data -----------------------------------

// `call->self` points to the tables of the host. All worlds and their threads share it, so it must not change. Each
// world also has an instance, for data that can be looked up again (ids of commands) or that cannot be saved.
typedef struct instance {
  uint64_t generation;  // commands.generation when `read_sensor` was looked up
  uint32_t read_sensor; // id of the command simReadProximitySensor; 0: there is no such command
  uint32_t alias;       // index of this name among the command's names
  tatu_func kept;       // the function that example.later retained; 0: none
} instance;

// The state of a world, in memory of the host, which saves, restores and zeroes it with the world. It must not contain
// pointers.
typedef struct state {
  int64_t count;
} state;

// ---------------------------------------------------------------- (2) The commands ----------------------------------
// The host has checked the arguments against the tables of section 3, so their number and types are as declared. A
// service that fails sets the error, which the host passes on, so `return status;` is sufficient.

// example.describe(number, text, table, function): arguments of several types, a callback, and a table as result.
static tatu_status TATU_CALL describe(tatu_call *call) {
  double number = tatu_arg_float(call, 0), sum = 0;
  uint64_t n;
  const double *table = tatu_arg_floats(call, 2, &n);

  // Results must not point into the arguments, so they are copied; this copy is also modified.
  double *scaled = tatu_keep(call, table, n * sizeof *table);
  if (!scaled) return tatu_call_fail(call, TATU_ERR_SPACE, "no room for the results");
  for (uint64_t i = 0; i < n; i++) {
    sum += table[i];
    scaled[i] *= number;
  }

  // The first result of the script's function may be returned, because memory of nested calls is valid until it is
  // released.
  tatu_value called;
  tatu_status status = tatu_call_func(call->self, call->world, call->error, tatu_arg_func(call, 3),
                                      TATU_VALUES(tatu_float(sum)), &called);
  if (status < 0) return status;

  // The results are a table and the number of elements.
  tatu_value about = tatu_map();
  tatu_put(call, &about, "name", tatu_copy_text(call, tatu_arg_text(call, 1)));
  tatu_put(call, &about, "scaled", tatu_span(TATU_F64S, scaled, n));
  tatu_put(call, &about, "sum", tatu_float(sum));
  tatu_put(call, &about, "called", called);
  return tatu_return_values(call, TATU_VALUES(about, tatu_int((int64_t)n)));
}

// example.nextStep(): waits for a step. The host calls this function twice: first with `resume` 0, and after the wait
// with the value that was passed to `wait`. If the caller cannot wait, `wait` fails and sets the error.
static tatu_status TATU_CALL next_step(tatu_call *call) {
  if (!call->resume) return call->api->wait(call, TATU_UNTIL_STEPS, 1, tatu_text(""), 1);
  return tatu_return(call, tatu_float(tatu_time(call->self, call->world)));
}

// example.refuse(text): fails. It sets the error's message, adds a help text, and returns the error's code.
static tatu_status TATU_CALL refuse(tatu_call *call) {
  call->error->say(call->error, TATU_ERR_ARGUMENT, tatu_arg_text(call, 0));
  call->error->add(call->error, TATU_PART_HELP, tatu_text("call example.count() instead, which never fails"), 0);
  return TATU_ERR_ARGUMENT;
}

// example.push(body, force): calls a service. Services accept handles of scripts.
static tatu_status TATU_CALL push(tatu_call *call) {
  const tatu_host_api *host = call->self;
  uint64_t n;
  return host->bodies->push(call->world, tatu_arg_object(call, 0), tatu_arg_floats(call, 1, &n), NULL);
}

// Returns the id of the command simReadProximitySensor, or 0. It is looked up again only when commands have changed.
static uint32_t read_sensor_command(tatu_call *call) {
  const tatu_host_commands *commands = ((const tatu_host_api *)call->self)->commands;
  instance *here = call->instance;
  uint64_t generation = commands->generation(call->world);
  if (here->generation != generation) {
    here->read_sensor = commands->find(call->world, tatu_text("simReadProximitySensor"), &here->alias);
    here->generation = generation;
  }
  return here->read_sensor;
}

// example.pushWhenNear(sensor, body, distance, force): calls a command of another plugin, then a service. For a single
// call of which only the first result is needed, tatu_call_command is shorter.
static tatu_status TATU_CALL push_when_near(tatu_call *call) {
  const tatu_host_api *host = call->self;
  uint32_t found = read_sensor_command(call);
  if (!found) return tatu_call_fail(call, TATU_ERR_UNKNOWN, "no plugin offers simReadProximitySensor");

  // The results of the command point to memory in the world's arena after `mark`, until it is released. The command
  // cannot wait, because the frame has no wait token.
  tatu_value results[16] = {{0}};
  tatu_call frame = tatu_frame(TATU_VALUES(tatu_handle(tatu_arg_object(call, 0))), results, 16);
  frame.command = found;
  frame.alias = ((instance *)call->instance)->alias;
  uint64_t mark = host->commands->mark(call->world);
  tatu_status status = host->commands->call(call->world, &frame);
  // The results are 1 and the distance, or only 0 (nothing detected) or -1 (not yet measured).
  int seen = status >= 0 && frame.n_results > 1 && tatu_to_float(results[0]) == 1 && results[1].tag != TATU_NIL;
  double distance = tatu_to_float(results[1]);
  host->commands->release(call->world, mark);
  if (status < 0) return tatu_fail_as(call->error, status, frame.error);

  // The second result, the distance, is omitted if nothing was detected.
  uint64_t n;
  int is_near = seen && distance < tatu_arg_float(call, 2);
  if (is_near) status = host->bodies->push(call->world, tatu_arg_object(call, 1), tatu_arg_floats(call, 3, &n), NULL);
  if (status < 0) return status;
  tatu_return(call, tatu_int(is_near));
  return seen ? tatu_return(call, tatu_float(distance)) : TATU_OK;
}

// example.count(): uses the state. Each world has its own counter, which restarts at 1 after a reset.
static tatu_status TATU_CALL count(tatu_call *call) {
  state *kept = call->state;
  return tatu_return(call, tatu_int(++kept->count));
}

// example.later(function): retains a function, which would otherwise be invalid when this call returns.
static tatu_status TATU_CALL later(tatu_call *call) {
  const tatu_host_api *host = call->self;
  instance *here = call->instance;
  tatu_func kept;
  tatu_status status = host->commands->retain(call->world, tatu_arg_func(call, 0), &kept);
  if (status < 0) return status;
  if (here->kept) host->commands->drop(call->world, here->kept);
  here->kept = kept;
  return TATU_OK;
}

// example.fire(): calls the retained function and drops it. The instance is cleared first, because the function may
// call example.later.
static tatu_status TATU_CALL fire(tatu_call *call) {
  const tatu_host_api *host = call->self;
  instance *here = call->instance;
  tatu_func kept = here->kept;
  if (!kept)
    return tatu_call_fail_help(call, TATU_ERR_MISSING, "there is no function to fire", "pass one to example.later first");
  here->kept = 0;
  tatu_value result;
  tatu_status status = tatu_call_func(host, call->world, call->error, kept, NULL, 0, &result);
  host->commands->drop(call->world, kept); // also if the call failed
  return status < 0 ? status : tatu_return(call, result);
}

// ---------------------------------------------------------------- (3) Declarations ---------------------------------

// Declares a command with a single name.
#define COMMAND(Call, Name, Params, Returns, Text, Example)                                                            \
  TATU_TABLE(tatu_command, .names = TATU_NAME(PREFIX Name), .call = (Call), .params = (Params), .returns = (Returns),  \
             .text = (Text), .example = (Example), .subject = "examples")
#define FORCE TATU_PARAM(TATU_F64S, "force", "N", "Force at the centre of mass, world frame.", .count = 3)

static const tatu_command *const commands[] = {
  COMMAND(describe, "describe",
    TATU_PARAMS(TATU_PARAM(TATU_F64, "number", "m", "Factor by which the table is multiplied."),
                TATU_PARAM(TATU_TEXT, "text", NULL, "Any text."),
                TATU_PARAM(TATU_F64S, "table", NULL, "Any number of numbers."),
                TATU_PARAM(TATU_FUNC, "function", NULL, "Called with the sum of the table.")),
    TATU_PARAMS(TATU_PARAM(TATU_MAP, "about", NULL, "name, scaled, sum and called."),
                TATU_PARAM(TATU_I64, "numbers", NULL, "Number of elements of the table.")),
    "Describes its arguments.",
    "about, n = example.describe(2, 'arm', {1, 2, 3}, function(sum) return sum / 2 end)"),
  COMMAND(next_step, "nextStep", NULL, TATU_PARAMS(TATU_PARAM(TATU_F64, "time", "s", "Simulation time after the wait.")),
    "Waits until the next step.", "t = example.nextStep()"),
  COMMAND(refuse, "refuse", TATU_PARAMS(TATU_PARAM(TATU_TEXT, "text", NULL, "The message of the error.")), NULL,
    "Fails with a message.", "ok, message = pcall(example.refuse, 'not today')"),
  COMMAND(push, "push", TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "body", NULL, "A dynamic shape."), FORCE), NULL,
    "Pushes a body during the next physics step.", "example.push(body, {0, 0, 10})"),
  COMMAND(push_when_near, "pushWhenNear",
    TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "sensor", NULL, "A proximity sensor."),
                TATU_PARAM(TATU_OBJECT, "body", NULL, "A dynamic shape."),
                TATU_PARAM(TATU_F64, "distance", "m", "Maximum distance at which the body is pushed.", TATU_AT_LEAST(0)), FORCE),
    TATU_PARAMS(TATU_PARAM(TATU_I64, "pushed", NULL, "1 or 0."),
                TATU_PARAM(TATU_F64, "measured", "m", "Measured distance; absent if nothing is detected.")),
    "Pushes a body if a proximity sensor detects something near.",
    "pushed, seen = example.pushWhenNear(sensor, body, 0.5, {0, 0, 10})"),
  COMMAND(count, "count", NULL, TATU_PARAMS(TATU_PARAM(TATU_I64, "count", NULL, "Number of calls, this one included.")),
    "Counts its calls in this world.", "n = example.count()"),
  COMMAND(later, "later", TATU_PARAMS(TATU_PARAM(TATU_FUNC, "function", NULL, "Called by example.fire.")), NULL,
    "Retains a function for example.fire, in place of an earlier one.", "example.later(function() return 'now' end)"),
  COMMAND(fire, "fire", NULL, TATU_PARAMS(TATU_PARAM_OF_ANY_TYPE("returned", "First result of the function.")),
    "Calls the function that example.later retained, once.",
    "example.later(function() return 'now' end)\nassert(example.fire() == 'now')"),
  NULL,
};

// Creates the instance of a world.
static tatu_status TATU_CALL begin_world(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self, (void)given; // not needed: the tables of the host; the world and the state block
  instance *here = tatu_new(sizeof *here, data, error);
  if (here) here->generation = UINT64_MAX; // forces a lookup at the first use
  return here ? TATU_OK : TATU_ERR_SPACE;
}

// Saves the instance for a snapshot. The host saves the state block; a retained function cannot be saved.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  const instance *here = data;
  (void)writer; // nothing else to write
  return here->kept ? tatu_fail(error, TATU_ERR_UNSUPPORTED, "a retained function cannot be saved") : TATU_OK;
}

// ---------------------------------------------------------------- (4) Identity and requirements of the plugin -------

TATU_PLUGIN(
  TATU_OFFER(TATU_COMMAND, tatu_ext_command, .commands = commands,
    .per_world = TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .create = begin_world, .destroy = tatu_delete,
                            .save = save, .load = tatu_load_nothing)),
  .id = "org.example.c_command", // unique: reversed domain and a name; scenes and messages use it
  .name = "Example commands in C", .version = "0.1.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_COMMANDS, TATU_NEED_BODIES, TATU_NEED_SCENE),
  .init = tatu_init_host_api, .shutdown = tatu_delete);
