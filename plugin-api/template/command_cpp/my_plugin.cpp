// my_plugin: commands for scripts, in C++.
//   metres = my_plugin.travelled(object)   distance that an object has moved since the first call for it
//   my_plugin.reset()                      forgets all objects
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

#include <algorithm>
#include <cmath>

namespace {

// The state of a world: plain numbers, no pointers. The host saves it in snapshots, and zeroes it when a run restarts.
struct state {
  struct track {
    tatu_object object; // 0: this entry is free
    double at[3];       // position at the last call, m
    double metres;      // distance travelled by then, m
  } tracks[64];
};

// Sums up distances. The host has checked that the arguments have the types that are declared below. Exceptions are
// converted to errors.
void travelled(tatu::call &c) {
  tatu_object object;
  double pose[7];
  tatu::check(c.host().scene->look(c.world(), c.object(0), &object, nullptr));
  tatu::check(c.host().scene->pose(c.world(), object, 0, pose));

  auto &tracks = c.state<state>().tracks;
  auto it = std::find_if(std::begin(tracks), std::end(tracks),
                         [&](const state::track &t) { return t.object == object || !t.object; });
  if (it == std::end(tracks))
    throw tatu::failure(TATU_ERR_SPACE, "my_plugin can track only 64 objects", "call my_plugin.reset() first");
  if (it->object) it->metres += std::hypot(pose[0] - it->at[0], pose[1] - it->at[1], pose[2] - it->at[2]);
  it->object = object;
  std::copy_n(pose, 3, it->at);
  c.give(it->metres);
}

void reset(tatu::call &c) { c.state<state>() = {}; }

// The plugin, with what it offers and requires. All worlds and their threads share one object, so it must not change.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {&tatu::need_scene, nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    keep_per_world<state>();
    offer(tatu::command("my_plugin.travelled", travelled)
            .takes({TATU_OBJECT, "object", nullptr, "The object."})
            .gives({TATU_F64, "metres", "m", "Distance moved since the first call for it."})
            .text("Returns the distance an object has moved.")
            .subject("my_plugin")
            .example("local box = sim.createDummy(0.1)\n"
                     "my_plugin.travelled(box)\n"
                     "sim.setObjectPosition(box, sim.handle_world, {3, 4, 0})\n"
                     "assert(math.abs(my_plugin.travelled(box) - 5) < 1e-9)"));
    offer(tatu::command("my_plugin.reset", reset)
            .text("Forgets all objects.")
            .subject("my_plugin")
            .example("my_plugin.reset()"));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
