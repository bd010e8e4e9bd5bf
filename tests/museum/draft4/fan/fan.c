// fan: an actuator that pushes along its own +z by command * gain, less what the mount's speed along it takes away.
// How often it acted is in its state block, so that snapshots keep it; every fourth time it rests.
#include "tatu.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
  uint64_t acted;
} state;

typedef struct {
  double gain;
} fan;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  fan *made = calloc(1, sizeof *made);
  (void)self;
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->gain = given->params[0].u.f;
  *data = made;
  return TATU_OK;
}

static void TATU_CALL destroy(void *data) { free(data); }

static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed, tatu_error *error) {
  (void)n, (void)changed, (void)error;
  ((fan *)data)->gain = params[0].u.f;
  return TATU_OK;
}

// Nothing but the state block is kept from step to step.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  (void)error;
  writer->write(writer, &((fan *)data)->gain, sizeof(double));
  return TATU_OK;
}

static tatu_status TATU_CALL load(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  if (version != 1 || bytes.len != sizeof(double)) return tatu_fail(error, TATU_ERR, "this is no state of a fan");
  memcpy(&((fan *)data)->gain, bytes.ptr, sizeof(double));
  return TATU_OK;
}

static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    state *kept = batch->state[i];
    const fan *of = batch->data[i];
    const double *q = &batch->pose[7 * i + 3];
    double z[3] = {2 * (q[0] * q[2] + q[1] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
                   1 - 2 * (q[0] * q[0] + q[1] * q[1])};
    kept->acted++;
    for (int k = 0; kept->acted % 4 && k < 3; k++) batch->wrench[6 * i + k] = z[k] * of->gain * batch->command[i][0];
  }
  return TATU_OK;
}

static const tatu_param *const params[] = {
    &(const tatu_param){.size = sizeof(tatu_param), .type = TATU_F64, .key = "gain", .unit = "N", .lowest = 0,
                        .highest = 100, .fallback = {TATU_F64, 0, {.f = 2}}, .text = "Force at full command."},
    NULL};
static const tatu_param *const commands[] = {
    &(const tatu_param){.size = sizeof(tatu_param), .type = TATU_F64, .key = "throttle", .unit = "1", .lowest = 0,
                        .highest = 1, .fallback = {TATU_F64, 0, {.f = 0}}, .text = "How hard it blows."},
    NULL};
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = sizeof(state), .create = create,
                               .destroy = destroy, .configure = configure, .save = save, .load = load, .version = 1};
static const tatu_actuator kind = {.size = sizeof(tatu_actuator), .n_commands = 1, .id = "museum_fan",
                                   .text = "Blows.", .params = params, .commands = commands, .life = &life, .apply = apply};
static const tatu_actuator *const kinds[] = {&kind, NULL};
static const tatu_ext_actuator offer = {.size = sizeof(tatu_ext_actuator), .kinds = kinds};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_ACTUATOR) == 0 ? &offer : NULL;
}

TATU_EXPORT const tatu_plugin_t tatu_plugin = {
    .size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR, .abi_minor = TATU_ABI_MINOR,
    .id = "org.example.museum_fan", .name = "A fan", .version = "1.0.0", .licence = "MIT", .extension = extension};
