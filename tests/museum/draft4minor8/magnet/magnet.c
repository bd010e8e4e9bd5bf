// magnet: an electromagnet that pulls, repels and turns the permanent magnets that the scene lists as its `targets`. All
// magnets are dipoles along the z axis of their object. The forces and torques on the two are opposite, so momentum and
// angular momentum are preserved. Formulas: Yung, Landecker, Villani, "An analytic solution for the force between two
// magnetic dipoles", Magnetic and Electrical Separation 9 (1998), 39-52.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_magnet.so magnet.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 20
#include "tatu/actuator.h"

typedef struct {
  double coil, moment, nearest;
} magnet;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self;
  magnet *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->coil = given->params[0].u.f, it->moment = given->params[1].u.f, it->nearest = given->params[2].u.f;
  return TATU_OK;
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void cross(const double *a, const double *b, double *out) {
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
// The z axis of a pose, times a size.
static void along_z(const double *pose, double size, double *out) {
  double x = pose[3], y = pose[4], z = pose[5], w = pose[6];
  out[0] = size * 2 * (x * z + w * y), out[1] = size * 2 * (y * z - w * x), out[2] = size * (1 - 2 * (x * x + y * y));
}

// The force and torque of a dipole `a` on a dipole `b` at the distance `r` in the direction `u`.
static void pull(const double *a, const double *b, const double *u, double r, double wrench[6]) {
  double field[3], on_a = dot(a, u), on_b = dot(b, u), together = dot(a, b);
  for (int k = 0; k < 3; k++) {
    field[k] = 1e-7 / (r * r * r) * (3 * on_a * u[k] - a[k]); // mu0 / (4 pi) is 1e-7 N/A^2
    wrench[k] = 3e-7 / (r * r * r * r) * (on_a * b[k] + on_b * a[k] + (together - 5 * on_a * on_b) * u[k]);
  }
  cross(b, field, wrench + 3);
}

static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const magnet *it = batch->data[i];
    const double *pose = batch->pose + 7 * (size_t)i;
    double own[3], *reaction = batch->wrench + 6 * (size_t)i;
    along_z(pose, it->coil * batch->command[i][0], own);
    for (uint64_t t = batch->first_target[i]; t < batch->first_target[i + 1]; t++) {
      if (!batch->target[t]) continue; // it has been removed
      const double *other = batch->target_pose + 7 * t;
      double theirs[3], arm[3], u[3], turn[3], *wrench = batch->target_wrench + 6 * t;
      for (int k = 0; k < 3; k++) arm[k] = other[k] - pose[k];
      double r = sqrt(dot(arm, arm));
      if (r < 1e-9) continue; // the direction is not defined
      for (int k = 0; k < 3; k++) u[k] = arm[k] / r;
      along_z(other, it->moment, theirs);
      pull(own, theirs, u, fmax(r, it->nearest), wrench);
      cross(arm, wrench, turn);
      for (int k = 0; k < 3; k++) reaction[k] -= wrench[k], reaction[3 + k] -= wrench[3 + k] + turn[k];
    }
  }
  return TATU_OK;
}

static const tatu_actuator kind = {
  .size = sizeof(tatu_actuator), .id = "magnet", .text = "An electromagnet that acts on permanent magnets.",
  .flags = TATU_ACTUATOR_EVERY_SUBSTEP, .inputs = TATU_IN_TARGETS, .n_commands = 1, .apply = apply,
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "current", "A", "Current through the coil; a negative one repels.",
                                     TATU_RANGE(-1000, 1000), TATU_DEFAULT_F64(0))),
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "coil", "m^2", "Turns of the coil times their area.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(5)),
    TATU_PARAM(TATU_F64, "moment", NULL, "Magnetic moment of each target, A m^2.", TATU_AT_LEAST(0),
               TATU_DEFAULT_F64(50)),
    TATU_PARAM(TATU_F64, "nearest", "m", "Distance below which the force grows no more: a magnet is no point.",
               TATU_AT_LEAST(0.001), TATU_DEFAULT_F64(0.05))),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_ACTUATORS(&kind), .id = "org.example.magnet", .name = "Magnet", .version = "1.0.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_TABLE(tatu_need, .minor = 8)));
