// tatu/plugin.hpp: plugins in C++17. A plugin is a class that declares what it offers. Its functions may throw: every
// exception is caught before it leaves the plugin, and is converted to an error. All of tatu.h can be used as well.
//
//   struct hello : tatu::plugin {
//     static constexpr const tatu_need *needs[] = {nullptr}; // &tatu::need_scene, ... for `host.scene`
//     explicit hello(const tatu_host *h) : plugin(h) {
//       offer(tatu::command("hello.twice", [](tatu::call &c) { c.give(2 * c.number(0)); })
//         .takes({TATU_F64, "x", nullptr, "Any number."}).text("Doubles a number."));
//     }
//   };
//   TATU_CPP_PLUGIN(hello, "org.example.hello", "Hello", "1.0.0", "MIT");
//
// Texts of declarations must live as long as the plugin, as literals do. Build with -std=c++17 -fvisibility=hidden.
#ifndef TATU_PLUGIN_HPP
#define TATU_PLUGIN_HPP

#include "actuator.h"
#include "command.h"
#include "event.h"
#include "host.h"
#include "importer.h"
#include "model.h"
#include "part.h"
#include "sensor.h"
#include "service.h"

#include <deque>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tatu {

// ---------------------------------------------------------------- Errors --------------------------------------------

// The exception that a function throws to fail with a code and, optionally, a help text.
struct failure : std::runtime_error {
  tatu_status code;
  std::string help, file, traceback; // what to do; for an error in a script, its file and its call stack
  uint64_t line = 0;                 // line in `file`, from 1; 0: none
  explicit failure(tatu_status code_, const std::string &text, std::string help_ = {})
      : std::runtime_error(text), code(code_), help(std::move(help_)) {}
};

inline std::string to_string(tatu_str text) { return text.len ? std::string(text.ptr, text.len) : std::string(); }
inline tatu_str to_str(const std::string &text) { return {text.data(), text.size()}; } // valid while the string lives

// Throws the error of a call or service that failed; has no effect if `status` is not negative.
inline void check(tatu_status status, const tatu_error *why = nullptr) {
  if (status >= 0) return;
  if (!TATU_HAS(why, code)) throw failure(status, ""); // without a text, the host uses the error of the service call
  failure f(status, to_string(why->text), to_string(why->help));
  f.file = to_string(why->file), f.line = why->line, f.traceback = to_string(why->traceback);
  throw f;
}

// Runs a function that may throw. If it throws, sets the error; returns the status for the host.
template <typename Body> tatu_status guard(tatu_error *error, Body body) noexcept {
  try {
    body();
    return TATU_OK;
  } catch (const failure &f) {
    if (!*f.what() || !TATU_HAS(error, say)) return f.code;
    error->say(error, f.code, tatu_text(f.what()));
    if (!f.help.empty()) error->add(error, TATU_PART_HELP, to_str(f.help), 0);
    if (!f.file.empty()) error->add(error, TATU_PART_FILE, to_str(f.file), f.line);
    if (!f.traceback.empty()) error->add(error, TATU_PART_TRACEBACK, to_str(f.traceback), 0);
    return f.code;
  } catch (const std::bad_alloc &) {
    return tatu_fail(error, TATU_ERR_SPACE, "out of memory");
  } catch (const std::exception &e) {
    return tatu_fail(error, TATU_ERR, e.what());
  } catch (...) {
    return tatu_fail(error, TATU_ERR_PANIC, "the plugin threw an object that is not a std::exception");
  }
}

// ---------------------------------------------------------------- Calls ---------------------------------------------

class plugin;

// A call to a command. Arguments have their declared types; missing arguments are 0 or empty.
class call {
  tatu_call &c;

  static tatu_call frame_of(std::initializer_list<tatu_value> args, tatu_value *results) {
    if (!tatu_all_made(args.begin(), uint32_t(args.size()))) throw failure(TATU_ERR_SPACE, "no room for the arguments");
    return tatu_frame(args.begin(), uint32_t(args.size()), results, 16);
  }

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
    tatu_value results[16];
    tatu_call frame = frame_of(args, results);
    frame.command = host().commands->find(c.world, tatu_text(name), &frame.alias);
    if (!frame.command) throw failure(TATU_ERR_UNKNOWN, std::string("no plugin offers the command `") + name + "`");
    tatu_status done = host().commands->call(c.world, &frame);
    check(done, frame.error); // separate statement: the call above sets frame.error
    return frame.n_results ? results[0] : tatu_nil();
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

// ---------------------------------------------------------------- Declarations --------------------------------------

// A parameter: type, key, unit (nullptr: none) and text; the member functions set the rest.
class param {
  tatu_param p{};

public:
  param(uint32_t type, const char *key, const char *unit, const char *text) {
    p.size = sizeof p, p.type = type, p.key = key, p.unit = unit, p.text = text;
  }
  param &&range(double lowest, double highest) && { return p.lowest = lowest, p.highest = highest, std::move(*this); }
  param &&at_least(double lowest) && { return std::move(*this).range(lowest, HUGE_VAL); }
  param &&count(uint32_t n) && { return p.count = n, std::move(*this); }
  param &&flags(uint32_t f) && { return p.flags |= f, std::move(*this); }
  param &&fallback(tatu_value value) && { return p.fallback = value, std::move(*this); }
  param &&fallback(double x) && { return std::move(*this).fallback(tatu_float(x)); }
  const tatu_param &table() const { return p; }
};

// Stores tables at fixed addresses, with a null-terminated list of pointers to them.
template <typename Table> class tables {
  std::deque<Table> all;
  std::vector<const Table *> pointers{nullptr};

public:
  const Table *add(const Table &t) {
    all.push_back(t);
    pointers.insert(pointers.end() - 1, &all.back());
    return &all.back();
  }
  const Table *const *list() const { return pointers.data(); }
};

// Declares a command, given its name and its function.
class command {
  friend class plugin;
  tatu_command t{};
  tatu_name n{};
  std::function<void(call &)> function;
  tables<tatu_param> params, returns;
  std::vector<const tatu_name *> names;

public:
  command(const char *name, std::function<void(call &)> f) : function(std::move(f)) {
    t.size = sizeof t, n.size = sizeof n, n.name = name;
  }
  command &&takes(param p) && { return params.add(p.table()), std::move(*this); }
  command &&gives(param p) && { return returns.add(p.table()), std::move(*this); }
  command &&text(const char *text) && { return t.text = text, std::move(*this); }
  command &&example(const char *lua) && { return t.example = lua, std::move(*this); }
  command &&no_wait(const char *text) && { return t.no_wait = text, std::move(*this); }
  command &&subject(const char *word) && { return t.subject = word, std::move(*this); }
};

// One sensor of a batch during `measure`: its inputs, and the buffers of its fields.
class sample {
  const tatu_sensor_batch &b;
  uint32_t i;

public:
  sample(const tatu_sensor_batch &batch, uint32_t index) : b(batch), i(index) {}
  const tatu_sensor_batch &batch() const { return b; }
  uint32_t index() const { return i; }
  uint64_t beams() const { return b.first_beam[i + 1] - b.first_beam[i]; }
  const double *distances() const { return b.distance + b.first_beam[i]; }
  const double *pose() const { return b.pose + 7 * size_t(i); }
  // Returns the buffer of field `k`; fields are numbered from 0 in the order of declaration.
  template <typename T> T *field(uint32_t k) const { return static_cast<T *>(tatu_field_of(&b, i, k)); }
  // Writes `n` normally distributed numbers (mean 0, standard deviation 1), which are the same in every run.
  void normal(uint64_t n, double *out) const { b.random->normal(b.random, i, 0, n, out); }
};

// Declares a kind of sensor. `Sensor` must have a constructor from `const tatu_value *params`, and the functions
// `void configure(const tatu_value *params)`, `void beams(tatu_beams &)` and `void measure(const sample &)`. Its
// parameters must fully determine its state.
template <typename Sensor> class sensor {
  friend class plugin;
  tatu_sensor t{};
  tatu_life life{};
  tables<tatu_param> params;
  tables<tatu_field> fields;
  tables<tatu_preset> presets;
  std::vector<const char *> schemas{nullptr};

  static tatu_status TATU_CALL create(void *, const tatu_instance *given, void **data, tatu_error *error) {
    return guard(error, [&] { *data = new Sensor(given->params); });
  }
  static void TATU_CALL destroy(void *data) { delete static_cast<Sensor *>(data); }
  static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t, uint64_t, tatu_error *error) {
    return guard(error, [&] { static_cast<Sensor *>(data)->configure(params); });
  }
  static tatu_status TATU_CALL beams(void *data, tatu_beams *out, tatu_error *error) {
    return guard(error, [&] { static_cast<Sensor *>(data)->beams(*out); });
  }
  static tatu_status TATU_CALL measure(void *, const tatu_sensor_batch *batch, tatu_error *error) {
    for (uint32_t i = 0; i < batch->n; i++) // an instance that fails is switched off; the others continue
      batch->status[i] = guard(error, [&] { static_cast<Sensor *>(batch->data[i])->measure(sample(*batch, i)); });
    return TATU_OK;
  }

public:
  sensor(const char *id, const char *text) {
    life.size = sizeof life, life.create = create, life.destroy = destroy, life.configure = configure;
    life.save = tatu_save_nothing, life.load = tatu_load_nothing;
    t.size = sizeof t, t.id = id, t.text = text, t.beams = beams, t.measure = measure;
  }
  sensor &&inputs(uint32_t in) && { return t.inputs = in, std::move(*this); }
  sensor &&schema(const char *id) && { return schemas.insert(schemas.end() - 1, id), std::move(*this); }
  sensor &&takes(param p) && { return params.add(p.table()), std::move(*this); }
  // Adds a field of `count` numbers (0: one for each beam). `nothing` is the value that stands for "no measurement";
  // `valid` is the name of the field that is 0 where this one contains no measurement.
  sensor &&field(uint32_t elem, const char *name, const char *unit, const char *text, uint32_t count = 1,
                 const char *nothing = nullptr, const char *valid = nullptr) && {
    tatu_field f{};
    f.size = sizeof f, f.elem = elem, f.dims[0] = count, f.dims[1] = f.dims[2] = 1;
    f.name = name, f.unit = unit, f.text = text, f.nothing = nothing, f.valid = valid;
    return fields.add(f), std::move(*this);
  }
  sensor &&preset(const char *id, const char *text, const char *settings) && {
    tatu_preset p{};
    p.size = sizeof p, p.id = id, p.text = text, p.settings = settings;
    return presets.add(p), std::move(*this);
  }
};

// One call of a part: the world, its commands, state and readings.
class part_call {
  const tatu_part_call &c;

public:
  explicit part_call(const tatu_part_call &raw) : c(raw) {}
  const tatu_part_call &raw() const { return c; }
  tatu_world *world() const { return c.world; }
  tatu_object part() const { return c.part; }
  tatu_object owner() const { return c.owner; }
  double time() const { return c.time; }
  double dt() const { return c.dt; }
  // Returns the value of command `k`; commands and fields are numbered from 0 in the order of declaration.
  double command(uint32_t k) const { return c.command[k]; }
  template <typename T> T *field(uint32_t k) const { return static_cast<T *>(c.fields[k]); }
  // The state block: plain data that the host saves, hashes and zeroes.
  template <typename State> State &state() const { return *static_cast<State *>(c.state); }
};

// Declares a kind of part. `Part` must have a constructor from `const tatu_host_api &` and `const tatu_value *params`,
// and the function `void configure(const tatu_value *params)`. It is called at those moments for which it has a function:
// `void actuate(const part_call &)`, and likewise `physics_step`, `sense` and `end`;
// `void paused(const part_call &, tatu_pause)`; `void event(const part_call &, const std::string &name, const tatu_value
// &payload)`, for the events of `hears`; and `void contact(const part_call &, tatu_contact_pair &)`. Its parameters, commands and state block must fully determine what it
// does. `State` is the type of the state block.
template <typename Part, typename State = void> class part {
  friend class plugin;
  tatu_part t{};
  tatu_life life{};
  tables<tatu_param> params, commands;
  tables<tatu_field> fields;
  tables<tatu_preset> presets;
  std::vector<const char *> schemas{nullptr}, events{nullptr};

  static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error);
  static void TATU_CALL destroy(void *data) { delete static_cast<Part *>(data); }
  static tatu_status TATU_CALL configure(void *data, const tatu_value *params, uint32_t, uint64_t, tatu_error *error) {
    return guard(error, [&] { static_cast<Part *>(data)->configure(params); });
  }
  template <typename P> using actuates = decltype(std::declval<P &>().actuate(std::declval<const part_call &>()));
  template <typename P> using steps = decltype(std::declval<P &>().physics_step(std::declval<const part_call &>()));
  template <typename P> using senses = decltype(std::declval<P &>().sense(std::declval<const part_call &>()));
  template <typename P> using pauses = decltype(std::declval<P &>().paused(std::declval<const part_call &>(), TATU_PAUSE_BEGINS));
  template <typename P> using hears_events = decltype(std::declval<P &>().event(
    std::declval<const part_call &>(), std::declval<const std::string &>(), std::declval<const tatu_value &>()));
  template <typename P> using decides = decltype(std::declval<P &>().contact(std::declval<const part_call &>(), std::declval<tatu_contact_pair &>()));
  template <typename P> using ends = decltype(std::declval<P &>().end(std::declval<const part_call &>()));
  template <template <typename> class Function, typename P, typename = void> struct has : std::false_type {};
  template <template <typename> class Function, typename P> struct has<Function, P, std::void_t<Function<P>>> : std::true_type {};

public:
  part(const char *id, const char *text) {
    life.size = sizeof life, life.create = create, life.destroy = destroy, life.configure = configure;
    life.save = tatu_save_nothing, life.load = tatu_load_nothing;
    if constexpr (!std::is_void_v<State>) life.state_bytes = sizeof(State);
    t.size = sizeof t, t.id = id, t.text = text;
    if constexpr (has<actuates, Part>::value)
      t.actuate = [](void *data, const tatu_part_call *c, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->actuate(part_call(*c)); });
      };
    if constexpr (has<steps, Part>::value)
      t.physics_step = [](void *data, const tatu_part_call *c, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->physics_step(part_call(*c)); });
      };
    if constexpr (has<senses, Part>::value)
      t.sense = [](void *data, const tatu_part_call *c, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->sense(part_call(*c)); });
      };
    if constexpr (has<pauses, Part>::value)
      t.paused = [](void *data, const tatu_part_call *c, uint32_t moment, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->paused(part_call(*c), static_cast<tatu_pause>(moment)); });
      };
    if constexpr (has<hears_events, Part>::value)
      t.event = [](void *data, const tatu_part_call *c, tatu_str name, const tatu_value *payload, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->event(part_call(*c), to_string(name), *payload); });
      };
    if constexpr (has<decides, Part>::value)
      t.contact = [](void *data, const tatu_part_call *c, tatu_contact_pair *pair, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->contact(part_call(*c), *pair); });
      };
    if constexpr (has<ends, Part>::value)
      t.end = [](void *data, const tatu_part_call *c, tatu_error *error) {
        return guard(error, [&] { static_cast<Part *>(data)->end(part_call(*c)); });
      };
  }
  part &&schema(const char *id) && { return schemas.insert(schemas.end() - 1, id), std::move(*this); }
  part &&takes(param p) && { return params.add(p.table()), std::move(*this); }
  part &&command(param p) && { return commands.add(p.table()), std::move(*this); }
  part &&field(uint32_t elem, const char *name, const char *unit, const char *text, uint32_t count = 1) && {
    tatu_field f{};
    f.size = sizeof f, f.elem = elem, f.dims[0] = count, f.dims[1] = f.dims[2] = 1;
    f.name = name, f.unit = unit, f.text = text;
    return fields.add(f), std::move(*this);
  }
  part &&preset(const char *id, const char *text, const char *settings) && {
    tatu_preset p{};
    p.size = sizeof p, p.id = id, p.text = text, p.settings = settings;
    return presets.add(p), std::move(*this);
  }
  part &&hears(const char *event) && { return events.insert(events.end() - 1, event), std::move(*this); }
  part &&version(uint32_t number) && { return life.version = number, std::move(*this); }
};

// ---------------------------------------------------------------- The plugin ----------------------------------------

// Base class of plugins. The constructor of the derived class declares what the plugin offers, which is then constant.
class plugin {
  std::deque<command> commands;
  std::vector<std::shared_ptr<void>> kept; // owners of the tables of sensors and parts
  tables<tatu_command> all;
  std::vector<const tatu_sensor *> kinds{nullptr};
  std::vector<const tatu_part *> parts{nullptr};
  tatu_ext_command ext_command{};
  tatu_ext_sensor ext_sensor{};
  tatu_ext_part ext_part{};
  tatu_life life{};

  static tatu_status TATU_CALL run(tatu_call *raw) {
    call c(*raw);
    tatu_status status = guard(raw->error, [&] { static_cast<const command *>(raw->user)->function(c); });
    return status < 0 ? status : c.status;
  }

public:
  const tatu_host_api host;

  explicit plugin(const tatu_host *h) : host(tatu_host_api_of(h)) {
    ext_command.size = sizeof ext_command, ext_sensor.size = sizeof ext_sensor, ext_part.size = sizeof ext_part, life.size = sizeof life;
  }
  plugin(const plugin &) = delete;
  plugin &operator=(const plugin &) = delete;
  virtual ~plugin() = default;

  const void *extension(const char *id) {
    ext_command.commands = all.list(), ext_sensor.kinds = kinds.data(), ext_part.kinds = parts.data();
    if (!commands.empty() && tatu_str_is(tatu_text(id), TATU_COMMAND)) return &ext_command;
    if (kinds.size() > 1 && tatu_str_is(tatu_text(id), TATU_SENSOR)) return &ext_sensor;
    if (parts.size() > 1 && tatu_str_is(tatu_text(id), TATU_PART)) return &ext_part;
    return other_extension(id);
  }

protected:
  // Returns the table of any other extension, given its id; may be overridden.
  virtual const void *other_extension(const char *) { return nullptr; }

  void offer(command given) {
    commands.push_back(std::move(given));
    command &c = commands.back();
    c.names = {&c.n, nullptr};
    c.t.names = c.names.data(), c.t.params = c.params.list(), c.t.returns = c.returns.list();
    c.t.user = &c, c.t.call = run;
    all.add(c.t);
  }
  template <typename Sensor> void offer(sensor<Sensor> given) {
    auto s = std::make_shared<sensor<Sensor>>(std::move(given));
    kept.push_back(s);
    s->t.params = s->params.list(), s->t.fields = s->fields.list(), s->t.schemas = s->schemas.data();
    s->t.presets = s->presets.list(), s->t.life = &s->life;
    kinds.insert(kinds.end() - 1, &s->t);
  }
  template <typename Part, typename State> void offer(part<Part, State> given) {
    auto p = std::make_shared<part<Part, State>>(std::move(given));
    kept.push_back(p);
    p->t.params = p->params.list(), p->t.commands = p->commands.list(), p->t.fields = p->fields.list();
    p->t.schemas = p->schemas.data(), p->t.presets = p->presets.list(), p->t.life = &p->life;
    p->t.events = p->events.data();
    parts.insert(parts.end() - 1, &p->t);
  }
  // Allocates a block of plain data for each world, call::state, which the host saves, restores and zeroes.
  template <typename State> void keep_per_world() {
    life.state_bytes = sizeof(State);
    ext_command.per_world = &life;
  }
};

template <typename Part, typename State>
tatu_status TATU_CALL part<Part, State>::create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  return guard(error, [&] { *data = new Part(static_cast<plugin *>(self)->host, given->params); });
}
inline const tatu_host_api &call::host() const { return static_cast<plugin *>(c.self)->host; }

// Entries for a plugin's `needs`: the services that it requires.
template <typename Table> constexpr tatu_need need(const char *id) { return {sizeof(tatu_need), 0, id, sizeof(Table), 0}; }
inline constexpr tatu_need need_scene = need<tatu_host_scene>(TATU_HOST_SCENE);
inline constexpr tatu_need need_bodies = need<tatu_host_bodies>(TATU_HOST_BODIES);
inline constexpr tatu_need need_readings = need<tatu_host_readings>(TATU_HOST_READINGS);
inline constexpr tatu_need need_commands = need<tatu_host_commands>(TATU_HOST_COMMANDS);
inline constexpr tatu_need need_signals = need<tatu_host_signals>(TATU_HOST_SIGNALS);
inline constexpr tatu_need need_events = need<tatu_host_events>(TATU_HOST_EVENTS);
inline constexpr tatu_need need_log = need<tatu_host_log>(TATU_HOST_LOG);
inline constexpr tatu_need need_session = need<tatu_host_session>(TATU_HOST_SESSION);

// The functions in the descriptor of a plugin class.
template <typename Plugin> struct entry {
  static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {
    return guard(error, [&] { *self = static_cast<plugin *>(new Plugin(host)); });
  }
  static void TATU_CALL shutdown(void *self) { delete static_cast<plugin *>(self); }
  static const void *TATU_CALL extension(void *self, const char *id) { return static_cast<plugin *>(self)->extension(id); }
};

} // namespace tatu

// Exports a class as the library's plugin. `needs` must be a static member of the class.
#define TATU_CPP_PLUGIN(Class, Id, Name, Version, Licence)                                                                \
  const tatu_plugin_t tatu_plugin = {sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, Id, Name, Version, Licence,   \
                                     Class::needs, tatu::entry<Class>::init, tatu::entry<Class>::shutdown,                \
                                     tatu::entry<Class>::extension}

#endif
