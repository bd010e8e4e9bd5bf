// my_plugin: a service in C. A separate thread waits for external events, queues them, and wakes the session. Between
// two steps, the service applies the queued events to the world. In this example the thread waits for the clock, and
// queues a tick every `period`. Replace it with your socket, device or bridge: see `listen`.
//   signal my_plugin.ticks   number of ticks received; the simulation waits until there are `wait_for` of them
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#define _POSIX_C_SOURCE 200809L // threads and clocks
#include "tatu/host.h"
#include "tatu/service.h"

#include <pthread.h>
#include <time.h>

enum { ROOM = 256 };

// A running service. Members that both threads use are protected by the lock.
typedef struct {
  const tatu_host_api *host;
  tatu_session *session;
  double period;
  int64_t wait_for, ticks; // used only by the session's thread
  pthread_t thread;
  pthread_mutex_t lock;
  pthread_cond_t changed;
  int ending;
  int64_t queue[ROOM]; // ticks that have not been applied yet, a ring buffer
  unsigned first, n;
} service;

// Runs on the service's own thread, which may call only two functions of the host: `wake`, and `write` of the log.
static void *listen(void *data) {
  service *it = data;
  pthread_mutex_lock(&it->lock);
  for (int64_t tick = 1; !it->ending; tick++) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    double at = (double)until.tv_nsec / 1e9 + it->period;
    until.tv_sec += (time_t)at;
    until.tv_nsec = (long)((at - (double)(time_t)at) * 1e9);
    while (!it->ending && pthread_cond_timedwait(&it->changed, &it->lock, &until) == 0) {}
    if (it->ending) break;
    if (it->n == ROOM) continue; // the queue is full: discard this tick
    it->queue[(it->first + it->n++) % ROOM] = tick;
    it->host->session->wake(it->session);
  }
  pthread_mutex_unlock(&it->lock);
  return NULL;
}

// Removes the oldest tick from the queue. Returns 0 if the queue is empty.
static int take(service *it, int64_t *tick) {
  pthread_mutex_lock(&it->lock);
  int some = it->n > 0;
  if (some) {
    *tick = it->queue[it->first];
    it->first = (it->first + 1) % ROOM;
    it->n--;
  }
  pthread_mutex_unlock(&it->lock);
  return some;
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  service *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  it->session = given->session;
  it->period = given->params[0].u.f;
  it->wait_for = given->params[1].u.i;
  pthread_mutex_init(&it->lock, NULL);
  pthread_cond_init(&it->changed, NULL);
  if (pthread_create(&it->thread, NULL, listen, it) == 0) return TATU_OK;
  tatu_delete(it);
  return tatu_fail(error, TATU_ERR, "cannot start a thread");
}

// Called when the session ends. The thread must have ended when this returns.
static void TATU_CALL destroy(void *data) {
  service *it = data;
  pthread_mutex_lock(&it->lock);
  it->ending = 1;
  pthread_cond_signal(&it->changed);
  pthread_mutex_unlock(&it->lock);
  pthread_join(it->thread, NULL);
  pthread_cond_destroy(&it->changed);
  pthread_mutex_destroy(&it->lock);
  tatu_delete(it);
}

// Runs between two steps, and must never block. Its calls to commands are recorded in the input log, so that a run can
// be replayed without the service.
static tatu_status TATU_CALL barrier(void *data, tatu_world *world, uint64_t step, tatu_error *error) {
  service *it = data;
  (void)step;
  for (int64_t tick; take(it, &tick);) {
    tatu_value result;
    it->ticks = tick;
    tatu_status status = tatu_call_command(it->host, world, error, "sim.setInt32Signal",
      TATU_VALUES(tatu_string("my_plugin.ticks"), tatu_int(tick)), &result);
    if (status < 0) return status;
  }
  return it->ticks < it->wait_for ? TATU_HOLD : TATU_GO;
}

static const tatu_service offered = {
  .size = sizeof(tatu_service), .id = "my_plugin", .text = "Counts ticks of the clock in a signal.", .barrier = barrier,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "period", "s", "Real time between two ticks.", TATU_RANGE(0.001, 60), TATU_DEFAULT_F64(0.01)),
    TATU_PARAM(TATU_I64, "wait_for", NULL, "The simulation waits for this many ticks.", TATU_AT_LEAST(0), TATU_DEFAULT_I64(1))),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = destroy, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_SERVICES(&offered), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0",
  .licence = "MIT", .needs = TATU_NEEDS(TATU_NEED_COMMANDS, TATU_NEED_SESSION), .init = tatu_init_host_api,
  .shutdown = tatu_delete);
