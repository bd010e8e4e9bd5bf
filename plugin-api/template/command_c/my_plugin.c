// my_plugin: commands for scripts, in C.
//   metres = my_plugin.travelled(object)   distance that an object has moved since the first call for it
//   my_plugin.reset()                      forgets all objects
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/command.h"
#include "tatu/host.h"

// The state of a world: plain numbers, no pointers. The host saves it in snapshots, and zeroes it when a run restarts.
enum { MOST = 64 };
typedef struct {
  tatu_object object; // 0: this entry is free
  double at[3];       // position at the last call, m
  double metres;      // distance travelled by then, m
} track;
typedef struct {
  track tracks[MOST];
} state;

// Returns the track of an object, or a free entry for it; null if there is none.
static track *find(state *kept, tatu_object object) {
  for (int i = 0; i < MOST; i++)
    if (kept->tracks[i].object == object || !kept->tracks[i].object) return &kept->tracks[i];
  return NULL;
}

// Sums up distances. The host has checked that the arguments have the types that are declared below.
static tatu_status TATU_CALL travelled(tatu_call *call) {
  const tatu_host_api *host = call->self;
  tatu_object object;
  double pose[7];
  // Get the full id of the object, and its pose in the world frame. A service that fails has set the error, so
  // returning its status is sufficient.
  tatu_status status = host->scene->look(call->world, tatu_arg_object(call, 0), &object, NULL);
  if (status >= 0) status = host->scene->pose(call->world, object, 0, pose);
  if (status < 0) return status;
  track *it = find(call->state, object);
  if (!it)
    return tatu_call_fail_help(call, TATU_ERR_SPACE, "my_plugin can track only 64 objects", "call my_plugin.reset() first");
  if (it->object) it->metres += hypot(hypot(pose[0] - it->at[0], pose[1] - it->at[1]), pose[2] - it->at[2]);
  it->object = object;
  for (int i = 0; i < 3; i++) it->at[i] = pose[i];
  return tatu_return(call, tatu_float(it->metres));
}

static tatu_status TATU_CALL reset(tatu_call *call) {
  *(state *)call->state = (state){0};
  return TATU_OK;
}

static const tatu_command travelled_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("my_plugin.travelled"), .call = travelled,
  .params = TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "object", NULL, "The object.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_F64, "metres", "m", "Distance moved since the first call for it.")),
  .text = "Returns the distance an object has moved.", .subject = "my_plugin",
  .example = "local box = sim.createDummy(0.1)\n"
             "my_plugin.travelled(box)\n"
             "sim.setObjectPosition(box, sim.handle_world, {3, 4, 0})\n"
             "assert(math.abs(my_plugin.travelled(box) - 5) < 1e-9)"};
static const tatu_command reset_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("my_plugin.reset"), .call = reset,
  .text = "Forgets all objects.", .example = "my_plugin.reset()", .subject = "my_plugin"};

TATU_PLUGIN(
  TATU_COMMANDS_PER_WORLD(TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .version = 1),
                          &travelled_command, &reset_command),
  .id = "org.example.my_plugin", .name = "my_plugin", .version = "0.1.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_SCENE), .init = tatu_init_host_api, .shutdown = tatu_delete);
