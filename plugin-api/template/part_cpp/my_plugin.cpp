// my_plugin: a part in C++. A controller that holds the body it belongs to at a height: it reads the height, and pushes.
//   my_plugin.height  command: wanted height, m
//   my_plugin.error   reading: wanted minus actual height, m
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

namespace {

enum { HEIGHT };       // the commands, in the order of their declaration
enum { HEIGHT_ERROR }; // the fields

// The state of one controller: plain data, which the host saves in snapshots, hashes, and zeroes at a reset.
struct state {
  double sum; // integral of the error, m s
};

// One controller of a scene.
class holder {
  const tatu_host_api &host;
  double stiffness = 0, damping = 0, integral = 0;

  double error(const tatu::part_call &call) const {
    double pose[7];
    tatu::check(host.scene->pose(call.world(), call.owner(), 0, pose));
    return call.command(HEIGHT) - pose[2];
  }

public:
  holder(const tatu_host_api &api, const tatu_value *params) : host(api) { configure(params); }

  // Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
  void configure(const tatu_value *params) {
    stiffness = params[0].u.f, damping = params[1].u.f, integral = params[2].u.f;
  }

  // Pushes before each physics step.
  void physics_step(const tatu::part_call &call) {
    double off = error(call), twist[6];
    tatu::check(host.bodies->twist(call.world(), call.owner(), twist));
    double &sum = call.state<state>().sum;
    sum += off * call.dt();
    double force[3] = {0, 0, stiffness * off + integral * sum - damping * twist[2]};
    tatu::check(host.bodies->push(call.world(), call.owner(), force, nullptr));
  }

  // Reports the error after each step, when the sensors have measured.
  void sense(const tatu::part_call &call) { *call.field<double>(HEIGHT_ERROR) = error(call); }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {&tatu::need_scene, &tatu::need_bodies, nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::part<holder, state>("my_plugin", "Holds the body that it belongs to at a height.")
            .schema("my_plugin/1")
            .takes(tatu::param(TATU_F64, "stiffness", "N/m", "Force per error.").at_least(0).fallback(40.0))
            .takes(tatu::param(TATU_F64, "damping", "N s/m", "Force per speed.").at_least(0).fallback(16.0))
            .takes(tatu::param(TATU_F64, "integral", nullptr, "Force per integral of the error, N/(m s).").at_least(0).fallback(40.0))
            .command(tatu::param(TATU_F64, "height", "m", "Wanted height.").fallback(1.0))
            .field(TATU_ELEM_F64, "my_plugin.error", "m", "Wanted minus actual height.")
            .preset("soft", "A slow controller; the values are examples.",
                    "stiffness_n_m = 10.0\ndamping_ns_m = 8.0\nintegral = 4.0\n")
            .version(1));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
