// uwb: a tag that measures its distances to the beacons that the scene lists as its `targets`, as ultra-wideband radios do.
//   uwb.range          m, per beacon; 0: out of range, or the beacon does not exist. The scene adds the noise
//   uwb.line_of_sight  per beacon; 0: something detectable is in between, which lengthens the range by `bias`
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_uwb.so uwb.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60
#include "tatu/sensor.h"

enum { RANGE, LINE_OF_SIGHT };

typedef struct {
  double range, bias, *directions;
} tag;

static void TATU_CALL destroy(void *data) {
  free(((tag *)data)->directions);
  free(data);
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  tag *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->range = given->params[0].u.f, it->bias = given->params[1].u.f;
  return TATU_OK;
}

// One ray for each beacon. `aim` points it.
static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  tag *it = data;
  double *directions = calloc(3 * (size_t)out->n_targets + 1, sizeof(double));
  if (!directions) return tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  for (uint32_t k = 0; k < out->n_targets; k++) directions[3 * k + 2] = 1;
  free(it->directions);
  it->directions = directions;
  tatu_rays(out, out->n_targets, directions, it->range);
  out->flags = TATU_BEAMS_AIMED | TATU_BEAMS_SKIP_MODEL;
  return TATU_OK;
}

// The vector from a sensor to a target, world frame, and its length.
static double toward(const tatu_sensor_batch *batch, uint32_t i, uint64_t target, double to[3]) {
  double square = 0;
  for (int k = 0; k < 3; k++) {
    to[k] = batch->target_pose[7 * target + (uint64_t)k] - batch->pose[7 * (size_t)i + (size_t)k];
    square += to[k] * to[k];
  }
  return sqrt(square);
}

static tatu_status TATU_CALL aim(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const double *pose = batch->pose + 7 * (size_t)i;
    double x = -pose[3], y = -pose[4], z = -pose[5], w = pose[6]; // from the world to the sensor's frame
    for (uint64_t t = batch->first_target[i]; t < batch->first_target[i + 1]; t++) {
      double v[3], *ray = batch->rays[i] + 6 * (t - batch->first_target[i]), distance = toward(batch, i, t, v);
      if (!batch->target[t] || distance < 1e-9) continue;
      for (int k = 0; k < 3; k++) v[k] /= distance;
      double c[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
      ray[3] = v[0] + w * c[0] + y * c[2] - z * c[1];
      ray[4] = v[1] + w * c[1] + z * c[0] - x * c[2];
      ray[5] = v[2] + w * c[2] + x * c[1] - y * c[0];
    }
  }
  return TATU_OK;
}

static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const tag *it = batch->data[i];
    double *range = tatu_field_of(batch, i, RANGE);
    int32_t *sees = tatu_field_of(batch, i, LINE_OF_SIGHT);
    for (uint64_t k = 0, t = batch->first_target[i]; t < batch->first_target[i + 1]; k++, t++) {
      double to[3], distance = toward(batch, i, t, to);
      if (!batch->target[t] || distance > it->range) continue; // the fields are 0
      uint64_t beam = batch->first_beam[i] + k;
      sees[k] = batch->distance[beam] >= distance || batch->object[beam] == batch->target[t];
      range[k] = distance + (sees[k] ? 0 : it->bias);
    }
  }
  return TATU_OK;
}

static const tatu_sensor kind = {
  .size = sizeof(tatu_sensor), .id = "uwb", .text = "Measures distances to beacons.",
  .inputs = TATU_IN_TARGETS | TATU_IN_POSE | TATU_IN_DISTANCE | TATU_IN_OBJECT, .schemas = TATU_TEXTS("uwb/1"),
  .beams = beams, .aim = aim, .measure = measure,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "range", "m", "Maximum range.", TATU_AT_LEAST(0.1), TATU_DEFAULT_F64(50)),
    TATU_PARAM(TATU_F64, "bias", "m", "What is added to the range without a line of sight.", TATU_AT_LEAST(0),
               TATU_DEFAULT_F64(0.3))),
  .fields = TATU_FIELDS(
    TATU_FIELD_ARRAY(TATU_ELEM_F64, TATU_DIM_TARGETS, "uwb.range", "m", "Distance to each beacon.", .nothing = "0"),
    TATU_FIELD_ARRAY(TATU_ELEM_I32, TATU_DIM_TARGETS, "uwb.line_of_sight", NULL, "Whether each beacon is seen.")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = destroy, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_SENSORS(&kind), .id = "org.example.uwb", .name = "UWB tag", .version = "1.0.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_TABLE(tatu_need, .minor = 8)));
