// tatu/cpp/command.hpp: declarations of commands.
#ifndef TATU_CPP_COMMAND_HPP
#define TATU_CPP_COMMAND_HPP

#include "declare.hpp"

#include <functional>

namespace tatu {

// Declares a command, given its name and its function.
class command {
  friend class plugin;
  tatu_command t{};
  tatu_name n{};
  std::function<void(call &)> function;
  tables<tatu_param> params, returns;
  const tatu_name *names[2] = {};

  static tatu_status TATU_CALL run(tatu_call *raw) {
    call c(*raw);
    tatu_status status = guard(raw->error, [&] { static_cast<const command *>(raw->user)->function(c); });
    return status < 0 ? status : c.status;
  }
  const tatu_command *finish() {
    names[0] = &n, t.names = names, t.params = params.list(), t.returns = returns.list();
    t.user = this, t.call = run;
    return &t;
  }

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

} // namespace tatu

#endif
