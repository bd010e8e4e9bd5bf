// fleet: two commands for scripts that supervise many robots.
//   list = fleet.each(handles, function)            calls function(handle, {index =, count =}) for each handle
//   time = fleet.arrive(object, {x, y}, tolerance)  waits until the object is near the point, seen from above
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_fleet.so fleet.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60 --threads 2
#include "tatu/command.h"
#include "tatu/host.h"

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

// fleet.each: nothing is released in the world's arena, so the results of the function can be returned without a copy.
static tatu_status TATU_CALL each(tatu_call *call) {
  uint64_t n;
  const tatu_value *handles = tatu_arg_list(call, 0, &n);
  tatu_value answers = tatu_list(), answer;
  for (uint64_t i = 0; i < n; i++) {
    tatu_value about = tatu_map_of(TATU_ENTRIES(tatu_entry("index", tatu_int((int64_t)i + 1)),
                                                tatu_entry("count", tatu_int((int64_t)n))));
    tatu_status status = tatu_call_func(call->self, call->world, call->error, tatu_arg_func(call, 1),
                                        TATU_VALUES(handles[i], about), &answer);
    if (status < 0) return status;
    // A nil would shorten the table in Lua, so a missing result is replaced by false.
    tatu_add(call, &answers, answer.tag == TATU_NIL ? tatu_bool(0) : answer);
  }
  return tatu_return(call, answers);
}

// fleet.arrive: called once with arguments, and then in each step with the number of its journey. If a service fails,
// the host passes its error on to the caller.
static tatu_status TATU_CALL arrive(tatu_call *call) {
  const tatu_host_api *host = call->self;
  state *kept = call->state;
  journey *way;
  if (!call->resume) {
    uint64_t n;
    const double *goal = tatu_arg_floats(call, 1, &n);
    journey begun = {kept->last + 1, 0, goal[0], goal[1], tatu_arg_float(call, 2)};
    // The full id, with which lookups fail if the object is removed and its handle is reused.
    tatu_status status = host->scene->look(call->world, tatu_arg_object(call, 0), &begun.who, NULL);
    if (status < 0) return status;
    way = &kept->journeys[++kept->last % SLOTS];
    *way = begun;
  } else {
    way = &kept->journeys[call->resume % SLOTS];
    if (way->number != call->resume) return tatu_call_fail(call, TATU_ERR_GONE, "more than 64 calls wait for an arrival");
  }
  double at[7];
  tatu_status status = host->scene->pose(call->world, way->who, 0, at);
  if (status >= 0 && hypot(at[0] - way->x, at[1] - way->y) > way->tolerance)
    return call->api->wait(call, TATU_UNTIL_POLL, 0, tatu_text(""), way->number);
  way->number = 0;
  return status < 0 ? status : tatu_return(call, tatu_float(tatu_time(host, call->world)));
}

static const tatu_command each_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("fleet.each"), .call = each, .subject = "fleets",
  .params = TATU_PARAMS(TATU_PARAM(TATU_LIST, "handles", NULL, "Handles of objects."),
                        TATU_PARAM(TATU_FUNC, "function", NULL, "Called with a handle and {index, count}.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_LIST, "answers", NULL, "Results of the function; false for none.")),
  .text = "Calls a function for each of many objects.", .example = "assert(#fleet.each({}, print) == 0)"};
static const tatu_command arrive_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("fleet.arrive"), .call = arrive, .subject = "fleets",
  .params = TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "object", NULL, "The object that must arrive."),
                        TATU_PARAM(TATU_F64S, "goal", "m", "x and y in the world.", .count = 2),
                        TATU_PARAM(TATU_F64, "tolerance", "m", "Maximum distance from the point.", TATU_AT_LEAST(0))),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_F64, "time", "s", "Simulation time of the arrival.")),
  .text = "Waits until an object is near a point.", .no_wait = "call fleet.arrive in sysCall_thread",
  .example = "time = fleet.arrive(sim.createDummy(0.1), {0, 0}, 0.1)"};

// The data of a world is in its state block.
TATU_PLUGIN(TATU_COMMANDS_PER_WORLD(TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .version = 1),
                                    &each_command, &arrive_command),
  .id = "org.outside.fleet", .name = "Fleet", .version = "1.0.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_COMMANDS), .init = tatu_init_host_api, .shutdown = tatu_delete);
