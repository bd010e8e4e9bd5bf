// counter: a service that counts steps and the commands that it called, and publishes the number of steps as a signal.
//   at each barrier        sim.setInt32Signal('ticks', steps)
//   every `round` steps    publishes the event counter.round with {steps, commands}
// Snapshots contain the counts. At the end of the world, the service logs them. T: ../../../target/release/tatu
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_counter.so counter.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40 --threads 1       (or 2)
// Snapshot: TATU_PLUGIN_PATH=. $T run snapshot.toml --steps 40 --snapshot-at 1 half.snapshot
//           TATU_PLUGIN_PATH=. $T run snapshot.toml --steps 40 --from half.snapshot
// Error (exit code 1 is expected): TATU_PLUGIN_PATH=. $T run scene.toml --steps 40 --service counter:most=20
#include "tatu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct { // the host's services; constant after `init`
  const tatu_host *host;
  const tatu_host_commands *commands;
  const tatu_host_session *session;
  const tatu_host_log *log;
} plugin;

typedef struct { // the counts, in the host's state block; numbers only
  int64_t steps, commands, started;
} state;

typedef struct { // the running service
  const plugin *of;
  state *counted;
  int64_t round, most;
} service;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  service *it = calloc(1, sizeof *it);
  if (!it) return tatu_fail(error, TATU_ERR, "out of memory");
  it->of = self;
  it->counted = given->state; // valid until `destroy`
  it->round = given->params[0].u.i;
  it->most = given->params[1].u.i;
  *data = it;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { free(data); }

// The state block contains everything that a snapshot needs. These two functions declare that there is nothing else.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  (void)data, (void)writer, (void)error;
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  (void)data, (void)bytes, (void)version, (void)error;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = sizeof(state), .create = create,
                               .destroy = destroy, .save = save, .load = load, .version = 1};

// Calls a command of the world by its name. Such calls are recorded in the input log, so a run can be replayed without
// this service.
static tatu_status command(service *it, tatu_world *world, const char *name, const tatu_value *args, uint32_t n,
                           tatu_error *error) {
  const tatu_host_commands *commands = it->of->commands;
  tatu_value results[16] = {{0}};
  tatu_call frame = tatu_frame(args, n, results, 16); // the wait token is 0: the command cannot wait
  frame.command = commands->find(world, tatu_text(name), &frame.alias);
  if (!frame.command) return tatu_fail(error, TATU_ERR_UNKNOWN, "the service calls a command that no plugin offers");
  uint64_t mark = commands->mark(world);
  tatu_status status = commands->call(world, &frame);
  commands->release(world, mark);
  if (status < 0) error->say(error, status, frame.error->text); // the text is not in the released memory
  if (status < 0) return status;
  it->counted->commands++;
  return TATU_GO; // equals TATU_OK (0)
}

// Called before each step except those that follow a stop, and also while time stands still; then it counts nothing.
static tatu_status TATU_CALL barrier(void *data, tatu_world *world, uint64_t step, tatu_error *error) {
  service *it = data;
  (void)step;
  if (it->of->session->state(world) != TATU_RUNNING) return TATU_GO;
  if (it->counted->steps >= it->most) {
    tatu_status status = tatu_fail(error, TATU_ERR, "the count has reached the limit `most`");
    error->add(error, TATU_PART_HELP, tatu_text("set a greater `most` for the service"), 0);
    return status; // the host reports the service and switches it off; the run continues
  }
  it->counted->steps++;
  tatu_value show[2] = {tatu_string("ticks"), tatu_int(it->counted->steps)};
  tatu_status status = command(it, world, "sim.setInt32Signal", show, 2, error);
  if (status < 0 || it->counted->steps % it->round != 0) return status;

  // This calls a command, not events.publish, because a replay does not repeat what services do through other tables.
  tatu_pair map[2] = {{tatu_string("steps"), tatu_int(it->counted->steps)},
                      {tatu_string("commands"), tatu_int(it->counted->commands)}};
  tatu_value emit[2] = {tatu_string("counter.round"), tatu_span(TATU_MAP, map, 2)};
  return command(it, world, "tatu.emit", emit, 2, error);
}

// Receives the events to which the service has subscribed.
static tatu_status TATU_CALL event(void *data, tatu_world *world, tatu_str name, const tatu_value *payload,
                                   tatu_error *error) {
  service *it = data;
  (void)world, (void)payload, (void)error;
  if (name.len == 7 && memcmp(name.ptr, "started", 7) == 0) it->counted->started++;
  return TATU_OK;
}

// Called at the end of the world, which can still be read but not changed.
static tatu_status TATU_CALL last(void *data, tatu_world *world, tatu_error *error) {
  const service *it = data;
  (void)error;
  char line[160];
  snprintf(line, sizeof line, "counted %lld steps, made %lld commands, saw %lld starts", (long long)it->counted->steps,
           (long long)it->counted->commands, (long long)it->counted->started);
  it->of->log->write(it->of->host, world, TATU_LOG_INFO, tatu_text(line));
  return TATU_OK;
}

// Declarations
#define PARAM(...) &(const tatu_param){.size = sizeof(tatu_param), __VA_ARGS__}
#define WHOLE(k, low, high, value, t) PARAM(.type = TATU_I64, .key = k, .lowest = low, .highest = high, \
                                            .fallback = {.tag = TATU_I64, .u.i = value}, .text = t)
static const tatu_param *const params[] = {
  WHOLE("round", 1, 1e6, 10, "Number of steps between two events."),
  WHOLE("most", 0, 1e12, 1000000, "Count at which the service fails."), NULL};
static const char *const told[] = {"started", NULL};
static const tatu_service kind = {.size = sizeof(tatu_service), .id = "counter", .params = params, .life = &life,
  .text = "Counts steps, and shows the count as the signal `ticks`.", .barrier = barrier, .event = event, .events = told,
  .last = last};
static const tatu_service *const kinds[] = {&kind, NULL};
static const tatu_ext_service offer = {.size = sizeof(tatu_ext_service), .services = kinds};

static const tatu_param *const event_fields[] = {PARAM(.type = TATU_I64, .key = "steps", .text = "Counted."),
                                                 PARAM(.type = TATU_I64, .key = "commands", .text = "Made."), NULL};
static const tatu_event round_event = {.size = sizeof(tatu_event), .name = "counter.round", .fields = event_fields,
  .text = "Published whenever `round` further steps have been counted."};
static const tatu_event *const events[] = {&round_event, NULL};
static const tatu_ext_event events_offer = {.size = sizeof(tatu_ext_event), .events = events};

#define NEED(t, i) &(const tatu_need){.size = sizeof(tatu_need), .id = i, .bytes = sizeof(t)}
static const tatu_need *const needs[] = {NEED(tatu_host_commands, TATU_HOST_COMMANDS),
  NEED(tatu_host_session, TATU_HOST_SESSION),
  NEED(tatu_host_log, TATU_HOST_LOG), NULL};

static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  plugin *made = calloc(1, sizeof *made);
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->host = host;
  made->commands = host->service(host, TATU_HOST_COMMANDS);
  made->session = host->service(host, TATU_HOST_SESSION);
  made->log = host->service(host, TATU_HOST_LOG);
  *self = made;
  return TATU_OK;
}
static void TATU_CALL end(void *self) { free(self); }
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  if (strcmp(id, TATU_SERVICE) == 0) return &offer;
  return strcmp(id, TATU_EVENT) == 0 ? &events_offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.outside.counter", .name = "Counter", .version = "1.0.0", .licence = "MIT",
  .needs = needs, .init = init, .shutdown = end, .extension = extension};
