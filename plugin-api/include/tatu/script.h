/* tatu/script.h: script languages. */
#ifndef TATU_SCRIPT_H
#define TATU_SCRIPT_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SCRIPT "tatu.script/draft.4"

/* Limits for one call to a script. 0: no limit. */
typedef struct tatu_budget {
  uint32_t size;
  uint32_t reserved;
  uint64_t instructions; /* of the language's virtual machine */
  uint64_t memory;       /* size of the script's state, bytes */
} tatu_budget;

enum tatu_find {
  /* A callback of the life cycle: "init", "thread", "actuation", "sensing", "cleanup", "nonSimulation",
   * "beforeSimulation", "afterSimulation", "suspend", "suspended", "resume", "beforeStep", "dyn", "joint", "contact" or
   * "measured". The last is called in the scripts of a sensor after the sensing stage has measured the sensor, with a
   * map whose entry `sensor` is the sensor's object. A callback may return a map: with `cmd` "cleanup" the script ends,
   * with "restart" it ends and starts again; with `skip` true, returned from "beforeStep", the stages of the pass are
   * skipped and time does not advance. */
  TATU_FIND_CALLBACK = 0,
  TATU_FIND_FUNCTION = 1  /* a function that the script defines, by its name */
};

enum tatu_script_trait {
  TATU_SCRIPT_SILENT = 1,  /* after an error, its clean-up is called at once, and nothing else until the next start */
  TATU_SCRIPT_MODERN = 2,  /* a scene that does not specify a dialect is modern if it contains such a script */
  TATU_SCRIPT_THREADED = 4 /* it runs as a separate thread, and is not called in each step */
};

enum tatu_language_flag {
  TATU_LANGUAGE_SIDE_BY_SIDE = 1 /* different scripts may be called on different threads at once */
};

/* A script language. Each script is one instance with a separate state. Errors of scripts are returned as a status. */
typedef struct tatu_language {
  uint32_t size;
  uint32_t flags;              /* TATU_LANGUAGE_* */
  const char *id;              /* "lua" */
  const char *text;
  const char *const *suffixes; /* ".lua" */
  const tatu_life *life;       /* an instance's owner is the script object. life->load is called after tatu_language.load:
                                * it restores the whole state if the text is equivalent to the writer's, otherwise it
                                * fails. After a file change it is called again after `init`, and restores the values
                                * that still fit */
  /* [step] Loads the text. `chunk` is the name for messages, a file if there is one. If `dialect` is empty, it is
   * determined from the text. `*chosen` receives the dialect in use; the plugin owns its memory. */
  tatu_status(TATU_CALL *load)(void *data, tatu_str text, tatu_str chunk, tatu_str dialect, tatu_str *chosen,
                               tatu_error *);
  /* [step] Returns the number of a callback or function, for `call`; 0: the script does not define it. `how` is one of
   * enum tatu_find. The function that a number refers to may change with each call. */
  uint32_t(TATU_CALL *find)(void *data, uint32_t how, tatu_str name);
  /* [step] Calls the function with the number `callable` with the frame's arguments, and writes the results to the
   * frame. TATU_WAIT: the function is suspended in a command that waits; the host calls `resume` with the token of that
   * wait. `*used` receives the number of instructions executed. May be called again before it returns. */
  tatu_status(TATU_CALL *call)(void *data, uint32_t callable, tatu_call *frame, const tatu_budget *, uint64_t *used,
                               tatu_error *);
  /* [step] Continues a script whose wait has ended: `frame->args` are the results of the command that waited. If
   * `failed` is not TATU_OK, that command failed, with the error in `frame->error`. Returns as `call` does. */
  tatu_status(TATU_CALL *resume)(void *data, uint64_t token, tatu_status failed, tatu_call *frame,
                                 const tatu_budget *, uint64_t *used, tatu_error *);
  /* [step] Retains a borrowed function reference. Returns its permanent local id; 0: the function no longer exists. */
  uint32_t(TATU_CALL *keep_func)(void *data, uint32_t local);
  /* [step] Releases a retained reference. */
  void(TATU_CALL *drop_func)(void *data, uint32_t local);
  /* [step] Calls a function reference, borrowed or retained. */
  tatu_status(TATU_CALL *call_func)(void *data, uint32_t local, tatu_call *frame, const tatu_budget *, uint64_t *used,
                                    tatu_error *);
  /* [any] Checks that the language supports a dialect that a scene specifies. If not, the error lists the supported
   * dialects. Null: every dialect is accepted. */
  tatu_status(TATU_CALL *knows_dialect)(void *self, tatu_str dialect, tatu_error *);
  /* [step] Returns the TATU_SCRIPT_* bits of a script whose text has been loaded. Null: none. */
  uint32_t(TATU_CALL *traits)(void *data);
  /* [step] Returns the order in which a world's scripts are called, enum tatu_order of vrep.h. `dialect` is the dialect
   * that the scene specifies; if it is empty, `modern` is 1 if the scene has modern scripts (TATU_SCRIPT_MODERN), else
   * 0. Called on any one loaded script. Null or 0: deepest first. */
  uint32_t(TATU_CALL *order)(void *data, tatu_str dialect, uint32_t modern);
  /* [step] Sets file, line and traceback of the error to the script's position, while a command that it called runs;
   * used for errors that are logged and not raised. Sets nothing if there is no position. Null: not supported. */
  void(TATU_CALL *place)(void *data, tatu_error *);
  /* The permission without which no script of the language is loaded, because such scripts can do anything that the
   * user's account can: a word of lower-case letters, digits and `_`, which the user grants with `--allow` and scenes
   * request in `[permissions]`. Null or beyond `size`: no permission is needed. Hosts below 0.9 ignore it: require
   * `tatu_need.minor` 9. */
  const char *permission;
  /* Settings of the language, such as the interpreter of its scripts: users set them with `--language ID:KEY=VALUE` or in
   * their own settings, scenes in `[language.ID]`. Each has a default or is optional. tatu_instance.params of each script
   * has their values. Null or beyond `size`: none. */
  const tatu_param *const *params;
} tatu_language;

typedef struct tatu_ext_script {
  uint32_t size;
  uint32_t reserved;
  const tatu_language *const *languages;
} tatu_ext_script;

#ifndef __cplusplus
/* Script languages of a plugin, for TATU_PLUGIN: pointers to tatu_language. */
#  define TATU_LANGUAGES(...) TATU_OFFER(TATU_SCRIPT, tatu_ext_script, .languages = TATU_LIST_OF(tatu_language, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
