// heaviest: a subcommand of the program in C.
//   tatu heaviest --scene room.toml 2 --least_kg 5     the two heaviest shapes of at least 5 kg
//   text, exit_code = subcommand.heaviest(count, least, remarks...)
#include "tatu/command.h"
#include "tatu/host.h"
#include <stdio.h>

enum { MOST = 100 };

static tatu_status TATU_CALL heaviest(tatu_call *call) {
  const tatu_host_api *host = call->self;
  tatu_object shapes[MOST];
  char used[MOST] = {0};
  uint32_t n = 0;
  tatu_status status = host->scene->list(call->world, 0, 1u << TATU_KIND_SHAPE, 0, shapes, MOST, &n);
  if (status < 0) return status;
  if (n > MOST) return tatu_call_fail(call, TATU_ERR_SPACE, "heaviest: expected at most 100 shapes");
  char *all = call->api->alloc(call, 64 * (uint64_t)MOST + 64);
  if (!all) return tatu_call_fail(call, TATU_ERR_SPACE, "heaviest: there is no room for the text");
  uint64_t length = 0;
  for (int64_t k = 0; k < tatu_arg_int(call, 0); k++) {
    double most = tatu_arg_float(call, 1);
    uint32_t found = MOST;
    for (uint32_t i = 0; i < n; i++) {
      double mass = 0;
      if (used[i] || host->scene->get_f64(call->world, shapes[i], host->scene->prop(host->host, "shape.mass"), &mass, 1) < 0) continue;
      if (mass >= most) most = mass, found = i;
    }
    if (found == MOST) break;
    used[found] = 1;
    length += (uint64_t)snprintf(all + length, 64, "%g kg\n", most);
  }
  for (uint32_t i = 2; i < call->n_args && i < 5; i++) {
    tatu_str word = tatu_arg_text(call, i);
    if (word.len < 16) length += (uint64_t)snprintf(all + length, 32, "# %.*s\n", (int)word.len, word.ptr);
  }
  return tatu_return_values(call, TATU_VALUES(tatu_span(TATU_TEXT, all, length), tatu_int(length ? 0 : 3)));
}

static const tatu_command heaviest_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("subcommand.heaviest"), .call = heaviest,
  .params = TATU_PARAMS(
    TATU_PARAM(TATU_I64, "count", NULL, "Number of shapes.", TATU_RANGE(1, 50)),
    TATU_PARAM(TATU_F64, "least", "kg", "Least mass.", .fallback = {TATU_F64, 0, {.f = 0}}),
    TATU_TABLE(tatu_param, .type = TATU_TEXT, .flags = TATU_PARAM_REST, .key = "remarks", .text = "Texts to print.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_TEXT, "text", NULL, "A line for each shape."),
                         TATU_PARAM(TATU_I64, "exit_code", NULL, "3 if there is none.")),
  .text = "Lists the heaviest shapes of a scene.", .subject = "subcommands"};

TATU_PLUGIN(
  TATU_COMMANDS(&heaviest_command),
  .id = "org.example.heaviest", .name = "heaviest", .version = "0.1.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_SCENE), .init = tatu_init_host_api, .shutdown = tatu_delete);
