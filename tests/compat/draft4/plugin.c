/* A plugin as it was built with this revision of the contract: a command with declared parameters, what it keeps per
 * world, and a sensor. A frozen copy of this file lies beside its header; see README.md. */
#include "tatu.h"

#include <stdlib.h>
#include <string.h>

/* -- per world: how often it was called, in the state block; the world's number in memory of its own -- */
static tatu_status world_create(void *self, const tatu_instance *info, void **data, tatu_error *error) {
  (void)self;
  if (!info->state) return tatu_fail(error, TATU_ERR, "no state block");
  *data = calloc(1, sizeof(uint64_t));
  if (!*data) return tatu_fail(error, TATU_ERR_MEMORY, "no memory");
  *(uint64_t *)*data = info->id;
  return TATU_OK;
}
static void world_destroy(void *data) { free(data); }
static const tatu_life world_life = {
  .size = sizeof(tatu_life), .state_bytes = sizeof(int64_t), .create = world_create, .destroy = world_destroy};

static tatu_status twice(tatu_call *call) {
  if (!*(uint64_t *)call->instance) return tatu_call_fail(call, TATU_ERR, "no instance");
  *(int64_t *)call->state += 1;
  return tatu_return(call, tatu_float(2 * tatu_arg_float(call, 0)));
}
static tatu_status count(tatu_call *call) { return tatu_return(call, tatu_int(*(int64_t *)call->state)); }

static const tatu_param number = {
  .size = sizeof(tatu_param), .type = TATU_F64, .key = "number", .lowest = -1e9, .highest = 1e9, .text = "Any."};
static const tatu_param *const twice_params[] = {&number, NULL};
static const tatu_name twice_name = {.size = sizeof(tatu_name), .name = "oldc.twice"};
static const tatu_name *const twice_names[] = {&twice_name, NULL};
static const tatu_name count_name = {.size = sizeof(tatu_name), .name = "oldc.count"};
static const tatu_name *const count_names[] = {&count_name, NULL};
static const tatu_command twice_command = {
  .size = sizeof(tatu_command), .names = twice_names, .params = twice_params, .text = "Doubles.", .call = twice};
static const tatu_command count_command = {
  .size = sizeof(tatu_command), .names = count_names, .text = "How often twice was called.", .call = count};
static const tatu_command *const commands[] = {&twice_command, &count_command, NULL};
static const tatu_ext_command ext_command = {
  .size = sizeof(tatu_ext_command), .commands = commands, .per_world = &world_life};

/* -- a sensor: one ray ahead -- */
static const double ahead[3] = {0, 0, 1};
static tatu_status eye_create(void *self, const tatu_instance *info, void **data, tatu_error *error) {
  double *range = calloc(1, sizeof *range);
  (void)self;
  if (!range) return tatu_fail(error, TATU_ERR_MEMORY, "no memory");
  *range = info->params[0].u.f;
  *data = range;
  return TATU_OK;
}
static tatu_status eye_beams(void *data, tatu_beams *beams, tatu_error *error) {
  (void)error;
  beams->form = TATU_BEAMS_RAYS;
  beams->count[0] = beams->count[1] = 1;
  beams->far_m = *(double *)data;
  beams->directions = ahead;
  return TATU_OK;
}
static tatu_status eye_measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  uint32_t i;
  (void)self, (void)error;
  for (i = 0; i < batch->n; i++) {
    double distance = batch->distance[batch->first_beam[i]];
    if (distance < *(double *)batch->data[i]) *(double *)batch->fields[i * batch->n_fields] = distance;
  }
  return TATU_OK;
}
static const tatu_life eye_life = {.size = sizeof(tatu_life), .create = eye_create, .destroy = world_destroy};
static const tatu_param range = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "range", .unit = "m",
  .lowest = 0, .highest = 100, .fallback = {TATU_F64, 0, {.f = 2}}, .text = "How far it sees."};
static const tatu_param *const eye_params[] = {&range, NULL};
static const tatu_field distance = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1},
  .name = "oldc.distance", .unit = "m", .text = "How far; 0: nothing."};
static const tatu_field *const eye_fields[] = {&distance, NULL};
static const char *const eye_schemas[] = {"oldc/1", NULL};
static const tatu_sensor eye = {.size = sizeof(tatu_sensor), .inputs = TATU_IN_DISTANCE, .id = "oldc_eye",
  .text = "One ray ahead.", .schemas = eye_schemas, .params = eye_params, .fields = eye_fields, .life = &eye_life,
  .beams = eye_beams, .measure = eye_measure};
static const tatu_sensor *const eyes[] = {&eye, NULL};
static const tatu_ext_sensor ext_sensor = {.size = sizeof(tatu_ext_sensor), .kinds = eyes};

/* -- the plugin -- */
static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
  const tatu_host_scene *scene = host->service(host, TATU_HOST_SCENE);
  (void)self;
  return TATU_HAS(scene, find) ? TATU_OK : tatu_fail(error, TATU_ERR, "this host has no scene");
}
static const void *extension(void *self, const char *id) {
  (void)self;
  if (!strcmp(id, TATU_COMMAND)) return &ext_command;
  if (!strcmp(id, TATU_SENSOR)) return &ext_sensor;
  return NULL;
}
static const tatu_need scene_need = {.size = sizeof(tatu_need), .id = TATU_HOST_SCENE};
static const tatu_need *const needs[] = {&scene_need, NULL};
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.tatu.compat.c", .name = "Of old", .version = "1", .licence = "MIT",
  .needs = needs, .init = init, .extension = extension};
