// A Tatu plugin in one C++17 file: commands for scripts. Copy it, and change the sections (1) to (3).
//
// Build: c++ -std=c++17 -O2 -shared -fPIC -fvisibility=hidden -I../../include -o libtatu_cpp_command.so cpp_command.cpp
// Try:   TATU_PLUGIN_PATH=. tatu list commands
//
// Commands may throw: every exception is converted to an error before control returns to the host. `../c_command/`
// shows state, waiting and commands of other plugins, which work in the same way in C++.

#include "tatu/plugin.hpp"

#include <numeric>

namespace {

#define PREFIX "examplecpp." // prefix of all command names: choose one that is unique

// ---------------------------------------------------------------- (1) The commands ----------------------------------
// The host has checked the arguments against the declarations in (2), so their number and types are as declared.

// Calls a script's function with a number. The function must return a number, which needs no memory, so the memory of
// its results is released at once.
double call_with(tatu::call &c, tatu_func function, double x) {
  tatu::scratch until_read(c);
  tatu_value y = c.run(function, {tatu_float(x)});
  if (y.tag != TATU_F64 && y.tag != TATU_I64)
    throw tatu::failure(TATU_ERR_ARGUMENT, "the function did not return a number", "end it with `return <number>`");
  return tatu_to_float(y);
}

// examplecpp.describe(number, text, table, function): arguments of several types, a callback, and a table as result.
void describe(tatu::call &c) {
  std::vector<double> table = c.numbers(2);
  double sum = std::accumulate(table.begin(), table.end(), 0.0);
  double called = call_with(c, c.function(3), sum);
  for (double &x : table) x *= c.number(0);
  c.give(c.map({
    tatu_entry("name", c.copy(c.text(1))),
    tatu_entry("scaled", c.copy(table)),
    tatu_entry("sum", tatu_float(sum)),
    tatu_entry("called", tatu_float(called)),
  }));
  c.give(static_cast<int64_t>(table.size()));
}

// examplecpp.map(table, function): calls a function with each number of a table, and returns the results.
void map(tatu::call &c) {
  std::vector<double> table = c.numbers(0);
  for (double &x : table) x = call_with(c, c.function(1), x);
  c.give(table);
}

// examplecpp.refuse(text): fails by throwing. An error always has a message, even if the caller passes an empty text.
void refuse(tatu::call &c) {
  std::string text = c.text(0);
  throw tatu::failure(TATU_ERR_ARGUMENT, *text.c_str() ? text : "refused without a reason", "call examplecpp.map instead");
}

// ---------------------------------------------------------------- (2) Declarations ----------------------------------

// All worlds and their threads share one object, so it must not change after its construction.
struct plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {&tatu::need_commands, nullptr}; // required services

  explicit plugin(const tatu_host *h) : tatu::plugin(h) {
    offer(tatu::command(PREFIX "describe", describe)
            .takes({TATU_F64, "number", "m", "Factor by which the table is multiplied."})
            .takes({TATU_TEXT, "text", nullptr, "Any text."})
            .takes({TATU_F64S, "table", nullptr, "Any number of numbers."})
            .takes({TATU_FUNC, "function", nullptr, "Takes a number and returns one."})
            .gives({TATU_MAP, "about", nullptr, "name, scaled, sum and called."})
            .gives({TATU_I64, "numbers", nullptr, "Number of elements of the table."})
            .text("Describes its arguments.")
            .example("about, n = examplecpp.describe(2, 'arm', {1, 2, 3}, function(sum) return sum / 2 end)"));
    offer(tatu::command(PREFIX "map", map)
            .takes({TATU_F64S, "table", nullptr, "Any number of numbers."})
            .takes({TATU_FUNC, "function", nullptr, "Takes a number and returns one."})
            .gives({TATU_F64S, "answers", nullptr, "The results of the function."})
            .text("Calls a function with each number of a table.")
            .example("squares = examplecpp.map({1, 2, 3}, function(x) return x * x end)"));
    offer(tatu::command(PREFIX "refuse", refuse)
            .takes({TATU_TEXT, "text", nullptr, "The message of the error."})
            .text("Fails with a message.")
            .example("ok, message = pcall(examplecpp.refuse, 'not today')"));
  }
};

} // namespace

// ---------------------------------------------------------------- (3) Identity of the plugin ------------------------

TATU_CPP_PLUGIN(plugin, "org.example.cpp_command", "Example commands in C++", "0.1.0", "MIT");
