// cart: a robot model with a body on two driven wheels and a caster ball. It stands on z = 0 and faces along +x.
// Parameter: wheel_radius, 0.06 to 0.2 m. The axle is below the middle of the body, the point that `tatu.drive` moves.
//
// Build: cc -std=c11 -Wall -Wextra -Werror -shared -fPIC -I ../../../plugin-api/include -o libtatu_cart.so cart.c
// Run:   TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 120 --threads 1
//        TATU_PLUGIN_PATH=. ../../../target/release/tatu run scene.toml --steps 120 --threads 2
#include "tatu/model.h"

#define TRACK 0.36 // distance between the centres of the wheels, m

// Sets the common properties of a dynamic shape. With this mask, parts of a cart do not collide with each other (low
// byte 0), but with everything else (high byte).
static void solid(tatu_build *p, uint32_t shape, double mass) {
  tatu_build_set(p, shape, "mass", tatu_float(mass));
  tatu_build_set(p, shape, "dynamic", tatu_bool(1));
  tatu_build_set(p, shape, "respondable", tatu_bool(1));
  tatu_build_set(p, shape, "respondable_mask", tatu_int(0xFF00));
}

// Adds a motor and its wheel. A joint rotates about its z axis; a rotation by -90 degrees about x points that axis
// along +y, so a positive velocity drives forward. The wheel collides as a ball, which touches the floor in a single
// point.
static void wheel(tatu_build *p, uint32_t base, double radius, double y, const char *motor, const char *tyre) {
  const double quarter = 1.5707963267948966;
  uint32_t joint = tatu_build_object(p, "joint", base, motor);
  tatu_build_set3(p, joint, "position", 0, y, 0);
  tatu_build_set3(p, joint, "orientation", -quarter, 0, 0);
  tatu_build_set(p, joint, "control", tatu_string("velocity"));
  tatu_build_set(p, joint, "max_force", tatu_float(5));
  uint32_t shape = tatu_build_object(p, "shape", joint, tyre);
  tatu_build_set(p, shape, "primitive", tatu_string("cylinder"));
  tatu_build_set3(p, shape, "size", 2 * radius, 2 * radius, 0.04);
  tatu_build_set(p, shape, "collide_as", tatu_string("sphere"));
  tatu_build_set3(p, shape, "collide_size", 2 * radius, 2 * radius, 2 * radius);
  tatu_build_set3(p, shape, "color", 0.1, 0.1, 0.1);
  solid(p, shape, 0.5);
}

static tatu_status TATU_CALL build(void *self, const tatu_builder *builder, const tatu_value *params, tatu_error *error) {
  (void)self;
  (void)error; // the builder has already reported the reason of a failure to the host
  tatu_build p = tatu_build_with(builder);
  double r = params[0].u.f, ball = r / 2;

  // The body. Its origin is on the axle; its centre of mass is slightly behind the axle, towards the caster.
  uint32_t base = tatu_build_object(&p, "shape", 0, "cart");
  tatu_build_set(&p, base, "primitive", tatu_string("box"));
  tatu_build_set3(&p, base, "size", 0.4, 0.3, 0.1);
  tatu_build_set3(&p, base, "position", 0, 0, r);
  tatu_build_set3(&p, base, "color", 0.9, 0.6, 0.1);
  tatu_build_set3(&p, base, "com", -0.05, 0, -0.02);
  tatu_build_set(&p, base, "model_base", tatu_bool(1));
  solid(&p, base, 6);

  wheel(&p, base, r, TRACK / 2, "left_motor", "left_wheel");
  wheel(&p, base, r, -TRACK / 2, "right_motor", "right_wheel");

  // The caster: a ball that can rotate about all axes.
  uint32_t socket = tatu_build_object(&p, "joint", base, "caster_socket");
  tatu_build_set(&p, socket, "type", tatu_string("spherical"));
  tatu_build_set3(&p, socket, "position", -0.15, 0, ball - r);
  uint32_t caster = tatu_build_object(&p, "shape", socket, "caster");
  tatu_build_set(&p, caster, "primitive", tatu_string("sphere"));
  tatu_build_set3(&p, caster, "size", 2 * ball, 2 * ball, 2 * ball);
  solid(&p, caster, 0.2);

  // The parameters of the drive, for commands and services. The keys are those of `drive` in scene files, without the
  // suffix of the unit: `radius` for `radius_m`.
  tatu_build_set(&p, base, "drive", tatu_map_of(TATU_ENTRIES(
    tatu_entry("type", tatu_string("differential")),
    tatu_entry("joints", tatu_list_of(TATU_VALUES(tatu_string(":/left_motor"), tatu_string(":/right_motor")))),
    tatu_entry("radius", tatu_float(r)),
    tatu_entry("track", tatu_float(TRACK)))));
  return p.status;
}

static const tatu_model cart = {
  .size = sizeof(tatu_model), .id = "cart", .text = "A body on two driven wheels and a caster ball.", .build = build,
  .category = "mobile robots", .params = TATU_PARAMS(TATU_PARAM(TATU_F64, "wheel_radius", "m",
    "Radius of the driven wheels.", TATU_RANGE(0.06, 0.2), TATU_DEFAULT_F64(0.1)))};

TATU_PLUGIN(TATU_MODELS(&cart), .id = "org.outside.cart", .name = "Cart", .version = "1.0.0", .licence = "MIT");
