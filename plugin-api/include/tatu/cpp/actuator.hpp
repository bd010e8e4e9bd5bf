// tatu/cpp/actuator.hpp: declarations of kinds of actuators.
#ifndef TATU_CPP_ACTUATOR_HPP
#define TATU_CPP_ACTUATOR_HPP

#include "../actuator.h"
#include "declare.hpp"

namespace tatu {

// One actuator of a batch during `apply`: the state of its mount, its commands, and the forces that it writes.
class drive {
  const tatu_actuator_batch &b;
  uint32_t i;

public:
  drive(const tatu_actuator_batch &batch, uint32_t index) : b(batch), i(index) {}
  const tatu_actuator_batch &batch() const { return b; }
  uint32_t index() const { return i; }
  double dt() const { return b.dt; }
  const double *pose() const { return b.pose + 7 * size_t(i); }   // of the mount in the world
  const double *twist() const { return b.twist + 6 * size_t(i); } // of the mount, world frame
  const double *joint() const { return b.joint + 2 * size_t(i); } // position and velocity
  // Returns the value of command `k`; commands and fields are numbered from 0 in the order of declaration.
  double command(uint32_t k) const { return b.command[i][k]; }
  double *wrench() const { return b.wrench + 6 * size_t(i); } // output: force (N) and torque (N m), world frame
  double &effort() const { return b.effort[i]; }              // output: torque (N m) or force (N) of the joint
  template <typename T> T *field(uint32_t k) const { return static_cast<T *>(b.fields[size_t(i) * b.n_fields + k]); }
  template <typename State> State &state() const { return *static_cast<State *>(b.state[i]); }
  // The targets that the scene lists, for kinds that declare TATU_IN_TARGETS: their number, and of target `k` the handle (0:
  // there is none at its path), pose and twist; output: force (N) at its origin and torque (N m) on it, world frame.
  uint32_t targets() const { return uint32_t(b.first_target[i + 1] - b.first_target[i]); }
  tatu_object target(uint32_t k) const { return b.target[b.first_target[i] + k]; }
  const double *target_pose(uint32_t k) const { return b.target_pose + 7 * (b.first_target[i] + k); }
  const double *target_twist(uint32_t k) const { return b.target_twist + 6 * (b.first_target[i] + k); }
  double *target_wrench(uint32_t k) const { return b.target_wrench + 6 * (b.first_target[i] + k); }
};

// Declares a kind of actuator. `Actuator` must have a constructor from `const tatu_value *params`, and the function `void
// apply(const drive &)`.
template <typename Actuator, typename State = void>
class actuator : public with_fields<actuator<Actuator, State>, tatu_actuator, Actuator, State> {
  friend class plugin;
  tables<tatu_param> commands;

  static tatu_status TATU_CALL create(void *, const tatu_instance *given, void **data, tatu_error *error) {
    return guard(error, [&] { *data = new Actuator(given->params); });
  }
  static tatu_status TATU_CALL apply(void *, const tatu_actuator_batch *batch, tatu_error *error) {
    for (uint32_t i = 0; i < batch->n; i++) // an instance that fails is switched off; the others continue
      batch->status[i] = guard(error, [&] { static_cast<Actuator *>(batch->data[i])->apply(drive(*batch, i)); });
    return TATU_OK;
  }
  const tatu_actuator *finish() {
    this->t.commands = commands.list();
    return with_fields<actuator, tatu_actuator, Actuator, State>::finish();
  }

public:
  actuator(const char *id, const char *text) : with_fields<actuator, tatu_actuator, Actuator, State>(id, text, create) {
    this->t.apply = apply;
  }
  actuator &&inputs(uint32_t in) && { return this->t.inputs = in, std::move(*this); }
  actuator &&flags(uint32_t f) && { return this->t.flags |= f, std::move(*this); }
  actuator &&command(param p) && { return commands.add(p.table()), this->t.n_commands++, std::move(*this); }
};

} // namespace tatu

#endif
