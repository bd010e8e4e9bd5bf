// tatu/cpp/model.hpp: models and importers, and the builder of their objects.
#ifndef TATU_CPP_MODEL_HPP
#define TATU_CPP_MODEL_HPP

#include "../importer.h"
#include "../model.h"
#include "declare.hpp"

namespace tatu {

// Creates the objects of a model or of an imported file. Throws if the host rejects one.
class builder {
  const tatu_builder &b;

  // The builder itself has set the error, so that the exception needs no text.
  template <typename Number> static Number made(Number number) {
    if (!number) throw failure(TATU_ERR, "");
    return number;
  }

public:
  explicit builder(const tatu_builder &raw) : b(raw) {}
  const tatu_builder &raw() const { return b; }
  // Adds an object of a kind ("shape", "joint", "dummy", ...) below `parent`; 0: the top level. Returns its number.
  uint32_t object(const char *kind, uint32_t parent, const std::string &alias) {
    return made(b.object(&b, kind, parent, to_str(alias)));
  }
  // Sets a property of an object, in SI units.
  void set(uint32_t object, const char *key, tatu_value value) { check(b.set(&b, object, key, &value)); }
  void set(uint32_t object, const char *key, bool x) { set(object, key, tatu_bool(x)); }
  void set(uint32_t object, const char *key, int x) { set(object, key, tatu_int(x)); }
  void set(uint32_t object, const char *key, double x) { set(object, key, tatu_float(x)); }
  void set(uint32_t object, const char *key, const char *text) { set(object, key, tatu_string(text)); }
  void set(uint32_t object, const char *key, const std::string &text) { set(object, key, text.c_str()); }
  // Sets a property that consists of three numbers: a position, a size, angles or a colour.
  void set3(uint32_t object, const char *key, double x, double y, double z) {
    const double numbers[] = {x, y, z};
    set(object, key, tatu_span(TATU_F64S, numbers, 3));
  }
  // Adds a triangle mesh: three coordinates per point, three indices per triangle. Returns its number, for the property
  // "mesh" of shapes.
  uint64_t mesh(const std::vector<double> &points, const std::vector<uint32_t> &triangles) {
    return made(b.mesh(&b, points.data(), points.size() / 3, triangles.data(), triangles.size() / 3));
  }
  // Gives an object of the kind "sensor" or "actuator" its device.
  void device(uint32_t object, const char *kind_or_schema) { check(b.device(&b, object, kind_or_schema)); }
  // Adds a script to an object; the suffix of `name` determines its language.
  void script(uint32_t owner, const char *kind, const std::string &name, const std::string &text) {
    made(b.script(&b, owner, nullptr, nullptr, kind, to_str(name), to_str(text)));
  }
  // Reads a file beside the source. Throws if there is none.
  std::string file(const std::string &relative) {
    tatu_str bytes{};
    check(b.file(&b, to_str(relative), &bytes));
    return to_string(bytes);
  }
  // Reports a problem of the source, of a severity in enum tatu_report.
  void report(tatu_report severity, uint32_t object, const std::string &text) {
    b.report(&b, severity, object, to_str(text));
  }
};

// Declares a model. `Robot` must have the function `static void build(builder &, const tatu_value *params)`.
template <typename Robot> class model : public with_params<model<Robot>, tatu_model> {
  friend class plugin;

public:
  model(const char *id, const char *text) : with_params<model, tatu_model>(id, text) {
    this->t.build = [](void *, const tatu_builder *to, const tatu_value *params, tatu_error *error) {
      return guard(error, [&] {
        builder all(*to);
        Robot::build(all, params);
      });
    };
  }
  model &&category(const char *heading) && { return this->t.category = heading, std::move(*this); }
};

// Declares an importer. `Reader` must have the function `static void load(tatu_str bytes, builder &, const tatu_value
// *params)`, which throws a `failure` with its line if the file is malformed; and may have the function `static uint32_t
// sniff(tatu_str head)`, which returns the confidence, 0 to 100, that a file that begins with `head` can be read.
template <typename Reader> class importer : public with_params<importer<Reader>, tatu_importer> {
  friend class plugin;
  std::vector<const char *> suffixes{nullptr};
  template <typename R> using sniffs = decltype(R::sniff(std::declval<tatu_str>()));

  const tatu_importer *finish() {
    this->t.suffixes = suffixes.data();
    return with_params<importer, tatu_importer>::finish();
  }

public:
  importer(const char *id, const char *text) : with_params<importer, tatu_importer>(id, text) {
    if constexpr (has<sniffs, Reader>::value)
      this->t.sniff = [](void *, tatu_str head) {
        uint32_t confidence = 0;
        guard(nullptr, [&] { confidence = Reader::sniff(head); });
        return confidence;
      };
    this->t.load = [](void *, tatu_str bytes, const tatu_builder *to, const tatu_value *params, tatu_error *error) {
      return guard(error, [&] {
        builder all(*to);
        Reader::load(bytes, all, params);
      });
    };
  }
  // Adds a suffix of file names, with its dot.
  importer &&suffix(const char *dotted) && { return suffixes.insert(suffixes.end() - 1, dotted), std::move(*this); }
};

} // namespace tatu

#endif
