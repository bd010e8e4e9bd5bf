// lamp: a sensor kind with its own schema, lamp/1. It measures how much of the light of its lamp is reflected.
//   lamp.level  1 at the lamp itself, 0 at the end of its range    lamp.seen  1: something reflects light; 0: nothing
// Two parameters can change during a run: `range` (of the light) and `tilt` (rotates the ray up or down).
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_lamp.so lamp.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40 --threads 2
#include "tatu.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// One lamp. Everything in it is derived from the parameters, so a snapshot does not have to store any of it.
typedef struct {
  double range;
  double ahead[3]; // direction of the ray in the sensor's frame; unit length
} lamp;

// Copies the parameters, which are in the order of `params` below. The host has checked them against their ranges.
static void take(lamp *it, const tatu_value *params) {
  double tilt = params[1].u.f;
  it->range = params[0].u.f;
  it->ahead[0] = 0;
  it->ahead[1] = sin(tilt);
  it->ahead[2] = cos(tilt);
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  lamp *it = calloc(1, sizeof *it);
  if (!it) return tatu_fail(error, TATU_ERR, "out of memory");
  take(it, given->params);
  *data = it;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { free(data); }

// Called when parameters change during a run. Afterwards the host requests the beams again. The limit on the tilt of a
// lamp with a long range relates two parameters, which their ranges cannot express. If this function fails, the old
// values remain in effect.
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed;
  if (params[0].u.f > 5 && fabs(params[1].u.f) > 0.5)
    return tatu_fail(error, TATU_ERR_ARGUMENT, "with a range above 5 m the tilt is at most 0.5 rad");
  take(data, params);
  return TATU_OK;
}

// A lamp has nothing to save, but without these two functions the host would assume that it cannot be saved.
static tatu_status TATU_CALL save(void *data, const tatu_writer *writer, tatu_error *error) {
  (void)data, (void)writer, (void)error;
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  (void)data, (void)bytes, (void)version, (void)error;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .create = create, .destroy = destroy, .configure = configure,
                               .save = save, .load = load, .version = 1};

// Describes one ray. Fields that are not set keep the host's default or zero.
static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  (void)error;
  const lamp *it = data;
  out->form = TATU_BEAMS_RAYS;
  out->count[0] = 1;
  out->near_m = 0;
  out->far_m = it->range;
  out->max_incidence = acos(-1.0) / 2; // no limit
  out->directions = it->ahead;
  return TATU_OK;
}

// Measures all lamps that are due. The host has zeroed the fields; field k of lamp i is fields[i * n_fields + k].
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const lamp *it = batch->data[i];
    double *level = batch->fields[(size_t)i * batch->n_fields];
    int32_t *seen = batch->fields[(size_t)i * batch->n_fields + 1];
    double way = batch->distance[batch->first_beam[i]];
    if (isfinite(way)) {
      *level = 1 - way / it->range;
      *seen = 1;
    }
  }
  return TATU_OK;
}

// Declarations
static const tatu_param range = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "range", .unit = "m",
  .lowest = 0.1, .highest = 20, .fallback = {.tag = TATU_F64, .u.f = 2}, .text = "How far its light comes back from."};
static const tatu_param tilt = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "tilt", .unit = "rad",
  .lowest = -1, .highest = 1, .fallback = {.tag = TATU_F64, .u.f = 0}, .text = "Turns the ray from +z to +y."};
static const tatu_param *const params[] = {&range, &tilt, NULL};

static const tatu_field level = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1},
  .name = "lamp.level", .unit = "1", .text = "How much light comes back.", .valid = "lamp.seen", .nothing = "0"};
static const tatu_field seen = {.size = sizeof(tatu_field), .elem = TATU_ELEM_I32, .dims = {1, 1, 1},
  .name = "lamp.seen", .text = "Whether any comes back.", .nothing = "0"};
static const tatu_field *const fields[] = {&level, &seen, NULL};

static const tatu_preset cheap = {.size = sizeof(tatu_preset), .id = "cheap", .text = "A cheap one; numbers invented.",
  .settings = "range_m = 4.0\nrate_hz = 20\n\n[noise.level]\nsigma = 0.01\ndropout = 0.2\n"};
static const tatu_preset *const presets[] = {&cheap, NULL};

static const char *const schemas[] = {"lamp/1", NULL};
static const tatu_sensor kind = {.size = sizeof(tatu_sensor), .inputs = TATU_IN_DISTANCE, .id = "lamp",
  .text = "Tells how strongly the light of its lamp comes back.", .schemas = schemas, .params = params,
  .fields = fields, .life = &life, .beams = beams, .measure = measure, .presets = presets};
static const tatu_sensor *const kinds[] = {&kind, NULL};
static const tatu_ext_sensor offer = {.size = sizeof(tatu_ext_sensor), .kinds = kinds};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_SENSOR) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.outside.lamp", .name = "Lamp", .version = "1.0.0", .licence = "MIT",
  .extension = extension};
