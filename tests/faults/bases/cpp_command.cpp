// A Tatu plugin in one C++17 file: commands for scripts. Copy it, and change the places numbered (1) to (5).
//
// Build: c++ -std=c++17 -O2 -shared -fPIC -fvisibility=hidden -I../../include -o libtatu_cpp_command.so cpp_command.cpp
// Try:   TATU_PLUGIN_PATH=. tatu list commands
//
// The commands may throw: `guarded` converts every exception into an error of the host. State, waiting, kept functions
// and commands of other plugins are shown in `../c_command/`; they work the same way in C++.

#include "tatu.h"

#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

// ---------------------------------------------------------------- (1) Who you are -----------------------------------

constexpr const char *plugin_id = "org.example.cpp_command"; // unique; scenes and messages use it
constexpr const char *plugin_name = "Example commands in C++";
constexpr const char *plugin_version = "0.1.0";
constexpr const char *plugin_licence = "MIT";
#define PREFIX "examplecpp." // starts the names of all commands; choose one that no other plugin uses

// ---------------------------------------------------------------- (2) What you keep ---------------------------------

// The plugin. There is one per host, shared by all worlds and their threads, so it does not change after `init`.
struct plugin {
  const tatu_host_commands *commands = nullptr;
};

// ---------------------------------------------------------------- Helpers: keep them unchanged ----------------------

// The exception that commands throw to fail with a code and, optionally, a hint.
struct failure : std::runtime_error {
  tatu_status code;
  std::string help;
  std::string traceback;
  failure(tatu_status code_, const std::string &text, std::string help_ = {}, std::string traceback_ = {})
      : std::runtime_error(text), code(code_), help(std::move(help_)), traceback(std::move(traceback_)) {}
};

// Converts a string of the ABI to a std::string.
std::string string_of(tatu_str text) { return text.len ? std::string(text.ptr, text.len) : std::string(); }

// Returns a view of a std::string as a string of the ABI.
tatu_str text_of(const std::string &text) { return {text.data(), text.size()}; }

// Reports a failure to the host.
tatu_status tell(tatu_error *error, const failure &f) noexcept {
  if (!TATU_HAS(error, say)) return f.code;
  error->say(error, f.code, tatu_text(f.what()));
  if (!f.help.empty()) error->add(error, TATU_PART_HELP, text_of(f.help), 0);
  if (!f.traceback.empty()) error->add(error, TATU_PART_TRACEBACK, text_of(f.traceback), 0);
  return f.code;
}

// Runs `body` and converts any exception into a status, because no exception may leave a plugin function.
template <typename Body> tatu_status guard(tatu_error *error, Body body) noexcept {
  try {
    body();
    return TATU_OK;
  } catch (const failure &f) {
    return tell(error, f);
  } catch (const std::bad_alloc &) {
    return tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  } catch (const std::exception &e) {
    return tatu_fail(error, TATU_ERR, e.what());
  } catch (...) {
    return tatu_fail(error, TATU_ERR_PANIC, "threw something that is no std::exception");
  }
}

// Wraps a command in a function that the host can call.
template <void (*Command)(tatu_call &)> tatu_status TATU_CALL guarded(tatu_call *call) {
  return guard(call->error, [call] { Command(*call); });
}

// Returns the plugin to which a call belongs.
const plugin &plugin_of(const tatu_call &call) { return *static_cast<const plugin *>(call.self); }

// Returns the values of argument `i`, which is declared as F64S.
std::vector<double> numbers(const tatu_call &call, uint32_t i) {
  auto first = static_cast<const double *>(call.args[i].u.s.ptr);
  return first ? std::vector<double>(first, first + call.args[i].u.s.len) : std::vector<double>();
}

// Copies an array into memory that is valid until the caller has read the results.
template <typename T> T *keep(tatu_call &call, const T *from, uint64_t n) {
  auto copy = static_cast<T *>(tatu_keep(&call, from, n * sizeof(T)));
  if (!copy) throw failure(TATU_ERR_SPACE, "no room for the results");
  return copy;
}

// These convert strings, tables of numbers and maps to results.
tatu_value kept(tatu_call &call, const std::string &text) {
  return tatu_span(TATU_TEXT, keep(call, text.data(), text.size()), text.size());
}
tatu_value kept(tatu_call &call, const std::vector<double> &table) {
  return tatu_span(TATU_F64S, keep(call, table.data(), table.size()), table.size());
}
tatu_value kept(tatu_call &call, const std::vector<tatu_pair> &map) {
  return tatu_span(TATU_MAP, keep(call, map.data(), map.size()), map.size());
}

// Adds a result.
void give(tatu_call &call, tatu_value value) {
  if (tatu_return(&call, value) < 0) throw failure(TATU_ERR_SPACE, "too many results");
}

// Records a position in the world's arena, and at the end of the block releases everything allocated after it.
class scratch {
  const tatu_host_commands *commands;
  tatu_world *world;
  uint64_t mark;

public:
  explicit scratch(const tatu_call &call)
      : commands(plugin_of(call).commands), world(call.world), mark(commands->mark(world)) {}
  ~scratch() { commands->release(world, mark); }
  scratch(const scratch &) = delete;
  scratch &operator=(const scratch &) = delete;
};

// Calls a script's function with a number and returns its result, which must be a number. Numbers are stored in the
// result itself, so the arena can be released immediately.
double call_with(const tatu_call &call, tatu_func function, double x) {
  scratch until_read(call);
  tatu_value argument = tatu_float(x);
  tatu_value results[16] = {};
  tatu_call frame{};
  frame.size = sizeof frame;
  frame.args = &argument;
  frame.n_args = 1;
  frame.results = results;
  frame.results_cap = 16;
  tatu_status status = plugin_of(call).commands->call_func(call.world, function, &frame);
  if (status < 0) {
    const tatu_error *why = frame.error;
    if (!TATU_HAS(why, code)) throw failure(status, "the function failed without a reason");
    throw failure(status, string_of(why->text), string_of(why->help), string_of(why->traceback));
  }
  if (frame.n_results == 0 || (results[0].tag != TATU_F64 && results[0].tag != TATU_I64))
    throw failure(TATU_ERR_ARGUMENT, "the function did not return a number", "let it end with `return <number>`");
  return results[0].tag == TATU_F64 ? results[0].u.f : static_cast<double>(results[0].u.i);
}

// ---------------------------------------------------------------- (3) The commands ----------------------------------
// The host has checked the count and the types of the arguments against the tables of section 4.

// examplecpp.describe(number, text, table, function): arguments of several types, a callback, and a table as result.
void describe(tatu_call &call) {
  double number = tatu_arg_float(&call, 0);
  std::string text = string_of(tatu_arg_text(&call, 1));
  std::vector<double> table = numbers(call, 2);
  double sum = std::accumulate(table.begin(), table.end(), 0.0);
  double called = call_with(call, call.args[3].u.u, sum);
  for (double &x : table) x *= number;

  std::vector<tatu_pair> about = {
      {tatu_string("name"), kept(call, text)},
      {tatu_string("scaled"), kept(call, table)},
      {tatu_string("sum"), tatu_float(sum)},
      {tatu_string("called"), tatu_float(called)},
  };
  give(call, kept(call, about));
  give(call, tatu_int(static_cast<int64_t>(table.size())));
}

// examplecpp.map(table, function): returns the function's result for each number of the table.
void map(tatu_call &call) {
  std::vector<double> table = numbers(call, 0);
  for (double &x : table) x = call_with(call, call.args[1].u.u, x);
  give(call, kept(call, table));
}

// examplecpp.refuse(text): fails by throwing.
void refuse(tatu_call &call) {
  throw failure(TATU_ERR_ARGUMENT, string_of(tatu_arg_text(&call, 0)), "call examplecpp.map instead");
}

// ---------------------------------------------------------------- (4) What is declared     -------------------------

// Declares a parameter or result without bounds.
constexpr tatu_param param(uint32_t type, const char *key, const char *unit, const char *text) {
  tatu_param p{};
  p.size = sizeof p;
  p.type = type;
  p.key = key;
  p.unit = unit;
  p.lowest = -std::numeric_limits<double>::infinity();
  p.highest = std::numeric_limits<double>::infinity();
  p.text = text;
  return p;
}

// Declares a name of a command.
constexpr tatu_name name(const char *text) {
  tatu_name n{};
  n.size = sizeof n;
  n.name = text;
  return n;
}

// Declares a command. Each list ends with a null pointer.
constexpr tatu_command command(tatu_status(TATU_CALL *call)(tatu_call *), const tatu_name *const *names,
                               const tatu_param *const *params, const tatu_param *const *returns, const char *text,
                               const char *example) {
  tatu_command c{};
  c.size = sizeof c;
  c.call = call;
  c.names = names;
  c.params = params;
  c.returns = returns;
  c.text = text;
  c.example = example;
  return c;
}

constexpr tatu_param number_param = param(TATU_F64, "number", "m", "By what the table is multiplied.");
constexpr tatu_param text_param = param(TATU_TEXT, "text", nullptr, "Any text.");
constexpr tatu_param table_param = param(TATU_F64S, "table", nullptr, "Any number of numbers.");
constexpr tatu_param function_param = param(TATU_FUNC, "function", nullptr, "Takes a number and returns one.");
constexpr tatu_param about_result = param(TATU_MAP, "about", nullptr, "name, scaled, sum and called.");
constexpr tatu_param count_result = param(TATU_I64, "numbers", nullptr, "How many numbers the table holds.");
constexpr tatu_param answers_result = param(TATU_F64S, "answers", nullptr, "What the function returned.");
constexpr const tatu_param *none[] = {nullptr};

constexpr tatu_name describe_name = name(PREFIX "describe");
constexpr const tatu_name *describe_names[] = {&describe_name, nullptr};
constexpr const tatu_param *describe_params[] = {&number_param, &text_param, &table_param, &function_param, nullptr};
constexpr const tatu_param *describe_returns[] = {&about_result, &count_result, nullptr};
constexpr tatu_command describe_command =
    command(guarded<describe>, describe_names, describe_params, describe_returns, "Tells about its arguments.",
            "about, n = examplecpp.describe(2, 'arm', {1, 2, 3}, function(sum) return sum / 2 end)");

constexpr tatu_name map_name = name(PREFIX "map");
constexpr const tatu_name *map_names[] = {&map_name, nullptr};
constexpr const tatu_param *map_params[] = {&table_param, &function_param, nullptr};
constexpr const tatu_param *map_returns[] = {&answers_result, nullptr};
constexpr tatu_command map_command =
    command(guarded<map>, map_names, map_params, map_returns, "Calls a function with each number of a table.",
            "squares = examplecpp.map({1, 2, 3}, function(x) return x * x end)");

constexpr tatu_name refuse_name = name(PREFIX "refuse");
constexpr const tatu_name *refuse_names[] = {&refuse_name, nullptr};
constexpr const tatu_param *refuse_params[] = {&text_param, nullptr};
constexpr tatu_command refuse_command =
    command(guarded<refuse>, refuse_names, refuse_params, none, "Fails with a message.",
            "ok, message = pcall(examplecpp.refuse, 'not today')");

constexpr const tatu_command *commands[] = {&describe_command, &map_command, &refuse_command, nullptr};

constexpr tatu_ext_command make_extension() {
  tatu_ext_command e{};
  e.size = sizeof e;
  e.commands = commands;
  return e; // per_world remains null because the plugin has no data per world
}
constexpr tatu_ext_command command_extension = make_extension();

// ---------------------------------------------------------------- (5) What you need ---------------------------------

constexpr tatu_need needs_commands = {sizeof(tatu_need), 0, TATU_HOST_COMMANDS, 0, 0}; // flags 0: required
constexpr const tatu_need *needs[] = {&needs_commands, nullptr};

// Starts the plugin: stores the tables of the services and checks that they contain all functions that it calls.
tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
  return guard(error, [&] {
    auto made = std::make_unique<plugin>();
    made->commands = static_cast<const tatu_host_commands *>(host->service(host, TATU_HOST_COMMANDS));
    if (!TATU_HAS(made->commands, mark) || !TATU_HAS(made->commands, release) || !TATU_HAS(made->commands, call_func))
      throw failure(TATU_ERR_UNSUPPORTED, "the host lacks a function that this plugin calls");
    *self = made.release(); // `end` deletes it
  });
}

// Ends the plugin.
void TATU_CALL end(void *self) { delete static_cast<plugin *>(self); }

// Returns the tables that the plugin offers: only commands.
const void *TATU_CALL extension(void *, const char *id) {
  return std::strcmp(id, TATU_COMMAND) == 0 ? &command_extension : nullptr;
}

} // namespace

// The only symbol that the library exports, with its fields in the order of the header
const tatu_plugin_t tatu_plugin = {
    sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, plugin_id, plugin_name, plugin_version,
    plugin_licence,        needs,          init,           end,       extension,
};
