// speedometer: a part that shows the speed of its body in a window of the page, which consists of data alone: a label, a
// table, a plot, and a button that calls a command of this plugin.
//   speedometer.window(window, widget, what, value)   called by the page: a click on the button stops the body
//
// Build: c++ -std=c++17 -Wall -Wextra -Werror -fvisibility=hidden -shared -fPIC -I ../../../plugin-api/include -o libtatu_speedometer.so speedometer.cpp
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu open scene.toml
#include "tatu/plugin.hpp"

#include <cmath>
#include <cstdio>

namespace {

const char EVENT[] = "ui.window", ACT[] = "speedometer.window";
enum { BOX, LABEL, TABLE, PLOT, BUTTON }; // indices of the widgets
const uint32_t POINTS = 100;              // of the curve

struct state {
  uint64_t n; // number of points
  double times[POINTS], speeds[POINTS];
};

// Widgets are maps of their type, the index of the widget that contains them, and their values.
struct widget {
  tatu_pair values[4], all[3];
  widget(const char *element, int above, std::initializer_list<tatu_pair> set) {
    std::copy(set.begin(), set.end(), values);
    all[0] = tatu_entry("element", tatu_string(element));
    all[1] = tatu_entry("above", above < 0 ? tatu_nil() : tatu_int(above));
    all[2] = tatu_entry("values", tatu_map_of(values, uint32_t(set.size())));
  }
  tatu_value map() const { return tatu_map_of(all, 3); }
};

class speedometer {
  const tatu_host_api &host;
  bool shown = false; // whether the window is open: not part of the state, since a restored run opens it again

  void publish(tatu_world *world, std::initializer_list<tatu_pair> entries) const {
    tatu_value payload = tatu_map_of(entries.begin(), uint32_t(entries.size()));
    tatu::check(host.events->publish(world, tatu_text(EVENT), &payload));
  }
  // Changes a value of a widget.
  void set(const tatu::part_call &call, int n, const char *key, tatu_value value) const {
    const tatu_pair one = tatu_entry(key, value);
    publish(call.world(), {tatu_entry("act", tatu_string(ACT)), tatu_entry("window", tatu_int(TATU_SLOT(call.part()))),
                           tatu_entry("n", tatu_int(n)), tatu_entry("set", tatu_map_of(&one, 1))});
  }
  // Opens the window. It is identified by the command that acts on it, and a number: here the handle of the part.
  void open(const tatu::part_call &call) const {
    const tatu_value headers[] = {tatu_string("quantity"), tatu_string("value")};
    const widget widgets[] = {
      {"ui", -1, {tatu_entry("title", tatu_string("Speedometer")), tatu_entry("layout", tatu_string("vbox"))}},
      {"label", BOX, {tatu_entry("text", tatu_string("of the body"))}},
      {"table", BOX, {tatu_entry("headers", tatu_list_of(headers, 2))}},
      {"plot", BOX, {}},
      {"button", BOX, {tatu_entry("text", tatu_string("Stop"))}}};
    tatu_value all[5];
    for (int i = 0; i < 5; i++) all[i] = widgets[i].map();
    publish(call.world(), {tatu_entry("act", tatu_string(ACT)), tatu_entry("window", tatu_int(TATU_SLOT(call.part()))),
                           tatu_entry("widgets", tatu_list_of(all, 5))});
  }

public:
  speedometer(const tatu_host_api &api, const tatu_value *) : host(api) {}

  void sense(const tatu::part_call &call) {
    state &now = call.state<state>();
    double twist[6];
    tatu::check(host.bodies->twist(call.world(), call.owner(), twist));
    if (now.n == POINTS) { // the oldest point is dropped
      now.n--;
      std::copy(now.times + 1, now.times + POINTS, now.times);
      std::copy(now.speeds + 1, now.speeds + POINTS, now.speeds);
    }
    now.times[now.n] = call.time();
    now.speeds[now.n++] = std::hypot(twist[0], twist[1], twist[2]);
    if (!shown) open(call), shown = true;

    char text[32];
    std::snprintf(text, sizeof text, "%.3f m/s", now.speeds[now.n - 1]);
    const tatu_value cells[] = {tatu_string("speed"), tatu_string(text)}, row = tatu_list_of(cells, 2);
    set(call, TABLE, "rows", tatu_list_of(&row, 1));
    const tatu_pair curve[] = {tatu_entry("name", tatu_string("speed")), tatu_entry("kind", tatu_int(0)),
                               tatu_entry("x", tatu_span(TATU_F64S, now.times, now.n)),
                               tatu_entry("y", tatu_span(TATU_F64S, now.speeds, now.n))};
    const tatu_value curves = tatu_map_of(curve, 4);
    set(call, PLOT, "curves", tatu_list_of(&curves, 1));
  }
};

struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {&tatu::need_scene, &tatu::need_bodies, &tatu::need_events, nullptr};

  // The page calls this when the user acts on a widget of the window of a part.
  void act(tatu::call &call) const {
    if (call.integer(1) != BUTTON || call.text(2) != "click") return;
    tatu_value owner = tatu_nil();
    tatu_prop parent = host.scene->prop(host.host, "object.parent");
    tatu::check(host.scene->get(call.world(), tatu_object(call.integer(0)), parent, &owner));
    const double still[6] = {0, 0, 0, 0, 0, 0};
    tatu::check(host.bodies->set_twist(call.world(), owner.u.u, still));
  }

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::part<speedometer, state>("speedometer", "Shows the speed of its body in a window.").version(1));
    offer(tatu::command(ACT, [this](tatu::call &c) { act(c); })
            .takes(tatu::param(TATU_I64, "window", nullptr, "Handle of the part."))
            .takes(tatu::param(TATU_I64, "widget", nullptr, "Index of the widget."))
            .takes(tatu::param(TATU_TEXT, "what", nullptr, "What the user did."))
            .takes(tatu::param(TATU_NIL, "value", nullptr, "The new value.").flags(TATU_PARAM_ANY | TATU_PARAM_OPTIONAL))
            .text("Called by views: acts on the window of a part.")
            .example("local ok = pcall(speedometer.window, 0, 0, 'click') assert(ok)"));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.speedometer", "Speedometer", "1.0.0", "MIT");
