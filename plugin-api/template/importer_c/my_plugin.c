// my_plugin: an importer in C. It reads text files `.my_plugin` that describe blocks:
//   blocks 1                       the first line
//   # a comment
//   box X Y Z LENGTH WIDTH HEIGHT  a box: its centre and its size, m
//   ball X Y Z DIAMETER
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/importer.h"

#include <stdio.h>
#include <string.h>

static const char FIRST[] = "blocks 1";

// Returns the confidence, 0 to 100, that the importer can read a file that begins with `head`.
static uint32_t TATU_CALL sniff(void *self, tatu_str head) {
  (void)self;
  return head.len >= sizeof FIRST - 1 && memcmp(head.ptr, FIRST, sizeof FIRST - 1) == 0 ? 100 : 0;
}

// Removes the next line from a text, and copies it as a NUL-terminated string. Returns 0 if there are no more lines, -1
// if the line is too long.
static int next_line(tatu_str *rest, char *line, size_t room) {
  if (!rest->len) return 0;
  const char *end = memchr(rest->ptr, '\n', rest->len);
  size_t n = end ? (size_t)(end - rest->ptr) : rest->len, used = end ? n + 1 : n;
  if (n >= room) return -1;
  memcpy(line, rest->ptr, n);
  line[n] = 0;
  if (n && line[n - 1] == '\r') line[n - 1] = 0;
  rest->ptr += used, rest->len -= used;
  return 1;
}

static void block(tatu_build *to, uint32_t base, const char *primitive, const double *at, double x, double y, double z) {
  uint32_t shape = tatu_build_object(to, "shape", base, primitive);
  tatu_build_set(to, shape, "primitive", tatu_string(strcmp(primitive, "ball") == 0 ? "sphere" : "box"));
  tatu_build_set3(to, shape, "position", at[0], at[1], at[2]);
  tatu_build_set3(to, shape, "size", x, y, z);
  tatu_build_set(to, shape, "respondable", tatu_bool(1));
}

// Reads a file. Malformed content must lead to an error with a line number, never to a crash.
static tatu_status TATU_CALL load(void *self, tatu_str bytes, const tatu_builder *builder, const tatu_value *params,
                                  tatu_error *error) {
  (void)self;
  tatu_build to = tatu_build_with(builder);
  double scale = params[0].u.f, n[6];
  char line[200], left;
  uint32_t base = tatu_build_object(&to, "dummy", 0, "blocks"); // the first object is the base of all others
  for (uint64_t number = 1; to.status >= 0; number++) {
    int more = next_line(&bytes, line, sizeof line);
    if (more == 0 && number > 1) break;
    const char *wrong = NULL;
    if (more < 0) {
      wrong = "the line is too long";
    } else if (number == 1) {
      if (more == 0 || strcmp(line, FIRST) != 0) wrong = "expected the line `blocks 1`";
    } else if (line[0] == 0 || line[0] == '#') {
      continue;
    } else {
      int box = sscanf(line, "box %lf %lf %lf %lf %lf %lf %c", n, n + 1, n + 2, n + 3, n + 4, n + 5, &left) == 6;
      int ball = !box && sscanf(line, "ball %lf %lf %lf %lf %c", n, n + 1, n + 2, n + 3, &left) == 4;
      if (ball) n[4] = n[5] = n[3];
      for (int i = 0; (box || ball) && i < 6; i++) {
        n[i] *= scale;
        if (!isfinite(n[i]) || (i > 2 && n[i] <= 0)) wrong = "a number is not finite, or a size is not above 0";
      }
      if (!box && !ball) wrong = "expected `box X Y Z LENGTH WIDTH HEIGHT` or `ball X Y Z DIAMETER`";
      else if (!wrong) block(&to, base, box ? "box" : "ball", n, n[3], n[4], n[5]);
    }
    if (wrong) return tatu_fail_line(error, TATU_ERR_ARGUMENT, wrong, tatu_text(""), number);
  }
  return to.status; // if the builder failed, it has set the error
}

static const tatu_importer importer = {
  .size = sizeof(tatu_importer), .id = "my_plugin", .text = "Blocks: boxes and balls, one per line.",
  .suffixes = TATU_TEXTS(".my_plugin"), .sniff = sniff, .load = load,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_F64, "scale", "1", "Factor for all numbers.", TATU_RANGE(0.001, 1000), TATU_DEFAULT_F64(1)))};

TATU_PLUGIN(TATU_IMPORTERS(&importer), .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0",
  .licence = "MIT");
