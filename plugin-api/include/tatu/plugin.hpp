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

#include "cpp/actuator.hpp"
#include "cpp/command.hpp"
#include "cpp/model.hpp"
#include "cpp/part.hpp"
#include "cpp/sensor.hpp"
#include "cpp/service.hpp"
#include "event.h"

#include <memory>

namespace tatu {

// The offers of one kind of extension: its table, with the list of the offers. `List` is the member for this list.
template <typename Extension, typename Table, const Table *const *Extension::*List> class offers {
  std::vector<const Table *> all{nullptr};
  Extension table{};

public:
  Extension &extension() { return table; }
  void add(const Table *offered) { all.insert(all.end() - 1, offered); }
  // Returns the table, or null if nothing is offered.
  const void *get() {
    table.size = sizeof table, table.*List = all.data();
    return all.size() > 1 ? &table : nullptr;
  }
};

// Base class of plugins. The constructor of the derived class declares what the plugin offers, which is then constant.
class plugin {
  std::vector<std::shared_ptr<void>> kept; // owners of the tables of all offers
  offers<tatu_ext_command, tatu_command, &tatu_ext_command::commands> commands;
  offers<tatu_ext_sensor, tatu_sensor, &tatu_ext_sensor::kinds> sensors;
  offers<tatu_ext_actuator, tatu_actuator, &tatu_ext_actuator::kinds> actuators;
  offers<tatu_ext_part, tatu_part, &tatu_ext_part::kinds> parts;
  offers<tatu_ext_model, tatu_model, &tatu_ext_model::models> models;
  offers<tatu_ext_importer, tatu_importer, &tatu_ext_importer::importers> importers;
  offers<tatu_ext_service, tatu_service, &tatu_ext_service::services> services;
  tatu_life per_world{};

  // Moves a declaration to a fixed address, and returns its finished table.
  template <typename Declaration> auto *keep(Declaration &&given) {
    auto at = std::make_shared<std::decay_t<Declaration>>(std::forward<Declaration>(given));
    kept.push_back(at);
    return at->finish();
  }

public:
  const tatu_host_api host;

  explicit plugin(const tatu_host *h) : host(tatu_host_api_of(h)) { per_world.size = sizeof per_world; }
  plugin(const plugin &) = delete;
  plugin &operator=(const plugin &) = delete;
  virtual ~plugin() = default;

  const void *extension(const char *id) {
    const auto is = [id](const char *other) { return tatu_str_is(tatu_text(id), other); };
    const void *found = is(TATU_COMMAND)    ? commands.get()
                        : is(TATU_SENSOR)   ? sensors.get()
                        : is(TATU_ACTUATOR) ? actuators.get()
                        : is(TATU_PART)     ? parts.get()
                        : is(TATU_MODEL)    ? models.get()
                        : is(TATU_IMPORTER) ? importers.get()
                        : is(TATU_SERVICE)  ? services.get()
                                            : nullptr;
    return found ? found : other_extension(id);
  }

protected:
  // Returns the table of any other extension, given its id, such as a script language; may be overridden.
  virtual const void *other_extension(const char *) { return nullptr; }

  void offer(command given) { commands.add(keep(std::move(given))); }
  template <typename C, typename State> void offer(sensor<C, State> given) { sensors.add(keep(std::move(given))); }
  template <typename C, typename State> void offer(actuator<C, State> given) { actuators.add(keep(std::move(given))); }
  template <typename C, typename State> void offer(part<C, State> given) { parts.add(keep(std::move(given))); }
  template <typename C> void offer(model<C> given) { models.add(keep(std::move(given))); }
  template <typename C> void offer(importer<C> given) { importers.add(keep(std::move(given))); }
  template <typename C> void offer(service<C> given) { services.add(keep(std::move(given))); }
  // Allocates a block of plain data for each world, call::state, which the host saves, restores and zeroes.
  template <typename State> void keep_per_world() {
    static_assert(std::is_trivially_copyable_v<State>, "the host copies state blocks byte by byte");
    per_world.state_bytes = sizeof(State);
    commands.extension().per_world = &per_world;
  }
};

template <typename Part, typename State>
tatu_status TATU_CALL part<Part, State>::create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  return guard(error, [&] { *data = new Part(static_cast<plugin *>(self)->host, given->params); });
}
template <typename Service>
tatu_status TATU_CALL service<Service>::create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  return guard(error, [&] { *data = new Service(static_cast<plugin *>(self)->host, given->session, given->params); });
}
inline const tatu_host_api &call::host() const { return static_cast<plugin *>(c.self)->host; }

// Entries for a plugin's `needs`: the services that it requires.
template <typename Table> constexpr tatu_need need(const char *id) { return {sizeof(tatu_need), 0, id, sizeof(Table), 0}; }
// A minor version of the ABI that the plugin requires, such as 8 for targets: `static constexpr tatu_need abi =
// tatu::need_abi(8);`.
constexpr tatu_need need_abi(uint32_t minor) { return {sizeof(tatu_need), 0, nullptr, 0, minor}; }
inline constexpr tatu_need need_scene = need<tatu_host_scene>(TATU_HOST_SCENE);
inline constexpr tatu_need need_bodies = need<tatu_host_bodies>(TATU_HOST_BODIES);
inline constexpr tatu_need need_readings = need<tatu_host_readings>(TATU_HOST_READINGS);
inline constexpr tatu_need need_commands = need<tatu_host_commands>(TATU_HOST_COMMANDS);
inline constexpr tatu_need need_signals = need<tatu_host_signals>(TATU_HOST_SIGNALS);
inline constexpr tatu_need need_events = need<tatu_host_events>(TATU_HOST_EVENTS);
inline constexpr tatu_need need_log = need<tatu_host_log>(TATU_HOST_LOG);
inline constexpr tatu_need need_session = need<tatu_host_session>(TATU_HOST_SESSION);
inline constexpr tatu_need need_files = need<tatu_host_files>(TATU_HOST_FILES);
inline constexpr tatu_need need_stage = need<tatu_host_stage>(TATU_HOST_STAGE);
inline constexpr tatu_need need_scripts = need<tatu_host_scripts>(TATU_HOST_SCRIPTS);
inline constexpr tatu_need need_figures = need<tatu_host_figures>(TATU_HOST_FIGURES);
inline constexpr tatu_need need_edits = need<tatu_host_edits>(TATU_HOST_EDITS);

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
