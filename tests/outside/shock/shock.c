// shock: a sensor kind that detects impacts, with its own schema, shock/1.
//   shock.strength  specific force in the last physics step, m/s^2: 9.81 at rest, 0 in free fall
//   shock.count     the number of times that `shock.strength` has risen above the threshold
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_shock.so shock.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60
#include "tatu/sensor.h"

typedef struct {
  double threshold; // specific force above which an impact is counted, m/s^2
} shock;

// The state from one measurement to the next. The host owns it and saves it in snapshots.
typedef struct {
  int32_t count, is_above;
} memory;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  shock *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->threshold = given->params[0].u.f;
  return TATU_OK;
}

enum { STRENGTH, COUNT }; // the fields, in the order of their declaration

static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const shock *it = batch->data[i];
    memory *kept = batch->state[i];
    const double *acceleration = batch->acceleration + 6 * (size_t)i;
    double square = 0;
    for (int k = 0; k < 3; k++) {
      double force = acceleration[k] - batch->gravity[k];
      square += force * force;
    }
    double strength = sqrt(square);
    kept->count += strength > it->threshold && !kept->is_above;
    kept->is_above = strength > it->threshold;
    *(double *)tatu_field_of(batch, i, STRENGTH) = strength;
    *(int32_t *)tatu_field_of(batch, i, COUNT) = kept->count;
  }
  return TATU_OK;
}

static const tatu_sensor kind = {
  .size = sizeof(tatu_sensor), .id = "shock", .text = "Feels blows, and counts them.",
  .schemas = TATU_TEXTS("shock/1"), .inputs = TATU_IN_ACCELERATION, .flags = TATU_SENSOR_EVERY_PHYSICS_STEP,
  .measure = measure,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "threshold", "m/s^2", "Specific force that counts as a blow.", TATU_RANGE(10, 1e6),
               TATU_DEFAULT_F64(50), .flags = TATU_PARAM_REBUILDS)),
  .fields = TATU_FIELDS(
    TATU_FIELD(TATU_ELEM_F64, "shock.strength", "m/s^2", "Specific force in the last physics step."),
    TATU_FIELD(TATU_ELEM_I32, "shock.count", NULL, "How many times it has risen above the threshold.")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .state_bytes = sizeof(memory),
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_SENSORS(&kind), .id = "org.outside.shock", .name = "Shock", .version = "1.0.0", .licence = "MIT");
