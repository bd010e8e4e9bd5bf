// my_plugin: a kind of sensor in C++. A fan of beams in the plane of its z and x axes measures the clearance ahead.
//   my_plugin.distance  for each beam, m; the range if nothing is hit
//   my_plugin.nearest   the smallest of them, m          my_plugin.bearing  its direction, rad, from +z towards +x
// The scene sets noise, rate and latency: see the preset below, and `[noise.distance]` in a scene.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

#include <algorithm>
#include <cmath>

namespace {

enum { DISTANCE, NEAREST, BEARING }; // the fields, in the order of their declaration

// One sensor of a scene. Its parameters fully determine its state, so there is nothing to save in a snapshot.
class fan {
  double range = 0, angle = 0;
  std::vector<double> ahead; // unit vectors in the sensor's frame, 3 numbers each

  double bearing(size_t beam) const {
    size_t beams = ahead.size() / 3;
    return beams > 1 ? angle * (double(beam) / double(beams - 1) - 0.5) : 0;
  }

public:
  explicit fan(const tatu_value *params) { configure(params); }

  // Reads the parameters, in the order of their declaration. The host has checked their types and ranges.
  void configure(const tatu_value *params) {
    range = params[0].u.f;
    angle = params[1].u.f;
    ahead.resize(3 * size_t(params[2].u.i));
    for (size_t k = 0; 3 * k < ahead.size(); k++) {
      ahead[3 * k] = std::sin(bearing(k));
      ahead[3 * k + 2] = std::cos(bearing(k));
    }
  }

  void beams(tatu_beams &out) const { tatu_rays(&out, uint32_t(ahead.size() / 3), ahead.data(), range); }

  // May be called on any thread, so it uses only the sensor and the sample.
  void measure(const tatu::sample &s) const {
    double *distance = s.field<double>(DISTANCE), nearest = range;
    for (size_t k = 0; k < s.beams(); k++) {
      distance[k] = std::min(s.distances()[k], range);
      if (distance[k] >= nearest) continue;
      nearest = distance[k];
      *s.field<double>(BEARING) = bearing(k);
    }
    *s.field<double>(NEAREST) = nearest;
  }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::sensor<fan>("my_plugin", "Measures the clearance ahead with a fan of beams.")
            .schema("my_plugin/1")
            .inputs(TATU_IN_DISTANCE)
            .takes(tatu::param(TATU_F64, "range", "m", "Maximum range.").range(0.01, 1000).fallback(5.0))
            .takes(tatu::param(TATU_F64, "angle", "rad", "Angle from first to last beam.").range(0, 3.1416).fallback(1.0))
            .takes(tatu::param(TATU_I64, "beams", nullptr, "Number of beams.")
                     .range(1, 1000)
                     .fallback(tatu_int(21))
                     .flags(TATU_PARAM_REBUILDS))
            .field(TATU_ELEM_F64, "my_plugin.distance", "m", "Distance along each beam.", 0)
            .field(TATU_ELEM_F64, "my_plugin.nearest", "m", "The least distance.")
            .field(TATU_ELEM_F64, "my_plugin.bearing", "rad", "Direction of that beam, from +z towards +x.")
            .preset("cheap", "A low-cost sensor with an error of 2 cm; the values are examples.",
                    "range_m = 4.0\n\n[noise.nearest]\nsigma = 0.02\n"));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
