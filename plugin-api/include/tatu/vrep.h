/* tatu/vrep.h: declarations that exist only so that scripts written for V-REP and CoppeliaSim run unchanged. */
#ifndef TATU_VREP_H
#define TATU_VREP_H

#include "command.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- Errors of old commands ------------------------ */

enum tatu_name_flag {
  TATU_NAME_OLD_ERRORS = 1 /* on failure, logs the error once per line of a script and returns tatu_name.on_error */
};

/* ---------------------------------------------------------------- Kinds and order of scripts -------------------- */

/* With the flag, a mark matches if the last non-empty line of the text begins with its word; without it, if any name in
 * the text does. */
enum tatu_mark_flag { TATU_MARK_LAST_LINE = 1 };

/* A word by which the kind of a script is recognized when the script is run without its scene. Kinds are "main",
 * "child", "threaded", "customization", "add-on" and "module". The first mark that matches determines the kind. */
struct tatu_kind_mark {
  uint32_t size;
  uint32_t flags; /* TATU_MARK_* */
  const char *language;
  const char *kind;
  const char *word;
};

/* The order of scripts: see tatu_language.order. */
enum tatu_order {
  TATU_ORDER_PARENTS_FIRST = 1, /* child scripts, from the root of each tree down; then customization scripts */
  TATU_ORDER_BY_KIND = 2,       /* threaded child scripts, child scripts, customization scripts; each children first */
  TATU_ORDER_DEEPEST_FIRST = 3  /* child scripts, customization scripts; each by depth in the whole scene, deepest first */
};

/* ---------------------------------------------------------------- Stand-ins ------------------------------------- */

#define TATU_HOST_STAND_INS "tatu.host.stand_ins/draft.4"

/* Stand-ins for objects that a script requests and that do not exist. They are created when a script is run without a
 * scene: the run is repeated, and each repetition starts with the objects that were missing in the previous ones.
 * Command plugins report requests for missing objects with these functions. In all other runs each function returns
 * TATU_ERR_MISSING without a message, at negligible cost. */
typedef struct tatu_host_stand_ins {
  uint32_t size;
  uint32_t reserved;
  /* [step] Returns TATU_OK if the run creates stand-ins, otherwise TATU_ERR_MISSING; for requests that do not concern
   * objects. */
  tatu_status(TATU_CALL *made)(tatu_world *);
  /* [step] Creates and returns a dummy in place of an object that a script requested by `name`, which is as for
   * scene.find: each missing part of a path is created, and a unique name is created below `from`. `kind`, if not null,
   * is what the object was used as: see `used`. */
  tatu_status(TATU_CALL *object)(tatu_world *, tatu_object from, tatu_str name, const char *kind, tatu_object *);
  /* [step] Reports that an object was used as one of `kind`: a kind of object ("joint") or a schema ("proximity/1").
   * TATU_OK: the object now is of that kind, so the call can continue. In the next run it is of that kind in any
   * case. */
  tatu_status(TATU_CALL *used)(tatu_world *, tatu_object, const char *kind);
  /* [step] Records that a script requested the parent of an object at the top of the tree. The next run creates the
   * parent. */
  tatu_status(TATU_CALL *parent)(tatu_world *, tatu_object);
  /* [step] As `parent`, for a missing child of an object, of the kind `kind` if that is not null. */
  tatu_status(TATU_CALL *child)(tatu_world *, tatu_object, const char *kind);
  /* [step] As `parent`, for the missing script of an object. */
  tatu_status(TATU_CALL *script)(tatu_world *, tatu_object);
  /* [step] Reports that a script requested a value that an object does not have. TATU_OK: the command should return a
   * neutral default. */
  tatu_status(TATU_CALL *value)(tatu_world *, tatu_object, tatu_str name);
} tatu_host_stand_ins;

#ifdef __cplusplus
}
#endif
#endif
