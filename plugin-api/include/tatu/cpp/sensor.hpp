// tatu/cpp/sensor.hpp: declarations of kinds of sensors.
#ifndef TATU_CPP_SENSOR_HPP
#define TATU_CPP_SENSOR_HPP

#include "declare.hpp"

namespace tatu {

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
  template <typename State> State &state() const { return *static_cast<State *>(b.state[i]); }
  // The targets that the scene lists, for kinds that declare TATU_IN_TARGETS: their number, and of target `k` the handle (0:
  // there is none at its path), pose and twist.
  uint32_t targets() const { return uint32_t(b.first_target[i + 1] - b.first_target[i]); }
  tatu_object target(uint32_t k) const { return b.target[b.first_target[i] + k]; }
  const double *target_pose(uint32_t k) const { return b.target_pose + 7 * (b.first_target[i] + k); }
  const double *target_twist(uint32_t k) const { return b.target_twist + 6 * (b.first_target[i] + k); }
  // Writes `n` normally distributed numbers (mean 0, standard deviation 1), which are the same in every run.
  void normal(uint64_t n, double *out) const { b.random->normal(b.random, i, 0, n, out); }
};

// Declares a kind of sensor. `Sensor` must have a constructor from `const tatu_value *params`, and the function `void
// measure(const sample &)`. For beams, it has the function `void beams(tatu_beams &)`. It may have `void aim(const sample
// &)` and `void finish(const sample &)`; tatu_sensor describes them.
template <typename Sensor, typename State = void>
class sensor : public with_fields<sensor<Sensor, State>, tatu_sensor, Sensor, State> {
  friend class plugin;
  tables<tatu_preset> presets;
  template <typename S> using casts = decltype(std::declval<S &>().beams(std::declval<tatu_beams &>()));

  template <typename S> using aims = decltype(std::declval<S &>().aim(std::declval<const sample &>()));
  template <typename S> using finishes = decltype(std::declval<S &>().finish(std::declval<const sample &>()));

  static tatu_status TATU_CALL create(void *, const tatu_instance *given, void **data, tatu_error *error) {
    return guard(error, [&] { *data = new Sensor(given->params); });
  }
  // Calls a function for each instance of a batch. One that fails is switched off; the others continue.
  template <typename Function> static tatu_status each(const tatu_sensor_batch *batch, tatu_error *error, Function f) {
    for (uint32_t i = 0; i < batch->n; i++)
      batch->status[i] = guard(error, [&] { f(*static_cast<Sensor *>(batch->data[i]), sample(*batch, i)); });
    return TATU_OK;
  }
  static tatu_status TATU_CALL measure(void *, const tatu_sensor_batch *batch, tatu_error *error) {
    return each(batch, error, [](Sensor &sensor, const sample &s) { sensor.measure(s); });
  }
  const tatu_sensor *finish() {
    this->t.presets = presets.list();
    return with_fields<sensor, tatu_sensor, Sensor, State>::finish();
  }

public:
  sensor(const char *id, const char *text) : with_fields<sensor, tatu_sensor, Sensor, State>(id, text, create) {
    this->t.measure = measure;
    if constexpr (has<casts, Sensor>::value)
      this->t.beams = [](void *data, tatu_beams *out, tatu_error *error) {
        return guard(error, [&] { static_cast<Sensor *>(data)->beams(*out); });
      };
    if constexpr (has<aims, Sensor>::value)
      this->t.aim = [](void *, const tatu_sensor_batch *batch, tatu_error *error) {
        return each(batch, error, [](Sensor &sensor, const sample &s) { sensor.aim(s); });
      };
    if constexpr (has<finishes, Sensor>::value)
      this->t.finish = [](void *, const tatu_sensor_batch *batch, tatu_error *error) {
        return each(batch, error, [](Sensor &sensor, const sample &s) { sensor.finish(s); });
      };
  }
  sensor &&flags(uint32_t f) && { return this->t.flags |= f, std::move(*this); }
  sensor &&inputs(uint32_t in) && { return this->t.inputs = in, std::move(*this); }
  sensor &&preset(const char *id, const char *text, const char *settings) && {
    return presets.add(preset_of(id, text, settings)), std::move(*this);
  }
};

} // namespace tatu

#endif
