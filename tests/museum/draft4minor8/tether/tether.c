// tether: a part that pulls two bodies together once they are farther apart than its length, with equal and opposite
// forces before each physics step.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_tether.so tether.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 100
#include "tatu/host.h"
#include "tatu/part.h"

typedef struct {
  const tatu_host_api *host;
  tatu_object other;
  double length, stiffness, damping;
} tether;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  tether *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  tatu_str path = {given->params[0].u.s.ptr, given->params[0].u.s.len};
  it->length = given->params[1].u.f, it->stiffness = given->params[2].u.f, it->damping = given->params[3].u.f;
  if (it->host->scene->find(given->world, given->owner, path, &it->other) >= 0) return TATU_OK;
  tatu_delete(it);
  *data = NULL;
  return tatu_fail(error, TATU_ERR_MISSING, "the parameter `other` is not the path of an object");
}

static tatu_status TATU_CALL physics_step(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  const tether *it = data;
  double a[7], b[7], va[6], vb[6], along[3], force[3], distance = 0, speed = 0;
  tatu_status status = it->host->scene->pose(call->world, call->owner, 0, a);
  if (status >= 0) status = it->host->scene->pose(call->world, it->other, 0, b);
  if (status >= 0) status = it->host->bodies->twist(call->world, call->owner, va);
  if (status >= 0) status = it->host->bodies->twist(call->world, it->other, vb);
  if (status < 0) return status;
  for (int k = 0; k < 3; k++) along[k] = b[k] - a[k], distance += along[k] * along[k];
  distance = sqrt(distance);
  *(double *)tatu_part_field(call, 0) = 0;
  if (distance <= it->length) return TATU_OK;
  for (int k = 0; k < 3; k++) along[k] /= distance, speed += (vb[k] - va[k]) * along[k];
  double tension = fmax(0, it->stiffness * (distance - it->length) + it->damping * speed);
  *(double *)tatu_part_field(call, 0) = tension;
  for (int k = 0; k < 3; k++) force[k] = tension * along[k];
  status = it->host->bodies->push(call->world, call->owner, force, NULL);
  for (int k = 0; k < 3; k++) force[k] = -force[k];
  return status < 0 ? status : it->host->bodies->push(call->world, it->other, force, NULL);
}

static const tatu_part kind = {
  .size = sizeof(tatu_part), .id = "tether", .text = "Pulls two bodies together.", .physics_step = physics_step,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_TEXT, "other", NULL, "Path of the other body."),
    TATU_PARAM(TATU_F64, "length", "m", "Length without tension.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(1)),
    TATU_PARAM(TATU_F64, "stiffness", NULL, "Tension per extension, N/m.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(200)),
    TATU_PARAM(TATU_F64, "damping", NULL, "Tension per speed, N s/m.", TATU_AT_LEAST(0), TATU_DEFAULT_F64(5))),
  .schemas = TATU_TEXTS("tether/1"),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "tether.tension", "N", "Tension in the last physics step.")),
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .save = tatu_save_nothing,
                     .load = tatu_load_nothing, .version = 1)};

TATU_PLUGIN(TATU_PARTS(&kind), .id = "org.example.tether", .name = "Tether", .version = "1.0.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_BODIES), .init = tatu_init_host_api, .shutdown = tatu_delete);
