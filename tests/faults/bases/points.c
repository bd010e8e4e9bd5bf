// points: an importer of text files with the line "points 1" and then one line "x y z" (m) per point. It creates a
// dummy at each point.
#include "tatu.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char HEAD[] = "points 1";

static uint32_t TATU_CALL sniff(void *self, tatu_str head) {
  (void)self;
  return head.len >= sizeof HEAD - 1 && memcmp(head.ptr, HEAD, sizeof HEAD - 1) == 0 ? 100 : 0;
}

// Reports an error in a line of the source.
static tatu_status bad_line(tatu_error *error, uint64_t line, const char *why) {
  tatu_fail(error, TATU_ERR_ARGUMENT, why);
  error->add(error, TATU_PART_FILE, tatu_text(""), line);
  return TATU_ERR_ARGUMENT;
}

// Copies the next line as a NUL-terminated string. Returns 0 if it does not fit or contains a NUL.
static int next_line(tatu_str *from, char *line, uint64_t room) {
  uint64_t n = 0;
  while (n < from->len && from->ptr[n] != '\n') n++;
  uint64_t kept = n && from->ptr[n - 1] == '\r' ? n - 1 : n;
  int fits = kept < room && (kept == 0 || !memchr(from->ptr, 0, kept));
  if (fits) {
    if (kept) memcpy(line, from->ptr, kept);
    line[kept] = 0;
  }
  uint64_t used = n < from->len ? n + 1 : n;
  from->ptr += used, from->len -= used;
  return fits;
}

static tatu_status TATU_CALL load(void *self, tatu_str bytes, const tatu_builder *to, const tatu_value *params,
                                  tatu_error *error) {
  (void)self;
  double scale = params[0].u.f;
  char line[256];
  if (!bytes.len || !next_line(&bytes, line, sizeof line) || strcmp(line, HEAD) != 0)
    return bad_line(error, 1, "expected the line `points 1`");
  uint32_t base = to->object(to, "dummy", 0, tatu_text("points"));
  if (!base) return TATU_ERR; // the builder has set the error
  for (uint64_t number = 2; bytes.len; number++) {
    if (!next_line(&bytes, line, sizeof line)) return bad_line(error, number, "the line is too long, or holds a NUL");
    if (!*line) continue;
    double at[3];
    char *rest = line;
    for (int k = 0; k < 3; k++) {
      char *from = rest;
      at[k] = scale * strtod(from, &rest);
      if (rest == from || !isfinite(at[k])) return bad_line(error, number, "expected three numbers, x y z");
    }
    if (rest[strspn(rest, " \t")]) return bad_line(error, number, "something follows the third number");
    char alias[32];
    snprintf(alias, sizeof alias, "point%llu", (unsigned long long)number - 1);
    uint32_t point = to->object(to, "dummy", base, tatu_text(alias));
    tatu_value position = tatu_span(TATU_F64S, at, 3);
    tatu_status status = point ? to->set(to, point, "position", &position) : TATU_ERR;
    if (status < 0) return status;
  }
  return TATU_OK;
}

static const tatu_param scale = {.size = sizeof scale, .type = TATU_F64, .key = "scale", .unit = "1", .lowest = 1e-6,
  .highest = 1e6, .fallback = {.tag = TATU_F64, .u.f = 1}, .text = "Multiplies all coordinates."};
static const tatu_param *const params[] = {&scale, NULL};
static const char *const suffixes[] = {".points", NULL};
static const tatu_importer importer = {.size = sizeof importer, .id = "points", .suffixes = suffixes,
  .text = "Reads points from a text file.", .params = params, .sniff = sniff, .load = load};
static const tatu_importer *const importers[] = {&importer, NULL};
static const tatu_ext_importer offer = {.size = sizeof offer, .importers = importers};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_IMPORTER) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.points", .name = "Points", .version = "1.0.0", .licence = "MIT",
  .extension = extension};
