"""Writes small scenes of boxes, balls and joints in the formats of Tatu and MuJoCo. Initially all frames are parallel
to that of the world. Lengths are in m, masses in kg, angles in rad."""

from dataclasses import dataclass, field
import math


@dataclass
class Body:
    name: str
    form: str  # box, sphere, cylinder
    size: tuple  # full extents
    mass: float
    at: tuple
    parent: str = ""  # the parent body, connected by the joint if there is one, otherwise rigidly
    joint: dict | None = None  # type (hinge, slide, ball, weld), axis (x, y, z), at, and its drive or spring
    inertia: tuple | None = None
    v: tuple = (0, 0, 0)
    w: tuple = (0, 0, 0)
    friction: float = 0.5
    restitution: float = 0.0
    collides: bool = True
    fixed: bool = False


@dataclass
class Scene:
    bodies: list = field(default_factory=list)
    gravity: tuple = (0, 0, -9.81)
    floor: bool = True

    def add(self, *args, **keys):
        self.bodies.append(Body(*args, **keys))
        return self.bodies[-1].name

    def of(self, name):
        return next(b for b in self.bodies if b.name == name)

    def path(self, name):
        body = self.of(name)
        if not body.parent:
            return f"/{name}"
        return f"{self.path(body.parent)}/{name}_joint/{name}"


# Frames whose z axis is the world's x, y, z.
FRAMES = {
    "x": (0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)),
    "y": (-math.sin(math.pi / 4), 0, 0, math.cos(math.pi / 4)),
    "z": (0, 0, 0, 1),
}
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def toml(scene, dt, substeps, solver):
    out = [f"format = 1\n[scene]\ngravity_m_s2 = {[float(x) for x in scene.gravity]}\n"
           f"dt_s = 0.05\nphysics_dt_s = {dt}\nphysics_substeps = {substeps}\njoint_solver = '{solver}'\n"]
    if scene.floor:
        out.append("[[object]]\nkind = 'shape'\nalias = 'floor'\nprimitive = 'plane'\nrespondable = true\n")
    for b in scene.bodies:
        parent = ""
        if b.parent:
            j, up = b.joint, scene.path(b.parent)
            kind = "force_sensor" if j["type"] == "weld" else "joint"
            pose = [float(x) for x in (*j["at"], *FRAMES[j.get("axis", "z")])]
            out.append(f"[[object]]\nkind = '{kind}'\nalias = '{b.name}_joint'\nparent = '{up}'\nworld_pose = {pose}\n")
            if kind == "joint":
                name = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical"}[j["type"]]
                out.append(f"type = '{name}'\n")
                turns = j["type"] == "hinge"
                if "hold" in j:
                    out.append(f"control = 'position'\nmax_force_{'nm' if turns else 'n'} = {float(j['limit'])}\n"
                               f"target_position_{'rad' if turns else 'm'} = {float(j['hold'])}\n")
                if "force" in j:
                    out.append(f"control = 'force'\nmax_force_{'nm' if turns else 'n'} = {float(j['force'])}\n")
                if "stiffness" in j:
                    out.append(f"stiffness_{'nm_rad' if turns else 'n_m'} = {float(j['stiffness'])}\n"
                               f"damping_{'nms_rad' if turns else 'ns_m'} = {float(j['damping'])}\n")
            parent = f"parent = '{up}/{b.name}_joint'\n"
        size = [float(x) for x in b.size]
        out.append(f"[[object]]\nkind = 'shape'\nalias = '{b.name}'\n{parent}primitive = '{b.form}'\nsize_m = {size}\n"
                   f"mass_kg = {float(b.mass)}\nworld_pose = {[float(x) for x in (*b.at, 0, 0, 0, 1)]}\n"
                   f"friction = {float(b.friction)}\nrestitution = {float(b.restitution)}\n"
                   f"respondable = {str(b.collides).lower()}\ndynamic = {str(not b.fixed).lower()}\n")
        if b.inertia:
            out.append(f"inertia_kg_m2 = {[float(x) for x in b.inertia]}\n")
        if any(b.v) or any(b.w):
            out.append(f"initial_velocity_m_s = {[float(x) for x in b.v]}\n"
                       f"initial_angular_velocity_rad_s = {[float(x) for x in b.w]}\n")
    return "".join(out)


TUNED = '<option timestep="{dt}" integrator="{integrator}" cone="elliptic" impratio="10" noslip_iterations="10" ' \
        'iterations="100" tolerance="1e-10" gravity="{g}"/>'
USUAL = '<option timestep="{dt}" gravity="{g}"/>'


def mjcf(scene, dt, tuned):
    g = " ".join(str(x) for x in scene.gravity)
    option = TUNED if tuned else USUAL
    falls = not scene.floor
    out = ['<mujoco>', option.format(dt=dt, g=g, integrator="RK4" if falls else "implicitfast"), '<worldbody>']
    if scene.floor:
        out.append('<geom type="plane" size="0 0 1" friction="1 0.005 0.0001"/>')
    actuators, children = [], {}
    for b in scene.bodies:
        children.setdefault(b.parent, []).append(b)

    def write(b, origin):
        place = " ".join(str(p - o) for p, o in zip(b.at, origin))
        out.append(f'<body name="{b.name}" pos="{place}">')
        j = b.joint
        if not b.parent and not b.fixed:
            out.append('<freejoint/>')
        elif j and j["type"] != "weld":
            where = " ".join(str(p - o) for p, o in zip(j["at"], b.at))
            axis = f'axis="{AXES[j["axis"]]}"' if "axis" in j and j["type"] != "ball" else ""
            spring = f'stiffness="{j["stiffness"]}" damping="{j["damping"]}"' if "stiffness" in j else ""
            out.append(f'<joint name="{b.name}_joint" type="{j["type"]}" pos="{where}" {axis} {spring}/>')
            if "hold" in j:
                kp = j["limit"] * 10
                actuators.append(f'<position joint="{b.name}_joint" kp="{kp}" dampratio="1" '
                                 f'forcerange="{-j["limit"]} {j["limit"]}"/>')
            if "force" in j:
                actuators.append(f'<motor joint="{b.name}_joint"/>')
        size = {"box": [x / 2 for x in b.size], "sphere": [b.size[0] / 2],
                "cylinder": [b.size[0] / 2, b.size[2] / 2]}[b.form]
        mass = f'mass="{b.mass}"' if not b.inertia else 'mass="0"'
        if b.inertia:
            out.append(f'<inertial pos="0 0 0" mass="{b.mass}" diaginertia="{" ".join(map(str, b.inertia))}"/>')
        # MuJoCo uses the greater friction of a pair. The floor has 1, so `priority` selects the friction of the body.
        contact = "" if b.collides else 'contype="0" conaffinity="0"'
        priority = 'priority="1"' if b.collides else ""
        out.append(f'<geom type="{b.form}" size="{" ".join(map(str, size))}" {mass} {contact} {priority} '
                   f'friction="{b.friction} 0.005 0.0001" condim="{3 if b.form == "box" else 4}"/>')
        for c in children.get(b.name, []):
            write(c, b.at)
        out.append('</body>')

    for b in children.get("", []):
        write(b, (0, 0, 0))
    out.append(f'</worldbody><actuator>{"".join(actuators)}</actuator></mujoco>')
    return "".join(out)
