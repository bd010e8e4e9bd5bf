// my_plugin: a kind of actuator in C. A propeller, which pushes along its +z axis with a force that follows the command
// `force` with a lag.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/actuator.h"

// One propeller of a scene, and its state. The host saves the state in snapshots, and zeroes it at a reset.
typedef struct {
  double max_force, lag;
} propeller;
typedef struct {
  double force; // current force, N
} state;

// Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
static void take(propeller *it, const tatu_value *params) {
  it->max_force = params[0].u.f;
  it->lag = params[1].u.f;
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  propeller *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  take(it, given->params);
  return TATU_OK;
}
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed, (void)error;
  take(data, params);
  return TATU_OK;
}

// Computes the z axis of a pose (x y z, quaternion x y z w).
static void z_axis(const double *pose, double *axis) {
  double x = pose[3], y = pose[4], z = pose[5], w = pose[6];
  axis[0] = 2 * (x * z + w * y);
  axis[1] = 2 * (y * z - w * x);
  axis[2] = 1 - 2 * (x * x + y * y);
}

// Computes the forces of all propellers in a batch. It may be called on any thread, so it uses only its arguments.
static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const propeller *it = batch->data[i];
    state *now = batch->state[i];
    double wanted = fmax(-it->max_force, fmin(it->max_force, batch->command[i][0]));
    double x = it->lag > 0 ? batch->dt / it->lag : 0;
    // The mean force during the step, so that the impulse does not depend on the duration of steps.
    double part = x > 0 ? -expm1(-x) : 1, mean = wanted;
    if (x > 0) mean = wanted + (now->force - wanted) * part / x;
    now->force += (wanted - now->force) * part;
    double axis[3];
    z_axis(batch->pose + 7 * (size_t)i, axis);
    for (int k = 0; k < 3; k++) batch->wrench[6 * (size_t)i + k] = mean * axis[k];
  }
  return TATU_OK;
}

static const tatu_actuator kind = {
  .size = sizeof(tatu_actuator), .id = "my_plugin", .text = "Pushes along its +z axis, with a lag.", .apply = apply,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "max_force", "N", "Maximum force, forwards and backwards.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(10)),
    TATU_PARAM(TATU_F64, "lag", "s", "Time in which 63 % of a change is reached.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(0.2))),
  .n_commands = 1,
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "force", "N", "Wanted force along +z.", TATU_DEFAULT_F64(0))),
  .life = TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .create = create, .destroy = tatu_delete,
                     .configure = configure, .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_ACTUATORS(&kind), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0", .licence = "MIT");
