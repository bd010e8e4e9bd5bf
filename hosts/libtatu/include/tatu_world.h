/* tatu_world.h: the simulator as a library, and its manual.
 *
 *   #include "tatu_world.h"
 *
 *   tatu_world_setup setup = {sizeof setup};
 *   setup.scene = "first/pioneer_avoids_walls.toml";
 *   tatu_world_handle *w = tatu_world_open(&setup);
 *   if (!w) { puts(tatu_world_error()); return 1; }
 *   tatu_world_step(w, 100, NULL);
 *   double pose[7];
 *   tatu_world_read(w, "/Pioneer_p3dx", "object.world_pose", pose, 7, NULL);
 *   tatu_world_close(w);
 *
 * Compile with `-I` for the folders of this header and of tatu/core.h, and link with `-ltatu`. The plugins, scenes and
 * models that come with the simulator are searched for relative to the library's folder: `../lib/tatu/plugins`,
 * `../share/tatu`.
 *
 * A world may be used from any thread; calls from several threads take turns, and different worlds run concurrently.
 * No function ends the process, installs a signal handler or an exit hook, or prints. After `fork`, the child process
 * cannot use worlds.
 *
 * A function that fails returns null or a negative status (TATU_ERR...); `tatu_world_error` returns the message.
 * Strings are UTF-8. Later versions can append fields to structs: set `size` to sizeof, and leave unused fields
 * zero. */
#ifndef TATU_WORLD_H
#define TATU_WORLD_H

#include "tatu/core.h" /* tatu_value, tatu_str, statuses */

#ifdef __cplusplus
extern "C" {
#endif

/* A handle of a world, which is a running scene. A handle that has been closed is rejected without being
 * dereferenced. */
typedef struct tatu_world_handle tatu_world_handle;

/* Arguments of tatu_world_open. Lists are null-terminated arrays of strings, or null. */
typedef struct tatu_world_setup {
  uint32_t size;
  uint32_t threads;           /* number of threads of this world, which does not affect results; 0: one */
  const char *scene;          /* a file, or the name of a scene that comes with the simulator; null: `text` */
  tatu_str text;              /* the text of a scene file */
  const char *folder;         /* folder to which paths in `text` are relative; null: the working folder */
  const char *const *set;     /* changes of the scene: "/Robot/motor.max_force_nm=2" */
  const char *const *scripts; /* scripts that replace those of objects: "/Robot=controller.lua" */
  const char *const *allow;   /* permissions: of scripts "exec", "native", "net=HOST:PORT"; of the scene "plugins" */
  const char *const *plugins; /* plugin libraries, or folders that contain plugin libraries */
  uint64_t seed;              /* seed of all random numbers, unless has_seed is 0; then the scene's own seed is used */
  uint32_t has_seed;
  uint32_t reserved;
} tatu_world_setup;

/* Opens a scene and starts it: time is 0, and nothing has been measured yet. */
TATU_EXPORT tatu_world_handle *tatu_world_open(const tatu_world_setup *);
/* Returns a new world in the same state, which is independent of the first. */
TATU_EXPORT tatu_world_handle *tatu_world_fork(tatu_world_handle *);
/* Closes a world; null is ignored. */
TATU_EXPORT tatu_status tatu_world_close(tatu_world_handle *);

/* Runs up to `n` steps, fewer if something in the scene requests a stop. Writes the number of steps that were run to
 * `done`, which may be null. Errors of scripts do not stop the world: see `tatu_world_lines`. */
TATU_EXPORT tatu_status tatu_world_step(tatu_world_handle *, uint64_t n, uint64_t *done);
/* Resets the world to time 0, with a different seed if `seed` is not null. */
TATU_EXPORT tatu_status tatu_world_reset(tatu_world_handle *, const uint64_t *seed);
/* Return the simulation time and the duration of a step, both in s, or -1 if the call fails. */
TATU_EXPORT double tatu_world_time(tatu_world_handle *);
TATU_EXPORT double tatu_world_dt(tatu_world_handle *);
/* Computes the hash of the state, which is the same on every machine for the same scene, seed and calls. */
TATU_EXPORT tatu_status tatu_world_hash(tatu_world_handle *, uint64_t *hash);

/* Reads numeric values of an object, given by path or unique name: a property ("object.world_pose", "joint.position"),
 * or a field of a sensor's last reading ("range_scan.ranges"). An empty path stands for the world ("scene.gravity").
 * Writes up to `cap` values to `out`, and the total number of values to `count`, which may be null. */
TATU_EXPORT tatu_status tatu_world_read(tatu_world_handle *, const char *path, const char *name, double *out, uint64_t cap,
                                        uint64_t *count);
/* Sets a property that is a number or an array of numbers. */
TATU_EXPORT tatu_status tatu_world_write(tatu_world_handle *, const char *path, const char *name, const double *numbers,
                                         uint64_t count);
/* Reads and sets properties of any type. Memory that `out` points to is valid until the next call with the same
 * world. */
TATU_EXPORT tatu_status tatu_world_get(tatu_world_handle *, const char *path, const char *name, tatu_value *out);
TATU_EXPORT tatu_status tatu_world_set(tatu_world_handle *, const char *path, const char *name, const tatu_value *value);
/* Calls a command of a plugin, such as "sim.getObject". Writes up to `cap` results, and their full count. */
TATU_EXPORT tatu_status tatu_world_call(tatu_world_handle *, const char *name, const tatu_value *args, uint32_t n_args,
                                        tatu_value *results, uint32_t cap, uint32_t *n_results);

/* Saves the state, from which this world, or another world of the same scene, can continue. The bytes are valid until
 * the next call with the same world. */
TATU_EXPORT tatu_status tatu_world_snapshot(tatu_world_handle *, tatu_str *out);
TATU_EXPORT tatu_status tatu_world_restore(tatu_world_handle *, tatu_str snapshot);

/* Renders an image: `rows` rows of `columns` pixels of 3 bytes, red, green and blue, from the upper left. `camera` is a
 * camera of the scene; null: the scene's first camera or, if it has none, a view of the whole scene. */
TATU_EXPORT tatu_status tatu_world_render(tatu_world_handle *, const char *camera, uint32_t columns, uint32_t rows,
                                          uint8_t *rgb);

/* Returns the output of scripts, warnings and errors since the last call, one per line, such as "error[F205]: ...". The
 * string is valid until the next call with the same world. */
TATU_EXPORT tatu_str tatu_world_lines(tatu_world_handle *);

/* Returns the message of the last failed call on this thread: what failed, where, what was expected, and how to correct
 * it. The string is NUL-terminated, and valid until the next call on this thread. */
TATU_EXPORT const char *tatu_world_error(void);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif
