// notes: commands that store notes for each world, outside the state block; `save` and `load` write and read them.
//   n = notes.put(name, text [, {x, y, z}])   stores or replaces the note `name`; returns the number of notes
//   text, time, place = notes.get(name)       the note, the simulation time at which it was stored, and its position
#include "tatu.h"

#include <stdlib.h>
#include <string.h>

typedef struct note {
  struct note *next;
  double time, place[3];
  uint64_t name_len, text_len;
  char bytes[]; // name, then text
} note;
typedef struct {
  const tatu_host_scene *scene;
  tatu_prop time;
  note *first;
} board;

static note *find(const board *of, tatu_str name) {
  note *it = of->first;
  while (it && (it->name_len != name.len || (name.len && memcmp(it->bytes, name.ptr, name.len) != 0))) it = it->next;
  return it;
}
static note *add(board *to, uint64_t name_len, uint64_t text_len) {
  note *made = calloc(1, sizeof *made + name_len + text_len), **end = &to->first;
  if (!made) return NULL;
  made->name_len = name_len, made->text_len = text_len;
  while (*end) end = &(*end)->next;
  return *end = made;
}

static tatu_status TATU_CALL put(tatu_call *call) {
  board *here = call->instance;
  tatu_str name = tatu_arg_text(call, 0), text = tatu_arg_text(call, 1);
  double time;
  tatu_status status = here->scene->get_f64(call->world, 0, here->time, &time, 1);
  if (status < 0) return status; // the host has already set the error
  note *old = find(here, name), *made = add(here, name.len, text.len);
  if (!made) return tatu_call_fail(call, TATU_ERR, "out of memory");
  if (name.len) memcpy(made->bytes, name.ptr, name.len);
  if (text.len) memcpy(made->bytes + name.len, text.ptr, text.len);
  made->time = time;
  if (tatu_has_arg(call, 2)) memcpy(made->place, call->args[2].u.s.ptr, sizeof made->place);
  int64_t n = 0;
  for (note **at = &here->first; *at;) {
    note *it = *at;
    if (it == old) *at = it->next, free(it);
    else n++, at = &it->next;
  }
  return tatu_return(call, tatu_int(n));
}

static tatu_status TATU_CALL get(tatu_call *call) {
  const note *it = find(call->instance, tatu_arg_text(call, 0));
  if (!it) return tatu_call_fail(call, TATU_ERR_MISSING, "there is no note of that name");
  void *text = tatu_keep(call, it->bytes + it->name_len, it->text_len);
  void *place = tatu_keep(call, it->place, sizeof it->place);
  if (!text || !place) return tatu_call_fail(call, TATU_ERR_SPACE, "no room for the results");
  tatu_status status = tatu_return(call, tatu_span(TATU_TEXT, text, it->text_len));
  if (status >= 0) status = tatu_return(call, tatu_float(it->time));
  return status < 0 ? status : tatu_return(call, tatu_span(TATU_F64S, place, 3));
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  const tatu_host *host = self; // `init` stores the host
  board *made = calloc(1, sizeof *made);
  (void)given;
  if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
  made->scene = host->service(host, TATU_HOST_SCENE), made->time = made->scene->prop(host, "scene.time");
  *data = made;
  return TATU_OK;
}
static void clear(board *it) {
  for (note *next; it->first; it->first = next) next = it->first->next, free(it->first);
}
static void TATU_CALL destroy(void *data) { clear(data), free(data); }

// A snapshot contains, for each note, the fields of the struct from `time` on, then its bytes. This is version 2;
// version 1 had no positions.
#define HEAD (sizeof(note) - offsetof(note, time))
static tatu_status TATU_CALL save(void *data, const tatu_writer *to, tatu_error *error) {
  (void)error;
  for (const note *it = ((board *)data)->first; it; it = it->next)
    to->write(to, &it->time, HEAD + it->name_len + it->text_len);
  return TATU_OK;
}
static tatu_status TATU_CALL load(void *data, tatu_str from, uint32_t version, tatu_error *error) {
  board *here = data;
  if (version != 2) return tatu_fail(error, TATU_ERR_UNSUPPORTED, "only notes of version 2 can be read");
  clear(here);
  for (note head; from.len;) {
    if (from.len < HEAD) return tatu_fail(error, TATU_ERR, "the saved notes end within a note");
    memcpy(&head.time, from.ptr, HEAD);
    from.ptr += HEAD, from.len -= HEAD;
    if (head.name_len > from.len || head.text_len > from.len - head.name_len)
      return tatu_fail(error, TATU_ERR, "the saved notes end within a text");
    note *made = add(here, head.name_len, head.text_len);
    if (!made) return tatu_fail(error, TATU_ERR, "out of memory");
    memcpy(&made->time, &head.time, HEAD);
    memcpy(made->bytes, from.ptr, head.name_len + head.text_len);
    from.ptr += head.name_len + head.text_len, from.len -= head.name_len + head.text_len;
  }
  return TATU_OK;
}
static const tatu_life life = {
  .size = sizeof life, .create = create, .destroy = destroy, .save = save, .load = load, .version = 2};

#define PARAM(...) &(const tatu_param){.size = sizeof(tatu_param), __VA_ARGS__}
#define PARAMS(...) (const tatu_param *const[]){__VA_ARGS__, NULL}
#define NAMES(n) (const tatu_name *const[]){&(const tatu_name){.size = sizeof(tatu_name), .name = n}, NULL}
static const tatu_command put_command = {.size = sizeof put_command, .names = NAMES("notes.put"), .call = put,
  .params = PARAMS(PARAM(.type = TATU_TEXT, .key = "name", .text = "Of the note."),
                   PARAM(.type = TATU_TEXT, .key = "text", .text = "What is kept."),
                   PARAM(.type = TATU_F64S, .count = 3, .flags = TATU_PARAM_OPTIONAL, .key = "place", .unit = "m",
                         .text = "Where, in the world's frame.")),
  .text = "Keeps a note.", .example = "assert(notes.put('example', 'text', {1, 2, 3}) >= 1)"};
static const tatu_command get_command = {.size = sizeof get_command, .names = NAMES("notes.get"), .call = get,
  .params = PARAMS(PARAM(.type = TATU_TEXT, .key = "name", .text = "Of the note.")),
  .text = "Gives a note.", .example = "notes.put('example', 'text')\nassert(notes.get('example') == 'text')"};
static const tatu_command *const commands[] = {&put_command, &get_command, NULL};
static const tatu_ext_command offer = {.size = sizeof offer, .commands = commands, .per_world = &life};

static const tatu_need scene_need = {
  .size = sizeof scene_need, .id = TATU_HOST_SCENE, .bytes = sizeof(tatu_host_scene)};
static const tatu_need *const needs[] = {&scene_need, NULL};
static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  (void)error;
  *self = (void *)host;
  return TATU_OK;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  return (void)self, strcmp(id, TATU_COMMAND) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.notes", .name = "Notes", .version = "1.0.0", .licence = "MIT",
  .needs = needs, .init = init, .extension = extension};
