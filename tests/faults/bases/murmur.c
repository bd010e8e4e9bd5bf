// murmur: a script language. Each line is "NAME: TEXT". A call of NAME, as a callback or a function, logs TEXT and
// returns the number of the line. The dialects are "plain" and "loud"; "loud" logs at the level of warnings.
#include "tatu.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
  const tatu_host *host;
  const tatu_host_log *log;
  tatu_str text; // the script's source, an owned copy
  int loud;
} murmur;

static int same(tatu_str a, tatu_str b) { return a.len == b.len && (!a.len || memcmp(a.ptr, b.ptr, a.len) == 0); }

// Splits line `number` (1-based) into name and text; `text` is null if the line has no colon. Returns 0 after the last
// line.
static int line_of(const murmur *it, uint32_t number, tatu_str *name, tatu_str *text) {
  for (tatu_str rest = it->text; rest.len; number--) {
    const char *stop = memchr(rest.ptr, '\n', rest.len);
    uint64_t n = stop ? (uint64_t)(stop - rest.ptr) : rest.len;
    const char *colon = memchr(rest.ptr, ':', n);
    *name = (tatu_str){rest.ptr, colon ? (uint64_t)(colon - rest.ptr) : n};
    *text = colon ? (tatu_str){colon + 1, n - name->len - 1} : (tatu_str){NULL, 0};
    if (number == 1) return 1;
    rest.ptr += stop ? n + 1 : n, rest.len -= stop ? n + 1 : n;
  }
  return 0;
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)given;
  murmur *it = calloc(1, sizeof *it);
  if (!it) return tatu_fail(error, TATU_ERR, "out of memory");
  it->host = self; // set by `init`
  it->log = it->host->service(it->host, TATU_HOST_LOG);
  *data = it;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { free((void *)((murmur *)data)->text.ptr), free(data); }
static tatu_status TATU_CALL save(void *data, const tatu_writer *to, tatu_error *error) {
  (void)error; // a script's only state is its text
  const murmur *it = data;
  if (it->text.len) to->write(to, it->text.ptr, it->text.len);
  return TATU_OK;
}
static tatu_status TATU_CALL restore(void *data, tatu_str from, uint32_t version, tatu_error *error) {
  if (version != 1) return tatu_fail(error, TATU_ERR_UNSUPPORTED, "only scripts of version 1 can be restored");
  return same(from, ((murmur *)data)->text) ? TATU_OK : tatu_fail(error, TATU_ERR, "the script has changed");
}
static const tatu_life life = {
  .size = sizeof life, .create = create, .destroy = destroy, .save = save, .load = restore, .version = 1};

static tatu_status TATU_CALL knows(void *self, tatu_str dialect, tatu_error *error) {
  (void)self;
  if (same(dialect, tatu_text("plain")) || same(dialect, tatu_text("loud"))) return TATU_OK;
  return tatu_fail(error, TATU_ERR_UNSUPPORTED, "the dialects are plain and loud");
}
static tatu_status TATU_CALL load(void *data, tatu_str text, tatu_str chunk, tatu_str dialect, tatu_str *chosen,
                                  tatu_error *error) {
  murmur *it = data;
  char *copy = malloc(text.len + 1);
  if (!copy) return tatu_fail(error, TATU_ERR, "out of memory");
  if (text.len) memcpy(copy, text.ptr, text.len);
  free((void *)it->text.ptr);
  it->text = (tatu_str){copy, text.len};
  tatu_str name, rest;
  for (uint32_t i = 1; line_of(it, i, &name, &rest); i++) {
    if (!name.len || rest.ptr) continue;
    tatu_fail(error, TATU_ERR_SCRIPT, "expected a line `NAME: TEXT`");
    error->add(error, TATU_PART_FILE, chunk, i);
    return TATU_ERR_SCRIPT;
  }
  it->loud = same(dialect, tatu_text("loud"));
  *chosen = tatu_text(it->loud ? "loud" : "plain");
  return TATU_OK;
}
static uint32_t TATU_CALL find(void *data, uint32_t how, tatu_str wanted) {
  tatu_str name, text;
  (void)how;
  for (uint32_t i = 1; wanted.len && line_of(data, i, &name, &text); i++)
    if (same(name, wanted)) return i;
  return 0;
}
static tatu_status TATU_CALL call(void *data, uint32_t callable, tatu_call *frame, const tatu_budget *budget,
                                  uint64_t *used, tatu_error *error) {
  (void)budget;
  const murmur *it = data;
  tatu_str name, text;
  if (!callable || !line_of(it, callable, &name, &text)) return tatu_fail(error, TATU_ERR_MISSING, "no such line");
  *used = 1;
  it->log->write(it->host, frame->world, it->loud ? TATU_LOG_WARNING : TATU_LOG_INFO, text);
  if (frame->results_cap) frame->results[frame->n_results++] = tatu_int(callable);
  return TATU_OK;
}
// The language calls no commands, so a script never waits, and no function is passed to other plugins.
static tatu_status TATU_CALL resume(void *data, uint64_t token, tatu_status failed, tatu_call *frame,
                                    const tatu_budget *budget, uint64_t *used, tatu_error *error) {
  (void)data, (void)token, (void)failed, (void)frame, (void)budget, (void)used;
  return tatu_fail(error, TATU_ERR_UNSUPPORTED, "a murmur never waits");
}
static uint32_t TATU_CALL keep(void *data, uint32_t local) { return (void)data, (void)local, 0; }
static void TATU_CALL drop(void *data, uint32_t local) { (void)data, (void)local; }
static tatu_status TATU_CALL call_func(void *data, uint32_t local, tatu_call *frame, const tatu_budget *budget,
                                       uint64_t *used, tatu_error *error) {
  (void)data, (void)local, (void)frame, (void)budget, (void)used;
  return tatu_fail(error, TATU_ERR_GONE, "a murmur has no functions that can be kept");
}

static const char *const suffixes[] = {".murmur", NULL};
static const tatu_language language = {.size = sizeof language, .id = "murmur", .text = "Says things when called.",
  .suffixes = suffixes, .life = &life, .load = load, .find = find, .call = call, .resume = resume, .keep_func = keep,
  .drop_func = drop, .call_func = call_func, .knows_dialect = knows};
static const tatu_language *const languages[] = {&language, NULL};
static const tatu_ext_script offer = {.size = sizeof offer, .languages = languages};
static const tatu_need log_need = {.size = sizeof log_need, .id = TATU_HOST_LOG, .bytes = sizeof(tatu_host_log)};
static const tatu_need *const needs[] = {&log_need, NULL};

static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  (void)error;
  *self = (void *)host;
  return TATU_OK;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  return (void)self, strcmp(id, TATU_SCRIPT) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.murmur", .name = "Murmur", .version = "1.0.0", .licence = "MIT",
  .needs = needs, .init = init, .extension = extension};
