/* tatu/actuator.h: actuators, which convert commands to forces. */
#ifndef TATU_ACTUATOR_H
#define TATU_ACTUATOR_H

#include "core.h"
#include "sensor.h" /* fields */

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_ACTUATOR "tatu.actuator/draft.4"

/* A kind's `apply` is called each time physics advances, by one step of the world or by the time that a driver
 * requests; with the flag, it is called before each engine step. A wrench acts on the nearest dynamic shape at or above
 * the actuator, an effort on the nearest joint between the actuator and that shape. Commands are properties
 * "<kind>.<key>" of the actuator's object: scenes set them like parameters, and they can be set at any time. */
enum tatu_actuator_flag { TATU_ACTUATOR_EVERY_SUBSTEP = 1 /* `apply` is called before each engine step */ };

/* The `n` actuators of one kind. Inputs are the state of the mount, the commands, and further inputs that the kind
 * declares; outputs are a wrench, an effort, and wrenches on targets. */
typedef struct tatu_actuator_batch {
  uint32_t size;
  uint32_t n;
  double time;               /* simulation time, s */
  double dt;                 /* time until the next call, s */
  void *const *data;         /* [n] instances */
  void *const *state;        /* [n] state blocks */
  const tatu_object *actuator; /* [n] */
  const double *pose;        /* [n], 7 each: pose of the mount in the world */
  const double *twist;       /* [n], 6 each: twist of the mount, world frame */
  const double *joint;       /* [n], 2 each: position and velocity of the joint it acts on; 0 without a joint */
  const double *const *command; /* [n] the command buffer: `n_commands` of the kind */
  double *wrench;            /* [n], 6 each: force (N) at the mount's origin, torque (N m), world; acts for dt; zeroed */
  double *effort;            /* [n] torque (N m) or force (N) added to that of the joint; acts for dt; zeroed */
  tatu_status *status;       /* [n] as for sensors; an output that is not finite is a failure of its actuator */
  void *const *fields;       /* [n * n_fields] output buffers of readings; host-owned, zeroed */
  const uint64_t *const *lengths; /* [n], n_fields each: number of elements of each field */
  uint32_t n_fields;
  uint32_t reserved;
  /* The following arrays are null unless the kind declares TATU_IN_TARGETS; hosts before ABI 0.8 do not have them. */
  const uint64_t *first_target; /* [n + 1] index of each actuator's first target in the arrays below. The targets of an
                                 * actuator are in the order of the scene's list */
  const tatu_object *target;    /* per target; 0: there is no object at that path, for instance because it has been
                                 * removed; its pose and twist are then NaN, and its `target_wrench` is ignored */
  const double *target_pose;    /* per target, 7: pose in the world */
  const double *target_twist;   /* per target, 6: twist of its origin, world frame */
  double *target_wrench;        /* per target, 6: force (N) at its origin, torque (N m), world, on the nearest dynamic shape
                                 * at or above it; none: no effect. Acts for dt; zeroed */
  /* The following arrays are null unless the kind declares TATU_IN_CONTACTS; hosts before ABI 0.8 do not have them. */
  const uint64_t *first_contact; /* [n + 1] index of each actuator's first contact in the arrays below */
  const tatu_contact *contact;  /* contacts of the shape on which the wrench acts, after the last physics step: shape[1] is
                                 * that shape, so the force acts on it along `normal` */
  const double *friction;       /* per contact, 3: friction on that shape, N, world frame */
} tatu_actuator_batch;

typedef struct tatu_actuator {
  uint32_t size;
  uint32_t flags;                    /* TATU_ACTUATOR_* */
  uint32_t n_commands;               /* size of an instance's command buffer: the number of entries in `commands` */
  uint32_t reserved;
  const char *id;
  const char *text;
  const tatu_param *const *params;
  const tatu_param *const *commands; /* declarations of the commands, each of type TATU_F64 */
  const tatu_life *life;
  /* [parallel] Converts commands to forces. The rules of tatu_sensor.measure apply. */
  tatu_status(TATU_CALL *apply)(void *self, const tatu_actuator_batch *, tatu_error *);
  /* The readings of the actuator itself, such as its speed and current, which are read like those of a sensor: `apply`
   * fills the fields in each call; the last values of a step are retained. Their shapes are fixed. Null: none. */
  const char *const *schemas;
  const tatu_field *const *fields;
  uint32_t inputs;                   /* sum of TATU_IN_TARGETS and TATU_IN_CONTACTS; needs ABI 0.8 (tatu_need.minor) */
  uint32_t reserved2;
} tatu_actuator;

typedef struct tatu_ext_actuator {
  uint32_t size;
  uint32_t reserved;
  const tatu_actuator *const *kinds;
} tatu_ext_actuator;

#ifndef __cplusplus
/* Kinds of actuators of a plugin, for TATU_PLUGIN: pointers to tatu_actuator. */
#  define TATU_ACTUATORS(...) TATU_OFFER(TATU_ACTUATOR, tatu_ext_actuator, .kinds = TATU_LIST_OF(tatu_actuator, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
