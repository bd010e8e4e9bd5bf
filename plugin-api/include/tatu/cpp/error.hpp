// tatu/cpp/error.hpp: errors as exceptions, which never leave a plugin.
#ifndef TATU_CPP_ERROR_HPP
#define TATU_CPP_ERROR_HPP

#include "../core.h"

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace tatu {

// The exception that a function throws to fail with a code and, optionally, a help text.
struct failure : std::runtime_error {
  tatu_status code;
  std::string help, file, traceback; // what to do; for an error in a script, its file and its call stack
  uint64_t line = 0;                 // line in `file`, from 1; 0: none
  explicit failure(tatu_status code_, const std::string &text, std::string help_ = {})
      : std::runtime_error(text), code(code_), help(std::move(help_)) {}
  // Sets the line of the error in the file that is being read, or in another file.
  failure &&at_line(uint64_t number, std::string name = {}) && { return line = number, file = std::move(name), std::move(*this); }
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
    if (!f.file.empty() || f.line) error->add(error, TATU_PART_FILE, to_str(f.file), f.line);
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

} // namespace tatu

#endif
