/* tatu/vrep.h: declarations that exist only so that scripts written for V-REP and CoppeliaSim run unchanged. */
#ifndef TATU_VREP_H
#define TATU_VREP_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- Errors of old commands ------------------------ */

enum tatu_name_flag {
  TATU_NAME_OLD_ERRORS = 1 /* an error is logged once per line of a script; tatu_name.on_error is returned instead */
};

/* ---------------------------------------------------------------- Kinds and order of scripts -------------------- */

/* The last non-empty line of the text must begin with the word; otherwise some name in the text must. */
enum tatu_mark_flag { TATU_MARK_LAST_LINE = 1 };

/* A word that identifies the kind of a script that is run without its scene. Kinds are "main", "child", "threaded",
 * "customization", "add-on", "module". The first mark that matches decides. */
struct tatu_kind_mark {
  uint32_t size;
  uint32_t flags; /* TATU_MARK_* */
  const char *language;
  const char *kind;
  const char *word;
};

/* The order of scripts: see tatu_language.order. */
enum tatu_order {
  TATU_ORDER_PARENTS_FIRST = 1, /* child scripts, down each tree; then customization scripts */
  TATU_ORDER_BY_KIND = 2,       /* threaded child scripts, child scripts, customization scripts; each up the trees */
  TATU_ORDER_DEEPEST_FIRST = 3  /* child scripts, customization scripts; each by depth over the whole scene */
};

/* ---------------------------------------------------------------- Stand-ins ------------------------------------- */

#define TATU_HOST_STAND_INS "tatu.host.stand_ins/draft.4"

/* Stand-ins for objects that scripts request and that do not exist. A run of a script without a scene creates them: the
 * run is repeated, and each repetition starts with the objects that the previous ones lacked. Command plugins report
 * such requests here. In all other runs each function returns TATU_ERR_MISSING without a message, at no cost. */
typedef struct tatu_host_stand_ins {
  uint32_t size;
  uint32_t reserved;
  /* [step] Whether the run creates stand-ins, for requests that do not concern objects. TATU_OK or TATU_ERR_MISSING. */
  tatu_status(TATU_CALL *made)(tatu_world *);
  /* [step] An object that a script named, and that does not exist: creates and returns a dummy. `name` as for
   * scene.find (a path is created part by part, a unique name below `from`). `kind`, if not null, is what it was used
   * as: see `used`. */
  tatu_status(TATU_CALL *object)(tatu_world *, tatu_object from, tatu_str name, const char *kind, tatu_object *);
  /* [step] An object was used as one of `kind`: a kind of object ("joint") or a schema ("proximity/1"). TATU_OK: it
   * is one now, so that the call can continue; in the next run it is one in any case. */
  tatu_status(TATU_CALL *used)(tatu_world *, tatu_object, const char *kind);
  /* [step] A script reached the end of the tree: it requested the parent of an object, */
  tatu_status(TATU_CALL *parent)(tatu_world *, tatu_object);
  /* a child of it (of a kind, if that is not null), */
  tatu_status(TATU_CALL *child)(tatu_world *, tatu_object, const char *kind);
  /* or its script. The request is recorded; the next run creates the object if it was missing. */
  tatu_status(TATU_CALL *script)(tatu_world *, tatu_object);
  /* [step] A script requested a value that an object does not have. TATU_OK: return a neutral default. */
  tatu_status(TATU_CALL *value)(tatu_world *, tatu_object, tatu_str name);
} tatu_host_stand_ins;

#ifdef __cplusplus
}
#endif
#endif
