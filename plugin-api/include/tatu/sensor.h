/* tatu/sensor.h: sensors, which convert beams, poses and other inputs to readings. */
#ifndef TATU_SENSOR_H
#define TATU_SENSOR_H

#include "core.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TATU_SENSOR "tatu.sensor/draft.4"

/* ---------------------------------------------------------------- Beams ----------------------------------------- */

/* Form of the beams, which start at the sensor's origin and point along its +z. */
enum tatu_beam_form {
  TATU_BEAMS_NONE = 0,
  TATU_BEAMS_RAYS = 1,     /* `count[0]` rays along `directions` */
  TATU_BEAMS_GRID = 2,     /* pinhole image: count = {columns, rows}; dims = {horizontal angle}; square pixels */
  TATU_BEAMS_CONE = 3,     /* volume with a round far end: dims = {half angle}; 0 to pi */
  TATU_BEAMS_PYRAMID = 4,  /* volume with flat ends at heights near_m and far_m (finite) along +z:
                              dims = {x near, y near, x far, y far}, their full sizes in m */
  TATU_BEAMS_CYLINDER = 5, /* the same with round ends: dims = {radius near, radius far} in m */
  TATU_BEAMS_DISC = 6,     /* volume, a flat sector around +z in the plane of x and z, with round ends: dims = {full
                              angle, up to 2 pi; height in m, centred on y = 0; full angle of a gap around +z,
                              0: none} */
  TATU_BEAMS_PARALLEL = 7  /* image of parallel rays: count = {columns, rows}; dims = {width m}; square pixels */
};
enum tatu_beam_flag {
  TATU_BEAMS_NO_FRONT = 1,  /* front faces are not detected */
  TATU_BEAMS_NO_BACK = 2,   /* back faces are not detected */
  TATU_BEAMS_SKIP_MODEL = 4, /* objects of the sensor's own model are not detected */
  TATU_BEAMS_VISIBLE = 8,   /* detects visible objects, as a camera does; otherwise detectable ones */
  TATU_BEAMS_OCCLUDE = 16,  /* the nearest point in a volume counts only if no surface, front or back, at any incidence,
                             * lies between it and the sensor; otherwise nothing is detected */
  TATU_BEAMS_AIMED = 32     /* rays whose origins and directions `tatu_sensor.aim` sets before each cast */
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

/* The beams that a sensor sends out. Filled by the plugin; `size` is set by the host. The optical axis of an image
 * (GRID, PARALLEL) is +z, with +y up and +x to the left; near_m and far_m are planes normal to it. Its pixels are
 * ordered by rows, from the bottom up, and from left to right within a row. */
typedef struct tatu_beams {
  uint32_t size;
  uint32_t form;            /* enum tatu_beam_form */
  uint32_t count[2];
  double near_m;            /* minimum range; of a pyramid and a cylinder: the height of the near end */
  double far_m;             /* maximum range; likewise */
  double dims[6];
  double max_incidence;     /* rad between line of sight and surface normal; pi/2: no limit */
  const double *directions; /* 3 per ray, unit vectors, sensor frame; owned by the instance, valid until the next `beams` */
  uint32_t flags;
  uint32_t reserved;
  uint32_t waves;           /* sum of TATU_WAVES_*; preset to TATU_WAVES_ALL; ignored for images */
  uint32_t reserved2;
  uint32_t own[4];          /* dimensions of the instance's own, to which TATU_DIM_OWN refers in the shape of a field */
  uint32_t without;         /* TATU_IN_*: inputs of the kind that this instance does not need; they are 0 in its pixels */
  uint32_t reserved3;
  const double *origins;    /* 3 per ray, m, sensor frame; null: all rays start at the sensor's origin. Owned as `directions` */
  tatu_object observed;     /* shape, joint or force sensor that TATU_IN_JOINT, _CONTACTS and _WRENCH are of; 0: the nearest
                             * of each kind at or above the sensor. If it is removed, the sensor is switched off. Motion is
                             * always the sensor's own */
} tatu_beams;

/* Sets rays along unit vectors, 3 numbers each, which the instance continues to own; up to `far_m`, m, at any
 * incidence. */
static inline void tatu_rays(tatu_beams *beams, uint32_t n, const double *directions, double far_m) {
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
  TATU_IN_COLOR = 64,   /* 3 bytes red green blue. Per pixel: shaded; per beam: of the surface, unshaded */
  TATU_IN_COSINE = 128, /* per pixel: cosine of the angle between line of sight and normal */
  TATU_IN_PRIMITIVE = 256, /* per beam: index of the triangle or face of the object */
  /* The following are for kinds with TATU_SENSOR_EVERY_PHYSICS_STEP. */
  TATU_IN_ACCELERATION = 512, /* per sensor: acceleration of its origin, world frame, without gravity */
  TATU_IN_JOINT = 1024,       /* per sensor: state of a joint */
  TATU_IN_CONTACTS = 2048,    /* per sensor: contacts of a shape, with their forces */
  TATU_IN_WRENCH = 4096       /* per sensor: load of a force sensor */
};

/* ---------------------------------------------------------------- Fields ---------------------------------------- */

/* In `dims` of a field: number of rows and of columns of the instance's image. */
#define TATU_DIM_ROWS 4294967295u
#define TATU_DIM_COLUMNS 4294967294u
/* Plus 0 to 3: index into tatu_beams.own; if the value there is 0, the field is empty for this instance. */
#define TATU_DIM_OWN 4294967280u

/* One field that a sensor kind fills, named "<schema>.<field>". */
typedef struct tatu_field {
  uint32_t size;
  uint32_t elem;       /* TATU_ELEM_* */
  uint32_t dims[3];    /* 0: the instance's number of beams or pixels; TATU_DIM_*; unused ones are 1 */
  uint32_t flags;      /* 0 */
  const char *name;    /* "proximity.distance" */
  const char *unit;
  const char *text;
  const char *valid;   /* the field of this kind that is 0 where this one holds no measurement; null: as in the schema */
  const char *nothing; /* numbers that stand for no measurement ("0", "0 0 0", "inf"), to which no noise is added; null: as in the schema */
} tatu_field;

#ifndef __cplusplus
/* A field of one number: element type, name, unit (NULL: none), text, and further fields by name:
 *   TATU_FIELD(TATU_ELEM_F64, "lamp.level", "1", "How much light comes back.", .valid = "lamp.seen", .nothing = "0") */
#  define TATU_FIELD(Elem, Name, Unit, ...) TATU_FIELD_ARRAY(Elem, 1, Name, Unit, __VA_ARGS__)
/* A field of `N` numbers; 0: one for each beam or pixel. */
#  define TATU_FIELD_ARRAY(Elem, N, Name, Unit, ...) \
    TATU_TABLE(tatu_field, .elem = (Elem), .dims = {(N), 1, 1}, .name = (Name), .unit = (Unit), .text = __VA_ARGS__)
/* A list of fields. */
#  define TATU_FIELDS(...) TATU_LIST_OF(tatu_field, __VA_ARGS__)
#endif

/* ---------------------------------------------------------------- Measuring ------------------------------------- */

/* Random numbers for `measure`, for effects that declared noise cannot express. A number depends only on the scene's
 * seed, the sensor, how often it has been measured, and the number's index (`first` and up), not on other sensors or
 * the order of calls. Callable from any thread during the call that received it. */
typedef struct tatu_random {
  uint32_t size;
  uint32_t reserved;
  void *ctx;
  /* `n` uniform numbers in [0, 1) for instance `i` of the batch. */
  void(TATU_CALL *uniform)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
  /* `n` normally distributed numbers: mean 0, standard deviation 1. */
  void(TATU_CALL *normal)(const struct tatu_random *, uint32_t i, uint64_t first, uint64_t n, double *out);
} tatu_random;

/* The `n` sensors of one kind that are due. Arrays are null unless the kind declares the input. */
typedef struct tatu_sensor_batch {
  uint32_t size;
  uint32_t n;
  uint32_t n_fields;
  uint32_t reserved;
  double time;                    /* simulation time, s; with TATU_SENSOR_EVERY_PHYSICS_STEP: the middle of that step */
  uint64_t step;                  /* number of the step, from 0 */
  void *const *data;              /* [n] instances */
  void *const *state;             /* [n] state blocks */
  const tatu_object *sensor;      /* [n] */
  const uint64_t *first_beam;     /* [n + 1] index of each sensor's first beam in the arrays below */
  const double *distance;         /* per beam */
  const double *point;            /* per beam, 3 */
  const double *normal;           /* per beam, 3 */
  const tatu_object *object;      /* per beam */
  const double *pose;             /* [n], 7 each */
  const double *twist;            /* [n], 6 each: mean motion over the last step, from the difference of its poses; of a
                                   * physics step: the engine's velocity */
  void *const *fields;            /* [n * n_fields] output buffers; host-owned, zeroed */
  tatu_status *status;            /* [n] TATU_OK; negative: that instance failed; it is switched off, the fault reported */
  const uint8_t *color;           /* per beam, 3: red green blue of the surface, unshaded; 0 0 0: no hit */
  const uint32_t *primitive;      /* per beam */
  const uint64_t *first_pixel;    /* [n + 1] index of each sensor's first pixel in the arrays below; null: no images */
  const float *depth;             /* per pixel: m along the sensor's +z; infinity: no hit. TATU_IN_DISTANCE */
  const uint8_t *pixel_color;     /* per pixel, 3; no hit: the colour of the sky. TATU_IN_COLOR */
  const float *pixel_cosine;      /* per pixel, 0 to 1; 0: no hit. TATU_IN_COSINE */
  const tatu_object *pixel_object; /* per pixel; 0: no hit. TATU_IN_OBJECT */
  const tatu_random *random;
  double *const *rays;            /* [n] with TATU_BEAMS_AIMED: 6 per ray, origin (m) and unit direction; else null */
  const uint64_t *const *lengths; /* [n] the number of elements of each field, n_fields each */
  double dt;                      /* duration of the last step, s: of physics with the flag below, else of the world */
  double gravity[3];              /* m/s^2, world frame */
  const double *acceleration;     /* [n], 6 each: m/s^2 and rad/s^2, mean over the step; 0 if no dynamic shape
                                   * carries the sensor. TATU_IN_ACCELERATION */
  const double *joint;            /* [n], 3 each: position (rad or m), velocity and effort (N m or N) at the end of the
                                   * step; 0 without a joint. TATU_IN_JOINT */
  const uint64_t *first_contact;  /* [n + 1] index of each sensor's first contact in the arrays below */
  const tatu_contact *contact;    /* shape[1] is the shape that is observed, so force and normal act on it.
                                   * TATU_IN_CONTACTS */
  const double *friction;         /* per contact, 3: friction on the observed shape, N, world frame */
  const double *wrench;           /* [n], 6 each: force (N), and torque (N m) about the sensor's origin, that the force
                                   * sensor exerts on its carrier, sensor frame, mean over the step; 0 without one.
                                   * TATU_IN_WRENCH */
} tatu_sensor_batch;

/* In `measure`: a pointer to the first element of field `k`, from 0 in the order of declaration, of sensor `i`. */
static inline void *tatu_field_of(const tatu_sensor_batch *batch, uint32_t i, uint32_t k) {
  return batch->fields[(size_t)i * batch->n_fields + k];
}
/* The distances along the beams of sensor `i`, m, infinity if nothing was hit, and the number of beams. */
static inline const double *tatu_distances_of(const tatu_sensor_batch *batch, uint32_t i, uint64_t *n) {
  *n = batch->first_beam[i + 1] - batch->first_beam[i];
  return batch->distance + batch->first_beam[i];
}

/* ---------------------------------------------------------------- A kind of sensor ------------------------------ */

/* Named settings: the keys that a scene would write for a sensor, as lines of TOML ("range_m = 5.6"), noise included.
 * A scene selects them with `preset = "<id>"`; its own keys override them. */
typedef struct tatu_preset {
  uint32_t size;
  uint32_t reserved;
  const char *id;       /* "hokuyo_urg_04lx" */
  const char *text;     /* one sentence, with the source of the numbers */
  const char *settings;
} tatu_preset;

enum tatu_sensor_flag {
  /* Sensors of motion, force and contact: `measure` is called after each physics step in which the sensor is due, and
   * its reading is retained until the next. Inputs, `time` and `step` are those of the physics step: pose, twist and
   * time are those of its middle. No beams are cast and no image is rendered. A request to measure such a sensor leaves
   * its last reading unchanged. */
  TATU_SENSOR_EVERY_PHYSICS_STEP = 1
};

/* A kind of sensor. */
typedef struct tatu_sensor {
  uint32_t size;
  uint32_t inputs;                   /* TATU_IN_* */
  const char *id;                    /* "proximity": what scenes write */
  const char *text;
  const char *const *schemas;        /* "proximity/1": what readers search for */
  const tatu_param *const *params;
  const tatu_field *const *fields;
  const tatu_life *life;
  /* [setup] Gets the beams of an instance, at creation and after its parameters change. Null: none. */
  tatu_status(TATU_CALL *beams)(void *data, tatu_beams *, tatu_error *);
  /* [parallel] Turns inputs into readings. May access only data, state and fields of its instances, and call only the
   * log and the batch's `random`. A negative status switches off all instances of the batch. The host then adds the
   * noise that the scene declares, except to values that stand for no measurement (see `nothing`, `valid`). */
  tatu_status(TATU_CALL *measure)(void *self, const tatu_sensor_batch *, tatu_error *);
  const tatu_preset *const *presets; /* may be null */
  /* [parallel] Recomputes derived fields, with the same batch, after declared noise was added: latitude and longitude
   * from a position, for instance. It overwrites them, so noise is declared for the field that they derive from. Not
   * called if no sensor of the batch has noise, so `measure` must fill derived fields too. Access and status as for
   * `measure`. Null: no derived fields. */
  tatu_status(TATU_CALL *finish)(void *self, const tatu_sensor_batch *, tatu_error *);
  /* [parallel] Before the cast, if an instance's rays are TATU_BEAMS_AIMED: may change `rays`, origins and unit
   * directions in the sensor's frame, preset to the sensor's origin and the directions from `beams`; for devices that
   * move while they scan, and rays that jitter. Hits and fields are not available yet; otherwise as `measure`. */
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
