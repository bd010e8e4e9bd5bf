// tatu/cpp/declare.hpp: what the declarations of all kinds have in common.
#ifndef TATU_CPP_DECLARE_HPP
#define TATU_CPP_DECLARE_HPP

#include "../sensor.h" // fields
#include "call.hpp"

#include <cmath>
#include <deque>
#include <type_traits>

namespace tatu {

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
  // Null-terminated list of the texts that are allowed, which must live as long as the plugin.
  param &&choices(const char *const *texts) && { return p.choices = texts, std::move(*this); }
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

// Whether an instance of T has a function: `Function` is an alias for the type of its result.
template <template <typename> class Function, typename T, typename = void> struct has : std::false_type {};
template <template <typename> class Function, typename T>
struct has<Function, T, std::void_t<Function<T>>> : std::true_type {};

// The declaration of a kind: its parameters. `Kind` is the derived class, `Table` the table of the contract.
template <typename Kind, typename Table> class with_params {
protected:
  Table t{};
  tables<tatu_param> params;

  with_params(const char *id, const char *text) { t.size = sizeof t, t.id = id, t.text = text; }
  Kind &&self() { return static_cast<Kind &&>(*this); }
  const Table *finish() { return t.params = params.list(), &t; }

public:
  // Adds a parameter. Its value is `params[k]`; parameters are numbered from 0 in the order of declaration.
  Kind &&takes(param p) && { return params.add(p.table()), self(); }
};

// The declaration of a kind with instances, which are objects of the class `Instance`. `State` is the type of the state
// block, plain data that the host saves, hashes and zeroes; void: none. Parameters, commands and the state block must
// fully determine what an instance does. If the class has the function `void configure(const tatu_value *params)`,
// changed parameters are passed to it; otherwise the instance is created anew.
template <typename Kind, typename Table, typename Instance, typename State>
class with_life : public with_params<Kind, Table> {
  template <typename T> using configures = decltype(std::declval<T &>().configure(std::declval<const tatu_value *>()));

protected:
  tatu_life life{};

  with_life(const char *id, const char *text, decltype(tatu_life::create) create) : with_params<Kind, Table>(id, text) {
    life.size = sizeof life, life.create = create;
    life.destroy = [](void *data) { delete static_cast<Instance *>(data); };
    if constexpr (has<configures, Instance>::value)
      life.configure = [](void *data, const tatu_value *params, uint32_t, uint64_t, tatu_error *error) {
        return guard(error, [&] { static_cast<Instance *>(data)->configure(params); });
      };
    life.save = tatu_save_nothing, life.load = tatu_load_nothing;
    if constexpr (!std::is_void_v<State>) {
      static_assert(std::is_trivially_copyable_v<State>, "the host copies state blocks byte by byte");
      life.state_bytes = sizeof(State);
    }
  }
  const Table *finish() { return this->t.life = &life, with_params<Kind, Table>::finish(); }

public:
  // Sets the version of the state block, which is then restored only from snapshots with the same version.
  Kind &&version(uint32_t number) && { return life.version = number, this->self(); }
};

// The declaration of a kind that has readings: fields, and the schemas that they fill.
template <typename Kind, typename Table, typename Instance, typename State>
class with_fields : public with_life<Kind, Table, Instance, State> {
  tables<tatu_field> fields;
  std::vector<const char *> schemas{nullptr};

protected:
  using with_life<Kind, Table, Instance, State>::with_life;
  const Table *finish() {
    this->t.fields = fields.list(), this->t.schemas = schemas.data();
    return with_life<Kind, Table, Instance, State>::finish();
  }

public:
  Kind &&schema(const char *id) && { return schemas.insert(schemas.end() - 1, id), this->self(); }
  // Adds a field of `count` numbers (0: one for each beam of a sensor; TATU_DIM_TARGETS: one
  // for each target). `nothing` is the value that stands for "no
  // measurement"; `valid` is the name of the field that is 0 where this one contains no measurement.
  Kind &&field(uint32_t elem, const char *name, const char *unit, const char *text, uint32_t count = 1,
               const char *nothing = nullptr, const char *valid = nullptr) && {
    tatu_field f{};
    f.size = sizeof f, f.elem = elem, f.dims[0] = count, f.dims[1] = f.dims[2] = 1;
    f.name = name, f.unit = unit, f.text = text, f.nothing = nothing, f.valid = valid;
    return fields.add(f), this->self();
  }
};

// Creates the preset of a kind: `settings` are lines of a scene file.
inline tatu_preset preset_of(const char *id, const char *text, const char *settings) {
  tatu_preset p{};
  p.size = sizeof p, p.id = id, p.text = text, p.settings = settings;
  return p;
}

} // namespace tatu

#endif
