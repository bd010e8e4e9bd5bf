// puff: an actuator kind that pushes along its +z axis, immediately or with a lag.
#include "tatu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  int lagged;
  double most, lag;
} puff;
typedef struct { // stored in the host's state block
  double thrust;
} state;

static void take(puff *it, const tatu_value *params) {
  it->lagged = params[0].u.s.len == strlen("lagged"); // the host accepts only the two choices
  it->most = params[1].u.f;
  it->lag = params[2].u.f;
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  puff *it = calloc(1, sizeof *it);
  if (!it) return tatu_fail(error, TATU_ERR, "out of memory");
  take(it, given->params);
  *data = it;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { free(data); }
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed, (void)error;
  take(data, params);
  return TATU_OK;
}
// Writes nothing: everything outside the state block is derived from the parameters.
static tatu_status TATU_CALL save(void *data, const tatu_writer *to, tatu_error *error) {
  (void)data, (void)to, (void)error;
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str from, uint32_t version, tatu_error *error) {
  (void)data, (void)version;
  return from.len ? tatu_fail(error, TATU_ERR, "a puff saves nothing but its block") : TATU_OK;
}
static const tatu_life life = {.size = sizeof life, .state_bytes = sizeof(state), .create = create,
  .destroy = destroy, .configure = configure, .save = save, .load = load, .version = 1};

static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const puff *it = batch->data[i];
    state *kept = batch->state[i];
    double wanted = fmax(-it->most, fmin(it->most, batch->command[i][0]));
    double share = it->lagged && it->lag > 0 ? -expm1(-batch->dt / it->lag) : 1;
    kept->thrust += (wanted - kept->thrust) * share;
    const double *q = batch->pose + 7 * (size_t)i + 3; // x y z w
    double *wrench = batch->wrench + 6 * (size_t)i;
    wrench[0] = kept->thrust * 2 * (q[0] * q[2] + q[1] * q[3]);
    wrench[1] = kept->thrust * 2 * (q[1] * q[2] - q[0] * q[3]);
    wrench[2] = kept->thrust * (1 - 2 * (q[0] * q[0] + q[1] * q[1]));
  }
  return TATU_OK;
}

static const char *const modes[] = {"direct", "lagged", NULL};
static const tatu_param mode = {.size = sizeof mode, .type = TATU_TEXT, .key = "mode", .choices = modes,
  .fallback = {.tag = TATU_TEXT, .u.s = {"direct", 6}}, .text = "Whether the thrust follows at once."};
static const tatu_param most = {.size = sizeof most, .type = TATU_F64, .key = "most", .unit = "N",
  .lowest = 0, .highest = 1e6, .fallback = {.tag = TATU_F64, .u.f = 10}, .text = "Greatest thrust, both ways."};
static const tatu_param lag = {.size = sizeof lag, .type = TATU_F64, .key = "lag", .unit = "s",
  .lowest = 0, .highest = 1e3, .fallback = {.tag = TATU_F64, .u.f = 0.1}, .text = "Time constant when lagged."};
static const tatu_param *const params[] = {&mode, &most, &lag, NULL};
static const tatu_param thrust = {.size = sizeof thrust, .type = TATU_F64, .key = "thrust", .unit = "N",
  .fallback = {.tag = TATU_F64, .u.f = 0}, .text = "Wanted force along +z."};
static const tatu_param *const commands[] = {&thrust, NULL};
static const tatu_actuator kind = {.size = sizeof kind, .n_commands = 1, .id = "puff", .params = params,
  .text = "Pushes along its +z axis.", .commands = commands, .life = &life, .apply = apply};
static const tatu_actuator *const kinds[] = {&kind, NULL};
static const tatu_ext_actuator offer = {.size = sizeof offer, .kinds = kinds};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_ACTUATOR) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.puff", .name = "Puff", .version = "1.0.0", .licence = "MIT",
  .extension = extension};
