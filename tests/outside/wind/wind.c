// wind: a part of the world that pushes all dynamic bodies within a box, in proportion to the square of the air's speed
// relative to them.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_wind.so wind.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 60
#include "tatu/host.h"
#include "tatu/part.h"

enum { MOST = 256 };
typedef struct {
  const tatu_host_api *host;
  double low[3], high[3], area;
  tatu_object shapes[MOST]; // dynamic shapes, listed at the beginning of each step
  uint32_t n;
} wind;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  wind *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  const double *low = given->params[0].u.s.ptr, *high = given->params[1].u.s.ptr;
  for (int k = 0; k < 3; k++) it->low[k] = low[k], it->high[k] = high[k];
  it->area = given->params[2].u.f;
  return TATU_OK;
}

static tatu_status TATU_CALL actuate(void *data, const tatu_part_call *call, tatu_error *error) {
  wind *it = data;
  tatu_object all[MOST];
  uint32_t n = 0;
  tatu_status status = it->host->scene->list(call->world, 0, 1u << TATU_KIND_SHAPE, 0, all, MOST, &n);
  if (status < 0) return status;
  if (n > MOST) return tatu_fail(error, TATU_ERR_SPACE, "the wind blows on 256 shapes at most");
  it->n = 0;
  for (uint32_t i = 0; i < n; i++) {
    uint32_t moves = 0;
    if (it->host->bodies->is_dynamic(call->world, all[i], &moves) >= 0 && moves) it->shapes[it->n++] = all[i];
  }
  return TATU_OK;
}

static tatu_status TATU_CALL physics_step(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  const wind *it = data;
  for (uint32_t i = 0; i < it->n; i++) {
    double pose[7], twist[6], force[3], speed = 0;
    tatu_status status = it->host->scene->pose(call->world, it->shapes[i], 0, pose);
    if (status >= 0) status = it->host->bodies->twist(call->world, it->shapes[i], twist);
    if (status == TATU_ERR_GONE) continue; // removed in this step
    if (status < 0) return status;
    int within = 1;
    for (int k = 0; k < 3; k++) within &= pose[k] >= it->low[k] && pose[k] <= it->high[k];
    if (!within) continue;
    for (int k = 0; k < 3; k++) force[k] = call->command[k] - twist[k], speed += force[k] * force[k];
    for (int k = 0; k < 3; k++) force[k] *= 0.5 * 1.2 * it->area * sqrt(speed);
    status = it->host->bodies->push(call->world, it->shapes[i], force, NULL);
    if (status < 0) return status;
  }
  return TATU_OK;
}

static const tatu_part kind = {
  .size = sizeof(tatu_part), .id = "wind", .text = "Pushes bodies within a box.", .actuate = actuate, .physics_step = physics_step,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64S, "low", "m", "Lowest corner of the box.", .count = 3),
    TATU_PARAM(TATU_F64S, "high", "m", "Highest corner of the box.", .count = 3),
    TATU_PARAM(TATU_F64, "area", NULL, "Drag area of each body, m^2.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(0.002))),
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "x", "m/s", "Speed of the air along x.", TATU_DEFAULT_F64(0)),
                          TATU_PARAM(TATU_F64, "y", "m/s", "Speed of the air along y.", TATU_DEFAULT_F64(0)),
                          TATU_PARAM(TATU_F64, "z", "m/s", "Speed of the air along z.", TATU_DEFAULT_F64(0))),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_PARTS(&kind), .id = "org.example.wind", .name = "Wind", .version = "1.0.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_BODIES), .init = tatu_init_host_api, .shutdown = tatu_delete);
