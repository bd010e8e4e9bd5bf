/* A plugin that breaks the contract. The argument of its command selects how; for its actuator and sensor, environment
 * variables BREACH_OF_* do. */
#define _GNU_SOURCE
#include "tatu.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

typedef struct {
  const tatu_host *host;
  const tatu_host_scene *scene;
  const tatu_host_log *log;
} plugin;

static int is(tatu_call *c, const char *how) {
  tatu_str t = tatu_arg_text(c, 0);
  return t.len == strlen(how) && memcmp(t.ptr, how, t.len) == 0;
}

static struct { const plugin *me; tatu_world *world; } stray;
static void *asks(void *unused) {
  double pose[7];
  stray.me->scene->pose(stray.world, 0, 0, pose);
  return unused;
}
static void waits_for_ever(void) { for (;;) sleep(1); }

static tatu_status TATU_CALL now(tatu_call *c) {
  plugin *me = c->self;
  if (is(c, "one result too many")) c->results[c->results_cap] = tatu_int(5);
  if (is(c, "results twice")) for (uint32_t i = 0; i < c->results_cap; i++) c->results[c->results_cap + i] = tatu_int(5);
  if (is(c, "before the results")) c->results[-1] = tatu_int(5);
  if (is(c, "past alloc")) memset((char *)c->api->alloc(c, 64), 'A', 80);
  if (is(c, "past an argument")) memset((void *)(c->args[1].u.s.ptr), 0, 8 * c->args[1].u.s.len + 16);
  if (is(c, "before the state")) memset((char *)c->state - 8, 'A', 8);
  if (is(c, "past the state")) memset((char *)c->state + 16, 'A', 64);
  if (is(c, "huge span")) return tatu_return(c, tatu_span(TATU_F64S, c, 1ull << 60));
  if (is(c, "large span")) return tatu_return(c, tatu_span(TATU_TEXT, "x", 1ull << 31));
  if (is(c, "list in itself")) {
    tatu_value *v = c->api->alloc(c, sizeof *v);
    *v = tatu_span(TATU_LIST, v, 1);
    return tatu_return(c, *v);
  }
  if (is(c, "key that is no number")) {
    tatu_pair *p = c->api->alloc(c, sizeof *p);
    p->key = tatu_float(NAN), p->value = tatu_int(1);
    return tatu_return(c, tatu_span(TATU_MAP, p, 1));
  }
  if (is(c, "null list")) return tatu_return(c, tatu_span(TATU_MAP, tatu_keep(c, (tatu_value[]){{TATU_NIL}, tatu_span(TATU_LIST, NULL, 3)}, 48), 1));
  if (is(c, "unaligned")) return tatu_return(c, tatu_span(TATU_F64S, (char *)c->api->alloc(c, 64) + 1, 2));
#ifdef __x86_64__
  if (is(c, "direction")) __asm__ volatile("std");
#endif
  if (is(c, "folder")) return tatu_return(c, tatu_int(chdir("/")));
  if (is(c, "signal")) signal(SIGUSR1, SIG_IGN);
  if (is(c, "signal of children")) signal(SIGCHLD, SIG_IGN);
  if (is(c, "output")) close(1);
  if (is(c, "fork")) return tatu_return(c, tatu_int(fork() >= 0));
  if (is(c, "timer")) {
    struct itimerval t = {{0, 0}, {0, 20000}};
    setitimer(ITIMER_REAL, &t, NULL);
    pause();
  }
  if (is(c, "thread")) {
    pthread_t one;
    stray.me = me, stray.world = c->world;
    pthread_create(&one, NULL, asks, NULL);
    pthread_join(one, NULL);
  }
  if (is(c, "end")) atexit(waits_for_ever);
  if (is(c, "log")) me->log->write(me->host, c->world, 99, tatu_text("x\033[2J")), me->log->write(me->host, c->world, TATU_LOG_STATUS, tatu_text("y\033[2J"));
  return tatu_return(c, tatu_int(1));
}

static tatu_status TATU_CALL make(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self, (void)given, (void)error;
  *data = NULL;
  return TATU_OK;
}
static void TATU_CALL end(void *data) { (void)data; }
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = 16, .create = make, .destroy = end};

static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *b, tatu_error *error) {
  const char *how = getenv("BREACH_OF_ACTUATOR");
  (void)self, (void)error;
  if (!how) return TATU_OK;
  if (!strcmp(how, "one force too many")) b->wrench[6 * b->n] = 1e3;
  if (!strcmp(how, "64 forces too many")) for (int i = 0; i < 64; i++) b->wrench[6 * b->n + i] = 1e3;
  if (!strcmp(how, "before the forces")) b->wrench[-1] = 1e3;
  if (!strcmp(how, "effort")) b->effort[b->n] = 1e3;
  if (!strcmp(how, "command")) ((double *)b->command[0])[0] = 77;
  if (!strcmp(how, "past the command")) for (int i = 0; i < 64; i++) ((double *)b->command[0])[i] = 77;
  if (!strcmp(how, "status")) b->status[0] = 9;
  if (!strcmp(how, "past the status")) b->status[b->n] = -1;
  if (!strcmp(how, "before the state")) memset((char *)b->state[0] - 16, 'A', 16);
  if (!strcmp(how, "past the state")) memset((char *)b->state[0] + 16, 'A', 8);
  return TATU_OK;
}

static tatu_status TATU_CALL beams(void *data, tatu_beams *b, tatu_error *error) {
  (void)data, (void)error;
  if (getenv("BREACH_OF_BEAMS")) memset(b + 1, 'A', 8);
  return TATU_OK;
}
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *b, tatu_error *error) {
  const char *how = getenv("BREACH_OF_SENSOR");
  (void)self, (void)error;
  if (how && !strcmp(how, "past the status")) b->status[b->n] = -1;
  if (how && !strcmp(how, "before the field")) ((double *)b->fields[0])[-1] = 1;
  if (how && !strcmp(how, "past the field")) ((double *)b->fields[0])[1] = 1;
  return TATU_OK;
}

static tatu_status TATU_CALL build(void *self, const tatu_builder *to, const tatu_value *params, tatu_error *error) {
  (void)self, (void)params, (void)error;
  to->object(to, "dummy", 0, tatu_text("base"));
  to->mesh(to, NULL, 3, (uint32_t[]){0, 1, 2}, 1);
  return TATU_OK;
}

static const tatu_name name = {.size = sizeof(tatu_name), .name = "breach.now"};
static const tatu_command command = {.size = sizeof(tatu_command), .flags = TATU_COMMAND_RAW, .names = (const tatu_name *const[]){&name, NULL},
  .text = "Breaks the contract.", .call = now};
static const tatu_ext_command commands = {.size = sizeof(tatu_ext_command), .commands = (const tatu_command *const[]){&command, NULL}, .per_world = &life};
static const tatu_param throttle = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "throttle", .text = "Nothing.", .fallback = {.tag = TATU_F64}};
static const tatu_actuator actuator = {.size = sizeof(tatu_actuator), .n_commands = 1, .id = "breach", .text = "Breaks the contract.",
  .commands = (const tatu_param *const[]){&throttle, NULL}, .life = &life, .apply = apply};
static const tatu_ext_actuator actuators = {.size = sizeof(tatu_ext_actuator), .kinds = (const tatu_actuator *const[]){&actuator, NULL}};
static const tatu_field field = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "breach.x", .text = "Nothing."};
static const tatu_sensor sensor = {.size = sizeof(tatu_sensor), .id = "breach_sensor", .text = "Breaks the contract.",
  .schemas = (const char *const[]){"breach/1", NULL}, .fields = (const tatu_field *const[]){&field, NULL}, .life = &life, .beams = beams, .measure = measure};
static const tatu_ext_sensor sensors = {.size = sizeof(tatu_ext_sensor), .kinds = (const tatu_sensor *const[]){&sensor, NULL}};
static const tatu_model model = {.size = sizeof(tatu_model), .id = "breach_model", .text = "Breaks the contract.", .build = build};
static const tatu_ext_model models = {.size = sizeof(tatu_ext_model), .models = (const tatu_model *const[]){&model, NULL}};

static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  static plugin me;
  (void)error;
  me.host = host, me.scene = host->service(host, TATU_HOST_SCENE), me.log = host->service(host, TATU_HOST_LOG);
  *self = &me;
  return TATU_OK;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  if (!strcmp(id, TATU_COMMAND)) return &commands;
  if (!strcmp(id, TATU_ACTUATOR)) return &actuators;
  if (!strcmp(id, TATU_SENSOR)) return &sensors;
  return strcmp(id, TATU_MODEL) ? NULL : &models;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR, .abi_minor = TATU_ABI_MINOR,
  .id = "org.example.breaches", .name = "Breaches", .version = "1.0.0", .licence = "MIT", .init = init, .extension = extension};
