// cart: a robot model with a body on two driven wheels and a caster ball. It stands on z = 0 and faces along +x.
// Parameter: wheel_radius, 0.06 to 0.2 m. The axle is below the middle of the body, the point that `tatu.drive` moves.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_cart.so cart.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 120 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 120 --threads 2
#include "tatu.h"

#include <string.h>

#define TRACK 0.36 // distance between the centres of the wheels, m

// A builder and the first error that it returned. After an error, further calls have no effect.
typedef struct {
  const tatu_builder *to;
  tatu_status status;
} pen;

static uint32_t object(pen *p, const char *kind, uint32_t parent, const char *alias) {
  uint32_t made = p->status < 0 ? 0 : p->to->object(p->to, kind, parent, tatu_text(alias));
  if (!made && p->status >= 0) p->status = TATU_ERR;
  return made;
}
static void set(pen *p, uint32_t object, const char *key, tatu_value value) {
  if (p->status >= 0) p->status = p->to->set(p->to, object, key, &value);
}
static void set3(pen *p, uint32_t object, const char *key, double x, double y, double z) {
  double numbers[3] = {x, y, z};
  set(p, object, key, tatu_span(TATU_F64S, numbers, 3));
}

// Sets the common properties of a dynamic shape. With this mask, parts of a cart do not collide with each other (low
// byte 0), but with everything else (high byte).
static void solid(pen *p, uint32_t shape, double mass) {
  set(p, shape, "mass", tatu_float(mass));
  set(p, shape, "dynamic", tatu_bool(1));
  set(p, shape, "respondable", tatu_bool(1));
  set(p, shape, "respondable_mask", tatu_int(0xFF00));
}

// Adds a motor and its wheel. A joint rotates about its z axis; a rotation by -90 degrees about x points that axis
// along +y, so a positive velocity drives forward. The wheel collides as a ball, which touches the floor in a single
// point.
static void wheel(pen *p, uint32_t base, double radius, double y, const char *motor, const char *tyre) {
  const double quarter = 1.5707963267948966;
  uint32_t joint = object(p, "joint", base, motor);
  set3(p, joint, "position", 0, y, 0);
  set3(p, joint, "orientation", -quarter, 0, 0);
  set(p, joint, "control", tatu_string("velocity"));
  set(p, joint, "max_force", tatu_float(5));
  uint32_t shape = object(p, "shape", joint, tyre);
  set(p, shape, "primitive", tatu_string("cylinder"));
  set3(p, shape, "size", 2 * radius, 2 * radius, 0.04);
  set(p, shape, "collide_as", tatu_string("sphere"));
  set3(p, shape, "collide_size", 2 * radius, 2 * radius, 2 * radius);
  set3(p, shape, "color", 0.1, 0.1, 0.1);
  solid(p, shape, 0.5);
}

static tatu_status TATU_CALL build(void *self, const tatu_builder *builder, const tatu_value *params, tatu_error *error) {
  (void)self;
  (void)error; // the builder has already reported the reason of a failure to the host
  pen p = {builder, TATU_OK};
  double r = params[0].u.f, ball = r / 2;

  // The body. Its origin is on the axle; its centre of mass is slightly behind the axle, towards the caster.
  uint32_t base = object(&p, "shape", 0, "cart");
  set(&p, base, "primitive", tatu_string("box"));
  set3(&p, base, "size", 0.4, 0.3, 0.1);
  set3(&p, base, "position", 0, 0, r);
  set3(&p, base, "color", 0.9, 0.6, 0.1);
  set3(&p, base, "com", -0.05, 0, -0.02);
  set(&p, base, "model_base", tatu_bool(1));
  solid(&p, base, 6);

  wheel(&p, base, r, TRACK / 2, "left_motor", "left_wheel");
  wheel(&p, base, r, -TRACK / 2, "right_motor", "right_wheel");

  // The caster: a ball that can rotate about all axes.
  uint32_t socket = object(&p, "joint", base, "caster_socket");
  set(&p, socket, "type", tatu_string("spherical"));
  set3(&p, socket, "position", -0.15, 0, ball - r);
  uint32_t caster = object(&p, "shape", socket, "caster");
  set(&p, caster, "primitive", tatu_string("sphere"));
  set3(&p, caster, "size", 2 * ball, 2 * ball, 2 * ball);
  solid(&p, caster, 0.2);

  // The parameters of the drive, for commands and services. The keys are those of `drive` in scene files, without the
  // suffix of the unit: `radius` for `radius_m`.
  tatu_value motors[2] = {tatu_string(":/left_motor"), tatu_string(":/right_motor")};
  tatu_pair drive[] = {
    {tatu_string("type"), tatu_string("differential")},
    {tatu_string("joints"), tatu_span(TATU_LIST, motors, 2)},
    {tatu_string("radius"), tatu_float(r)},
    {tatu_string("track"), tatu_float(TRACK)},
  };
  set(&p, base, "drive", tatu_span(TATU_MAP, drive, sizeof drive / sizeof *drive));
  return p.status;
}

static const tatu_param wheel_radius = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "wheel_radius", .unit = "m",
  .lowest = 0.06, .highest = 0.2, .fallback = {.tag = TATU_F64, .u.f = 0.1}, .text = "Radius of the driven wheels."};
static const tatu_param *const params[] = {&wheel_radius, NULL};
static const tatu_model model = {.size = sizeof(tatu_model), .id = "cart", .params = params, .build = build,
  .text = "A body on two driven wheels and a caster ball.", .category = "mobile robots"};
static const tatu_model *const models[] = {&model, NULL};
static const tatu_ext_model offer = {.size = sizeof(tatu_ext_model), .models = models};

static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_MODEL) == 0 ? &offer : NULL;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.outside.cart", .name = "Cart", .version = "1.0.0", .licence = "MIT",
  .extension = extension};
