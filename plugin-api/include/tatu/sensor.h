/* tatu/sensor.h: sensors, which convert beams, poses and other inputs to readings. */
#ifndef TATU_SENSOR_H
#define TATU_SENSOR_H

#include "core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SENSOR "tatu.sensor/draft.4"

/* ---------------------------------------------------------------- Beams ----------------------------------------- */

/* Form of the beams. Volumes and images start at the sensor's origin and point along its +z. */
enum tatu_beam_form {
  TATU_BEAMS_NONE = 0,
  TATU_BEAMS_RAYS = 1,     /* `count[0]` rays along `directions` */
  TATU_BEAMS_GRID = 2,     /* pinhole image: count = {columns, rows}; dims = {horizontal angle}; square pixels */
  TATU_BEAMS_CONE = 3,     /* volume with a round far end: dims = {half angle}; 0 to pi */
  TATU_BEAMS_PYRAMID = 4,  /* volume with flat ends at heights near_m and far_m (finite) along +z:
                              dims = {x near, y near, x far, y far}, their full sizes in m */
  TATU_BEAMS_CYLINDER = 5, /* as PYRAMID, with round ends: dims = {radius near, radius far} in m */
  TATU_BEAMS_DISC = 6,     /* volume, a flat sector around +z in the plane of x and z, with round ends: dims = {full
                              angle, up to 2 pi; height in m, centred on y = 0; full angle of a gap around +z,
                              0: none} */
  TATU_BEAMS_PARALLEL = 7  /* image of parallel rays: count = {columns, rows}; dims = {width m}; square pixels */
};
enum tatu_beam_flag {
  TATU_BEAMS_NO_FRONT = 1,  /* front faces are not detected */
  TATU_BEAMS_NO_BACK = 2,   /* back faces are not detected */
  TATU_BEAMS_SKIP_MODEL = 4, /* objects of the sensor's own model are not detected */
  TATU_BEAMS_VISIBLE = 8,   /* detects visible objects, as a camera does; without it, detectable objects */
  TATU_BEAMS_OCCLUDE = 16,  /* the nearest point in a volume is detected only if no surface, front or back, at any
                             * incidence, lies between it and the sensor; otherwise nothing is detected */
  TATU_BEAMS_AIMED = 32     /* `tatu_sensor.aim` sets the origins and directions of the rays before each cast */
};

/* Physical kind of the beams. A beam detects a shape if it shares a bit with "shape.detectable_mask". */
enum tatu_wave {
  TATU_WAVES_ULTRASONIC = 16,
  TATU_WAVES_INFRARED = 32,
  TATU_WAVES_LASER = 64,
  TATU_WAVES_INDUCTIVE = 128,
  TATU_WAVES_CAPACITIVE = 256,
  TATU_WAVES_ALL = 65535
};

/* The beams that a sensor emits. The plugin fills in all fields except `size`, which the host sets. The optical axis of
 * an image (GRID, PARALLEL) is +z, with +y up and +x to the left; near_m and far_m are distances of planes normal to
 * it. Its pixels are ordered by rows, from the bottom up, and from left to right within a row. */
typedef struct tatu_beams {
  uint32_t size;
  uint32_t form;            /* enum tatu_beam_form */
  uint32_t count[2];
  double near_m;            /* minimum range, m; of a pyramid and a cylinder, the height of the near end */
  double far_m;             /* maximum range, m; of a pyramid and a cylinder, the height of the far end */
  double dims[6];
  double max_incidence;     /* rad between line of sight and surface normal; pi/2: no limit */
  const double *directions; /* 3 per ray, unit vectors, sensor frame; owned by the instance, valid until the next `beams` */
  uint32_t flags;
  uint32_t reserved;
  uint32_t waves;           /* sum of TATU_WAVES_*; preset to TATU_WAVES_ALL; ignored for images */
  uint32_t reserved2;
  uint32_t own[4];          /* additional dimensions of this instance, to which TATU_DIM_OWN refers in the shape of a field */
  uint32_t without;         /* TATU_IN_*: inputs of the kind that this instance does not need; they are 0 in its pixels */
  uint32_t reserved3;
  const double *origins;    /* 3 per ray, m, sensor frame; null: all rays start at the sensor's origin. Owned as `directions` */
  tatu_object observed;     /* shape, joint or force sensor whose state TATU_IN_JOINT, _CONTACTS and _WRENCH provide; 0: the
                             * nearest of each kind at or above the sensor. If it is removed, the sensor is switched
                             * off. Inputs of motion always refer to the sensor itself */
  uint32_t n_targets;       /* set by the host: number of the sensor's targets, if the kind declares TATU_IN_TARGETS; else
                             * 0. `beams` is called again when it changes */
  uint32_t reserved4;
} tatu_beams;

/* Sets `n` rays along unit vectors, 3 numbers each, with the range `far_m`, m, and any incidence. The instance keeps
 * ownership of `directions`. */
TATU_INLINE void tatu_rays(tatu_beams *beams, uint32_t n, const double *directions, double far_m) {
  beams->form = TATU_BEAMS_RAYS;
  beams->count[0] = n;
  beams->directions = directions;
  beams->far_m = far_m;
  beams->max_incidence = 1.5707963267948966;
}

/* ---------------------------------------------------------------- Inputs ---------------------------------------- */

/* Inputs of `measure`. */
enum tatu_input {
  TATU_IN_DISTANCE = 1, /* per beam: m, from the origin; infinity: no hit */
  TATU_IN_POINT = 2,    /* per beam: 3 doubles, sensor frame */
  TATU_IN_NORMAL = 4,   /* per beam: 3 doubles, unit, sensor frame, towards the sensor */
  TATU_IN_OBJECT = 8,   /* per beam: the object hit, 0: none */
  TATU_IN_POSE = 16,    /* per sensor: pose in the world */
  TATU_IN_TWIST = 32,   /* per sensor: twist of its mount, world frame */
  TATU_IN_COLOR = 64,   /* 3 bytes red green blue; per pixel: shaded; per beam: colour of the surface, unshaded */
  TATU_IN_COSINE = 128, /* per pixel: cosine of the angle between line of sight and normal */
  TATU_IN_PRIMITIVE = 256, /* per beam: index of the triangle or face of the object that was hit */
  TATU_IN_HIT_TWIST = 8192, /* per beam: velocity of the object that was hit; absent in hosts before ABI 0.7 */
  TATU_IN_TARGETS = 16384, /* per target: the objects that the scene lists as `targets` of the device, their poses and
                            * twists; absent in hosts before ABI 0.8. Also of actuators. For a sensor, `targets` then no
                            * longer selects the objects that its beams detect */
  /* The following inputs are available only to kinds with TATU_SENSOR_EVERY_PHYSICS_STEP. */
  TATU_IN_ACCELERATION = 512, /* per sensor: acceleration of its origin, world frame, without gravity */
  TATU_IN_JOINT = 1024,       /* per sensor: state of a joint */
  TATU_IN_CONTACTS = 2048,    /* per sensor: contacts of a shape, with their forces. Also of actuators */
  TATU_IN_WRENCH = 4096       /* per sensor: load of a force sensor */
};

/* ---------------------------------------------------------------- Fields ---------------------------------------- */

/* Values for `dims` of a field: the number of rows and the number of columns of the instance's image. */
#define TATU_DIM_ROWS 4294967295u
#define TATU_DIM_COLUMNS 4294967294u
/* TATU_DIM_OWN + k, for k from 0 to 3, stands for tatu_beams.own[k]; if that is 0, the instance's field is empty. */
#define TATU_DIM_OWN 4294967280u
/* The number of the sensor's targets; for kinds that declare TATU_IN_TARGETS. */
#define TATU_DIM_TARGETS 4294967293u

/* One field that a sensor kind fills, named "<schema>.<field>". */
typedef struct tatu_field {
  uint32_t size;
  uint32_t elem;       /* TATU_ELEM_* */
  uint32_t dims[3];    /* 0: the instance's number of beams or pixels; TATU_DIM_*; unused ones are 1 */
  uint32_t flags;      /* 0 */
  const char *name;    /* "proximity.distance" */
  const char *unit;
  const char *text;
  const char *valid;   /* field of this kind that is 0 where this one contains no measurement; null: as in the schema */
  const char *nothing; /* values that stand for "no measurement" ("0", "0 0 0", "inf"), to which no noise is added; null: as in the schema */
} tatu_field;

#ifndef __cplusplus
/* Declares a field of one number: element type, name, unit (NULL: none), text, and further fields by name:
 *   TATU_FIELD(TATU_ELEM_F64, "lamp.level", "1", "Reflected light, 0 to 1.", .valid = "lamp.seen", .nothing = "0") */
#  define TATU_FIELD(Elem, Name, Unit, ...) TATU_FIELD_ARRAY(Elem, 1, Name, Unit, __VA_ARGS__)
/* Declares a field of `N` numbers; 0: one number for each beam or pixel. */
#  define TATU_FIELD_ARRAY(Elem, N, Name, Unit, ...) \
    TATU_TABLE(tatu_field, .elem = (Elem), .dims = {(N), 1, 1}, .name = (Name), .unit = (Unit), .text = __VA_ARGS__)
/* A list of fields. */
#  define TATU_FIELDS(...) TATU_LIST_OF(tatu_field, __VA_ARGS__)
#endif

/* ---------------------------------------------------------------- Measuring ------------------------------------- */

/* Random numbers for `measure`, for effects that declared noise cannot express. A number depends only on the scene's
 * seed, the sensor, the number of its measurements so far, and the index of the number (from `first`), not on other
 * sensors or the order of calls. Any thread may call these functions during the call that received the table. */
typedef struct tatu_random {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  /* Writes `n` uniformly distributed numbers in [0, 1) for instance `i` of the batch. */
  void(TATU_CALL *uniform)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
  /* Writes `n` normally distributed numbers, mean 0, standard deviation 1, for instance `i` of the batch. */
  void(TATU_CALL *normal)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
} tatu_random;

/* The `n` sensors of one kind that are due. The arrays of an input are null unless the kind declares that input. */
typedef struct tatu_sensor_batch {
  uint32_t size;
  uint32_t n;
  uint32_t n_fields;
  uint32_t reserved;
  double time;                    /* simulation time, s; with TATU_SENSOR_EVERY_PHYSICS_STEP: the middle of that step */
  uint64_t step;                  /* index of the step, from 0 */
  void *const *data;              /* [n] instances */
  void *const *state;             /* [n] state blocks */
  const tatu_object *sensor;      /* [n] */
  const uint64_t *first_beam;     /* [n + 1] index of each sensor's first beam in the arrays below */
  const double *distance;         /* per beam */
  const double *point;            /* per beam, 3 */
  const double *normal;           /* per beam, 3 */
  const tatu_object *object;      /* per beam */
  const double *pose;             /* [n], 7 each */
  const double *twist;            /* [n], 6 each: mean over the last step, from the difference of the poses; with
                                   * TATU_SENSOR_EVERY_PHYSICS_STEP: the engine's velocity */
  void *const *fields;            /* [n * n_fields] output buffers; host-owned, zeroed */
  tatu_status *status;            /* [n] preset to TATU_OK; negative: the instance failed; it is switched off and reported */
  const uint8_t *color;           /* per beam, 3: red green blue of the surface, unshaded; 0 0 0: no hit */
  const uint32_t *primitive;      /* per beam */
  const uint64_t *first_pixel;    /* [n + 1] index of each sensor's first pixel in the arrays below; null: no images */
  const float *depth;             /* per pixel: m along the sensor's +z; infinity: no hit. TATU_IN_DISTANCE */
  const uint8_t *pixel_color;     /* per pixel, 3; no hit: the colour of the sky. TATU_IN_COLOR */
  const float *pixel_cosine;      /* per pixel, 0 to 1; 0: no hit. TATU_IN_COSINE */
  const tatu_object *pixel_object; /* per pixel; 0: no hit. TATU_IN_OBJECT */
  const tatu_random *random;
  double *const *rays;            /* [n] with TATU_BEAMS_AIMED: 6 per ray, origin (m) and unit direction; else null */
  const uint64_t *const *lengths; /* [n], n_fields each: number of elements of each field */
  double dt;                      /* duration of the last step, s; with TATU_SENSOR_EVERY_PHYSICS_STEP: of the physics step */
  double gravity[3];              /* m/s^2, world frame */
  const double *acceleration;     /* [n], 6 each: m/s^2 and rad/s^2, mean over the step; 0 if no dynamic shape
                                   * carries the sensor. TATU_IN_ACCELERATION */
  const double *joint;            /* [n], 3 each: position (rad or m), velocity and effort (N m or N) at the end of the
                                   * step; 0 without a joint. TATU_IN_JOINT */
  const uint64_t *first_contact;  /* [n + 1] index of each sensor's first contact in the arrays below */
  const tatu_contact *contact;    /* shape[1] is the observed shape, so the force acts on it along `normal`.
                                   * TATU_IN_CONTACTS */
  const double *friction;         /* per contact, 3: friction on the observed shape, N, world frame */
  const double *wrench;           /* [n], 6 each: force (N), and torque (N m) about the sensor's origin, that the force
                                   * sensor exerts on its carrier, sensor frame, mean over the step; 0 without one.
                                   * TATU_IN_WRENCH */
  const double *hit_twist;        /* per beam, 6: velocity of the object that was hit, as bodies.twist gives it; 0: no
                                   * hit. TATU_IN_HIT_TWIST */
  const uint64_t *first_target;   /* [n + 1] index of each sensor's first target in the arrays below. The targets of a
                                   * sensor are in the order of the scene's list. TATU_IN_TARGETS, as all of these */
  const tatu_object *target;      /* per target; 0: there is no object at that path, for instance because it has been
                                   * removed; its pose and twist are then NaN */
  const double *target_pose;      /* per target, 7: pose in the world, at the time of the measurement */
  const double *target_twist;     /* per target, 6: as bodies.twist gives it; with TATU_SENSOR_EVERY_PHYSICS_STEP: the
                                   * engine's velocity */
} tatu_sensor_batch;

/* For `measure`: returns a pointer to the first element of field `k` of sensor `i`; fields are numbered from 0 in the
 * order of declaration. */
TATU_INLINE void *tatu_field_of(const tatu_sensor_batch *batch, uint32_t i, uint32_t k) {
  return batch->fields[(size_t)i * batch->n_fields + k];
}
/* Returns the distances along the beams of sensor `i`, m, infinity where nothing was hit, and their number in `*n`. */
TATU_INLINE const double *tatu_distances_of(const tatu_sensor_batch *batch, uint32_t i, uint64_t *n) {
  *n = batch->first_beam[i + 1] - batch->first_beam[i];
  return batch->distance + batch->first_beam[i];
}

/* ---------------------------------------------------------------- A kind of sensor ------------------------------ */

/* Named settings for a sensor, including noise, as the lines of TOML that a scene file would contain ("range_m = 5.6").
 * A scene selects them with `preset = "<id>"`; keys that the scene sets itself take precedence. */
typedef struct tatu_preset {
  uint32_t size;
  uint32_t reserved;
  const char *id;       /* "hokuyo_urg_04lx" */
  const char *text;     /* one sentence, with the source of the numbers */
  const char *settings;
} tatu_preset;

enum tatu_sensor_flag {
  /* Sensors of motion, force and contact: `measure` is called after each physics step in which the sensor is due, and
   * its reading is retained until the next call. Inputs, `time` and `step` refer to the physics step; pose, twist and
   * time to its middle. No beams are cast and no image is rendered. A request to measure such a sensor leaves its last
   * reading unchanged. */
  TATU_SENSOR_EVERY_PHYSICS_STEP = 1
};

/* A kind of sensor. */
typedef struct tatu_sensor {
  uint32_t size;
  uint32_t inputs;                   /* TATU_IN_* */
  const char *id;                    /* "proximity": the kind's name in scene files */
  const char *text;
  const char *const *schemas;        /* schemas that the fields fill, by which readers find sensors: "proximity/1" */
  const tatu_param *const *params;
  const tatu_field *const *fields;
  const tatu_life *life;
  /* [setup] Describes the beams of an instance, after its creation and after each change of its parameters. Null: the
   * kind has no beams. */
  tatu_status(TATU_CALL *beams)(void *data, tatu_beams *, tatu_error *);
  /* [parallel] Converts inputs to readings. May access only the data, state and fields of its instances, and call only
   * the log and the batch's `random`. If it returns a negative status, all instances of the batch are switched off. The
   * host then adds the noise that the scene declares, except to values that stand for "no measurement" (see `nothing`
   * and `valid`). */
  tatu_status(TATU_CALL *measure)(void *self, const tatu_sensor_batch *, tatu_error *);
  const tatu_preset *const *presets; /* may be null */
  /* [parallel] Recomputes derived fields, with the same batch, after declared noise has been added: for instance,
   * latitude and longitude from a position. It overwrites these fields, so noise must be declared for the field from
   * which they are derived. Not called if no sensor of the batch has noise, so `measure` must also fill derived fields.
   * The same access rules and status values as for `measure` apply. Null: no derived fields. */
  tatu_status(TATU_CALL *finish)(void *self, const tatu_sensor_batch *, tatu_error *);
  /* [parallel] Called before the cast for instances with TATU_BEAMS_AIMED. May change `rays`, the origins and unit
   * directions in the sensor's frame, which are preset to the sensor's origin and the directions from `beams`; for
   * devices that move while they scan, and for rays that jitter. Hits and fields are not available yet; otherwise as
   * `measure`. */
  tatu_status(TATU_CALL *aim)(void *self, const tatu_sensor_batch *, tatu_error *);
  uint32_t flags; /* enum tatu_sensor_flag */
  uint32_t reserved;
} tatu_sensor;

typedef struct tatu_ext_sensor {
  uint32_t size;
  uint32_t reserved;
  const tatu_sensor *const *kinds;
} tatu_ext_sensor;

#ifndef __cplusplus
/* Kinds of sensors of a plugin, for TATU_PLUGIN: pointers to tatu_sensor. */
#  define TATU_SENSORS(...) TATU_OFFER(TATU_SENSOR, tatu_ext_sensor, .kinds = TATU_LIST_OF(tatu_sensor, __VA_ARGS__))
#endif

#ifdef __cplusplus
}
#endif
#endif
