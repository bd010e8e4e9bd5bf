// radar: a sensor that measures range and radial speed of what its beam hits.
//   radar.range   m; the maximum range without an echo
//   radar.speed   m/s along the beam, positive if the target moves away; 0 without an echo
//   radar.object  the target
// For bridges to ROS, the command `message.ros.radar` converts a reading to a message.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_radar.so radar.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40
#include "tatu/command.h"
#include "tatu/host.h"
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

// Returns the type of the message of a sensor, its fields, and the last part of the topic's name.
static tatu_status TATU_CALL message(tatu_call *call) {
  const tatu_host_api *host = call->self;
  tatu_object sensor = tatu_arg_object(call, 0);
  tatu_prop key = host->scene->prop(host->host, "radar.range"); // of the field, and of the parameter
  double most = 0;
  tatu_field_view range = {0};
  tatu_status status = host->readings->field(call->world, sensor, key, &range);
  if (status >= 0) status = host->scene->get_f64(call->world, sensor, key, &most, 1);
  if (status < 0) return status;
  double found = *(const double *)range.ptr;
  tatu_return(call, tatu_string("sensor_msgs/Range"));
  tatu_return(call, tatu_copy(call, TATU_MAP, TATU_ENTRIES(
    tatu_entry("max_range", tatu_float(most)),
    tatu_entry("range", tatu_float(found < most ? found : HUGE_VAL))), sizeof(tatu_pair)));
  return tatu_return(call, tatu_string("radar"));
}

static const tatu_command command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("message.ros.radar"), .call = message,
  .params = TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "sensor", NULL, "The radar.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_TEXT, "type", NULL, "The type of the message."),
                         TATU_PARAM(TATU_MAP, "fields", NULL, "Its fields."),
                         TATU_PARAM(TATU_TEXT, "topic", NULL, "The last part of the topic's name.")),
  .text = "Returns the last reading of a radar as a message of ROS."};

TATU_PLUGIN(TATU_OFFERS(TATU_SENSORS(&kind), TATU_COMMANDS(&command)), .id = "org.example.radar", .name = "Radar",
            .version = "1.0.0", .licence = "MIT", .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_READINGS),
            .init = tatu_init_host_api, .shutdown = tatu_delete);
