"""The cases of the table: a scene, its duration, the observed bodies, and the error relative to a closed form."""

import math

import numpy as np

from scenes import Scene

G = 9.81


def stack(boxes, friction=0.5):
    s = Scene()
    for i, (size, mass, at) in enumerate(boxes):
        s.add(f"b{i}", "box", size, mass, at, friction=friction)
    names = [b.name for b in s.bodies]

    def shift(t):
        start = [s.of(n).at for n in names]
        return 1e3 * max(math.hypot(*(t.of(n, "at")[-1][:2] - np.array(a[:2]))) for n, a in zip(names, start))

    return s, 10, names, shift


def tower():
    return stack([((.1, .1, .1), 1, (0, 0, .05 + .1 * i)) for i in range(10)])


def wall(rows=10, columns=10):
    aside = lambda r: .05 if r % 2 else 0
    x = lambda r, c: (c - (columns - 1) / 2) * .2 + aside(r)
    return stack([((.2, .1, .1), 1, (x(r, c), 0, .05 + .1 * r)) for r in range(rows) for c in range(columns)])


def heavy():
    return stack([((.1, .1, .1), 1, (0, 0, .05)), ((.1, .1, .1), 1000, (0, 0, .15))])


def creep():
    a = math.radians(25)
    s = Scene(gravity=(G * math.sin(a), 0, -G * math.cos(a)))
    s.add("b", "box", (.2, .2, .1), 1, (0, 0, .05), friction=.5)
    return s, 10, ["b"], lambda t: 1e3 * abs(t.of("b", "at")[-1][0] - t.of("b", "at")[0][0])


def sliding():
    a = math.radians(30)
    s = Scene(gravity=(G * math.sin(a), 0, -G * math.cos(a)))
    s.add("b", "box", (.2, .2, .1), 1, (0, 0, .05), friction=.3)
    rate = G * (math.sin(a) - .3 * math.cos(a))

    def error(t):
        v = t.of("b", "v")[:, 0]
        return 100 * abs((v[-1] - v[9]) / (t.t[-1] - t.t[9]) / rate - 1)

    return s, 2, ["b"], error


def pendulum():
    s = Scene(floor=False)
    s.add("base", "box", (.05, .05, .05), 1, (0, 0, 0), fixed=True, collides=False)
    s.add("bob", "sphere", (.1, .1, .1), 1, (1, 0, 0), "base", {"type": "hinge", "axis": "y", "at": (0, 0, 0)},
          collides=False)
    inertia = .4 * .05 ** 2

    def error(t):
        v, w, z = t.of("bob", "v")[-40:], t.of("bob", "w")[-40:], t.of("bob", "at")[-40:, 2]
        e = .5 * (v ** 2).sum(1) + .5 * inertia * (w ** 2).sum(1) + G * (z + 1)
        return 100 * abs(e.mean() / G - 1)

    return s, 100, ["bob"], error


def double_pendulum():
    s = Scene(floor=False)
    s.add("base", "box", (.05, .05, .05), 1, (0, 0, 0), fixed=True, collides=False)
    s.add("a", "sphere", (.1, .1, .1), 1, (1, 0, 0), "base", {"type": "hinge", "axis": "y", "at": (0, 0, 0)},
          collides=False)
    s.add("b", "sphere", (.1, .1, .1), 1, (2, 0, 0), "a", {"type": "hinge", "axis": "y", "at": (1, 0, 0)},
          collides=False)

    def error(t):
        e = sum(.5 * (t.of(n, "v") ** 2).sum(1) + .5 * .001 * (t.of(n, "w") ** 2).sum(1) + G * t.of(n, "at")[:, 2]
                for n in "ab")
        return 100 * np.abs(e).max() / (3 * G)

    return s, 20, ["a", "b"], error


def tumbling():
    s = Scene(floor=False, gravity=(0, 0, 0))
    inertia, w = np.array((.01, .02, .03)), np.array((2., 1., 3.))
    s.add("b", "box", (.3, .2, .1), 1, (0, 0, 0), inertia=tuple(inertia), w=tuple(w), collides=False)

    def error(t):
        x, y, z, c = t.of("b", "q")[-1]
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * c), 2 * (x * z + y * c)],
                         [2 * (x * y + z * c), 1 - 2 * (x * x + z * z), 2 * (y * z - x * c)],
                         [2 * (x * z - y * c), 2 * (y * z + x * c), 1 - 2 * (x * x + y * y)]])
        now = turn.T @ t.of("b", "w")[-1]
        return 100 * abs((inertia * now ** 2).sum() / (inertia * w ** 2).sum() - 1)

    return s, 60, ["b"], error


def arm():
    """An arm with seven joints, held horizontally by position control."""
    s = Scene(floor=False)
    s.add("base", "box", (.05, .05, .05), 1, (0, 0, 0), fixed=True, collides=False)
    parent, masses = "base", (4, 4, 3, 3, 2, 1.5, 1)
    for i, m in enumerate(masses):
        axis = "z" if i % 2 == 0 else "x"
        parent = s.add(f"l{i}", "box", (.2, .08, .08), m, (.1 + .2 * i, 0, 0), parent,
                       {"type": "hinge", "axis": "y" if axis == "x" else "z", "at": (.2 * i, 0, 0), "hold": 0,
                        "limit": 1000}, collides=False)
    return s, 5, ["l6"], lambda t: 1e3 * np.linalg.norm(t.of("l6", "at")[-1] - (1.3, 0, 0))


def cantilever():
    s = Scene(floor=False)
    s.add("base", "box", (.05, .05, .05), 1, (0, 0, 0), fixed=True, collides=False)
    parent = "base"
    for i in range(10):
        parent = s.add(f"l{i}", "box", (.2, .2, .2), 1, (.1 + .2 * i, 0, 0), parent,
                       {"type": "weld", "at": (.2 * i, 0, 0)}, collides=False)
    return s, 5, ["l9"], lambda t: 1e3 * abs(t.of("l9", "at")[-1][2])


def chain():
    s = Scene(floor=False)
    s.add("base", "box", (.05, .05, .05), 1, (0, 0, 0), fixed=True, collides=False)
    parent = "base"
    for i in range(20):
        parent = s.add(f"l{i}", "box", (.02, .02, .1), .1, (0, 0, -.05 - .1 * i), parent,
                       {"type": "hinge", "axis": "xy"[i % 2], "at": (0, 0, -.1 * i)}, collides=False)
    s.add("load", "sphere", (.1, .1, .1), 10, (0, 0, -2.05), parent, {"type": "weld", "at": (0, 0, -2)}, collides=False)
    return s, 5, ["load"], lambda t: 1e3 * np.linalg.norm(t.of("load", "at")[-1] - (0, 0, -2.05))


def gripper():
    """A box of 1 kg between two fingers that press with 200 N."""
    s = Scene(floor=False)
    s.add("palm", "box", (.05, .05, .05), 1, (0, 0, .3), fixed=True, collides=False)
    for name, y, force in (("left", -.06, 200), ("right", .06, -200)):
        s.add(name, "box", (.04, .02, .06), .2, (0, y, 0), "palm",
              {"type": "slide", "axis": "y", "at": (0, y, .3), "force": force}, friction=1)
    s.add("o", "box", (.1, .1, .1), 1, (0, 0, 0), friction=.8)

    def error(t):
        z = t.of("o", "at")[:, 2]
        return 1e3 * abs(z[-1] - z[20]) / (t.t[-1] - t.t[20])

    return s, 20, ["o"], error


def free_fall():
    s = Scene(floor=False)
    s.add("b", "sphere", (.1, .1, .1), 1, (0, 0, 0), collides=False)
    return s, 1, ["b"], lambda t: 1e3 * abs(t.of("b", "at")[-1][2] + .5 * G * t.t[-1] ** 2)


def rolling():
    a = math.radians(10)
    s = Scene(gravity=(G * math.sin(a), 0, -G * math.cos(a)))
    s.add("b", "sphere", (.4, .4, .4), 1, (0, 0, .2), friction=1)
    rate = 5 / 7 * G * math.sin(a)

    def error(t):
        v = t.of("b", "v")[:, 0]
        return 100 * abs((v[-1] - v[9]) / (t.t[-1] - t.t[9]) / rate - 1)

    return s, 3, ["b"], error


# Name, unit of the error, case.
ALL = [
    ("ten boxes: shift in 10 s", "mm", tower),
    ("wall of 100 boxes: shift in 10 s", "mm", wall),
    ("1000 kg on 1 kg: shift in 10 s", "mm", heavy),
    ("box on a slope of 25°, friction 0.5: creep in 10 s", "mm", creep),
    ("box slides down 30°, friction 0.3: acceleration", "%", sliding),
    ("ball rolls down 10°: acceleration", "%", rolling),
    ("free fall of 1 s", "mm", free_fall),
    ("pendulum from 90°: energy after 100 s", "%", pendulum),
    ("double pendulum from level: greatest error of energy in 20 s", "%", double_pendulum),
    ("tumbling body: energy after 60 s", "%", tumbling),
    ("arm of 7 joints held level: tip", "mm", arm),
    ("cantilever of 10 tied boxes: droop", "mm", cantilever),
    ("chain of 20 links with 10 kg: stretch", "mm", chain),
    ("1 kg between fingers of 200 N: creep", "mm/s", gripper),
]
