// my_plugin: an importer in C++. It reads text files `.my_plugin` that describe blocks:
//   blocks 1                       the first line
//   # a comment
//   box X Y Z LENGTH WIDTH HEIGHT  a box: its centre and its size, m
//   ball X Y Z DIAMETER
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

#include <cmath>
#include <sstream>

namespace {

const std::string FIRST = "blocks 1";

struct blocks {
  // Returns the confidence, 0 to 100, that a file that begins with `head` can be read.
  static uint32_t sniff(tatu_str head) { return tatu::to_string(head).rfind(FIRST, 0) == 0 ? 100 : 0; }

  // Reads a file. Malformed content must lead to an error with a line number, never to a crash.
  static void load(tatu_str bytes, tatu::builder &to, const tatu_value *params) {
    std::istringstream file(tatu::to_string(bytes));
    uint32_t base = to.object("dummy", 0, "blocks"); // the first object is the base of all others
    std::string line;
    for (uint64_t number = 1; std::getline(file, line) || number == 1; number++) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      try {
        if (number == 1 && line != FIRST) throw tatu::failure(TATU_ERR_ARGUMENT, "expected the line `blocks 1`");
        if (number > 1 && !line.empty() && line[0] != '#') block(to, base, line, params[0].u.f);
      } catch (tatu::failure &wrong) {
        throw std::move(wrong).at_line(number);
      }
    }
  }

private:
  static void block(tatu::builder &to, uint32_t base, const std::string &line, double scale) {
    std::istringstream words(line);
    std::string kind, left;
    words >> kind;
    std::vector<double> n;
    for (double x; words >> x;) n.push_back(x * scale);
    words.clear();
    bool box = kind == "box" && n.size() == 6, ball = kind == "ball" && n.size() == 4;
    if ((!box && !ball) || words >> left)
      throw tatu::failure(TATU_ERR_ARGUMENT, "expected `box X Y Z LENGTH WIDTH HEIGHT` or `ball X Y Z DIAMETER`");
    if (ball) n.insert(n.end(), 2, n[3]);
    for (size_t i = 0; i < n.size(); i++)
      if (!std::isfinite(n[i]) || (i > 2 && n[i] <= 0))
        throw tatu::failure(TATU_ERR_ARGUMENT, "a number is not finite, or a size is not above 0");
    uint32_t shape = to.object("shape", base, kind);
    to.set(shape, "primitive", ball ? "sphere" : "box");
    to.set3(shape, "position", n[0], n[1], n[2]);
    to.set3(shape, "size", n[3], n[4], n[5]);
    to.set(shape, "respondable", true);
  }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::importer<blocks>("my_plugin", "Blocks: boxes and balls, one per line.")
            .suffix(".my_plugin")
            .takes(tatu::param(TATU_F64, "scale", "1", "Factor for all numbers.").range(0.001, 1000).fallback(1.0)));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
