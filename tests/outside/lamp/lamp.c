// lamp: a sensor kind with its own schema, lamp/1. It measures how much of the light of its lamp is reflected.
//   lamp.level  1 at the lamp itself, 0 at the end of its range    lamp.seen  1: something reflects light; 0: nothing
// Two parameters can change during a run: `range` (of the light) and `tilt` (rotates the ray up or down).
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_lamp.so lamp.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40 --threads 2
#include "tatu/sensor.h"

// One lamp. Everything in it is derived from the parameters, so a snapshot does not have to store any of it.
typedef struct {
  double range;
  double ahead[3]; // direction of the ray in the sensor's frame; unit length
} lamp;

// Copies the parameters, which are in the order of their declaration below. The host has checked them against their
// ranges.
static void take(lamp *it, const tatu_value *params) {
  double tilt = params[1].u.f;
  it->range = params[0].u.f;
  it->ahead[0] = 0;
  it->ahead[1] = sin(tilt);
  it->ahead[2] = cos(tilt);
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  lamp *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  take(it, given->params);
  return TATU_OK;
}

// Called when parameters change during a run. Afterwards the host requests the beams again. The limit on the tilt of a
// lamp with a long range relates two parameters, which their ranges cannot express. If this function fails, the old
// values remain in effect.
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed;
  if (params[0].u.f > 5 && fabs(params[1].u.f) > 0.5)
    return tatu_fail(error, TATU_ERR_ARGUMENT, "the tilt must be at most 0.5 rad if the range is above 5 m");
  take(data, params);
  return TATU_OK;
}


static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  (void)error;
  const lamp *it = data;
  tatu_rays(out, 1, it->ahead, it->range);
  return TATU_OK;
}

// Measures all lamps that are due. The host has zeroed the fields.
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const lamp *it = batch->data[i];
    double way = batch->distance[batch->first_beam[i]];
    if (!isfinite(way)) continue;
    *(double *)tatu_field_of(batch, i, 0) = 1 - way / it->range;
    *(int32_t *)tatu_field_of(batch, i, 1) = 1;
  }
  return TATU_OK;
}

static const tatu_sensor kind = {
  .size = sizeof(tatu_sensor), .id = "lamp", .text = "Measures how much of the light of its lamp is reflected.",
  .inputs = TATU_IN_DISTANCE, .schemas = TATU_TEXTS("lamp/1"), .beams = beams, .measure = measure,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "range", "m", "Maximum range of its light.", TATU_RANGE(0.1, 20), TATU_DEFAULT_F64(2)),
    TATU_PARAM(TATU_F64, "tilt", "rad", "Turns the ray from +z to +y.", TATU_RANGE(-1, 1), TATU_DEFAULT_F64(0))),
  .fields = TATU_FIELDS(
    TATU_FIELD(TATU_ELEM_F64, "lamp.level", "1", "Reflected light, 0 to 1.", .valid = "lamp.seen", .nothing = "0"),
    TATU_FIELD(TATU_ELEM_I32, "lamp.seen", NULL, "Whether light is reflected: 1 or 0.", .nothing = "0")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .configure = configure,
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1),
  .presets = TATU_LIST_OF(tatu_preset,
    TATU_TABLE(tatu_preset, .id = "cheap", .text = "A low-cost lamp; the values are examples.",
               .settings = "range_m = 4.0\nrate_hz = 20\n\n[noise.level]\nsigma = 0.01\ndropout = 0.2\n"))};

TATU_PLUGIN(TATU_SENSORS(&kind), .id = "org.outside.lamp", .name = "Lamp", .version = "1.0.0", .licence = "MIT");
