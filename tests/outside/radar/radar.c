// radar: a sensor that measures range and radial speed of what its beam hits.
//   radar.range   m; the maximum range without an echo
//   radar.speed   m/s along the beam, positive if the target moves away; 0 without an echo
//   radar.object  the target
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_radar.so radar.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40
#include "tatu/sensor.h"

static const double ahead[3] = {0, 0, 1};

typedef struct {
  double range;
} radar;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  radar *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->range = given->params[0].u.f;
  return TATU_OK;
}
static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  (void)error;
  tatu_rays(out, 1, ahead, ((const radar *)data)->range);
  return TATU_OK;
}

static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const radar *it = batch->data[i];
    uint64_t beam = batch->first_beam[i];
    double *range = tatu_field_of(batch, i, 0), *speed = tatu_field_of(batch, i, 1);
    *range = fmin(batch->distance[beam], it->range);
    *(tatu_object *)tatu_field_of(batch, i, 2) = batch->object[beam];
    if (!batch->object[beam]) continue;
    // The beam is the z axis of the sensor's frame.
    const double *pose = batch->pose + 7 * (size_t)i;
    double x = pose[3], y = pose[4], z = pose[5], w = pose[6];
    double axis[3] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
    for (int k = 0; k < 3; k++)
      *speed += (batch->hit_twist[6 * beam + (uint64_t)k] - batch->twist[6 * (size_t)i + (size_t)k]) * axis[k];
  }
  return TATU_OK;
}

static const tatu_sensor kind = {
  .size = sizeof(tatu_sensor), .id = "radar", .text = "Measures range and radial speed.",
  .inputs = TATU_IN_DISTANCE | TATU_IN_OBJECT | TATU_IN_HIT_TWIST | TATU_IN_POSE | TATU_IN_TWIST,
  .schemas = TATU_TEXTS("radar/1"), .beams = beams, .measure = measure,
  .params = TATU_PARAMS(TATU_PARAM(TATU_F64, "range", "m", "Maximum range.", TATU_AT_LEAST(0.1), TATU_DEFAULT_F64(50))),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "radar.range", "m", "Range of the target."),
                        TATU_FIELD(TATU_ELEM_F64, "radar.speed", "m/s", "Radial speed of the target."),
                        TATU_FIELD(TATU_ELEM_OBJECT, "radar.object", NULL, "The target.")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_SENSORS(&kind), .id = "org.example.radar", .name = "Radar", .version = "1.0.0", .licence = "MIT");
