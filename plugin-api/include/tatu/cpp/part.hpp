// tatu/cpp/part.hpp: declarations of kinds of parts.
#ifndef TATU_CPP_PART_HPP
#define TATU_CPP_PART_HPP

#include "../part.h"
#include "declare.hpp"

namespace tatu {

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


// Declares a kind of part. `Part` must have a constructor from `const tatu_host_api &` and `const tatu_value *params`. It
// is called at those moments for which it has a function: `void actuate(const part_call &)`, and likewise `physics_step`,
// `sense` and `end`; `void paused(const part_call &, tatu_pause)`; `void event(const part_call &, const std::string
// &name, const tatu_value &payload)`, for the events of `hears`; and `void contact(const part_call &, tatu_contact_pair
// &)`.
template <typename Part, typename State = void>
class part : public with_fields<part<Part, State>, tatu_part, Part, State> {
  friend class plugin;
  tables<tatu_param> commands;
  tables<tatu_preset> presets;
  std::vector<const char *> events{nullptr};

  static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error);
  static const part_call &a_call(); // for the types of the functions
  template <typename P> using actuates = decltype(std::declval<P &>().actuate(a_call()));
  template <typename P> using steps = decltype(std::declval<P &>().physics_step(a_call()));
  template <typename P> using senses = decltype(std::declval<P &>().sense(a_call()));
  template <typename P> using pauses = decltype(std::declval<P &>().paused(a_call(), TATU_PAUSE_BEGINS));
  template <typename P> using hears_events =
    decltype(std::declval<P &>().event(a_call(), std::declval<const std::string &>(), std::declval<const tatu_value &>()));
  template <typename P> using decides =
    decltype(std::declval<P &>().contact(a_call(), std::declval<tatu_contact_pair &>()));
  template <typename P> using ends = decltype(std::declval<P &>().end(a_call()));

  const tatu_part *finish() {
    this->t.commands = commands.list(), this->t.presets = presets.list(), this->t.events = events.data();
    return with_fields<part, tatu_part, Part, State>::finish();
  }

public:
  part(const char *id, const char *text) : with_fields<part, tatu_part, Part, State>(id, text, create) {
    tatu_part &t = this->t;
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
  part &&command(param p) && { return commands.add(p.table()), std::move(*this); }
  part &&preset(const char *id, const char *text, const char *settings) && {
    return presets.add(preset_of(id, text, settings)), std::move(*this);
  }
  part &&hears(const char *event) && { return events.insert(events.end() - 1, event), std::move(*this); }
};

} // namespace tatu

#endif
