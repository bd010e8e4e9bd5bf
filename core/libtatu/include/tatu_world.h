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
 * models that come with the simulator are found from where the library lies: `../lib/tatu/plugins`, `../share/tatu`.
 *
 * A world may be used from any thread; calls from several threads take turns, and different worlds run at once. Nothing
 * here ends the process, installs a signal handler or an exit hook, or prints. After `fork`, the copy cannot use worlds.
 *
 * A function that fails returns null or a negative status (TATU_ERR...), and `tatu_world_error` tells why. Texts are
 * UTF-8. Tables grow at their ends: set `size` to sizeof, and leave what is not used zero. */
#ifndef TATU_WORLD_H
#define TATU_WORLD_H

#include "tatu/core.h" /* tatu_value, tatu_str, statuses */

#ifdef __cplusplus
extern "C" {
#endif

/* A world: a scene that runs. A handle that was closed is refused, and nothing is read through it. */
typedef struct tatu_world_handle tatu_world_handle;

/* What a world is made of. Lists are null-terminated arrays of texts, or null. */
typedef struct tatu_world_setup {
  uint32_t size;
  uint32_t threads;           /* of this world; results do not depend on it; 0: one */
  const char *scene;          /* a file, or the name of a scene that comes with the simulator; null: `text` */
  tatu_str text;              /* the text of a scene file */
  const char *folder;         /* from which the paths in `text` start; null: the working folder */
  const char *const *set;     /* changes: "/Robot/motor.max_force_nm=2" */
  const char *const *scripts; /* scripts that replace those of objects: "/Robot=controller.lua" */
  const char *const *allow;   /* what scripts may use of the outside: "exec", "native", "net=HOST:PORT"; "plugins" */
  const char *const *plugins; /* libraries of plugins, or folders with such */
  uint64_t seed;              /* of all random numbers, if has_seed is 1; else the scene's own */
  uint32_t has_seed;
  uint32_t reserved;
} tatu_world_setup;

/* Opens a scene and starts it: time is 0, and nothing has been measured yet. */
TATU_EXPORT tatu_world_handle *tatu_world_open(const tatu_world_setup *);
/* Another world in the same state, which goes on by itself. */
TATU_EXPORT tatu_world_handle *tatu_world_fork(tatu_world_handle *);
/* Ends a world; null is ignored. */
TATU_EXPORT tatu_status tatu_world_close(tatu_world_handle *);

/* Does up to `n` steps, fewer if something in the scene stops it. Writes how many were done; `done` may be null. Errors of
 * scripts do not stop it: see `tatu_world_lines`. */
TATU_EXPORT tatu_status tatu_world_step(tatu_world_handle *, uint64_t n, uint64_t *done);
/* Begins anew, at time 0. With another seed if `seed` is not null. */
TATU_EXPORT tatu_status tatu_world_reset(tatu_world_handle *, const uint64_t *seed);
/* Simulation time, s, and the length of a step, s; negative: there is no such world. */
TATU_EXPORT double tatu_world_time(tatu_world_handle *);
TATU_EXPORT double tatu_world_dt(tatu_world_handle *);
/* The hash of the state: the same scene, seed and calls give the same on every machine. */
TATU_EXPORT tatu_status tatu_world_hash(tatu_world_handle *, uint64_t *hash);

/* Reads numbers of an object, by path or unique name: a property ("object.world_pose", "joint.position"), or a field of a
 * sensor's last reading ("range_scan.ranges"). An empty path is the world ("scene.gravity"). Writes up to `cap` numbers,
 * and how many there are; `count` may be null. */
TATU_EXPORT tatu_status tatu_world_read(tatu_world_handle *, const char *path, const char *name, double *out, uint64_t cap,
                                        uint64_t *count);
/* Sets a property that is a number or an array of numbers. */
TATU_EXPORT tatu_status tatu_world_write(tatu_world_handle *, const char *path, const char *name, const double *numbers,
                                         uint64_t count);
/* Reads and sets properties of any type. What `out` points to is valid until the next call with the same world. */
TATU_EXPORT tatu_status tatu_world_get(tatu_world_handle *, const char *path, const char *name, tatu_value *out);
TATU_EXPORT tatu_status tatu_world_set(tatu_world_handle *, const char *path, const char *name, const tatu_value *value);
/* Calls a command of a plugin, such as "sim.getObject". Writes up to `cap` results, and how many there are. */
TATU_EXPORT tatu_status tatu_world_call(tatu_world_handle *, const char *name, const tatu_value *args, uint32_t n_args,
                                        tatu_value *results, uint32_t cap, uint32_t *n_results);

/* The state, from which this world, or another one of the same scene, can go on. The bytes are valid until the next call
 * with the same world. */
TATU_EXPORT tatu_status tatu_world_snapshot(tatu_world_handle *, tatu_str *out);
TATU_EXPORT tatu_status tatu_world_restore(tatu_world_handle *, tatu_str snapshot);

/* A picture: `rows` rows of `columns` pixels of 3 bytes, red, green and blue, from the upper left. Seen by a camera of the
 * scene, or, if it is null, by the scene's first camera or from where everything is in sight. */
TATU_EXPORT tatu_status tatu_world_render(tatu_world_handle *, const char *camera, uint32_t columns, uint32_t rows,
                                          uint8_t *rgb);

/* What scripts printed, and warnings and errors, since the last call: a line each, "error[F205]: ...". Valid until the next
 * call with the same world. */
TATU_EXPORT tatu_str tatu_world_lines(tatu_world_handle *);

/* Why the last call on this thread failed: what, where, what was expected, what to do. Ends with 0; valid until the next
 * call on this thread. */
TATU_EXPORT const char *tatu_world_error(void);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif
