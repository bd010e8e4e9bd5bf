/* tatu/script.h: script languages. */
#ifndef TATU_SCRIPT_H
#define TATU_SCRIPT_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SCRIPT "tatu.script/draft.4"

/* Limits of one call of a script. 0: no limit. */
typedef struct tatu_budget {
  uint32_t size;
  uint32_t reserved;
  uint64_t instructions; /* of the language's virtual machine */
  uint64_t memory;       /* bytes of the script's state */
} tatu_budget;

enum tatu_find {
  /* A callback of the life cycle: "init", "thread", "actuation", "sensing", "cleanup", "nonSimulation",
   * "beforeSimulation", "afterSimulation", "suspend", "suspended", "resume", "beforeStep", "dyn", "joint", "contact",
   * or "measured": for a sensor's scripts, after it was measured in the sensing stage, with a map whose `sensor` is
   * that object. It may return a map: `cmd` "cleanup" ends the script, "restart" ends it and starts it again; `skip`
   * true from "beforeStep" skips the stages of the pass, and time does not advance. */
  TATU_FIND_CALLBACK = 0,
  TATU_FIND_FUNCTION = 1  /* a function of the script, by its own name */
};

enum tatu_script_trait {
  TATU_SCRIPT_SILENT = 1,  /* after an error its clean-up is called at once, then nothing until the next start */
  TATU_SCRIPT_MODERN = 2,  /* a scene that names no dialect counts as modern if it has such a script */
  TATU_SCRIPT_THREADED = 4 /* it runs as a thread of its own and is not called in each step */
};

enum tatu_language_flag {
  TATU_LANGUAGE_SIDE_BY_SIDE = 1 /* different scripts may be called on different threads at once */
};

/* A script language. Each script is one instance with a state of its own. Errors of scripts are returned as a
 * status. */
typedef struct tatu_language {
  uint32_t size;
  uint32_t flags;              /* TATU_LANGUAGE_* */
  const char *id;              /* "lua" */
  const char *text;
  const char *const *suffixes; /* ".lua" */
  const tatu_life *life;       /* the instance's owner is the script object. Its `load` is called after the one below: it
                                * restores all of the state if the text is equivalent to the writer's, else it fails.
                                * After a file change it is called again after `init`, and restores values that fit */
  /* [step] Loads the text. `chunk` is the name for messages, a file if there is one. An empty `dialect` is determined
   * from the text; the dialect in use is returned in `*chosen`, which the plugin owns. */
  tatu_status(TATU_CALL *load)(void *data, tatu_str text, tatu_str chunk, tatu_str dialect, tatu_str *chosen,
                               tatu_error *);
  /* [step] The number of a callback or function; 0: the script does not have it. The function that the number refers to
   * may change with each call. */
  uint32_t(TATU_CALL *find)(void *data, uint32_t how, tatu_str name);
  /* [step] Calls a callable with the frame's arguments; results go into the frame. TATU_WAIT: suspended in a command
   * that waits; the host calls `resume` with that wait's token. `*used` counts instructions. May be re-entered. */
  tatu_status(TATU_CALL *call)(void *data, uint32_t callable, tatu_call *frame, const tatu_budget *, uint64_t *used,
                               tatu_error *);
  /* [step] A wait has ended: `frame->args` are the results of the command that waited. If `failed` is not TATU_OK, the
   * command failed, with the error in `frame->error`. Returns as `call` does. */
  tatu_status(TATU_CALL *resume)(void *data, uint64_t token, tatu_status failed, tatu_call *frame,
                                 const tatu_budget *, uint64_t *used, tatu_error *);
  /* [step] Retains a borrowed function reference: returns its permanent local id, 0 if it is gone. */
  uint32_t(TATU_CALL *keep_func)(void *data, uint32_t local);
  /* [step] Releases a retained reference. */
  void(TATU_CALL *drop_func)(void *data, uint32_t local);
  /* [step] Calls a function reference, borrowed or retained. */
  tatu_status(TATU_CALL *call_func)(void *data, uint32_t local, tatu_call *frame, const tatu_budget *, uint64_t *used,
                                    tatu_error *);
  /* [any] Whether the language supports a dialect that a scene names; the error lists the supported dialects. Null: any
   * is accepted. */
  tatu_status(TATU_CALL *knows_dialect)(void *self, tatu_str dialect, tatu_error *);
  /* [step] TATU_SCRIPT_* bits of a script whose text has been loaded. Null: none. */
  uint32_t(TATU_CALL *traits)(void *data);
  /* [step] The order in which a world's scripts are called, enum tatu_order of vrep.h, if its scene names this dialect
   * or, if that is empty, if it has modern scripts (1) or none (0). Called on one loaded script. Null or 0: deepest
   * first. */
  uint32_t(TATU_CALL *order)(void *data, tatu_str dialect, uint32_t modern);
  /* [step] The script's position while a command that it called runs, for errors that are logged and not raised: sets
   * file, line and traceback in the error object, as for a failure, or nothing. Null: not supported. */
  void(TATU_CALL *place)(void *data, tatu_error *);
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
