// my_plugin: a robot model in C++. A body on two driven wheels and a caster ball; it stands on z = 0 and heads along +x.
// Parameter: wheel_radius, 0.06 to 0.2 m. The axle is below the centre of the body, so `tatu.drive` moves this centre.
//
// Build: tatu plugin build      Run the demo: tatu plugin run      The manual: sdk/include/tatu.h, tatu/plugin.hpp
#include "tatu/plugin.hpp"

namespace {

const double TRACK = 0.36; // m, between the centres of the wheels

struct cart {
  static void build(tatu::builder &to, const tatu_value *params) {
    double r = params[0].u.f, ball = r / 2;

    // The body: its origin is on the axle. The centre of mass is slightly behind it, so that the caster carries some
    // weight.
    uint32_t base = to.object("shape", 0, "my_plugin");
    to.set(base, "primitive", "box");
    to.set3(base, "size", 0.4, 0.3, 0.1);
    to.set3(base, "position", 0, 0, r);
    to.set3(base, "color", 0.9, 0.6, 0.1);
    to.set3(base, "com", -0.05, 0, -0.02);
    to.set(base, "model_base", true);
    solid(to, base, 6);

    wheel(to, base, r, TRACK / 2, "left_motor", "left_wheel");
    wheel(to, base, r, -TRACK / 2, "right_motor", "right_wheel");

    // The caster: a ball that rotates freely in all directions.
    uint32_t socket = to.object("joint", base, "caster_socket");
    to.set(socket, "type", "spherical");
    to.set3(socket, "position", -0.15, 0, ball - r);
    uint32_t caster = to.object("shape", socket, "caster");
    to.set(caster, "primitive", "sphere");
    to.set3(caster, "size", 2 * ball, 2 * ball, 2 * ball);
    solid(to, caster, 0.2);

    // The kinematics of the drive, for commands such as `tatu.drive`: the keys of `drive` in a scene, without units.
    const tatu_value joints[] = {tatu_string(":/left_motor"), tatu_string(":/right_motor")};
    const tatu_pair drive[] = {tatu_entry("type", tatu_string("differential")),
                               tatu_entry("joints", tatu_list_of(joints, 2)), tatu_entry("radius", tatu_float(r)),
                               tatu_entry("track", tatu_float(TRACK))};
    to.set(base, "drive", tatu_map_of(drive, 4));
  }

private:
  // Sets the properties that all dynamic shapes have in common. With this mask, parts of the robot do not collide with
  // each other (low byte 0), but with everything else (high byte).
  static void solid(tatu::builder &to, uint32_t shape, double mass) {
    to.set(shape, "mass", mass);
    to.set(shape, "dynamic", true);
    to.set(shape, "respondable", true);
    to.set(shape, "respondable_mask", 0xFF00);
  }

  // Adds a motor and its wheel. A joint rotates about its z axis, which is rotated by -90 degrees about x to point along
  // +y, so that a positive velocity drives forward. The wheel collides as a sphere, which has a single point of contact.
  static void wheel(tatu::builder &to, uint32_t base, double radius, double y, const char *motor, const char *tyre) {
    const double quarter = 1.5707963267948966;
    uint32_t joint = to.object("joint", base, motor);
    to.set3(joint, "position", 0, y, 0);
    to.set3(joint, "orientation", -quarter, 0, 0);
    to.set(joint, "control", "velocity");
    to.set(joint, "max_force", 5.0);
    uint32_t shape = to.object("shape", joint, tyre);
    to.set(shape, "primitive", "cylinder");
    to.set3(shape, "size", 2 * radius, 2 * radius, 0.04);
    to.set(shape, "collide_as", "sphere");
    to.set3(shape, "collide_size", 2 * radius, 2 * radius, 2 * radius);
    to.set3(shape, "color", 0.1, 0.1, 0.1);
    solid(to, shape, 0.5);
  }
};

// The plugin, with what it offers and requires.
struct this_plugin : tatu::plugin {
  static constexpr const tatu_need *needs[] = {nullptr};

  explicit this_plugin(const tatu_host *h) : plugin(h) {
    offer(tatu::model<cart>("my_plugin", "A body on two driven wheels and a caster ball.")
            .category("mobile robots")
            .takes(tatu::param(TATU_F64, "wheel_radius", "m", "Radius of the driven wheels.").range(0.06, 0.2).fallback(0.1)));
  }
};

} // namespace

TATU_CPP_PLUGIN(this_plugin, "org.example.my_plugin", "my_plugin", "0.1.0", "MIT");
