"""Writes the arena of `peers/scenes.py` as a Tatu scene.

    python arena.py --robots 100 --out DIR      writes arena.toml, robot.toml and robot.lua into DIR
"""
import argparse
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "peers"))

import scenes  # noqa: E402


def numbers(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def quaternion(turn):
    """Returns the quaternion x y z w of a rotation matrix given by rows. The angle must be less than 180 degrees."""
    m = turn
    w = math.sqrt(max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2
    return [(m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w), (m[1][0] - m[0][1]) / (4 * w), w]


def ray_frame(angle):
    """Returns the orientation whose z axis is horizontal in the direction `angle`, and whose x axis points up."""
    z = (math.cos(angle), math.sin(angle), 0.0)
    x = (0.0, 0.0, 1.0)
    y = (z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0])
    return quaternion([[x[i], y[i], z[i]] for i in range(3)])


def chassis():
    """Returns mass, centre of mass and inertia (by rows) of the chassis and the castor ball fixed to it."""
    rb = scenes.ROBOT
    h = rb["chassis_half"]
    m_box, m_ball, at = rb["chassis_mass"], rb["castor_mass"], rb["castor"]
    mass = m_box + m_ball
    com = [m_ball * x / mass for x in at]
    inertia = [[0.0] * 3 for _ in range(3)]
    own = [[m_box / 3 * (h[1] ** 2 + h[2] ** 2), m_box / 3 * (h[0] ** 2 + h[2] ** 2), m_box / 3 * (h[0] ** 2 + h[1] ** 2)],
           [0.4 * m_ball * rb["castor_radius"] ** 2] * 3]
    for m, place, about in ((m_box, [0.0] * 3, own[0]), (m_ball, at, own[1])):
        r = [p - c for p, c in zip(place, com)]
        square = sum(x * x for x in r)
        for i in range(3):
            inertia[i][i] += about[i] + m * square
            for j in range(3):
                inertia[i][j] -= m * r[i] * r[j]
    return mass, com, inertia


def robot():
    rb = scenes.ROBOT
    size = [2 * h for h in rb["chassis_half"]]
    out = ["# The robot of the arena: a box, two driven wheels, a castor and 16 range sensors.", "format = 1", ""]
    mass, com, inertia = chassis()
    d = 2 * rb["castor_radius"]
    out += ["[[object]]", 'kind = "shape"', 'alias = "robot"', 'primitive = "compound"', "parts = [",
            '  { primitive = "box", size_m = %s },' % numbers(size),
            '  { primitive = "sphere", size_m = %s, position_m = %s, friction = 0.0 },'
            % (numbers([d, d, d]), numbers(rb["castor"])), "]",
            "mass_kg = %r" % mass, "com_m = " + numbers(com), "inertia_kg_m2 = " + numbers(sum(inertia, [])),
            "position_m = [0.0, 0.0, %r]" % rb["chassis_z"], "dynamic = true", "respondable = true",
            "friction = %r" % rb["mu_chassis_any"], "model_base = true", ""]
    d = 2 * rb["wheel_radius"]
    for side in ("left", "right"):
        out += ["[[object]]", 'kind = "joint"', 'alias = "%s"' % side, 'parent = "robot"',
                "position_m = " + numbers(rb["wheel_" + side]), "orientation_deg = [-90.0, 0.0, 0.0]",
                'control = "velocity"', "max_force_nm = %r" % rb["motor_max_torque"], ""]
        out += ["[[object]]", 'kind = "shape"', 'alias = "%s_wheel"' % side, 'parent = "%s"' % side,
                'primitive = "cylinder"', "size_m = " + numbers([d, d, 2 * rb["wheel_half_width"]]),
                'collide_as = "sphere"', "collide_size_m = " + numbers([d] * 3), "mass_kg = %r" % rb["wheel_mass"],
                "dynamic = true", "respondable = true", "respondable_mask = 0xFF00",
                "friction = %r" % rb["mu_wheel_ground"], ""]
    for i, (angle, off) in enumerate(zip(scenes.SENSOR_ANGLES, scenes.SENSOR_OFFSETS)):
        at = [off * math.cos(angle), off * math.sin(angle), rb["sensor_z"]]
        out += ["[[object]]", 'kind = "sensor"', 'sensor = "proximity"', 'alias = "s%d"' % (i + 1),
                'parent = "robot"', "position_m = " + numbers(at), "quaternion = " + numbers(ray_frame(angle)),
                'volume = "ray"', "range_m = %r" % rb["sensor_range"], ""]
    return "\n".join(out)


def script():
    c = scenes.CONTROL
    return """-- In the style of courses of 2015: avoids obstacles by wheel = v0 + gain * sum of weight * nearness.
if sim_call_type == sim_childscriptcall_initialization then
    v0, gain, near, far = %r, %r, %r, %r
    left_weight = {%s}
    right_weight = {%s}
    sensor = {}
    for i = 1, 16 do sensor[i] = simGetObjectHandle('s' .. i) end
    left, right = simGetObjectHandle('left'), simGetObjectHandle('right')
end

if sim_call_type == sim_childscriptcall_actuation then
    local l, r = v0, v0
    for i = 1, 16 do
        local seen, d = simReadProximitySensor(sensor[i])
        if seen > 0 and d < far then
            local a = d > near and (far - d) / (far - near) or 1
            l = l + gain * left_weight[i] * a
            r = r + gain * right_weight[i] * a
        end
    end
    simSetJointTargetVelocity(left, l)
    simSetJointTargetVelocity(right, r)
end
""" % (c["v0"], c["gain"], c["near"], c["far"], ", ".join(map(repr, c["w_left"])), ", ".join(map(repr, c["w_right"])))


def box(alias, b):
    return ["[[object]]", 'kind = "shape"', 'alias = "%s"' % alias, "size_m = " + numbers([2 * b[3], 2 * b[4], 2 * b[5]]),
            "position_m = " + numbers(b[:3]), "orientation_deg = [0.0, 0.0, %r]" % math.degrees(b[6]),
            "respondable = true", "friction = 1.0", ""]


def arena(n, physics_dt):
    a = scenes.arena(n)
    out = ["format = 1", "", "[scene]", 'text = "The arena with %d robots"' % n, "dt_s = %r" % scenes.DT_CONTROL,
           "physics_dt_s = %r" % physics_dt, "", "[[object]]", 'kind = "shape"', 'alias = "floor"', 'primitive = "plane"',
           "respondable = true", "friction = 1.0", ""]
    for i, b in enumerate(a["boxes"]):
        out += box("box%d" % i, b)
    for i, b in enumerate(a["walls"]):
        out += box("wall%d" % i, b)
    for i, (x, y, yaw) in enumerate(a["robots"]):
        out += ["[[model]]", 'model = "robot.toml"', 'alias = "r%d"' % i, "position_m = " + numbers([x, y, 0.0]),
                "orientation_deg = [0.0, 0.0, %r]" % math.degrees(yaw), 'script = { file = "robot.lua", side_by_side = true }', ""]
    return "\n".join(out)


def write(folder, n, physics_dt=0.01):
    """Writes the scene, and returns its path."""
    os.makedirs(folder, exist_ok=True)
    for name, text in (("robot.toml", robot()), ("robot.lua", script()), ("arena.toml", arena(n, physics_dt))):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
    return os.path.join(folder, "arena.toml")


if __name__ == "__main__":
    ap = argparse.ArgumentParser()
    ap.add_argument("--robots", type=int, default=100)
    ap.add_argument("--physics-dt", type=float, default=0.01)
    ap.add_argument("--out", required=True)
    args = ap.parse_args()
    print(write(args.out, args.robots, args.physics_dt))
