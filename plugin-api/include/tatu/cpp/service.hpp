// tatu/cpp/service.hpp: declarations of services.
#ifndef TATU_CPP_SERVICE_HPP
#define TATU_CPP_SERVICE_HPP

#include "../service.h"
#include "declare.hpp"

namespace tatu {

// Declares a service. `Service` must have a constructor from `const tatu_host_api &`, `tatu_session *` and `const
// tatu_value *params`; a destructor, which joins its threads; and the function `tatu_hold barrier(tatu_world *, uint64_t
// step)`. It may have `void event(tatu_world *, const std::string &name, const tatu_value &payload)`, `void
// resume(tatu_world *, uint64_t token, tatu_status, const tatu_call &frame)`, `tatu_status call_func(tatu_world *,
// uint32_t local, tatu_call &frame)` and `void last(tatu_world *)`; tatu_service describes each.
template <typename Service> class service : public with_life<service<Service>, tatu_service, Service, void> {
  friend class plugin;
  std::vector<const char *> events{nullptr};

  static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error);
  static tatu_world *a_world(); // for the types of the functions
  template <typename S> using hears_events =
    decltype(std::declval<S &>().event(a_world(), std::declval<const std::string &>(), std::declval<const tatu_value &>()));
  template <typename S> using resumes =
    decltype(std::declval<S &>().resume(a_world(), uint64_t(), tatu_status(), std::declval<const tatu_call &>()));
  template <typename S> using calls =
    decltype(std::declval<S &>().call_func(a_world(), uint32_t(), std::declval<tatu_call &>()));
  template <typename S> using ends = decltype(std::declval<S &>().last(a_world()));

  const tatu_service *finish() {
    if (events.size() > 1) this->t.events = events.data();
    return with_life<service, tatu_service, Service, void>::finish();
  }

public:
  service(const char *id, const char *text) : with_life<service, tatu_service, Service, void>(id, text, create) {
    tatu_service &t = this->t;
    t.barrier = [](void *data, tatu_world *world, uint64_t step, tatu_error *error) {
      tatu_hold answer = TATU_GO;
      tatu_status status = guard(error, [&] { answer = static_cast<Service *>(data)->barrier(world, step); });
      return status < 0 ? status : tatu_status(answer);
    };
    if constexpr (has<hears_events, Service>::value)
      t.event = [](void *data, tatu_world *world, tatu_str name, const tatu_value *payload, tatu_error *error) {
        return guard(error, [&] { static_cast<Service *>(data)->event(world, to_string(name), *payload); });
      };
    if constexpr (has<resumes, Service>::value)
      t.resume = [](void *data, tatu_world *world, uint64_t token, tatu_status done, const tatu_call *frame,
                    tatu_error *error) {
        return guard(error, [&] { static_cast<Service *>(data)->resume(world, token, done, *frame); });
      };
    if constexpr (has<calls, Service>::value)
      t.call_func = [](void *data, tatu_world *world, uint32_t local, tatu_call *frame) {
        tatu_status answer = TATU_OK;
        tatu_status thrown =
          guard(frame->error, [&] { answer = static_cast<Service *>(data)->call_func(world, local, *frame); });
        return thrown < 0 ? thrown : answer;
      };
    if constexpr (has<ends, Service>::value)
      t.last = [](void *data, tatu_world *world, tatu_error *error) {
        return guard(error, [&] { static_cast<Service *>(data)->last(world); });
      };
  }
  // Adds the name of an event that the service receives; without any, it receives those listed for tatu_service.event.
  service &&hears(const char *event) && { return events.insert(events.end() - 1, event), std::move(*this); }
};

} // namespace tatu

#endif
