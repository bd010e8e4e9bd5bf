/* Drives a Pioneer through a scene that comes with the simulator, and uses commands, readings, snapshots and a picture.
 *
 *   cc pioneer.c -I include -ltatu -o pioneer */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tatu_world.h"

static void fail(const char *what) {
  fprintf(stderr, "%s: %s\n", what, tatu_world_error());
  exit(1);
}

int main(int n_args, char **args) {
  tatu_world_setup setup = {sizeof(tatu_world_setup), 0, 0, {0, 0}, 0, 0, 0, 0, 0, 0, 0, 0};
  tatu_world_handle *world, *other;
  uint64_t hash = 0, done = 0, count = 0, other_hash = 0;
  double pose[7], distance = -1;
  tatu_value name = {TATU_TEXT, 0, {0}}, handle = {TATU_NIL, 0, {0}};
  uint32_t n_results = 0;
  tatu_str state;
  char *kept;
  uint8_t *picture = malloc(64 * 48 * 3);
  uint64_t sum = 0, i;

  setup.scene = n_args > 1 ? args[1] : "first/pioneer_avoids_walls.toml";
  world = tatu_world_open(&setup);
  if (!world) fail("cannot open the scene");
  if (tatu_world_step(world, 100, &done) < 0) fail("cannot run steps");
  if (tatu_world_hash(world, &hash) < 0) fail("cannot compute the hash");
  printf("%lu steps of %g s, hash %016lx\n", (unsigned long)done, tatu_world_dt(world), (unsigned long)hash);

  if (tatu_world_read(world, "/Pioneer_p3dx", "object.world_pose", pose, 7, &count) < 0) fail("cannot read the pose");
  printf("%lu numbers, at %.3f %.3f m\n", (unsigned long)count, pose[0], pose[1]);
  if (tatu_world_read(world, "Pioneer_p3dx_ultrasonicSensor4", "proximity.distance", &distance, 1, 0) < 0)
    fail("cannot read the sensor");

  name.u.s.ptr = "/Pioneer_p3dx";
  name.u.s.len = strlen("/Pioneer_p3dx");
  if (tatu_world_call(world, "sim.getObject", &name, 1, &handle, 1, &n_results) < 0) fail("cannot find the object");
  printf("%u result, handle %ld\n", n_results, (long)handle.u.i);

  /* Two worlds that continue from the same state reach the same state. */
  if (tatu_world_snapshot(world, &state) < 0) fail("cannot capture the state");
  kept = malloc(state.len);
  memcpy(kept, state.ptr, state.len);
  state.ptr = kept;
  other = tatu_world_fork(world);
  if (!other) fail("cannot copy the world");
  tatu_world_step(world, 20, 0);
  tatu_world_step(other, 20, 0);
  tatu_world_hash(world, &hash);
  tatu_world_hash(other, &other_hash);
  if (tatu_world_restore(world, state) < 0) fail("cannot restore the state");
  tatu_world_step(world, 20, 0);
  printf("the copy %s, ", hash == other_hash ? "agrees" : "differs");
  tatu_world_hash(world, &other_hash);
  printf("the restored one %s\n", hash == other_hash ? "agrees" : "differs");
  free(kept);

  if (tatu_world_render(world, 0, 64, 48, picture) < 0) fail("cannot render a picture");
  for (i = 0; i < 64 * 48 * 3; i++) sum += picture[i];
  printf("the picture is %s\n", sum ? "rendered" : "black");
  free(picture);

  /* Errors have a status and a message. */
  if (tatu_world_read(world, "/Nobody", "object.world_pose", pose, 7, 0) >= 0) return 1;
  printf("%s\n", tatu_world_error());
  tatu_world_close(other);
  tatu_world_close(world);
  if (tatu_world_step(world, 1, 0) != TATU_ERR_GONE) return 1;
  printf("%s\n", tatu_world_error());
  return 0;
}
