/* tatu/test.h: support for tests of plugins in C and C++. The guide is docs/plugin-authors/testing.md.
 *
 *   #include "tatu/test.h"
 *
 *   TATU_TEST(sees_the_wall) {
 *     tatu_test_scene(t, "format = 1 ...");
 *     tatu_test_step(t, 1);
 *     TATU_CHECK_NEAR(tatu_test_number(t, "/lamp", "lamp.level", 0), 0.5, 1e-9);
 *   }
 *
 *   TATU_TESTS(sees_the_wall);
 *
 * Each file in a plugin's folder `tests` is built as a separate library, which does not contain the plugin: the tests
 * use the plugin as scenes and scripts do. `tatu plugin test` builds the library and runs each test in its own process.
 *
 * The plugin itself does not need this header, and tatu.h does not include it. */
#ifndef TATU_TEST_H
#define TATU_TEST_H

#include <stdio.h>
#ifndef __cplusplus
#  include <setjmp.h>
#endif

#include "tatu/core.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- The host of tests ----------------------------- */

/* A world that a test has opened. Only the thread that opened it may use it. */
typedef struct tatu_test_world tatu_test_world;

/* Arguments of tatu_test_host.open. */
typedef struct tatu_test_setup {
  uint32_t size;
  uint32_t reserved;
  tatu_str scene;             /* the text of a scene file */
  const char *folder;         /* base of relative file names in the scene; null: the working folder */
  const char *const *plugins; /* libraries of plugins, or folders with them, besides the program's own; may be null */
} tatu_test_setup;

/* The host's interface to tests, in the library `tatuhost` beside the program, or in the program itself. Its functions
 * never end the process. A function that fails returns null or a negative status, and `last_error` returns the message:
 * what is wrong, where, and what was expected. Results returned by pointer are valid until the next call with the same
 * world; texts from `last_error` are valid until the next call on the same thread. */
typedef struct tatu_test_host {
  uint32_t size;
  uint32_t reserved;
  /* Opens a scene and starts it: time is 0, and nothing has been measured yet. */
  tatu_test_world *(TATU_CALL *open)(const tatu_test_setup *);
  /* Stops a world and closes it; null is ignored. Negative: a fault occurred, while stopping or earlier, that `faults`
   * has not returned yet. */
  tatu_status(TATU_CALL *close)(tatu_test_world *);
  /* Runs `n` steps. Faults of scripts and plugins do not stop the world; see `faults`. */
  tatu_status(TATU_CALL *step)(tatu_test_world *, uint64_t n);
  /* Returns the simulation time, s; -1: there is no such world. */
  double(TATU_CALL *time)(tatu_test_world *);
  /* Gets a field of a sensor's last reading, an array of numbers. `path` is the path or unique name of the sensor, and
   * `name` that of the field. */
  tatu_status(TATU_CALL *field)(tatu_test_world *, const char *path, const char *name, tatu_value *out);
  /* Gets the whole reading: a map with `kind`, `time` (s), `sequence` (the number of measurements so far) and
   * `fields`. */
  tatu_status(TATU_CALL *reading)(tatu_test_world *, const char *path, tatu_value *out);
  /* Gets or sets a property of an object: "position", "joint.position", a parameter ("lamp.range") or a command of an
   * actuator. An empty path stands for the world ("scene.gravity"). */
  tatu_status(TATU_CALL *get)(tatu_test_world *, const char *path, const char *key, tatu_value *out);
  tatu_status(TATU_CALL *set)(tatu_test_world *, const char *path, const char *key, const tatu_value *value);
  /* Calls a command between two steps, with the host as the caller. Writes up to `cap` results; `*n_results` is the
   * full number of results. */
  tatu_status(TATU_CALL *call)(tatu_test_world *, const char *name, const tatu_value *args, uint32_t n_args,
                               tatu_value *results, uint32_t cap, uint32_t *n_results);
  /* Returns the messages logged since the previous call to `lines`, one per line: "warning: ...". */
  tatu_str(TATU_CALL *lines)(tatu_test_world *);
  /* Returns the faults since the previous call to `faults`, one per line: "[F207] ...". Empty: there were none. */
  tatu_str(TATU_CALL *faults)(tatu_test_world *);
  /* Returns the message of the last call on this thread that failed. */
  tatu_str(TATU_CALL *last_error)(void);
} tatu_test_host;

/* The one function that the library `tatuhost` exports. */
typedef const tatu_test_host *(TATU_CALL *tatu_test_host_get_t)(void);

/* ---------------------------------------------------------------- Tests ----------------------------------------- */

/* A running test, for the macros and functions below. */
typedef struct tatu_test {
  uint32_t size;
  uint32_t failures;          /* number of checks that have failed */
  const tatu_test_host *host;
  const char *folder;         /* base of relative file names in scenes: the folder `tests` */
  const char *const *plugins; /* the plugin under test */
  tatu_test_world *world;     /* the world that tatu_test_scene opened; closed at the end */
  void *leave;                /* in C, the jmp_buf to which TATU_TEST_LEAVE jumps */
  void *ctx;                  /* private to the runner */
  /* Records a failure with its position and message. */
  void(TATU_CALL *report)(struct tatu_test *, const char *file, uint32_t line, const char *text);
} tatu_test;

/* One test, as TATU_TEST declares it. */
typedef struct tatu_test_case {
  uint32_t size;
  uint32_t line;
  const char *name;
  const char *file;
  void(TATU_CALL *run)(tatu_test *);
} tatu_test_case;

/* All tests of a library; exported as the symbol `tatu_tests`. */
typedef struct tatu_test_list {
  uint32_t size;
  uint16_t abi_major;
  uint16_t abi_minor;
  const tatu_test_case *const *cases; /* null-terminated */
} tatu_test_list;

#ifdef __cplusplus
} /* extern "C" */

struct tatu_test_end {}; /* thrown to leave a test, so that destructors run */
#  define TATU_TEST_LEAVE(Test) throw tatu_test_end()
#  define TATU_TEST_ENTER(Test, Body) \
    try { Body(Test); } \
    catch (const tatu_test_end &) {} \
    catch (...) { tatu_test_fail(Test, __FILE__, __LINE__, "an exception was thrown"); }
#  define TATU_TEST_LINKAGE extern "C"
#else
#  define TATU_TEST_LEAVE(Test) longjmp(*(jmp_buf *)(Test)->leave, 1)
#  define TATU_TEST_ENTER(Test, Body) \
    jmp_buf leave; \
    (Test)->leave = &leave; \
    if (!setjmp(leave)) Body(Test); \
    (Test)->leave = NULL;
#  define TATU_TEST_LINKAGE extern
#endif

/* Declares a test; its body follows. In the body, `t` is the running test. `Name` also becomes the name of a constant,
 * to be listed in TATU_TESTS. */
#define TATU_TEST(Name) \
  static void tatu_body_##Name(tatu_test *t); \
  static void TATU_CALL tatu_run_##Name(tatu_test *t) { TATU_TEST_ENTER(t, tatu_body_##Name) } \
  static const tatu_test_case Name[1] = {{sizeof(tatu_test_case), __LINE__, #Name, __FILE__, tatu_run_##Name}}; \
  static void tatu_body_##Name(tatu_test *t)

/* Exports the tests of a file; used once, at its end: TATU_TESTS(sees_the_wall, counts). */
#define TATU_TESTS(...) \
  static const tatu_test_case *const tatu_test_cases[] = {__VA_ARGS__, NULL}; \
  TATU_TEST_LINKAGE TATU_EXPORT const tatu_test_list tatu_tests; \
  const tatu_test_list tatu_tests = {sizeof(tatu_test_list), TATU_ABI_MAJOR, TATU_ABI_MINOR, tatu_test_cases}

/* ---------------------------------------------------------------- Checks ---------------------------------------- */

/* Records a failure; the test continues. */
TATU_INLINE void tatu_test_fail(tatu_test *t, const char *file, int line, const char *text) {
  t->failures++;
  if (TATU_HAS(t, report)) t->report(t, file, (uint32_t)line, text);
}
TATU_INLINE int tatu_test_check(tatu_test *t, const char *file, int line, int holds, const char *what) {
  char text[512];
  if (holds) return 1;
  snprintf(text, sizeof text, "%s does not hold", what);
  tatu_test_fail(t, file, line, text);
  return 0;
}
TATU_INLINE int tatu_test_check_near(tatu_test *t, const char *file, int line, double a, double b, double tolerance,
                                       const char *what_a, const char *what_b) {
  char text[512];
  double apart = a > b ? a - b : b - a;
  if (apart <= tolerance || a == b) return 1;
  snprintf(text, sizeof text, "%s is %.17g, and %s is %.17g: %g apart, at most %g expected", what_a, a, what_b, b, apart,
           tolerance);
  tatu_test_fail(t, file, line, text);
  return 0;
}

/* Checks a condition; the test continues if it does not hold. */
#define TATU_CHECK(Holds) tatu_test_check(t, __FILE__, __LINE__, !!(Holds), #Holds)
/* Checks that two numbers differ by at most a tolerance; the test continues if they do not. */
#define TATU_CHECK_NEAR(A, B, Tolerance) \
  tatu_test_check_near(t, __FILE__, __LINE__, (double)(A), (double)(B), (double)(Tolerance), #A, #B)
/* Checks a condition; ends the test if it does not hold. */
#define TATU_REQUIRE(Holds) \
  do { \
    if (!TATU_CHECK(Holds)) TATU_TEST_LEAVE(t); \
  } while (0)

/* ---------------------------------------------------------------- The world of a test --------------------------- */

/* If the host reports an error, the functions below end the test with its message. */
TATU_INLINE void tatu_test_need(tatu_test *t, const char *file, int line, int done) {
  char text[4096];
  tatu_str why;
  if (done) return;
  why = t->host->last_error();
  snprintf(text, sizeof text, "%.*s", (int)(why.len < 4000 ? why.len : 4000), why.ptr ? why.ptr : "");
  tatu_test_fail(t, file, line, text);
  TATU_TEST_LEAVE(t);
}
TATU_INLINE int tatu_test_has_world(tatu_test *t, const char *file, int line) {
  if (t->world) return 1;
  tatu_test_fail(t, file, line, "there is no world yet: call tatu_test_scene first");
  TATU_TEST_LEAVE(t);
  return 0;
}
TATU_INLINE void tatu_test_scene_at(tatu_test *t, const char *file, int line, const char *scene) {
  tatu_test_setup setup = {sizeof(tatu_test_setup), 0, {0, 0}, 0, 0};
  tatu_test_world *before = t->world;
  t->world = 0;
  tatu_test_need(t, file, line, t->host->close(before) >= 0);
  setup.scene = tatu_text(scene);
  setup.folder = t->folder;
  setup.plugins = t->plugins;
  t->world = t->host->open(&setup);
  tatu_test_need(t, file, line, t->world != 0);
}
TATU_INLINE void tatu_test_step_at(tatu_test *t, const char *file, int line, uint64_t n) {
  if (tatu_test_has_world(t, file, line)) tatu_test_need(t, file, line, t->host->step(t->world, n) >= 0);
}
TATU_INLINE double tatu_test_number_at(tatu_test *t, const char *file, int line, const char *path, const char *field,
                                         uint64_t index) {
  tatu_value v = {TATU_NIL, 0, {0}};
  if (!tatu_test_has_world(t, file, line)) return 0;
  tatu_test_need(t, file, line, t->host->field(t->world, path, field, &v) >= 0);
  if (v.tag == TATU_F64S && index < v.u.s.len) return ((const double *)v.u.s.ptr)[index];
  if (v.tag == TATU_I64S && index < v.u.s.len) return (double)((const int64_t *)v.u.s.ptr)[index];
  {
    char text[512];
    int numbers = v.tag == TATU_F64S || v.tag == TATU_I64S;
    snprintf(text, sizeof text, "%s: `%s` has %lu numbers, but index %lu was requested", path, field,
             numbers ? (unsigned long)v.u.s.len : 0ul, (unsigned long)index);
    tatu_test_fail(t, file, line, text);
    TATU_TEST_LEAVE(t);
  }
  return 0;
}
TATU_INLINE tatu_value tatu_test_get_at(tatu_test *t, const char *file, int line, const char *path, const char *key) {
  tatu_value v = {TATU_NIL, 0, {0}};
  if (tatu_test_has_world(t, file, line)) tatu_test_need(t, file, line, t->host->get(t->world, path, key, &v) >= 0);
  return v;
}
TATU_INLINE void tatu_test_set_at(tatu_test *t, const char *file, int line, const char *path, const char *key,
                                    tatu_value value) {
  if (tatu_test_has_world(t, file, line)) tatu_test_need(t, file, line, t->host->set(t->world, path, key, &value) >= 0);
}
TATU_INLINE tatu_value tatu_test_call_at(tatu_test *t, const char *file, int line, const char *name,
                                           const tatu_value *args, uint32_t n_args) {
  tatu_value result = {TATU_NIL, 0, {0}};
  uint32_t n = 0;
  if (tatu_test_has_world(t, file, line))
    tatu_test_need(t, file, line, t->host->call(t->world, name, args, n_args, &result, 1, &n) >= 0);
  return n ? result : tatu_nil();
}

/* Opens a scene, given as the text of a scene file, with the plugin under test. Closes the scene that is already
 * open. */
#define tatu_test_scene(Test, Text) tatu_test_scene_at(Test, __FILE__, __LINE__, Text)
/* Runs `N` steps. */
#define tatu_test_step(Test, N) tatu_test_step_at(Test, __FILE__, __LINE__, N)
/* Returns a number of a sensor's last reading, given the path of the sensor, the name of the field, and an index from
 * 0. */
#define tatu_test_number(Test, Path, Field, Index) tatu_test_number_at(Test, __FILE__, __LINE__, Path, Field, Index)
/* These macros get a property of an object as a tatu_value, which tatu_to_float converts to a number, and set a
 * property to a tatu_value. */
#define tatu_test_get(Test, Path, Key) tatu_test_get_at(Test, __FILE__, __LINE__, Path, Key)
#define tatu_test_set(Test, Path, Key, Value) tatu_test_set_at(Test, __FILE__, __LINE__, Path, Key, Value)
/* Calls a command and returns its first result, or nil: tatu_test_call(t, "hello.twice", TATU_VALUES(tatu_float(21))).
 * Without arguments: tatu_test_call(t, "hello.count", NULL, 0). */
#define tatu_test_call(Test, Name, ...) tatu_test_call_at(Test, __FILE__, __LINE__, Name, __VA_ARGS__)

/* Calls a command, and returns 1 if it fails with a message that contains `text`, else 0; for tests of errors. */
TATU_INLINE int tatu_test_refuses(tatu_test *t, const char *text, const char *name, const tatu_value *args,
                                    uint32_t n_args) {
  tatu_str why, wanted = tatu_text(text);
  uint32_t n = 0;
  uint64_t i, j;
  if (!t->world || t->host->call(t->world, name, args, n_args, 0, 0, &n) >= 0) return 0;
  why = t->host->last_error();
  for (i = 0; i + wanted.len <= why.len; i++) {
    for (j = 0; j < wanted.len && why.ptr[i + j] == wanted.ptr[j]; j++) {}
    if (j == wanted.len) return 1;
  }
  return 0;
}
/* Returns the simulation time, s; 0 if no scene is open. */
TATU_INLINE double tatu_test_time(tatu_test *t) { return t->world ? t->host->time(t->world) : 0; }
/* Returns the faults since the previous call. A test fails if faults have occurred that it has not read with this
 * function by its end. */
TATU_INLINE tatu_str tatu_test_faults(tatu_test *t) { return t->world ? t->host->faults(t->world) : tatu_text(""); }
/* Returns the messages logged since the previous call. */
TATU_INLINE tatu_str tatu_test_lines(tatu_test *t) { return t->world ? t->host->lines(t->world) : tatu_text(""); }

#endif
