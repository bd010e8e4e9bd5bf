// bubble: the behaviour of BubbleRob as a command for scripts, in C.
//   backing = bubble.drive(left, right, nose)   sets the wheels for one step; call it in each step
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h
#include "tatu/command.h"
#include "tatu/host.h"

static const double AHEAD = 5.0;                              // rad/s, both wheels
static const double BACK_LEFT = -2.5, BACK_RIGHT = -0.625;    // rad/s
static const double BACK_TIME = 3.0;                          // s

// The state of a world: plain values, no pointers. The host saves it in snapshots, and zeroes it at each start.
enum { MOST = 64 };
typedef struct {
  tatu_object nose;  // identifies the robot; 0: this slot is free
  double back_until; // s
} robot;
typedef struct {
  robot robots[MOST];
} state;

// Returns the slot of a robot, or a free slot for it; NULL if all slots are in use.
static robot *find(state *kept, tatu_object nose) {
  for (int i = 0; i < MOST; i++)
    if (kept->robots[i].nose == nose || !kept->robots[i].nose) return &kept->robots[i];
  return NULL;
}

static tatu_status set_speed(tatu_call *call, tatu_object joint, double speed) {
  tatu_value none;
  return tatu_call_command(call->self, call->world, call->error, "sim.setJointTargetVelocity",
                           TATU_VALUES(tatu_handle(joint), tatu_float(speed)), &none);
}

// The host has already checked that the arguments are objects of the world.
static tatu_status TATU_CALL drive(tatu_call *call) {
  const tatu_host_api *host = call->self;
  tatu_object left = tatu_arg_object(call, 0), right = tatu_arg_object(call, 1), nose = tatu_arg_object(call, 2);
  robot *it = find(call->state, nose);
  if (!it) return tatu_call_fail(call, TATU_ERR_SPACE, "it drives at most 64 robots");
  it->nose = nose;

  tatu_value seen; // 1, 0, or -1 before the first measurement
  tatu_status status = tatu_call_command(host, call->world, call->error, "sim.readProximitySensor",
                                         TATU_VALUES(tatu_handle(nose)), &seen);
  if (status < 0) return status;
  double now = tatu_time(host, call->world);
  if (tatu_to_float(seen) == 1) it->back_until = now + BACK_TIME;
  int backing = now < it->back_until;

  status = set_speed(call, left, backing ? BACK_LEFT : AHEAD);
  if (status >= 0) status = set_speed(call, right, backing ? BACK_RIGHT : AHEAD);
  return status < 0 ? status : tatu_return(call, tatu_bool(backing));
}

static const tatu_command drive_command = {
  .size = sizeof(tatu_command), .names = TATU_NAME("bubble.drive"), .call = drive,
  .params = TATU_PARAMS(TATU_PARAM(TATU_OBJECT, "left", NULL, "Joint of the left wheel."),
                        TATU_PARAM(TATU_OBJECT, "right", NULL, "Joint of the right wheel."),
                        TATU_PARAM(TATU_OBJECT, "nose", NULL, "Proximity sensor that looks ahead.")),
  .returns = TATU_PARAMS(TATU_PARAM(TATU_BOOL, "backing", NULL, "Whether the robot backs up.")),
  .text = "Drives ahead, and backwards in a curve for 3 s once the sensor has seen something.", .subject = "bubble",
  .example = "backing = bubble.drive(left, right, nose)"};

TATU_PLUGIN(
  TATU_COMMANDS_PER_WORLD(TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .version = 1), &drive_command),
  .id = "org.example.bubble", .name = "bubble", .version = "0.1.0", .licence = "MIT",
  .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_COMMANDS), .init = tatu_init_host_api, .shutdown = tatu_delete);
