/* tatu/model.h: models, and the builder that creates their objects. */
#ifndef TATU_MODEL_H
#define TATU_MODEL_H

#include "core.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- Builder --------------------------------------- */

enum tatu_report {
  TATU_REPORT_NOTE = 0,
  TATU_REPORT_WARNING = 1, /* the scene works, but differs from what the source describes */
  TATU_REPORT_ERROR = 2,   /* the build fails */
  TATU_REPORT_LACK = 3     /* a part is not supported here: the scene starts without it, and each run reports a fault;
                              hosts that do not support this severity print it as a note */
};

/* Writes a document: the description of a scene, read from a scene file or produced by a model or an importer. The
 * objects in it do not exist in a world yet. */
typedef struct tatu_builder {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  /* [setup] Adds an object of a kind ("shape", "joint", "dummy", "sensor", ...) below `parent` (0: the top level of the
   * build). Returns the object's number, from 1; 0: the object was rejected, and the error of the build is set. */
  uint32_t(TATU_CALL *object)(const struct tatu_builder *, const char *kind, uint32_t parent, tatu_str alias);
  /* [setup] Sets a property by key, with or without the kind's prefix ("mass", "position", "color"). SI units.
   * Object 0 with a key that begins with "scene." sets a parameter of the world ("scene.dt", "scene.gravity") or its
   * free data ("scene.data"); this has an effect only if an importer's file is opened as the scene. So does
   * "object.name", the unique name of an object ("arm#0"), in which the object's alias precedes the `#`. */
  tatu_status(TATU_CALL *set)(const struct tatu_builder *, uint32_t object, const char *key, const tatu_value *);
  /* [setup] Adds a triangle mesh, `n_points` * 3 doubles and `n_triangles` * 3 indices. Returns its number, for the
   * property "mesh" of shapes; 0: the mesh was rejected. Equal meshes are stored once. */
  uint64_t(TATU_CALL *mesh)(const struct tatu_builder *, const double *points, uint64_t n_points,
                            const uint32_t *triangles, uint64_t n_triangles);
  /* [setup] Adds an image, 4 bytes per pixel, top row first. Returns its number; 0: the image was rejected. */
  uint64_t(TATU_CALL *image)(const struct tatu_builder *, const uint8_t *rgba, uint32_t width, uint32_t height);
  /* [setup] Adds a script to an object. If `language` is null, the suffix of `name` determines it; if `dialect` is
   * null, the text does. `kind` is "child", "threaded", "customization" or "main" (a scene's driver; ignored in models
   * and in imports that are not the scene itself). Returns the script's number; 0: the script was rejected. */
  uint32_t(TATU_CALL *script)(const struct tatu_builder *, uint32_t owner, const char *language, const char *dialect,
                              const char *kind, tatu_str name, tatu_str text);
  /* [setup] Gives an object of kind "sensor" or "actuator" its device: a kind ("proximity"), or a schema that the kind
   * must fill ("proximity/1"). Its parameters are then set like properties. */
  tatu_status(TATU_CALL *device)(const struct tatu_builder *, uint32_t object, const char *kind_or_schema);
  /* [setup] Reports a problem of the source, of a severity in enum tatu_report; it is printed with the file name. */
  void(TATU_CALL *report)(const struct tatu_builder *, uint32_t severity, uint32_t object, tatu_str text);
  /* [setup] Reads a file, whose name is relative to the folder of the source; the bytes live as long as the build. The
   * source of an importer is the imported file, that of a model is the scene. TATU_ERR_MISSING: there is no such file;
   * the build can continue. Names may contain `..`, but a path outside the folders of the source, of the scene and, for
   * importers, of the run makes the build fail. */
  tatu_status(TATU_CALL *file)(const struct tatu_builder *, tatu_str relative, tatu_str *bytes);
  /* [setup] Describes the source for `tatu check FILE --json`, in a map with text keys that the importer documents.
   * Null or absent: no description was requested, so the importer need not gather it. */
  tatu_status(TATU_CALL *describe)(const struct tatu_builder *, const tatu_value *map);
  /* The declaration of the model that is being built, so that one function can build several models; null in imports.
   * Absent in hosts that do not read models from text. */
  const struct tatu_model *model;
  /* [setup] Adds the objects that a text in the scene format describes. Objects without a parent are added below
   * `parent` (0: the top level of the build), and paths in the text are relative to it. `name` is the name of the file
   * that contains the text, relative to the folder of the source; empty: the file that describes the model. File names
   * in the text are relative to that file, and errors refer to its lines. The text may contain other models, so `build`
   * of this plugin may be called within this call; a model that contains itself is rejected. Absent in hosts that do
   * not read models from text. */
  tatu_status(TATU_CALL *scene)(const struct tatu_builder *, uint32_t parent, tatu_str name, tatu_str text);
  /* [setup] As `mesh`, with texture coordinates for textures whose mapping is "mesh": for each point two floats, 0 to 1
   * to the right and 0 to 1 up in the image; null: none. Absent in hosts that only project images. */
  uint64_t(TATU_CALL *textured_mesh)(const struct tatu_builder *, const double *points, const float *coordinates,
                                     uint64_t n_points, const uint32_t *triangles, uint64_t n_triangles);
} tatu_builder;

/* A builder that remembers failure: the functions below store the first negative status in `status`, which `build` or
 * `load` then returns, and have no effect after it. The builder itself has set the error of the build. */
typedef struct tatu_build {
  const tatu_builder *to;
  tatu_status status;
} tatu_build;

TATU_INLINE tatu_build tatu_build_with(const tatu_builder *to) {
  tatu_build b;
  b.to = to;
  b.status = TATU_OK;
  return b;
}
TATU_INLINE uint32_t tatu_build_object(tatu_build *b, const char *kind, uint32_t parent, const char *alias) {
  uint32_t object = b->status < 0 ? 0 : b->to->object(b->to, kind, parent, tatu_text(alias));
  if (!object && b->status >= 0) b->status = TATU_ERR;
  return object;
}
TATU_INLINE void tatu_build_set(tatu_build *b, uint32_t object, const char *key, tatu_value value) {
  if (b->status >= 0) b->status = b->to->set(b->to, object, key, &value);
}
/* Sets a property that consists of three numbers: a position, a size, angles or a colour. */
TATU_INLINE void tatu_build_set3(tatu_build *b, uint32_t object, const char *key, double x, double y, double z) {
  double numbers[3];
  numbers[0] = x, numbers[1] = y, numbers[2] = z;
  tatu_build_set(b, object, key, tatu_span(TATU_F64S, numbers, 3));
}

/* ---------------------------------------------------------------- Models ---------------------------------------- */

#define TATU_MODEL "tatu.model/draft.4"

/* An object of a model to which other models can be attached. */
typedef struct tatu_model_slot {
  uint32_t size;
  uint32_t reserved;
  const char *alias; /* alias of the object */
  const char *mount; /* name of the mount that fits, such as "iso9409-50-4-m6"; null: any */
  const char *text;  /* position of the slot, one sentence; null: none */
  double payload;    /* attached mass, kg, above which the host warns; 0: not stated */
} tatu_model_slot;

/* A constant of a model and its source, for the documentation. */
typedef struct tatu_model_number {
  uint32_t size;
  uint32_t reserved;
  const char *name;
  tatu_value value;
  const char *unit;   /* null: none */
  const char *source; /* "data sheet, p. 5", or "estimate: " and the reasoning */
} tatu_model_number;

/* A model: a function from parameters to objects. Object 1 of the build is the model's base. */
typedef struct tatu_model {
  uint32_t size;
  uint32_t flags;                  /* 0 */
  const char *id;                  /* "pioneer_p3dx": its name in scene files */
  const char *text;
  const tatu_param *const *params;
  const char *const *slots;        /* aliases of objects to which other models may be attached; null: none */
  /* [setup] Builds the model, with the base placed such that the model stands on the floor z = 0. A model on wheels
   * describes its drive in the property "object.drive" of its base. */
  tatu_status(TATU_CALL *build)(void *self, const tatu_builder *, const tatu_value *params, tatu_error *);
  const char *category;            /* heading in lists: "mobile robots", "arms", "furniture"; null: none */
  const char *licence;             /* SPDX identifier; null: that of the plugin */
  const char *const *mounts;       /* names of the mounts with which it fits a slot of another model; null: any */
  const tatu_model_slot *const *slot_infos;   /* details of `slots`; null: none */
  const tatu_model_number *const *numbers;    /* null: none */
} tatu_model;

/* The models of a plugin, and optionally a function that reads models described by text. When a scene uses a model
 * NAME, the host searches the folders `models` for `NAME/model.toml`, and calls the `read` functions of all plugins in
 * order. */
typedef struct tatu_ext_model {
  uint32_t size;
  uint32_t reserved;
  const tatu_model *const *models;  /* may be null if `read` is set */
  /* [setup] Reads a model from the text of its file; `name` is the name of the file's folder. The plugin owns the
   * model, which must be valid until shutdown. TATU_ERR_UNSUPPORTED: the text is in another format, and the next
   * plugin's `read` is called. Other errors, with the line (TATU_PART_FILE), are reported to the user of the model.
   * When the model is built, the host passes its address in `tatu_builder.model`. Null or absent: the plugin does not
   * read models. */
  tatu_status(TATU_CALL *read)(void *self, tatu_str name, tatu_str text, const tatu_model **out, tatu_error *);
} tatu_ext_model;

#ifndef __cplusplus
/* Models of a plugin, for TATU_PLUGIN: pointers to tatu_model. */
#  define TATU_MODELS(...) TATU_OFFER(TATU_MODEL, tatu_ext_model, .models = TATU_LIST_OF(tatu_model, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
