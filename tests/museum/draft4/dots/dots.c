// dots: an importer of files with lines "x y z size", each a cube, in m.
#include "tatu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static tatu_status TATU_CALL load(void *self, tatu_str bytes, const tatu_builder *to, const tatu_value *params, tatu_error *error) {
  uint32_t base = to->object(to, "dummy", 0, tatu_text("dots"));
  uint64_t line = 0, at = 0;
  (void)self;
  if (!base) return TATU_ERR;
  while (at < bytes.len) {
    char text[128];
    double x[4];
    uint64_t n = 0;
    for (; at < bytes.len && bytes.ptr[at] != '\n'; at++) if (n + 1 < sizeof text) text[n++] = bytes.ptr[at];
    at++, line++, text[n] = 0;
    if (!n) continue;
    if (sscanf(text, "%lf %lf %lf %lf", &x[0], &x[1], &x[2], &x[3]) != 4) {
      tatu_fail(error, TATU_ERR_ARGUMENT, "four numbers are expected: x y z size");
      error->add(error, TATU_PART_FILE, tatu_text(""), line);
      return TATU_ERR_ARGUMENT;
    }
    double size[3] = {x[3] * params[0].u.f, x[3] * params[0].u.f, x[3] * params[0].u.f};
    tatu_value place = tatu_span(TATU_F64S, x, 3), extent = tatu_span(TATU_F64S, size, 3);
    uint32_t cube = to->object(to, "shape", base, tatu_text("dot"));
    if (!cube || to->set(to, cube, "position", &place) < 0 || to->set(to, cube, "size", &extent) < 0) return TATU_ERR;
  }
  return TATU_OK;
}

static const char *const suffixes[] = {".dots", NULL};
static const tatu_param *const params[] = {
    &(const tatu_param){.size = sizeof(tatu_param), .type = TATU_F64, .key = "scale", .unit = "1", .lowest = 0.001,
                        .highest = 1000, .fallback = {TATU_F64, 0, {.f = 1}}, .text = "Factor of all sizes."},
    NULL};
static const tatu_importer importer = {.size = sizeof(tatu_importer), .id = "museum_dots", .text = "Cubes from lines.",
                                       .suffixes = suffixes, .params = params, .load = load};
static const tatu_importer *const importers[] = {&importer, NULL};
static const tatu_ext_importer offer = {.size = sizeof(tatu_ext_importer), .importers = importers};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_IMPORTER) == 0 ? &offer : NULL;
}

TATU_EXPORT const tatu_plugin_t tatu_plugin = {
    .size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR, .abi_minor = TATU_ABI_MINOR,
    .id = "org.example.museum_dots", .name = "Dots", .version = "1.0.0", .licence = "MIT", .extension = extension};
