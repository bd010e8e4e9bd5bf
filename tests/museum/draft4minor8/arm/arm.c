// controllers: two parts, which drive to the same bits as the scripts beside them.
//   braitenberg  a Pioneer that turns away from obstacles, as scenes/first/avoid_walls.lua does. It belongs to the robot
//   pid          a torque on a joint, before each physics step, as arm.lua computes it. It belongs to the world
//
// Build: cc -std=c11 -Wall -Wextra -Werror -ffp-contract=off -shared -fPIC -I ../../../plugin-api/include -o libtatu_controllers.so controllers.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run pioneer.toml --seconds 20
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run arm.toml --seconds 2
#include "tatu/host.h"
#include "tatu/part.h"

#include <stdio.h>
#include <string.h>

// Finds an object of the scene; objects exist before parts are created.
static tatu_status find(const tatu_host_api *host, tatu_world *world, tatu_object from, const char *path, tatu_object *out) {
  return host->scene->find(world, from, tatu_text(path), out);
}

// ---------------------------------------------------------------- Braitenberg ---------------------------------------

enum { SONARS = 8 };
typedef struct {
  const tatu_host_api *host;
  tatu_prop seen, distance, target;
  tatu_object sonar[SONARS], left, right;
  double far, near, cruise;
  int64_t side; // the side to which it turns until the path is clear, 1 or -1; 0: none
} vehicle;

static tatu_status TATU_CALL create_vehicle(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  vehicle *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  const tatu_host_scene *scene = it->host->scene;
  it->seen = scene->prop(it->host->host, "proximity.detected");
  it->distance = scene->prop(it->host->host, "proximity.distance");
  it->target = scene->prop(it->host->host, "joint.target_velocity");
  it->cruise = given->params[0].u.f, it->far = given->params[1].u.f, it->near = given->params[2].u.f;
  tatu_value robot;
  tatu_status status = scene->get(given->world, given->owner, scene->prop(it->host->host, "object.parent"), &robot);
  for (int i = 0; i < SONARS && status >= 0; i++) {
    char path[64];
    snprintf(path, sizeof path, "./Pioneer_p3dx_ultrasonicSensor%d", i + 1);
    status = find(it->host, given->world, robot.u.u, path, &it->sonar[i]);
  }
  if (status >= 0) status = find(it->host, given->world, robot.u.u, "./Pioneer_p3dx_leftMotor", &it->left);
  if (status >= 0) status = find(it->host, given->world, robot.u.u, "./Pioneer_p3dx_rightMotor", &it->right);
  if (status < 0) {
    tatu_delete(it);
    *data = NULL;
    return tatu_fail(error, status, "a part of this kind must belong to a Pioneer with sonars");
  }
  return TATU_OK;
}

// Returns 0 if nothing is near, up to 1 if an obstacle is very near.
static tatu_status nearness(const vehicle *it, tatu_world *world, int sonar, double *out) {
  tatu_field_view seen, distance;
  tatu_status status = it->host->readings->field(world, it->sonar[sonar], it->seen, &seen);
  if (status >= 0) status = it->host->readings->field(world, it->sonar[sonar], it->distance, &distance);
  if (status < 0) return status;
  *out = 0;
  if (!seen.sequence || !*(const int32_t *)seen.ptr) return TATU_OK;
  double d = *(const double *)distance.ptr;
  if (d <= it->far) *out = fmin(1, (it->far - d) / (it->far - it->near));
  return TATU_OK;
}

static tatu_status TATU_CALL actuate_vehicle(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  vehicle *it = data;
  double near[SONARS], turn_right = 0, turn_left = 0;
  for (int i = 0; i < SONARS; i++) {
    tatu_status status = nearness(it, call->world, i, &near[i]);
    if (status < 0) return status;
  }
  for (int i = 0; i < 4; i++) turn_right = turn_right + (i + 1) * near[i];
  for (int i = 4; i < 8; i++) turn_left = turn_left + (8 - i) * near[i];
  double ahead = fmax(near[3], near[4]), turn = 0.8 * (turn_right - turn_left);
  if (ahead > 0) {
    if (!it->side) it->side = turn < 0 ? -1 : 1;
    turn = (double)it->side * fmax(1.5, fabs(turn));
  } else {
    it->side = 0;
  }
  double speed = it->cruise * (1 - ahead), left = speed + turn, right = speed - turn;
  tatu_status status = it->host->scene->set_f64(call->world, it->left, it->target, &left, 1);
  return status < 0 ? status : it->host->scene->set_f64(call->world, it->right, it->target, &right, 1);
}

// The side is not in a state block, which would be part of the hash of the world's state.
static tatu_status TATU_CALL save_vehicle(void *data, const tatu_writer *to, tatu_error *error) {
  (void)error;
  to->write(to, &((vehicle *)data)->side, sizeof(int64_t));
  return TATU_OK;
}
static tatu_status TATU_CALL load_vehicle(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  if (version != 1 || bytes.len != sizeof(int64_t)) return tatu_fail(error, TATU_ERR, "the saved data has another form");
  memcpy(&((vehicle *)data)->side, bytes.ptr, sizeof(int64_t));
  return TATU_OK;
}

static const tatu_part braitenberg = {
  .size = sizeof(tatu_part), .id = "braitenberg", .text = "Turns a Pioneer away from obstacles.", .actuate = actuate_vehicle,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "cruise", "rad/s", "Speed of both wheels with nothing in sight.", TATU_DEFAULT_F64(3)),
    TATU_PARAM(TATU_F64, "far", "m", "Distance of the first reaction.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(0.6)),
    TATU_PARAM(TATU_F64, "near", "m", "Distance of the full reaction.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(0.2))),
  .presets = TATU_LIST_OF(tatu_preset, TATU_TABLE(tatu_preset, .id = "timid", .text = "Slow, and reacts early.",
                                                  .settings = "cruise_deg_s = 60.0\nfar_m = 0.9\n")),
  .life = TATU_TABLE(tatu_life, .create = create_vehicle, .destroy = tatu_delete, .save = save_vehicle, .load = load_vehicle,
                     .version = 1)};

// ---------------------------------------------------------------- PID -----------------------------------------------

typedef struct {
  const tatu_host_api *host;
  tatu_prop position, velocity, torque;
  tatu_object joint;
  double p, i, d;
} pid;
typedef struct {
  double sum;   // integral of the error, rad s
  double ended; // 1 once `end` was called
} pid_state;

static tatu_status TATU_CALL create_pid(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  pid *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  const tatu_host_scene *scene = it->host->scene;
  it->position = scene->prop(it->host->host, "joint.position");
  it->velocity = scene->prop(it->host->host, "joint.velocity");
  it->torque = scene->prop(it->host->host, "joint.max_force");
  it->p = given->params[1].u.f, it->i = given->params[2].u.f, it->d = given->params[3].u.f;
  tatu_str path = {given->params[0].u.s.ptr, given->params[0].u.s.len};
  tatu_status status = scene->find(given->world, given->owner, path, &it->joint);
  if (status < 0) {
    tatu_delete(it);
    *data = NULL;
    return tatu_fail(error, status, "the parameter `joint` is not the path of an object");
  }
  return TATU_OK;
}

static tatu_status TATU_CALL step_pid(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  pid *it = data;
  pid_state *now = call->state;
  const tatu_host_scene *scene = it->host->scene;
  double at, speed;
  tatu_status status = scene->get_f64(call->world, it->joint, it->position, &at, 1);
  if (status >= 0) status = scene->get_f64(call->world, it->joint, it->velocity, &speed, 1);
  if (status < 0) return status;
  double off = call->command[0] - at;
  now->sum = now->sum + off * call->dt;
  double torque = it->p * off + it->i * now->sum - it->d * speed;
  ((double *)tatu_part_field(call, 0))[0] = off;
  return scene->set_f64(call->world, it->joint, it->torque, &torque, 1);
}

static tatu_status TATU_CALL end_pid(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  const pid *it = data;
  tatu_log(it->host, call->world, TATU_LOG_INFO, ((pid_state *)call->state)->ended ? "pid ended twice" : "pid ended");
  ((pid_state *)call->state)->ended = 1;
  return TATU_OK;
}

static tatu_status TATU_CALL pause_pid(void *data, const tatu_part_call *call, uint32_t moment, tatu_error *error) {
  (void)error;
  static const char *const names[] = {"a pause begins", "a pause lasts", "a pause ends"};
  tatu_log(((const pid *)data)->host, call->world, TATU_LOG_INFO, names[moment]);
  return TATU_OK;
}

static const tatu_part pid_kind = {
  .size = sizeof(tatu_part), .id = "pid", .text = "A torque that moves a joint to a position.",
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_TEXT, "joint", NULL, "Path of the joint, in force control."),
    TATU_PARAM(TATU_F64, "p", NULL, "Torque per error, N m/rad.", TATU_DEFAULT_F64(30)),
    TATU_PARAM(TATU_F64, "i", NULL, "Torque per integral of the error, N m/(rad s).", TATU_DEFAULT_F64(20)),
    TATU_PARAM(TATU_F64, "d", NULL, "Torque per speed, N m s/rad.", TATU_DEFAULT_F64(4))),
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "target", "rad", "Wanted position.", TATU_DEFAULT_F64(0))),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "pid.error", "rad", "Wanted minus actual position.")),
  .life = TATU_TABLE(tatu_life, .state_bytes = sizeof(pid_state), .create = create_pid, .destroy = tatu_delete,
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1),
  .physics_step = step_pid, .paused = pause_pid, .end = end_pid};

TATU_PLUGIN(TATU_PARTS(&braitenberg, &pid_kind), .id = "org.example.controllers", .name = "Controllers", .version = "1.0.0",
            .licence = "MIT", .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_READINGS, TATU_NEED_LOG),
            .init = tatu_init_host_api, .shutdown = tatu_delete);
