// blocks: an exporter in C, for files with the size of each shape in a line.
//   text = export.blocks(object)     what `tatu export SCENE -o room.blocks` writes
#include "tatu/command.h"
#include "tatu/host.h"
#include <stdio.h>

enum { MOST = 1000 };

// Returns a line for each shape.
static tatu_status TATU_CALL blocks(tatu_call *call) {
  const tatu_host_api *host = call->self;
  tatu_object shapes[MOST];
  char line[100];
  uint32_t n = 0;
  tatu_value lost = tatu_list(), entry = tatu_map();
  tatu_status status = host->scene->list(call->world, tatu_arg_object(call, 0), 1u << TATU_KIND_SHAPE, 0, shapes, MOST, &n);
  if (status >= 0 && n > MOST) return tatu_call_fail(call, TATU_ERR_SPACE, "blocks: expected at most 1000 shapes");
  char *all = status < 0 ? NULL : call->api->alloc(call, sizeof line * (n + 1));
  if (status >= 0 && !all) return tatu_call_fail(call, TATU_ERR_SPACE, "blocks: there is no room for the text");
  uint64_t length = 0;
  for (uint32_t i = 0; status >= 0 && i < n; i++) {
    double size[3];
    status = host->scene->get_f64(call->world, shapes[i], host->scene->prop(host->host, "shape.size"), size, 3);
    if (status >= 0) length += (uint64_t)snprintf(all + length, sizeof line, "%g %g %g\n", size[0], size[1], size[2]);
  }
  if (status < 0) return status;
  tatu_value text = tatu_span(TATU_TEXT, all, length);
  tatu_put(call, &entry, "lost", tatu_bool(1));
  tatu_put(call, &entry, "text", tatu_string("masses are left out"));
  tatu_add(call, &lost, entry);
  return tatu_return_values(call, TATU_VALUES(text, tatu_map(), lost));
}

static const tatu_command blocks_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("export.blocks"), .call = blocks,
  .params = TATU_PARAMS(TATU_TABLE(tatu_param, .type = TATU_OBJECT, .flags = TATU_PARAM_OPTIONAL, .key = "object", .text = "The object to export; nil: the scene."),
                        TATU_TABLE(tatu_param, .type = TATU_TEXT, .flags = TATU_PARAM_OPTIONAL, .key = "name", .text = "Name of the file.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_TEXT, "text", NULL, "The file.")),
  .text = "Describes the shapes of a scene.", .subject = "export"};

TATU_PLUGIN(
  TATU_COMMANDS(&blocks_command),
  .id = "org.example.blocks", .name = "blocks", .version = "0.1.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_SCENE), .init = tatu_init_host_api, .shutdown = tatu_delete);
