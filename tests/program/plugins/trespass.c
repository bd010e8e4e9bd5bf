/* A sensor that calls forbidden functions in the callback selected by its parameter `where`, and prints "TRESPASSED"
 * for each call that is not refused. The command `nosy.thread()` does the same on a separate thread, and `nosy.nulls()`
 * passes null pointers. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include "tatu.h"

static const tatu_host *host;
static const tatu_host_scene *scene;
static const tatu_host_commands *commands;
static const tatu_host_log *out;

static void told(tatu_world *w, const char *what, int allowed) {
  char text[120];
  snprintf(text, sizeof text, "%s %s", allowed ? "TRESPASSED" : "was refused:", what);
  out->write(host, w, TATU_LOG_INFO, tatu_text(text));
}

#define TRY(call) told(w, #call, (call) == TATU_OK)

/* Calls functions that change the world, which are allowed only during a step. */
static void act(tatu_world *w, tatu_object o) {
  const tatu_host_signals *signals = host->service(host, TATU_HOST_SIGNALS);
  const tatu_host_events *events = host->service(host, TATU_HOST_EVENTS);
  const tatu_host_session *session = host->service(host, TATU_HOST_SESSION);
  const tatu_host_stage *stage = host->service(host, TATU_HOST_STAGE);
  const tatu_host_bodies *bodies = host->service(host, TATU_HOST_BODIES);
  tatu_value value = tatu_int(1), results[16];
  tatu_call frame = tatu_frame(0, 0, results, 16);
  tatu_object made = 0;
  double pose[7] = {1, 2, 3, 0, 0, 0, 1};
  frame.command = 1;
  TRY(scene->set_pose(w, o, 0, pose));
  TRY(scene->set(w, o, scene->prop(host, "object.alias"), &value));
  TRY(scene->create(w, "dummy", 0, tatu_text("made"), &made));
  TRY(scene->remove(w, &o, 1));
  TRY(bodies->impulse(w, o, pose, 0));
  TRY(commands->call(w, &frame));
  TRY(signals->set(w, 0, tatu_text("s"), &value));
  TRY(events->publish(w, tatu_text("nosy.was"), 0));
  TRY(session->request(w, TATU_REQUEST_STOP));
  TRY(stage->run(w, TATU_STAGE_PHYSICS, 0.05));
}

/* Calls functions that read the world, which are forbidden in a batch. */
static void look(tatu_world *w, tatu_object o) {
  const tatu_host_files *files = host->service(host, TATU_HOST_FILES);
  const tatu_host_bodies *bodies = host->service(host, TATU_HOST_BODIES);
  tatu_value value;
  tatu_contact touching[2];
  tatu_str path;
  double pose[7];
  uint32_t n = 0;
  TRY(scene->pose(w, o, 0, pose));
  TRY(scene->get(w, o, scene->prop(host, "object.alias"), &value));
  TRY(bodies->contacts(w, 0, touching, 2, &n));
  TRY(files->resolve(w, tatu_text("scene.toml"), TATU_FILE_READ, &path));
  told(w, "commands->alloc", commands->alloc(w, 8) != 0);
}

typedef struct { tatu_world *world; tatu_object self; char where[16]; } nosy;

static void maybe(nosy *n, const char *where) {
  if (strcmp(n->where, where)) return;
  act(n->world, n->self);
}

static nosy all[64];
static uint32_t made;

static tatu_status TATU_CALL create(void *me, const tatu_instance *i, void **data, tatu_error *e) {
  nosy *n = &all[made++ % 64];
  (void)me; (void)e;
  memset(n, 0, sizeof *n);
  n->world = i->world;
  n->self = i->owner;
  memcpy(n->where, i->params[0].u.s.ptr, i->params[0].u.s.len < 15 ? i->params[0].u.s.len : 15);
  *data = n;
  maybe(n, "create");
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { maybe(data, "destroy"); }
static tatu_status TATU_CALL configure(void *data, const tatu_value *p, uint32_t n, uint64_t changed, tatu_error *e) {
  (void)p; (void)n; (void)changed; (void)e;
  maybe(data, "configure");
  return TATU_OK;
}
static tatu_status TATU_CALL save(void *data, const tatu_writer *w, tatu_error *e) {
  (void)w; (void)e;
  maybe(data, "save");
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str bytes, uint32_t version, tatu_error *e) {
  (void)data; (void)bytes; (void)version; (void)e;
  return TATU_OK;
}
static tatu_status TATU_CALL beams(void *data, tatu_beams *b, tatu_error *e) {
  (void)b; (void)e;
  maybe(data, "beams");
  return TATU_OK;
}
static tatu_status TATU_CALL measure(void *me, const tatu_sensor_batch *b, tatu_error *e) {
  uint32_t i;
  (void)me; (void)e;
  for (i = 0; i < b->n; i++) {
    nosy *n = b->data[i];
    maybe(n, "measure");
    if (!strcmp(n->where, "measure")) look(n->world, n->self);
    *(double *)b->fields[i] = 1;
  }
  return TATU_OK;
}

static void *from_elsewhere(void *world) {
  act(world, 1);
  look(world, 1);
  return 0;
}
static tatu_status TATU_CALL thread(tatu_call *c) {
  pthread_t t;
  if (pthread_create(&t, 0, from_elsewhere, c->world)) return tatu_call_fail(c, TATU_ERR, "no thread");
  pthread_join(t, 0);
  return TATU_OK;
}
static tatu_status TATU_CALL nulls(tatu_call *c) {
  tatu_world *w = c->world;
  const tatu_host_readings *readings = host->service(host, TATU_HOST_READINGS);
  const tatu_host_bodies *bodies = host->service(host, TATU_HOST_BODIES);
  const tatu_host_scripts *scripts = host->service(host, TATU_HOST_SCRIPTS);
  const tatu_host_signals *signals = host->service(host, TATU_HOST_SIGNALS);
  const tatu_host_figures *figures = host->service(host, TATU_HOST_FIGURES);
  const tatu_host_files *files = host->service(host, TATU_HOST_FILES);
  tatu_object one = tatu_arg_object(c, 0);
  tatu_prop mass = scene->prop(host, "object.position");
  tatu_call frame = tatu_frame(0, 2, 0, 16);
  double pose[7] = {0}, points[6];
  tatu_object pair[2];
  frame.command = 1;
  TRY(scene->pose(w, one, 0, 0));
  TRY(scene->set_pose(w, one, 0, 0));
  TRY(scene->get(w, one, mass, 0));
  TRY(scene->set(w, one, mass, 0));
  TRY(scene->get_f64(w, one, mass, 0, 3));
  TRY(scene->set_f64(w, one, mass, 0, 3));
  TRY(scene->get_f64_many(w, 0, 2, mass, 0, 3));
  TRY(scene->set_f64_many(w, &one, 1, mass, 0, 3));
  TRY(scene->find(w, 0, tatu_text("/eye"), 0));
  TRY(scene->create(w, "dummy", 0, tatu_text("d"), 0));
  TRY(scene->remove(w, 0, 3));
  TRY(scene->copy(w, 0, 1, 0));
  TRY(scene->row(w, one, 0, 0));
  TRY(readings->field(w, one, scene->prop(host, "nosy.number"), 0));
  TRY(readings->look(w, one, 0));
  TRY(readings->describe(w, one, 0, 0));
  TRY(bodies->twist(w, one, 0));
  TRY(bodies->set_twist(w, one, 0));
  TRY(bodies->is_dynamic(w, one, 0));
  TRY(bodies->closest_at(w, &one, 0, 1, 0, 0, 0, points, pair));
  TRY(bodies->closest_at(w, 0, pose, 1, 0, 0, 0, points, pair));
  TRY(bodies->closest_at(w, &one, pose, 1, 0, 0, 0, points, pair)); /* no quaternion */
  TRY(commands->call(w, 0));
  TRY(commands->call(w, &frame));
  TRY(commands->constant(w, tatu_text("sim.handle_all"), 0));
  TRY(commands->prelude(w, "lua", 0, 0, 0));
  TRY(commands->call_func(w, 7, 0));
  TRY(scripts->call(w, one, tatu_text("f"), 0));
  TRY(scripts->broadcast(w, tatu_text("x"), 0, 4, 0));
  TRY(signals->set(w, 0, tatu_text("s"), 0));
  TRY(figures->add(w, 0, TATU_FIGURE_DRAWING, 0, 0));
  TRY(files->resolve(w, tatu_text("scene.toml"), TATU_FILE_READ, 0));
  TRY(scene->pose(0, one, 0, 0));
  return TATU_OK;
}

static tatu_status TATU_CALL init(const tatu_host *h, void **me, tatu_error *e) {
  (void)me; (void)e;
  host = h;
  scene = h->service(h, TATU_HOST_SCENE);
  commands = h->service(h, TATU_HOST_COMMANDS);
  out = h->service(h, TATU_HOST_LOG);
  return TATU_OK;
}

static const tatu_param where = {sizeof where, TATU_TEXT, 0, TATU_PARAM_REBUILDS, "where", 0, 0, 0, {TATU_TEXT, 0, {0}}, 0, "Where.", 0};
static const tatu_param knob = {sizeof knob, TATU_F64, 0, 0, "knob", 0, 0, 0, {TATU_F64, 0, {0}}, 0, "A knob.", 0};
static const tatu_param *const params[] = {&where, &knob, 0};
static const tatu_field number = {sizeof number, TATU_ELEM_F64, {1, 1, 1}, 0, "nosy.number", "1", "One.", 0, 0};
static const tatu_field *const fields[] = {&number, 0};
static const char *const schemas[] = {"nosy/1", 0};
static const tatu_life life = {.size = sizeof life, .create = create, .destroy = destroy, .configure = configure, .save = save, .load = load, .version = 1};
static const tatu_sensor kind = {sizeof kind, 0, "nosy", "Calls what it may not.", schemas, params, fields, &life, beams, measure, 0, 0, 0, 0, 0};
static const tatu_sensor *const kinds[] = {&kind, 0};
static const tatu_ext_sensor sensors = {sizeof sensors, 0, kinds};

static const tatu_name n_thread = {sizeof n_thread, 0, "nosy.thread", 0, 0, 0, 0}, n_nulls = {sizeof n_nulls, 0, "nosy.nulls", 0, 0, 0, 0};
static const tatu_name *const names_thread[] = {&n_thread, 0}, *const names_nulls[] = {&n_nulls, 0};
static const tatu_command c_thread = {sizeof c_thread, 0, names_thread, 0, 0, "Acts from a thread.", 0, 0, 0, thread, 0, 0, 0, 0};
static const tatu_command c_nulls = {sizeof c_nulls, TATU_COMMAND_RAW, names_nulls, 0, 0, "Passes null.", 0, 0, 0, nulls, 0, 0, 0, 0};
static const tatu_command *const list[] = {&c_thread, &c_nulls, 0};
static const tatu_ext_command ext = {sizeof ext, 0, list, 0, 0, 0, 0};

static const void *TATU_CALL extension(void *me, const char *id) {
  (void)me;
  if (!strcmp(id, TATU_SENSOR)) return &sensors;
  return strcmp(id, TATU_COMMAND) ? 0 : &ext;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {sizeof tatu_plugin, TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.nosy", "Nosy",
  "1.0.0", "MIT", 0, init, 0, extension};
