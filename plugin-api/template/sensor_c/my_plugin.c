// my_plugin: a kind of sensor in C. A fan of beams in the plane of its z and x axes measures the clearance ahead.
//   my_plugin.distance  for each beam, m; the range if nothing is hit
//   my_plugin.nearest   the smallest of them, m          my_plugin.bearing  its direction, rad, from +z towards +x
// The scene sets noise, rate and latency: see the preset below, and `[noise.distance]` in a scene.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/sensor.h"

enum { MOST = 181 };

// One sensor of a scene. Its parameters fully determine its state, so there is nothing to save in a snapshot.
typedef struct {
  double range, angle;
  uint32_t beams;
  double ahead[MOST][3]; // unit vectors in the sensor's frame
} fan;

static double bearing(const fan *it, uint64_t beam) {
  return it->beams > 1 ? it->angle * ((double)beam / (it->beams - 1) - 0.5) : 0;
}

// Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
static void take(fan *it, const tatu_value *params) {
  it->range = params[0].u.f;
  it->angle = params[1].u.f;
  it->beams = (uint32_t)params[2].u.i;
  for (uint32_t k = 0; k < it->beams; k++) {
    it->ahead[k][0] = sin(bearing(it, k));
    it->ahead[k][1] = 0;
    it->ahead[k][2] = cos(bearing(it, k));
  }
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  fan *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  take(it, given->params);
  return TATU_OK;
}

// Applies parameters that were changed during a run; the host then requests the beams again.
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed, (void)error;
  take(data, params);
  return TATU_OK;
}

static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  (void)error;
  const fan *it = data;
  tatu_rays(out, it->beams, it->ahead[0], it->range);
  return TATU_OK;
}

enum { DISTANCE, NEAREST, BEARING }; // the fields, in the order of their declaration

// Measures with all sensors of this kind that are due. It may be called on any thread, so it uses only its arguments.
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const fan *it = batch->data[i];
    uint64_t n;
    const double *met = tatu_distances_of(batch, i, &n);
    double *distance = tatu_field_of(batch, i, DISTANCE), *nearest = tatu_field_of(batch, i, NEAREST);
    *nearest = it->range;
    for (uint64_t k = 0; k < n; k++) {
      distance[k] = met[k] < it->range ? met[k] : it->range;
      if (distance[k] >= *nearest) continue;
      *nearest = distance[k];
      *(double *)tatu_field_of(batch, i, BEARING) = bearing(it, k);
    }
  }
  return TATU_OK;
}

static const tatu_sensor kind = {
  .size = sizeof(tatu_sensor), .id = "my_plugin", .text = "Measures the clearance ahead with a fan of beams.",
  .schemas = TATU_TEXTS("my_plugin/1"), .inputs = TATU_IN_DISTANCE, .beams = beams, .measure = measure,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "range", "m", "Maximum range.", TATU_RANGE(0.01, 1000), TATU_DEFAULT_F64(5)),
    TATU_PARAM(TATU_F64, "angle", "rad", "Angle from first to last beam.", TATU_RANGE(0, 3.1416), TATU_DEFAULT_F64(1)),
    TATU_PARAM(TATU_I64, "beams", NULL, "Number of beams.", TATU_RANGE(1, MOST), TATU_DEFAULT_I64(21),
               .flags = TATU_PARAM_REBUILDS)),
  .fields = TATU_FIELDS(
    TATU_FIELD_ARRAY(TATU_ELEM_F64, 0, "my_plugin.distance", "m", "Distance along each beam."),
    TATU_FIELD(TATU_ELEM_F64, "my_plugin.nearest", "m", "The least distance."),
    TATU_FIELD(TATU_ELEM_F64, "my_plugin.bearing", "rad", "Direction of that beam, from +z towards +x.")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .configure = configure,
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1),
  .presets = TATU_LIST_OF(tatu_preset,
    TATU_TABLE(tatu_preset, .id = "cheap", .text = "A low-cost sensor with an error of 2 cm; the values are examples.",
               .settings = "range_m = 4.0\n\n[noise.nearest]\nsigma = 0.02\n"))};

TATU_PLUGIN(TATU_SENSORS(&kind), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0", .licence = "MIT");
