// guard: commands in C++ that use exceptions internally. `guarded` converts each exception into an error of the host.
//   x    = guard.at(table, index)        the number at a 1-based index; an index out of range is an error
//   x    = guard.number(text)            the number that a string contains (std::stod)
//   list = guard.map(table, function)    the results of a script's function for each number
//
// Build: c++ -std=c++17 -Wall -Wextra -Werror -shared -fPIC -fvisibility=hidden -I ../../../plugin-api/include -o libtatu_guard.so guard.cpp
// Run:   ../../../target/release/tatu run scene.toml --allow plugins --steps 5 --threads 1
//        ../../../target/release/tatu run scene.toml --allow plugins --steps 5 --threads 2
#include "tatu.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct plugin {
  const tatu_host_commands *commands; // constant after `init`
};

// An exception with a code for the caller.
struct failure : std::runtime_error {
  tatu_status code;
  failure(tatu_status c, const std::string &text) : std::runtime_error(text), code(c) {}
};

// Runs `body` and converts any exception into a sentence in the error object.
template <typename Body> tatu_status border(tatu_error *error, Body body) noexcept {
  try {
    body();
    return TATU_OK;
  } catch (const failure &f) {
    return tatu_fail(error, f.code, f.what());
  } catch (const std::bad_alloc &) {
    return tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  } catch (const std::exception &e) {
    return tatu_fail(error, TATU_ERR, e.what());
  } catch (...) {
    return tatu_fail(error, TATU_ERR_PANIC, "the command threw an object that is not a std::exception");
  }
}
template <void (*Command)(tatu_call &)> tatu_status TATU_CALL guarded(tatu_call *call) {
  return border(call->error, [call] { Command(*call); });
}

std::vector<double> table_of(const tatu_call &call, uint32_t i) {
  uint64_t n;
  const double *first = tatu_arg_floats(&call, i, &n);
  return n ? std::vector<double>(first, first + n) : std::vector<double>();
}
void give(tatu_call &call, tatu_value value) {
  if (tatu_return(&call, value) < 0) throw failure(TATU_ERR_SPACE, "no room for the result");
}

void at(tatu_call &call) {
  std::vector<double> table = table_of(call, 0);
  int64_t index = tatu_arg_int(&call, 1); // 1-based, as in Lua
  try {
    give(call, tatu_float(table.at(static_cast<size_t>(index - 1))));
  } catch (const std::out_of_range &) { // replaces the library's message by one that names the argument
    throw failure(TATU_ERR_ARGUMENT, "`index`: there is no element " + std::to_string(index) + " in a table of " +
                                         std::to_string(table.size()));
  }
}

void number(tatu_call &call) {
  tatu_str given = tatu_arg_text(&call, 0);
  std::string text = given.len ? std::string(given.ptr, given.len) : std::string();
  // Throws invalid_argument or out_of_range, whose message is only "stod"; `border` reports that.
  size_t used = 0;
  double x = std::stod(text, &used);
  if (used != text.size()) throw failure(TATU_ERR_ARGUMENT, "`text`: there is more text after the number");
  give(call, tatu_float(x));
}

void map(tatu_call &call) {
  std::vector<double> table = table_of(call, 0);
  for (double &x : table) {
    tatu_value argument = tatu_float(x), results[16] = {};
    tatu_call frame = tatu_frame(&argument, 1, results, 16);
    tatu_status status = static_cast<const plugin *>(call.self)->commands->call_func(call.world, tatu_arg_func(&call, 1), &frame);
    if (status < 0) throw failure(status, std::string(frame.error->text.ptr, frame.error->text.len));
    if (!frame.n_results || (results[0].tag != TATU_F64 && results[0].tag != TATU_I64))
      throw failure(TATU_ERR_ARGUMENT, "the function did not return a number");
    x = tatu_to_float(results[0]);
  }
  void *kept = tatu_keep(&call, table.data(), table.size() * sizeof(double));
  if (!kept) throw failure(TATU_ERR_SPACE, "no room for the result");
  give(call, tatu_span(TATU_F64S, kept, table.size()));
}

// Declarations. Tables are initialised with {} and then filled, because C++17 has no designated initialisers.
constexpr tatu_param param(uint32_t type, const char *key, const char *text) {
  tatu_param p{};
  p.size = sizeof p, p.type = type, p.key = key, p.text = text;
  p.lowest = -HUGE_VAL, p.highest = HUGE_VAL;
  return p;
}
constexpr tatu_name name(const char *text) {
  tatu_name n{};
  n.size = sizeof n, n.name = text;
  return n;
}
constexpr tatu_command command(tatu_status(TATU_CALL *call)(tatu_call *), const tatu_name *const *names,
                               const tatu_param *const *params, const char *text, const char *example) {
  tatu_command c{};
  c.size = sizeof c, c.call = call, c.names = names, c.params = params, c.text = text, c.example = example;
  return c;
}
constexpr tatu_param p_table = param(TATU_F64S, "table", "Numbers.");
constexpr tatu_param p_index = param(TATU_I64, "index", "From 1.");
constexpr tatu_param p_text = param(TATU_TEXT, "text", "A number as text.");
constexpr tatu_param p_func = param(TATU_FUNC, "function", "Called with a number; must return a number.");
constexpr const tatu_param *at_params[] = {&p_table, &p_index, nullptr};
constexpr const tatu_param *number_params[] = {&p_text, nullptr};
constexpr const tatu_param *map_params[] = {&p_table, &p_func, nullptr};
constexpr tatu_name at_name = name("guard.at"), number_name = name("guard.number"), map_name = name("guard.map");
constexpr const tatu_name *at_names[] = {&at_name, nullptr}, *number_names[] = {&number_name, nullptr},
                          *map_names[] = {&map_name, nullptr};
constexpr tatu_command at_command = command(guarded<at>, at_names, at_params, "Returns an element of a table, or fails.",
                                            "assert(guard.at({5, 6}, 2) == 6)");
constexpr tatu_command number_command = command(guarded<number>, number_names, number_params, "Reads a number.",
                                                "assert(guard.number('1.5') == 1.5)");
constexpr tatu_command map_command = command(guarded<map>, map_names, map_params, "Calls a function for each number.",
                                             "assert(guard.map({2}, function(x) return x * x end)[1] == 4)");
constexpr const tatu_command *commands[] = {&at_command, &number_command, &map_command, nullptr};
constexpr tatu_ext_command offer = [] {
  tatu_ext_command e{};
  e.size = sizeof e, e.commands = commands;
  return e;
}();

constexpr tatu_need need = {sizeof(tatu_need), 0, TATU_HOST_COMMANDS, sizeof(tatu_host_commands), 0};
constexpr const tatu_need *needs[] = {&need, nullptr};

tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  return border(error, [&] {
    auto made = std::make_unique<plugin>();
    made->commands = static_cast<const tatu_host_commands *>(host->service(host, TATU_HOST_COMMANDS));
    *self = made.release();
  });
}
void TATU_CALL end(void *self) { delete static_cast<plugin *>(self); }
const void *TATU_CALL extension(void *, const char *id) { return std::strcmp(id, TATU_COMMAND) == 0 ? &offer : nullptr; }

} // namespace

const tatu_plugin_t tatu_plugin = {sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.outside.guard", "Guard",
                                   "1.0.0", "MIT", needs, init, end, extension};
