// tatu/cpp/call.hpp: calls to commands, their arguments and results.
#ifndef TATU_CPP_CALL_HPP
#define TATU_CPP_CALL_HPP

#include "../command.h"
#include "../host.h"
#include "error.hpp"

#include <initializer_list>
#include <vector>

namespace tatu {

class plugin;

// Creates the frame of a call with these arguments.
inline tatu_call frame_of(std::initializer_list<tatu_value> args, tatu_value (&results)[16]) {
  if (!tatu_all_made(args.begin(), uint32_t(args.size()))) throw failure(TATU_ERR_SPACE, "no room for the arguments");
  return tatu_frame(args.begin(), uint32_t(args.size()), results, 16);
}

// Calls a command by its name, and returns its first result, or nil. Throws if it fails. The result lives until the end
// of the step. Requires the service `commands`.
inline tatu_value run(const tatu_host_api &host, tatu_world *world, const char *name,
                      std::initializer_list<tatu_value> args) {
  tatu_value results[16];
  tatu_call frame = frame_of(args, results);
  frame.command = host.commands->find(world, tatu_text(name), &frame.alias);
  if (!frame.command) throw failure(TATU_ERR_UNKNOWN, std::string("no plugin offers the command `") + name + "`");
  tatu_status done = host.commands->call(world, &frame);
  check(done, frame.error); // separate statement: the call above sets frame.error
  return frame.n_results ? results[0] : tatu_nil();
}

// A call to a command. Arguments have their declared types; missing arguments are 0 or empty.
class call {
  tatu_call &c;

public:
  tatu_status status = TATU_OK; // returned to the host: TATU_WAIT after `wait_steps`

  explicit call(tatu_call &raw) : c(raw) {}
  tatu_call &raw() { return c; }
  tatu_world *world() const { return c.world; }

  bool has(uint32_t i) const { return tatu_has_arg(&c, i) != 0; }
  double number(uint32_t i) const { return tatu_arg_float(&c, i); }
  int64_t integer(uint32_t i) const { return tatu_arg_int(&c, i); }
  tatu_object object(uint32_t i) const { return tatu_arg_object(&c, i); }
  tatu_func function(uint32_t i) const { return tatu_arg_func(&c, i); }
  std::string text(uint32_t i) const { return to_string(tatu_arg_text(&c, i)); }
  std::vector<double> numbers(uint32_t i) const {
    uint64_t n;
    const double *first = tatu_arg_floats(&c, i, &n);
    return n ? std::vector<double>(first, first + n) : std::vector<double>();
  }

  // These functions create values that live until the caller has read them.
  tatu_value copy(const std::string &text) { return tatu_copy_text(&c, to_str(text)); }
  tatu_value copy(const std::vector<double> &x) { return tatu_copy_floats(&c, x.data(), x.size()); }
  tatu_value map(std::initializer_list<tatu_pair> entries) {
    return tatu_copy(&c, TATU_MAP, entries.begin(), entries.size(), sizeof(tatu_pair));
  }
  tatu_value list(const std::vector<tatu_value> &values) {
    return tatu_copy(&c, TATU_LIST, values.data(), values.size(), sizeof(tatu_value));
  }

  // Adds a result.
  void give(tatu_value value) { check(tatu_return(&c, value), c.error); }
  void give(bool x) { give(tatu_bool(x)); }
  void give(double x) { give(tatu_float(x)); }
  void give(int x) { give(tatu_int(x)); }
  void give(int64_t x) { give(tatu_int(x)); }
  void give(const char *text) { give(copy(std::string(text))); }
  void give(const std::string &text) { give(copy(text)); }
  void give(const std::vector<double> &x) { give(copy(x)); }

  // The plugin object, and the world's state block: plain data that the host saves and zeroes.
  template <typename Plugin> Plugin &plugin_as() const { return *static_cast<Plugin *>(static_cast<plugin *>(c.self)); }
  template <typename State> State &state() const { return *static_cast<State *>(c.state); }
  const tatu_host_api &host() const;

  // Calls a function of a script, or a command by its name, and returns its first result, or nil. Throws if it fails.
  tatu_value run(tatu_func f, std::initializer_list<tatu_value> args) {
    tatu_value results[16];
    tatu_call frame = frame_of(args, results);
    tatu_status done = host().commands->call_func(c.world, f, &frame);
    check(done, frame.error); // separate statement: the call above sets frame.error
    return frame.n_results ? results[0] : tatu_nil();
  }
  tatu_value run(const char *name, std::initializer_list<tatu_value> args) {
    return tatu::run(host(), c.world, name, args);
  }
  // Suspends the command for `steps` steps; the command must then return. It is called again with `resumed() == word`.
  void wait_steps(double steps, uint64_t word) {
    check(status = c.api->wait(&c, TATU_UNTIL_STEPS, steps, tatu_text(""), word), c.error);
  }
  uint64_t resumed() const { return c.resume; }
};

// Releases, at the end of a block, the memory of all results that the block has received, by returning to a mark in the
// world's arena. For loops that call many functions and do not store their results.
class scratch {
  const tatu_host_commands *commands;
  tatu_world *world;
  uint64_t mark;

public:
  explicit scratch(const call &c) : commands(c.host().commands), world(c.world()), mark(commands->mark(world)) {}
  ~scratch() { commands->release(world, mark); }
  scratch(const scratch &) = delete;
  scratch &operator=(const scratch &) = delete;
};

} // namespace tatu

#endif
