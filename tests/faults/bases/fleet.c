// fleet: two commands for scripts that supervise many robots.
//   list = fleet.each(handles, function)            calls function(handle, {index =, count =}) for each handle
//   time = fleet.arrive(object, {x, y}, tolerance)  waits until the object is near the point, seen from above
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_fleet.so fleet.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60 --threads 2
#include "tatu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// The plugin: the host's services and the keys of properties. It does not change after `init`.
typedef struct {
  const tatu_host_scene *scene;
  const tatu_host_commands *commands;
  const tatu_host_log *log;
  tatu_prop time, position;
} plugin;

// The state of a world: the pending journeys. It consists of plain numbers, so the host can save and restore it.
// Journeys are numbered from 1; journey n is in slot n % SLOTS and overwrites the one that was there before.
enum { SLOTS = 64 };
typedef struct {
  uint64_t number; // 0: empty
  tatu_object who;
  double x, y, tolerance;
} journey;
typedef struct {
  uint64_t last;
  journey journeys[SLOTS];
} state;

// Passes the error of a nested call or of a service on to the caller.
static tatu_status pass_on(tatu_call *call, tatu_status status, const tatu_error *why) {
  if (why == call->error) return status;
  call->error->say(call->error, status, why->text);
  if (why->help.len) call->error->add(call->error, TATU_PART_HELP, why->help, 0);
  if (why->file.len) call->error->add(call->error, TATU_PART_FILE, why->file, why->line);
  if (why->traceback.len) call->error->add(call->error, TATU_PART_TRACEBACK, why->traceback, 0);
  return status;
}

static tatu_status refused(tatu_call *call, tatu_status status) {
  return pass_on(call, status, ((const plugin *)call->self)->log->last_error(call->world));
}

// fleet.each: everything is allocated in the world's arena and nothing is released, so the results of the function can
// be returned without a copy.
static tatu_status TATU_CALL each(tatu_call *call) {
  const plugin *self = call->self;
  const tatu_value *handles = call->args[0].u.s.ptr;
  uint64_t n = call->args[0].u.s.len;
  tatu_value *answers = call->api->alloc(call, (n ? n : 1) * sizeof *answers);
  if (!answers) return tatu_call_fail(call, TATU_ERR_SPACE, "no room for the answers");
  for (uint64_t i = 0; i < n; i++) {
    tatu_pair about[2] = {{tatu_string("index"), tatu_int((int64_t)i + 1)}, {tatu_string("count"), tatu_int((int64_t)n)}};
    tatu_value args[2] = {handles[i], tatu_span(TATU_MAP, about, 2)}, results[16] = {{0}};
    tatu_call frame = tatu_frame(args, 2, results, 16);
    tatu_status status = self->commands->call_func(call->world, tatu_arg_func(call, 1), &frame);
    if (status < 0) return pass_on(call, status, frame.error);
    // A nil would shorten the table in Lua, so a missing result is replaced by false.
    answers[i] = frame.n_results && results[0].tag != TATU_NIL ? results[0] : tatu_bool(0);
  }
  return tatu_return(call, tatu_span(TATU_LIST, answers, n));
}

// fleet.arrive: called once with arguments, and then in each step with the number of its journey.
static tatu_status TATU_CALL arrive(tatu_call *call) {
  const plugin *self = call->self;
  state *kept = call->state;
  journey *way;
  if (!call->resume) {
    uint64_t n;
    const double *goal = tatu_arg_floats(call, 1, &n);
    journey begun = {kept->last + 1, 0, goal[0], goal[1], tatu_arg_float(call, 2)};
    // The full id, with which lookups fail if the object is removed and its handle is reused.
    tatu_status status = self->scene->look(call->world, tatu_arg_object(call, 0), &begun.who, NULL);
    if (status < 0) return refused(call, status);
    way = &kept->journeys[++kept->last % SLOTS];
    *way = begun;
  } else {
    way = &kept->journeys[call->resume % SLOTS];
    if (way->number != call->resume) return tatu_call_fail(call, TATU_ERR_GONE, "more than 64 journeys are waited for");
  }
  double at[7], time;
  tatu_status status = self->scene->pose(call->world, way->who, 0, at);
  if (status >= 0) status = self->scene->get_f64(call->world, 0, self->time, &time, 1);
  if (status >= 0 && hypot(at[0] - way->x, at[1] - way->y) > way->tolerance)
    return call->api->wait(call, TATU_UNTIL_POLL, 0, tatu_text(""), way->number);
  way->number = 0;
  return status < 0 ? refused(call, status) : tatu_return(call, tatu_float(time));
}

// Declarations. A parameter has a size, type, count, flags, key, unit, bounds and text.
#define PARAM(...) &(const tatu_param){.size = sizeof(tatu_param), __VA_ARGS__}
#define PARAMS(...) (const tatu_param *const[]){__VA_ARGS__, NULL}
#define NAMES(n) (const tatu_name *const[]){&(const tatu_name){.size = sizeof(tatu_name), .name = n}, NULL}

static const tatu_command each_command = {.size = sizeof(tatu_command), .names = NAMES("fleet.each"), .call = each,
  .params = PARAMS(PARAM(.type = TATU_LIST, .key = "handles", .text = "Handles of objects."),
                   PARAM(.type = TATU_FUNC, .key = "function", .text = "Gets a handle and {index, count}.")),
  .returns = PARAMS(PARAM(.type = TATU_LIST, .key = "answers", .text = "What it returned; false for nothing.")),
  .text = "Calls a function for each of many objects.",
  .example = "assert(#fleet.each({}, print) == 0)", .subject = "fleets"};
static const tatu_command arrive_command = {.size = sizeof(tatu_command), .names = NAMES("fleet.arrive"), .call = arrive,
  .params = PARAMS(PARAM(.type = TATU_OBJECT, .key = "object", .text = "Who is waited for."),
                   PARAM(.type = TATU_F64S, .count = 2, .key = "goal", .unit = "m", .text = "x and y in the world."),
                   PARAM(.type = TATU_F64, .key = "tolerance", .unit = "m", .lowest = 0, .highest = HUGE_VAL,
                         .text = "How near is near.")),
  .returns = PARAMS(PARAM(.type = TATU_F64, .key = "time", .unit = "s", .text = "Simulation time of the arrival.")),
  .text = "Waits until an object is near a point.", .no_wait = "call fleet.arrive in sysCall_thread",
  .example = "time = fleet.arrive(sim.getObject('/robot'), {1, 2}, 0.1)", .subject = "fleets"};
static const tatu_command *const commands[] = {&each_command, &arrive_command, NULL};

static tatu_status TATU_CALL begin_world(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self, (void)given, (void)error;
  *data = NULL; // the data of a world is in the state block
  return TATU_OK;
}
static void TATU_CALL end_world(void *data) { (void)data; }
static const tatu_life per_world = {
  .size = sizeof(tatu_life), .state_bytes = sizeof(state), .create = begin_world, .destroy = end_world, .version = 1};
static const tatu_ext_command offer = {.size = sizeof(tatu_ext_command), .commands = commands, .per_world = &per_world};

#define NEED(t, i) &(const tatu_need){.size = sizeof(tatu_need), .id = i, .bytes = sizeof(t)}
static const tatu_need *const needs[] = {NEED(tatu_host_scene, TATU_HOST_SCENE),
  NEED(tatu_host_commands, TATU_HOST_COMMANDS), NEED(tatu_host_log, TATU_HOST_LOG), NULL};

static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  plugin *made = calloc(1, sizeof *made);
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->scene = host->service(host, TATU_HOST_SCENE);
  made->commands = host->service(host, TATU_HOST_COMMANDS);
  made->log = host->service(host, TATU_HOST_LOG);
  made->time = made->scene->prop(host, "scene.time");
  *self = made;
  return TATU_OK;
}
static void TATU_CALL end(void *self) { free(self); }
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_COMMAND) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.outside.fleet", .name = "Fleet", .version = "1.0.0", .licence = "MIT",
  .needs = needs, .init = init, .shutdown = end, .extension = extension};
