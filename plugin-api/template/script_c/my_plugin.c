// my_plugin: a script language in C. Each line of a script names a callback or a function, and a command with
// arguments:
//   init        sim.setInt32Signal ready 1
//   actuation   my_robot.go 0.5
// A line runs when its callback or function is called. Arguments are numbers or words.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/host.h"
#include "tatu/script.h"

#include <string.h>

enum { MOST_WORDS = 18 }; // per line: a name, a command and its arguments; further words are ignored

// A script. Its only state is its text.
typedef struct {
  const tatu_host_api *host;
  char *text;
  uint64_t len;
} script;

// Splits the first line of `rest` into words, and removes it from `rest`. Returns the number of words, 0 for a comment.
static uint32_t words_of(tatu_str *rest, tatu_str *words) {
  uint32_t n = 0;
  const char *at = rest->ptr, *end = at + rest->len;
  while (at < end && *at != '\n') {
    const char *from = at;
    while (at < end && *at != '\n' && *at != ' ' && *at != '\t' && *at != '\r') at++;
    if (at > from && n < MOST_WORDS) words[n++] = (tatu_str){from, (uint64_t)(at - from)};
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r')) at++;
  }
  if (at < end) at++;
  *rest = (tatu_str){at, (uint64_t)(end - at)};
  return n && words[0].ptr[0] == '#' ? 0 : n;
}

// Converts a word to a number if possible, otherwise to a text, which points into the script and so outlives the call.
static tatu_value value_of(tatu_str word) {
  char text[64], *end;
  if (word.len < sizeof text) {
    memcpy(text, word.ptr, word.len);
    text[word.len] = 0;
    double x = strtod(text, &end);
    if (end != text && !*end) return x == floor(x) && fabs(x) < 1e15 ? tatu_int((int64_t)x) : tatu_float(x);
  }
  return tatu_span(TATU_TEXT, word.ptr, word.len);
}

static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)given;
  script *it = tatu_new(sizeof *it, data, error);
  if (!it) return TATU_ERR_SPACE;
  it->host = self;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) {
  script *it = data;
  free(it->text);
  free(it);
}

// Snapshots: the only state of a script is its text, which must be the same when it is restored.
static tatu_status TATU_CALL save(void *data, const tatu_writer *to, tatu_error *error) {
  const script *it = data;
  (void)error;
  if (it->len) to->write(to, it->text, it->len);
  return TATU_OK;
}
static tatu_status TATU_CALL restore(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  const script *it = data;
  if (version == 1 && bytes.len == it->len && (!it->len || memcmp(bytes.ptr, it->text, it->len) == 0)) return TATU_OK;
  return tatu_fail(error, TATU_ERR_UNSUPPORTED, "the text of the script has changed since the snapshot");
}

// Stores the text, and checks that each line has a command.
static tatu_status TATU_CALL load(void *data, tatu_str text, tatu_str chunk, tatu_str dialect, tatu_str *chosen,
                                  tatu_error *error) {
  script *it = data;
  (void)dialect;
  char *copy = malloc(text.len + 1);
  if (!copy) return tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  if (text.len) memcpy(copy, text.ptr, text.len);
  free(it->text);
  it->text = copy, it->len = text.len;
  *chosen = tatu_text("1");
  tatu_str rest = {it->text, it->len}, words[MOST_WORDS];
  for (uint64_t line = 1; rest.len; line++)
    if (words_of(&rest, words) == 1)
      return tatu_fail_line(error, TATU_ERR_SCRIPT, "expected a command after the name", chunk, line);
  return TATU_OK;
}

// Returns the number of the first line that begins with this name, or 0.
static uint32_t TATU_CALL find(void *data, uint32_t how, tatu_str name) {
  const script *it = data;
  (void)how;
  tatu_str rest = {it->text, it->len}, words[MOST_WORDS];
  for (uint32_t line = 1; rest.len; line++)
    if (words_of(&rest, words) && words[0].len == name.len && memcmp(words[0].ptr, name.ptr, name.len) == 0) return line;
  return 0;
}

// Runs the lines that begin with the same name as line `callable`.
static tatu_status TATU_CALL call(void *data, uint32_t callable, tatu_call *frame, const tatu_budget *budget,
                                  uint64_t *used, tatu_error *error) {
  const script *it = data;
  (void)budget; // a call runs each line at most once, so no limit is needed
  tatu_str rest = {it->text, it->len}, words[MOST_WORDS], name = {NULL, 0};
  for (uint32_t line = 1; rest.len; line++) {
    uint32_t n = words_of(&rest, words);
    if (line == callable) name = words[0];
    if (!n || !name.len || words[0].len != name.len || memcmp(words[0].ptr, name.ptr, name.len) != 0) continue;
    tatu_value args[MOST_WORDS], results[16];
    for (uint32_t i = 2; i < n; i++) args[i - 2] = value_of(words[i]);
    tatu_call made = tatu_frame(args, n - 2, results, 16);
    made.command = it->host->commands->find(frame->world, words[1], &made.alias);
    if (!made.command) return tatu_fail_line(error, TATU_ERR_SCRIPT, "no plugin offers this command", tatu_text(""), line);
    tatu_status status = it->host->commands->call(frame->world, &made);
    ++*used;
    if (status < 0) return tatu_fail_as(error, status, made.error);
  }
  return TATU_OK;
}

// Scripts of this language cannot wait, and cannot pass functions.
static tatu_status TATU_CALL resume(void *data, uint64_t token, tatu_status failed, tatu_call *frame,
                                    const tatu_budget *budget, uint64_t *used, tatu_error *error) {
  (void)data, (void)token, (void)failed, (void)frame, (void)budget, (void)used;
  return tatu_fail(error, TATU_ERR_UNSUPPORTED, "a script of my_plugin cannot wait");
}
static uint32_t TATU_CALL keep_func(void *data, uint32_t local) { return (void)data, (void)local, 0; }
static void TATU_CALL drop_func(void *data, uint32_t local) { (void)data, (void)local; }
static tatu_status TATU_CALL call_func(void *data, uint32_t local, tatu_call *frame, const tatu_budget *budget,
                                       uint64_t *used, tatu_error *error) {
  (void)data, (void)local, (void)frame, (void)budget, (void)used;
  return tatu_fail(error, TATU_ERR_GONE, "a script of my_plugin has no functions that can be retained");
}

static const tatu_language language = {
  .size = sizeof(tatu_language), .id = "my_plugin", .text = "Lines that name a callback and a command to call in it.",
  .suffixes = TATU_TEXTS(".my_plugin"), .load = load, .find = find, .call = call, .resume = resume,
  .keep_func = keep_func, .drop_func = drop_func, .call_func = call_func,
  .life = TATU_TABLE(tatu_life, .create = create, .destroy = destroy, .save = save, .load = restore, .version = 1)};

TATU_PLUGIN(TATU_LANGUAGES(&language), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0",
  .licence = "MIT", .needs = TATU_NEEDS(TATU_NEED_COMMANDS), .init = tatu_init_host_api, .shutdown = tatu_delete);
