//! Tests of tables as arguments: a parameter declared as a map receives a map for any table of a script, and its keys
//! can be declared.

use std::process::Command;

use crate::kit::*;

/// A plugin with the commands `opts.any`, which describes its argument, and `opts.known`, which declares its keys.
const PLUGIN: &str = r#"
#include <stdio.h>
#include <string.h>
#include "tatu.h"
static int one(char *to, size_t room, const tatu_value *v) {
  if (v->tag == TATU_I64) return snprintf(to, room, "%lld", (long long)v->u.i);
  if (v->tag == TATU_F64) return snprintf(to, room, "%g", v->u.f);
  if (v->tag == TATU_TEXT) return snprintf(to, room, "%.*s", (int)v->u.s.len, (const char *)v->u.s.ptr);
  if (v->tag == TATU_F64S) return snprintf(to, room, "%llu numbers", (unsigned long long)v->u.s.len);
  return snprintf(to, room, "tag %u", v->tag);
}
static tatu_status TATU_CALL tell(tatu_call *c) {
  char text[1000];
  int n = snprintf(text, sizeof text, "%u:", c->args[0].tag);
  uint64_t pairs, i;
  const tatu_pair *p = tatu_arg_map(c, 0, &pairs);
  for (i = 0; i < pairs; i++) {
    n += snprintf(text + n, sizeof text - n, " ");
    n += one(text + n, sizeof text - n, &p[i].key);
    n += snprintf(text + n, sizeof text - n, "=");
    n += one(text + n, sizeof text - n, &p[i].value);
  }
  if (!tatu_map_get(&c->args[0], "speed")) n += snprintf(text + n, sizeof text - n, " (no speed)");
  return tatu_return(c, tatu_span(TATU_TEXT, tatu_keep(c, text, n), n));
}
static const char *const modes[] = {"slow", "fast", 0};
static const tatu_param speed = {.size = sizeof speed, .type = TATU_F64, .key = "speed", .unit = "m/s", .lowest = 0, .highest = 5, .fallback = {TATU_F64, 0, {.f = 1}}, .text = "How fast."};
static const tatu_param mode = {.size = sizeof mode, .type = TATU_TEXT, .key = "mode", .flags = TATU_PARAM_OPTIONAL, .choices = modes, .text = "In which way."};
static const tatu_param target = {.size = sizeof target, .type = TATU_F64S, .count = 3, .key = "target", .unit = "m", .text = "Where to."};
static const tatu_param *const keys[] = {&speed, &mode, &target, 0};
static const tatu_param any = {.size = sizeof any, .type = TATU_MAP, .key = "table", .text = "A table."};
static const tatu_param known = {.size = sizeof known, .type = TATU_MAP, .key = "options", .text = "Options.", .keys = keys};
static const tatu_param list = {.size = sizeof list, .type = TATU_LIST, .key = "list", .text = "A list."};
static const tatu_param *const anys[] = {&any, 0}, *const knowns[] = {&known, 0}, *const lists[] = {&list, 0};
#define NAMED(x, n) static const tatu_name x##_name = {.size = sizeof(tatu_name), .name = n}; static const tatu_name *const x##_names[] = {&x##_name, 0}
NAMED(a, "opts.any"); NAMED(k, "opts.known"); NAMED(l, "opts.list");
static const tatu_command a = {.size = sizeof a, .names = a_names, .params = anys, .text = "Tells.", .call = tell};
static const tatu_command k = {.size = sizeof k, .names = k_names, .params = knowns, .text = "Tells.", .call = tell};
static const tatu_command l = {.size = sizeof l, .names = l_names, .params = lists, .text = "Tells.", .call = tell};
static const tatu_command *const all[] = {&a, &k, &l, 0};
static const tatu_ext_command offer = {.size = sizeof offer, .commands = all};
static const void *TATU_CALL extension(void *me, const char *id) { (void)me; return strcmp(id, TATU_COMMAND) ? 0 : &offer; }
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_minor = TATU_ABI_MINOR, .id = "org.example.opts",
  .name = "Options", .version = "1", .licence = "MIT", .extension = extension};
"#;

fn place(script: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\n{}", watcher("caller", script)));
    place.write("mine/opts.c", PLUGIN);
    let include = root().join("plugin-api/include");
    let args = ["-std=c11", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Werror", "-shared", "-fPIC", "-I"];
    let mut compile = Command::new(compiler("cc"));
    compile
        .args(args)
        .arg(include)
        .args(["opts.c", "-o", &library("tatu_opts")])
        .current_dir(place.path().join("mine"));
    succeed(&mut compile);
    place
}

#[test]
fn a_declared_map_is_a_map_whatever_the_table_looks_like() {
    let script = "function sysCall_init()
        local function gives(expected, f, ...) local got = f(...) assert(got == expected, got) end
        gives('12: a=1', opts.any, {a = 1})
        gives('12: 1=1 2=2', opts.any, {1, 2})
        gives('12: 1=1.5', opts.any, {1.5})
        gives('12: 1=a', opts.any, {'a'})
        gives('12:', opts.any, {})
        assert(opts.list({}):find('^11:') and opts.list({1, 2}):find('^11:') and opts.list({'a'}):find('^11:'))
        local ok, why = pcall(opts.list, {a = 1})
        assert(not ok and why:find('expected a list, found a table with 1 keys', 1, true), why)
        ok, why = pcall(opts.any, 5)
        assert(not ok and why:find('expected a table with keys, found 5', 1, true), why)
    end"
    .replace("'12:'", "'12: (no speed)'")
    .replace("a=1'", "a=1 (no speed)'")
    .replace("2=2'", "2=2 (no speed)'")
    .replace("1=1.5'", "1=1.5 (no speed)'")
    .replace("1=a'", "1=a (no speed)'");
    place(&script).run(&["--steps", "1"]).good();
}

#[test]
fn declared_keys_are_checked_converted_and_filled_up() {
    let script = "function sysCall_init()
        local function gives(expected, ...) local got = opts.known(...) assert(got == expected, got) end
        gives('12: speed=1 target=3 numbers', {target = {1, 2, 3}})
        gives('12: speed=2 mode=fast target=3 numbers', {target = {1, 2, 3.5}, speed = 2, mode = 'fast'})
        local function fails(with, ...)
            local ok, why = pcall(opts.known, ...)
            assert(not ok and why:find(with, 1, true) and why:find('argument 1 `options`', 1, true), tostring(why))
        end
        fails('there is no key `sped`, did you mean `speed`? (keys are speed, mode, target)', {sped = 2, target = {1, 2, 3}})
        fails('there is no key 1 ', {5})
        fails('the key `target` is missing: 3 numbers', {})
        fails('key `speed`: expected a number from 0 to 5, found 7', {speed = 7, target = {1, 2, 3}})
        fails('key `mode`: expected one of', {mode = 'quick', target = {1, 2, 3}})
        fails('key `target`: expected 3 numbers', {target = {1, 2}})
    end";
    let place = place(script);
    place.run(&["--steps", "1"]).good();
    let env = [("TATU_PLUGIN_PATH", "mine")];
    let told = run(program(), place.path(), &["describe", "opts.known", "--json"], &env).good().json();
    let keys = told["parameters"][0]["keys"].as_array().unwrap();
    assert_eq!((keys.len(), keys[0]["name"].as_str(), keys[0]["unit"].as_str()), (3, Some("speed"), Some("m/s")));
}
