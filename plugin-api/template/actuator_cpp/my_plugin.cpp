// my_plugin: a kind of actuator in C++. A propeller, which pushes along its +z axis with a force that follows the command
// `force` with a lag.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

#include <algorithm>
#include <cmath>

namespace {

enum { FORCE }; // the commands, in the order of their declaration

// The state of one propeller: plain data, which the host saves in snapshots, hashes, and zeroes at a reset.
struct state {
  double force; // current force, N
};

// One propeller of a scene.
class propeller {
  double max_force = 0, lag = 0;

public:
  explicit propeller(const tatu_value *params) { configure(params); }

  // Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
  void configure(const tatu_value *params) { max_force = params[0].u.f, lag = params[1].u.f; }

  // May be called on any thread, so it uses only the propeller and its entry of the batch.
  void apply(const tatu::drive &drive) const {
    double &force = drive.state<state>().force;
    double wanted = std::clamp(drive.command(FORCE), -max_force, max_force);
    double x = lag > 0 ? drive.dt() / lag : 0;
    // The mean force during the step, so that the impulse does not depend on the duration of steps.
    double part = x > 0 ? -std::expm1(-x) : 1, mean = wanted;
    if (x > 0) mean = wanted + (force - wanted) * part / x;
    force += (wanted - force) * part;
    // The z axis of the pose (x y z, quaternion x y z w).
    const double *q = drive.pose() + 3;
    double axis[3] = {2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]), 1 - 2 * (q[0] * q[0] + q[1] * q[1])};
    for (int k = 0; k < 3; k++) drive.wrench()[k] = mean * axis[k];
  }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::actuator<propeller, state>("my_plugin", "Pushes along its +z axis, with a lag.")
            .takes(tatu::param(TATU_F64, "max_force", "N", "Maximum force, forwards and backwards.").at_least(0).fallback(10.0))
            .takes(tatu::param(TATU_F64, "lag", "s", "Time in which 63 % of a change is reached.").at_least(0).fallback(0.2))
            .command(tatu::param(TATU_F64, "force", "N", "Wanted force along +z.").fallback(0.0))
            .version(1));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
