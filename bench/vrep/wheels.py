"""Compares wheeled robots of V-REP's scenes with their behaviour in the original program.

    python bench/vrep/wheels.py FOLDER [--program target/release/tatu] [--only NAME] [--write]

FOLDER contains the scenes and REFERENCES.md with a table of wheel experiments. In these, scripts are off and the robot
starts 0.5 mm above a flat floor with friction 1. The wheels are at 0 from 0 to 11 s, at 2 rad/s from 11 to 21 s, at 0
from 21 to 23 s, and at 1 (left) and 2 rad/s (right) from 23 to 33 s. The speed of the midpoint between the wheels is
measured from 13 to 21 s and from 25 to 33 s. --write writes the table into docs/vrep-scenes.md.
"""
import argparse
import multiprocessing
import os
import re
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
PAGE = os.path.join(HERE, "../../docs/vrep-scenes.md")
BEGIN, END = "<!-- wheels -->", "<!-- end of wheels -->"

DRIVER = """
local robot = sim.getObject('/%(robot)s')
local motors = {}
for _, j in ipairs(sim.getObjectsInTree(robot, sim.object_joint_type)) do
    local name = string.lower(sim.getObjectAlias(j))
    for _, side in ipairs({'left', 'right'}) do
        if name:find(side) and not motors[side] and sim.getJointType(j) == sim.joint_revolute_subtype then motors[side] = j end
    end
end
local function place()
    local a = sim.getObjectPosition(motors.left, -1)
    local b = sim.getObjectPosition(motors.right, -1)
    return {(a[1] + b[1]) / 2, (a[2] + b[2]) / 2}, math.atan2(b[2] - a[2], b[1] - a[1]), (a[3] + b[3]) / 2
end
local function speeds(left, right)
    sim.setJointTargetVelocity(motors.left, left)
    sim.setJointTargetVelocity(motors.right, right)
end
function sysCall_init()
    local p = sim.getObjectPosition(robot, -1)
    local _, _, axle = place()
    sim.setObjectPosition(robot, -1, {500, 500, p[3] - axle + %(radius)s + 0.0005})
    speeds(0, 0)
end
local marks, yaw, turned, way, last = {}, nil, 0, 0, nil
function sysCall_actuation()
    local t = sim.getSimulationTime()
    local here, angle = place()
    if yaw then turned = turned + ((angle - yaw + math.pi) %% (2 * math.pi) - math.pi) end
    if last then way = way + math.sqrt((here[1] - last[1])^2 + (here[2] - last[2])^2) end
    yaw, last = angle, here
    for _, at in ipairs({1, 11, 13, 21, 25, 33}) do
        if math.abs(t - at) < 1e-6 then marks[at] = {here[1], here[2], turned, way} end
    end
    if math.abs(t - 11) < 1e-6 then speeds(2, 2) end
    if math.abs(t - 21) < 1e-6 then speeds(0, 0) end
    if math.abs(t - 23) < 1e-6 then speeds(1, 2) end
    if marks[33] and not marks.told then
        marks.told = true
        local function apart(a, b) return math.sqrt((a[1] - b[1])^2 + (a[2] - b[2])^2) end
        print(string.format('RESULT %%.9f %%.9f %%.9f %%.9f', apart(marks[11], marks[1]), apart(marks[21], marks[13]) / 8,
            (marks[33][4] - marks[25][4]) / 8, math.abs(marks[33][3] - marks[25][3]) / 8))
    end
end
"""

FLOOR = """
[[object]]
kind = "shape"
alias = "measured_floor"
position_m = [500, 500, -0.1]
primitive = "box"
size_m = [60, 60, 0.2]
respondable = true
friction = 1.0

[[object]]
kind = "dummy"
alias = "measuring_driver"
script = { file = "driver.lua", dialect = "4.9" }
"""


def rows(page):
    """Returns file, robot, wheel radius, and the original's drift (mm), both speeds (m/s) and yaw rate (rad/s)."""
    for line in open(page):
        cells = [c.strip() for c in line.strip().strip("|").split("|")]
        if len(cells) == 12 and cells[2] == "Bullet":
            first = [float(re.split("[ ,]", cells[i])[0]) if re.match("[-0-9]", cells[i]) else None for i in (4, 6, 7, 10, 11)]
            yield cells[0], cells[1], first


def drive(task):
    (name, robot, (radius, *there)), arguments = task
    path = next(p for s in (".ttt", ".ttm") if os.path.exists(p := os.path.join(arguments.folder, name + s)))
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "scene.toml")
        subprocess.run([arguments.program, "convert", path, scene], check=True, capture_output=True)
        text = "".join(line for line in open(scene) if not line.startswith(("script =", "scripts =")))
        open(scene, "w").write(text + FLOOR)
        open(os.path.join(folder, "driver.lua"), "w").write(DRIVER % {"robot": robot, "radius": radius})
        run = subprocess.run([arguments.program, "run", scene, "--seconds", "33.2", "--no-addons"], capture_output=True, text=True)
        found = re.search("RESULT (.*)", run.stdout + run.stderr)
        here = [float(x) for x in found[1].split()] if found else None
        return name, robot, there, here, "" if found else (run.stdout + run.stderr)[-400:]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--program", default="target/release/tatu")
    parser.add_argument("--only", default="")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    tasks = [(r, arguments) for r in rows(os.path.join(arguments.folder, "REFERENCES.md")) if arguments.only in r[0]]
    out = ["| file | robot | rest, mm in 10 s, here / there | straight m/s | % | turn m/s | % | yaw rate rad/s | % |",
           "|---|---|---|---|---|---|---|---|---|"]
    with multiprocessing.Pool(2) as pool:
        for name, robot, there, here, why in pool.imap(drive, tasks):
            if here is None:
                out.append(f"| {name} | {robot} | it was not driven | | | | | | |")
                print(why)
                continue
            cells = [f"{1000 * here[0]:.2f} / {there[0]:.2f}"]
            for a, b in zip(here[1:], there[1:]):
                cells += [f"{a:.4f}", f"{100 * (a / b - 1):+.2f}" if b else "-"]
            out.append(f"| {name} | {robot} | " + " | ".join(cells) + " |")
    text = "\n".join(out)
    print(text)
    if arguments.write:
        page = open(PAGE).read()
        page = page[:page.index(BEGIN) + len(BEGIN)] + "\n" + text + "\n" + page[page.index(END):]
        open(PAGE, "w").write(page)


if __name__ == "__main__":
    main()
