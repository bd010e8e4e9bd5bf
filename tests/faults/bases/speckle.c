// speckle: a sensor kind with its own schema, a fan of rays some of which are lost at random.
//   speckle.distance  per ray, m, rounded to steps   speckle.hit  per ray, 1 or 0     speckle.age  s since the setup
#include "tatu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 64 };

typedef struct { // stored in the host's state block
  double since;
} state;
typedef struct {
  const tatu_host_scene *scene;
  tatu_prop time;
  tatu_world *world; // for `configure`
  state *kept;
  double range, lost, ways[MOST][3];
  uint32_t rays;
} speckle;

static double now(const speckle *it) {
  double time = 0;
  it->scene->get_f64(it->world, 0, it->time, &time, 1);
  return time;
}
static void take(speckle *it, const tatu_value *params) {
  it->range = params[0].u.f;
  it->lost = params[1].u.f;
  it->rays = (uint32_t)params[2].u.i;
  for (uint32_t k = 0; k < it->rays; k++) {
    double angle = (k + 0.5) / it->rays - 0.5;
    it->ways[k][0] = sin(angle), it->ways[k][1] = 0, it->ways[k][2] = cos(angle);
  }
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  const tatu_host *host = self; // `init` stores the host
  speckle *it = calloc(1, sizeof *it);
  if (!it) return tatu_fail(error, TATU_ERR, "out of memory");
  it->scene = host->service(host, TATU_HOST_SCENE), it->time = it->scene->prop(host, "scene.time");
  it->world = given->world, it->kept = given->state;
  take(it, given->params);
  it->kept->since = now(it);
  *data = it;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { free(data); }
static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t n, uint64_t changed,
                                       tatu_error *error) {
  (void)n, (void)changed, (void)error;
  speckle *it = data;
  take(it, params);
  it->kept->since = now(it);
  return TATU_OK;
}
// Writes nothing: everything outside the state block is derived from the parameters.
static tatu_status TATU_CALL save(void *data, const tatu_writer *to, tatu_error *error) {
  (void)data, (void)to, (void)error;
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str from, uint32_t version, tatu_error *error) {
  (void)data, (void)version;
  return from.len ? tatu_fail(error, TATU_ERR, "a speckle saves nothing but its block") : TATU_OK;
}
static const tatu_life life = {.size = sizeof life, .state_bytes = sizeof(state), .create = create,
  .destroy = destroy, .configure = configure, .save = save, .load = load, .version = 1};

static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
  (void)error;
  const speckle *it = data;
  out->form = TATU_BEAMS_RAYS, out->count[0] = it->rays, out->directions = it->ways[0];
  out->near_m = 0, out->far_m = it->range, out->max_incidence = acos(-1.0) / 2;
  return TATU_OK;
}

static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *batch, tatu_error *error) {
  (void)self, (void)error;
  for (uint32_t i = 0; i < batch->n; i++) {
    const speckle *it = batch->data[i];
    void *const *fields = batch->fields + (size_t)i * batch->n_fields;
    double *distance = fields[0], *age = fields[2], luck[MOST];
    int32_t *hit = fields[1];
    const double *seen = batch->distance + batch->first_beam[i];
    batch->random->uniform(batch->random, i, 0, it->rays, luck);
    for (uint32_t k = 0; k < it->rays; k++) {
      if (!isfinite(seen[k]) || luck[k] < it->lost) continue;
      distance[k] = floor(seen[k] * 1000) / 1000;
      hit[k] = 1;
    }
    *age = batch->time - ((const state *)batch->state[i])->since;
  }
  return TATU_OK;
}

#define PARAM(...) &(const tatu_param){.size = sizeof(tatu_param), __VA_ARGS__}
#define FIELD(...) &(const tatu_field){.size = sizeof(tatu_field), __VA_ARGS__}
static const tatu_param *const params[] = {
  PARAM(.type = TATU_F64, .key = "range", .unit = "m", .lowest = 0.1, .highest = 100,
        .fallback = {.tag = TATU_F64, .u.f = 5}, .text = "How far it sees."),
  PARAM(.type = TATU_F64, .key = "lost", .unit = "1", .lowest = 0, .highest = 1,
        .fallback = {.tag = TATU_F64, .u.f = 0.25}, .text = "Share of the rays that are lost."),
  PARAM(.type = TATU_I64, .key = "rays", .lowest = 1, .highest = MOST, .flags = TATU_PARAM_REBUILDS,
        .fallback = {.tag = TATU_I64, .u.i = 5}, .text = "Number of rays."), NULL};
static const tatu_field *const fields[] = {
  FIELD(.elem = TATU_ELEM_F64, .dims = {0, 1, 1}, .name = "speckle.distance", .unit = "m", .valid = "speckle.hit",
        .nothing = "0", .text = "Distance along each ray."),
  FIELD(.elem = TATU_ELEM_I32, .dims = {0, 1, 1}, .name = "speckle.hit", .nothing = "0", .text = "Whether it hit."),
  FIELD(.elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "speckle.age", .unit = "s", .text = "Since it was set up."),
  NULL};
static const char *const schemas[] = {"speckle/1", NULL};
static const tatu_sensor kind = {.size = sizeof kind, .inputs = TATU_IN_DISTANCE, .id = "speckle", .schemas = schemas,
  .text = "A fan of rays of which some are lost.", .params = params, .fields = fields, .life = &life, .beams = beams,
  .measure = measure};
static const tatu_sensor *const kinds[] = {&kind, NULL};
static const tatu_ext_sensor offer = {.size = sizeof offer, .kinds = kinds};

static const tatu_need scene_need = {
  .size = sizeof scene_need, .id = TATU_HOST_SCENE, .bytes = sizeof(tatu_host_scene)};
static const tatu_need *const needs[] = {&scene_need, NULL};
static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  (void)error;
  *self = (void *)host;
  return TATU_OK;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  return (void)self, strcmp(id, TATU_SENSOR) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.speckle", .name = "Speckle", .version = "1.0.0", .licence = "MIT",
  .needs = needs, .init = init, .extension = extension};
