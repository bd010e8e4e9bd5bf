/* tatu/importer.h: importers, which convert files to objects. */
#ifndef TATU_IMPORTER_H
#define TATU_IMPORTER_H

#include "model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_IMPORTER "tatu.importer/draft.4"

/* An importer reads files of one format into a document, for `[[import]]` in scenes and for files that are opened as
 * the scene. */
typedef struct tatu_importer {
  uint32_t size;
  uint32_t reserved;
  const char *id;
  const char *text;
  const char *const *suffixes;     /* of file names: ".urdf" */
  const tatu_param *const *params;
  /* [setup] Returns the confidence, 0 to 100, that the importer can read a file that begins with `head`. Null: only the
   * suffix decides. */
  uint32_t(TATU_CALL *sniff)(void *self, tatu_str head);
  /* [setup] Reads the file; object 1 of the build is the base. Malformed input must cause an error, never a crash. The
   * error states its line in TATU_PART_FILE, where an empty file name stands for the source itself. */
  tatu_status(TATU_CALL *load)(void *self, tatu_str bytes, const tatu_builder *, const tatu_value *params,
                               tatu_error *);
} tatu_importer;

typedef struct tatu_ext_importer {
  uint32_t size;
  uint32_t reserved;
  const tatu_importer *const *importers;
} tatu_ext_importer;

#ifndef __cplusplus
/* Importers of a plugin, for TATU_PLUGIN: pointers to tatu_importer. */
#  define TATU_IMPORTERS(...) TATU_OFFER(TATU_IMPORTER, tatu_ext_importer, .importers = TATU_LIST_OF(tatu_importer, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
