// surfaces: a part that decides on the contacts of the shape that it belongs to, and a plugin that counts events.
//   surface   mode "open": other shapes pass through; "ice": no friction; "belt": the surface moves; "bouncy": restitution
//   surfaces.counts() -> how many events of each kind the plugin has received in this world
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_surfaces.so surfaces.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 40
#include "tatu/command.h"
#include "tatu/event.h"
#include "tatu/host.h"
#include "tatu/part.h"

#include <string.h>

// ---------------------------------------------------------------- The part ------------------------------------------

typedef struct {
  const tatu_host_api *host;
  char mode[8], with[64]; // path of the only shape on whose contact it decides; empty: all
} surface;
typedef struct {
  double hooked, calls, begun, removed; // removed: objects of whose removal it was told
} surface_state;

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  surface *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  uint64_t n = given->params[0].u.s.len;
  memcpy(it->mode, given->params[0].u.s.ptr, n < 7 ? n : 7);
  n = given->params[1].u.s.len;
  if (n > 63) n = 63;
  if (n) memcpy(it->with, given->params[1].u.s.ptr, n);
  return TATU_OK;
}

// Registers the shape with all that it touches, or with one other shape, on which it then decides before they touch. A
// stop ends the registration, and zeroes the state.
static tatu_status TATU_CALL actuate(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)error;
  const surface *it = data;
  surface_state *now = call->state;
  if (now->hooked > 0) return TATU_OK;
  now->hooked = 1;
  tatu_object other = 0;
  tatu_status status = TATU_OK;
  if (it->with[0]) status = it->host->scene->find(call->world, 0, tatu_text(it->with), &other);
  return status < 0 ? status : it->host->bodies->hook(call->world, call->part, call->owner, other, 1);
}

static tatu_status TATU_CALL contact(void *data, const tatu_part_call *call, tatu_contact_pair *pair, tatu_error *error) {
  (void)error;
  const surface *it = data;
  ((surface_state *)call->state)->calls += 1;
  // The surface of the first shape moves; if that is the other one, it must move the other way.
  double side = TATU_SLOT(pair->contact.shape[0]) == TATU_SLOT(call->owner) ? 1 : -1;
  if (!strcmp(it->mode, "open")) pair->collide = 0;
  if (!strcmp(it->mode, "ice")) pair->friction = 0;
  if (!strcmp(it->mode, "belt")) pair->surface[0] = 0.3 * side;
  if (!strcmp(it->mode, "bouncy")) pair->restitution = 0.8;
  return TATU_OK;
}

static tatu_status TATU_CALL event(void *data, const tatu_part_call *call, tatu_str name, const tatu_value *payload,
                                   tatu_error *error) {
  (void)data;
  surface_state *now = call->state;
  if (tatu_str_is(name, "started")) now->begun += 1;
  if (!tatu_str_is(name, "object_removed")) return TATU_OK;
  const tatu_value *kind = tatu_map_get(payload, "kind");
  if (!kind || kind->tag != TATU_TEXT) return tatu_fail(error, TATU_ERR, "the event has no kind");
  now->removed += 1;
  return TATU_OK;
}

static tatu_status TATU_CALL sense(void *data, const tatu_part_call *call, tatu_error *error) {
  (void)data, (void)error;
  const surface_state *now = call->state;
  *(double *)tatu_part_field(call, 0) = now->calls;
  *(double *)tatu_part_field(call, 1) = now->begun;
  *(double *)tatu_part_field(call, 2) = now->removed;
  return TATU_OK;
}

static const tatu_part kind = {
  .size = sizeof(tatu_part), .id = "surface", .text = "Decides on the contacts of a shape.", .actuate = actuate, .sense = sense,
  .params = TATU_PARAMS(TATU_PARAM(TATU_TEXT, "mode", NULL, "What it does.", .choices = TATU_TEXTS("open", "ice", "belt", "bouncy", "none")),
                        TATU_PARAM(TATU_TEXT, "with", NULL, "Path of the only shape that it decides on; empty: all.", TATU_DEFAULT_TEXT(""))),
  .schemas = TATU_TEXTS("surface/1"),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "surface.calls", NULL, "Number of decisions."),
                        TATU_FIELD(TATU_ELEM_F64, "surface.begun", NULL, "Number of starts."),
                        TATU_FIELD(TATU_ELEM_F64, "surface.removed", NULL, "Number of objects removed.")),
  .life = TATU_TABLE(tatu_life, .state_bytes = sizeof(surface_state), .create = create, .destroy = tatu_delete,
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1),
  .event = event, .events = TATU_TEXTS("started", "object_removed"), .contact = contact};

// ---------------------------------------------------------------- The listener --------------------------------------

typedef struct {
  int64_t added, removed, contact, separation;
} counts;

static tatu_status TATU_CALL heard(void *self, void *instance, void *state, tatu_world *world, tatu_str name,
                                   const tatu_value *payload, tatu_error *error) {
  (void)self, (void)instance, (void)world;
  counts *n = state;
  if (payload->tag != TATU_MAP) return tatu_fail(error, TATU_ERR, "the payload is not a map");
  if (tatu_str_is(name, "object_added")) n->added++;
  if (tatu_str_is(name, "object_removed")) n->removed++;
  if (tatu_str_is(name, "separation")) n->separation++;
  if (!tatu_str_is(name, "contact")) return TATU_OK;
  n->contact++;
  const tatu_value *force = tatu_map_get(payload, "force");
  return force && force->tag == TATU_F64 ? TATU_OK : tatu_fail(error, TATU_ERR, "the contact has no force");
}

static tatu_status TATU_CALL tell(tatu_call *call) {
  const counts *n = call->state;
  tatu_status status = tatu_return(call, tatu_int(n->added));
  if (status >= 0) status = tatu_return(call, tatu_int(n->removed));
  if (status >= 0) status = tatu_return(call, tatu_int(n->contact));
  return status < 0 ? status : tatu_return(call, tatu_int(n->separation));
}

static const tatu_command tell_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("surfaces.counts"), .call = tell,
  .text = "Returns how many events of each kind there were.", .example = "surfaces.counts()", .subject = "surfaces",
  .returns = TATU_PARAMS(TATU_PARAM(TATU_I64, "added", NULL, "Objects added."), TATU_PARAM(TATU_I64, "removed", NULL, "Objects removed."),
                         TATU_PARAM(TATU_I64, "contact", NULL, "Contacts."), TATU_PARAM(TATU_I64, "separation", NULL, "Ends of contacts."))};

TATU_PLUGIN(TATU_OFFERS(TATU_PARTS(&kind),
                        TATU_COMMANDS_PER_WORLD(TATU_TABLE(tatu_life, .state_bytes = sizeof(counts), .version = 1), &tell_command),
                        TATU_LISTENS(heard, "object_added", "object_removed", "contact", "separation")),
            .id = "org.example.surfaces", .name = "Surfaces", .version = "1.0.0", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_BODIES), .init = tatu_init_host_api, .shutdown = tatu_delete);
