/* tatu/part.h: parts, native controllers that act with the world in hand. */
#ifndef TATU_PART_H
#define TATU_PART_H

#include "core.h"
#include "sensor.h" /* fields, presets */

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_PART "tatu.part/draft.4"

/* A part is a controller in native code. It is an object of a scene or model (`kind = "part"`), and belongs to the
 * object above it, or to the world if there is none. Where an actuator computes a force in a batch, a part is called
 * alone, on the thread of the world, and may use every host function that a command may use (tatu.h, WHAT A CALL MAY
 * USE).
 *
 * Parts of a world are called in ascending order of their handles. In a step:
 *   actuate        scripts act, then parts
 *   physics        before each physics step: the scripts' callbacks, then `physics_step` of parts, then actuators
 *   sense          sensors measure; then `sense` of parts; their readings are published
 *   react          scripts read what sensors and parts have sensed
 * A script thus commands the parts of the same step, and reads what they report in it.
 * `docs/plugin-authors/parts.md` describes each moment.
 *
 * Commands are properties "<kind>.<key>" of the part's object, as those of an actuator: scenes set them like
 * parameters, and scripts, clients and other parts can set them at any time. */

/* One call of a part. The host owns it; it is valid during the call. */
typedef struct tatu_part_call {
  uint32_t size;
  uint32_t n_fields;
  tatu_world *world;
  tatu_object part;         /* the part's own object */
  tatu_object owner;        /* the object that it belongs to; 0: the world */
  double time;              /* simulation time, s; in `physics_step`, at the beginning of that physics step */
  double dt;                /* duration of the step, s; in `physics_step`, of the physics step */
  uint64_t step;            /* index of the step, from 0 */
  uint32_t physics_step;    /* in `physics_step`: index of the physics step in its step, from 0; else 0 */
  uint32_t n_physics_steps; /* in `physics_step`: number of physics steps in the step; else 0 */
  void *state;              /* state block */
  const double *command;    /* values of the commands, in the order of declaration */
  void *const *fields;      /* [n_fields] buffers of the readings; host-owned; they keep their values between calls */
  const uint64_t *lengths;  /* [n_fields] number of elements of each field */
} tatu_part_call;

/* A pair of shapes on whose contact a part decides. The host owns it. The answer, from `collide` on, is preset to the
 * part's last one for this pair, at first to the values that change nothing; it holds until the next one. */
typedef struct tatu_contact_pair {
  uint32_t size;
  uint32_t touching;     /* 1: the shapes were in contact after the last physics step */
  tatu_contact contact;  /* the shapes, the lower handle first, and their strongest contact; zeros without one */
  uint32_t collide;      /* 1; 0: the shapes pass through each other */
  uint32_t reserved;
  double friction;       /* coefficient; negative: that of the materials and shapes, as at first */
  double restitution;    /* 0 to 1; negative: as for friction */
  double surface[3];     /* velocity of the surface of contact.shape[0] relative to its body, world frame, m/s */
} tatu_contact_pair;

/* Moments of a pause, for `paused`. */
enum tatu_pause {
  TATU_PAUSE_BEGINS = 0, /* the first pass without time */
  TATU_PAUSE_LASTS = 1,  /* each pass until the pause ends */
  TATU_PAUSE_ENDS = 2    /* before time advances again */
};

/* A kind of part. All functions but those that it needs may be null. A function that returns a negative status, panics
 * or breaks the contract is reported once, and the part is switched off: none of its functions but `destroy` is called
 * again. `tatu_life` applies as for actuators; `create` may read the world, whose objects all exist, but a sensor or
 * part that is declared later may not have been created yet. The state block is part of the hash of the world's
 * state. */
typedef struct tatu_part {
  uint32_t size;
  uint32_t flags;                    /* 0 */
  const char *id;                    /* "braitenberg": the kind's name in scene files */
  const char *text;
  const tatu_param *const *params;
  const tatu_param *const *commands; /* each of type TATU_F64; null: none */
  const tatu_life *life;
  /* [step] Called in the stage `actuate` of each step. */
  tatu_status(TATU_CALL *actuate)(void *data, const tatu_part_call *, tatu_error *);
  /* [step] Called before each physics step. */
  tatu_status(TATU_CALL *physics_step)(void *data, const tatu_part_call *, tatu_error *);
  /* [step] Called in the stage `sense` of each step, after the sensors have measured. */
  tatu_status(TATU_CALL *sense)(void *data, const tatu_part_call *, tatu_error *);
  /* [step] Called when a pause begins, lasts and ends; `moment` is one of enum tatu_pause. */
  tatu_status(TATU_CALL *paused)(void *data, const tatu_part_call *, uint32_t moment, tatu_error *);
  /* [step] Called once, after the scripts have cleaned up: at the end of a run, or when the part's object has been
   * removed, in which case the object can no longer be found. Not called for a part that was switched off. */
  tatu_status(TATU_CALL *end)(void *data, const tatu_part_call *, tatu_error *);
  /* The readings of the part, which are read like those of a sensor. Their shapes are fixed. The values in `fields` are
   * published when all parts have been called in a stage. Null: none. */
  const char *const *schemas;
  const tatu_field *const *fields;
  /* Named settings: parameters and commands, as lines of TOML. A scene selects them with `preset = "<id>"`; keys that
   * the scene sets itself take precedence. Null: none. */
  const tatu_preset *const *presets;
  /* [step] Receives an event (docs/reference/events.md): `name` and `payload`, a map, are valid during the call. Called
   * where events are delivered, after the functions of scripts that subscribe to the event. */
  tatu_status(TATU_CALL *event)(void *data, const tatu_part_call *, tatu_str name, const tatu_value *payload,
                                tatu_error *);
  const char *const *events; /* names of the events that `event` receives; "*" as in tatu_service.events. Null: none */
  /* [step] Decides on a pair of shapes that the part has registered with bodies.hook, before each physics step, after
   * `physics_step` of all parts: for a registered pair always, for a shape that is registered with all others while it
   * touches another one, from the physics step after the first contact on, or is kept from touching it. */
  tatu_status(TATU_CALL *contact)(void *data, const tatu_part_call *, tatu_contact_pair *, tatu_error *);
} tatu_part;

typedef struct tatu_ext_part {
  uint32_t size;
  uint32_t reserved;
  const tatu_part *const *kinds;
} tatu_ext_part;

/* For a part's functions: returns a pointer to the first element of its field `k`, counted from 0 in the order of
 * declaration. */
TATU_INLINE void *tatu_part_field(const tatu_part_call *call, uint32_t k) { return call->fields[k]; }

#ifndef __cplusplus
/* Kinds of parts of a plugin, for TATU_PLUGIN: pointers to tatu_part. */
#  define TATU_PARTS(...) TATU_OFFER(TATU_PART, tatu_ext_part, .kinds = TATU_LIST_OF(tatu_part, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
