// my_plugin: a part in C. A controller that holds the body it belongs to at a height: it reads the height, and pushes.
//   my_plugin.height  command: wanted height, m
//   my_plugin.error   reading: wanted minus actual height, m
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/part.h
#include "tatu/host.h"
#include "tatu/part.h"

// One controller of a scene, and its state: plain numbers. The host saves the state in snapshots, hashes it, and zeroes
// it at a reset.
typedef struct {
  const tatu_host_api *host;
  double stiffness, damping, integral;
} holder;
typedef struct {
  double sum; // integral of the error, m s
} state;

enum { HEIGHT };         // the commands, in the order of their declaration
enum { HEIGHT_ERROR };   // the fields

// Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
static void take(holder *it, const tatu_value *params) {
  it->stiffness = params[0].u.f;
  it->damping = params[1].u.f;
  it->integral = params[2].u.f;
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  holder *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  take(it, given->params);
  return TATU_OK;
}
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed, (void)error;
  take(data, params);
  return TATU_OK;
}

// Pushes before each physics step. A host function that fails has set the error, so returning its status is sufficient.
static tatu_status TATU_CALL physics_step(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  holder *it = data;
  state *now = call->state;
  double pose[7], twist[6], force[3] = {0, 0, 0};
  tatu_status status = it->host->scene->pose(call->world, call->owner, 0, pose);
  if (status >= 0) status = it->host->bodies->twist(call->world, call->owner, twist);
  if (status < 0) return status;
  double off = call->command[HEIGHT] - pose[2];
  now->sum += off * call->dt;
  force[2] = it->stiffness * off + it->integral * now->sum - it->damping * twist[2];
  return it->host->bodies->push(call->world, call->owner, force, NULL);
}

// Reports the error after each step, when the sensors have measured.
static tatu_status TATU_CALL sense(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  const holder *it = data;
  double pose[7];
  tatu_status status = it->host->scene->pose(call->world, call->owner, 0, pose);
  if (status < 0) return status;
  *(double *)tatu_part_field(call, HEIGHT_ERROR) = call->command[HEIGHT] - pose[2];
  return TATU_OK;
}

static const tatu_part kind = {
  .size = sizeof(tatu_part), .id = "my_plugin", .text = "Holds the body that it belongs to at a height.",
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "stiffness", "N/m", "Force per error.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(40)),
    TATU_PARAM(TATU_F64, "damping", "N s/m", "Force per speed.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(16)),
    TATU_PARAM(TATU_F64, "integral", NULL, "Force per integral of the error, N/(m s).", TATU_AT_LEAST(0), TATU_DEFAULT_F64(40))),
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "height", "m", "Wanted height.", TATU_DEFAULT_F64(1))),
  .life = TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .create = create, .destroy = tatu_delete,
                     .configure = configure, .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1),
  .physics_step = physics_step, .sense = sense, .schemas = TATU_TEXTS("my_plugin/1"),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "my_plugin.error", "m", "Wanted minus actual height.")),
  .presets = TATU_LIST_OF(tatu_preset, TATU_TABLE(tatu_preset, .id = "soft", .text = "A slow controller; the values are examples.",
                                                  .settings = "stiffness_n_m = 10.0\ndamping_ns_m = 8.0\nintegral = 4.0\n"))};

TATU_PLUGIN(TATU_PARTS(&kind), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_BODIES), .init = tatu_init_host_api, .shutdown = tatu_delete);
