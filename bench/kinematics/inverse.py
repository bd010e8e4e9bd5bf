"""Compares `tatu.kin.ik` with a closed loop (CLIK) on Pinocchio and with mink, on the same reachable poses in one run.

    python bench/kinematics/inverse.py [--poses 10000] [--others 300]

Poses are those of random positions within limits; all start from the middle of the limits, with ten restarts, and count
as solved within 1e-6 m and 1e-6 rad and the limits. The others run on fewer poses, since they are loops in Python.
Needs `pip install pin mink numpy` and the package tatu_sim.
"""

import argparse
import time

import mink
import mujoco
import numpy as np
import pinocchio as pin
import tatu_sim
from mechanism import PinMechanism

PRECISION = 1e-6
RESTARTS = 10
ITERATIONS = 200
ARMS = {"ur5": "/robot/tool0", "panda": "/robot/flange"}


class Arm:
    """An arm in a world, with its model for Pinocchio and MuJoCo; positions are in the order of the chain."""

    def __init__(self, name, tip):
        self.world = tatu_sim.World(text=f'format = 1\n[[model]]\nmodel = "{name}"\nalias = "robot"\ncontroller = false\n')
        base = int(self.world.call("sim.getObject", "/robot"))
        self.tip = int(self.world.call("sim.getObject", tip))
        own = PinMechanism(self.world, base)
        joint = own.carriers[self.tip]
        chain = []
        while joint:
            chain.insert(0, joint)
            joint = own.model.parents[joint]
        # A model of the chain alone, without fingers.
        self.model, parent = pin.Model(), 0
        limits = [own.get(own.owners[j - 1], "joint.limits") for j in chain]
        for i, j in enumerate(chain):
            parent = self.model.addJoint(parent, pin.JointModelRZ(), own.model.jointPlacements[j], f"j{i}")
        self.frame = self.model.addFrame(pin.Frame("tip", parent, 0, own.frames[self.tip], pin.FrameType.OP_FRAME))
        self.data = self.model.createData()
        self.low, self.high = np.array(limits, float).T
        self.middle = 0.5 * (self.low + self.high)
        self.mujoco = mujoco.MjModel.from_xml_string(self._xml(own, chain))

    def _xml(self, own, chain):
        text = lambda x: " ".join(repr(float(v)) for v in x)
        place = lambda m: f'pos="{text(m.translation)}" quat="{text(np.roll(pin.Quaternion(m.rotation).coeffs(), 1))}"'
        head = tail = ""
        for i, j in enumerate(chain):
            head += f'<body {place(own.model.jointPlacements[j])}><joint name="j{i}" axis="0 0 1" ' \
                    f'range="{text([self.low[i], self.high[i]])}"/><geom size="0.01"/>'
            tail += "</body>"
        head += f'<site name="tip" {place(own.frames[self.tip])}/>'
        return f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{head}{tail}</worldbody></mujoco>'

    def pose(self, q):
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.frame].copy()

    def solves(self, q, goal):
        if q is None or np.any(q < self.low - 1e-12) or np.any(q > self.high + 1e-12):
            return False
        error = self.pose(q).inverse() * goal
        return np.linalg.norm(error.translation) <= 1.01 * PRECISION and np.linalg.norm(pin.log3(error.rotation)) <= 1.01 * PRECISION


def tatu(arm, goal, _):
    found = arm.world.call("tatu.kin.ik", arm.tip, list(pin.SE3ToXYZQUAT(goal)), {"from": list(arm.middle)})
    return None if found[0] is None else np.array(found[0])


def clik(arm, goal, random):
    """Damped least squares, clamped to the limits, as in Pinocchio's example."""
    for restart in range(RESTARTS + 1):
        q = arm.middle.copy() if restart == 0 else random.uniform(arm.low, arm.high)
        for _ in range(ITERATIONS):
            pin.framesForwardKinematics(arm.model, arm.data, q)
            error = pin.log(arm.data.oMf[arm.frame].actInv(goal)).vector
            if np.linalg.norm(error[:3]) <= PRECISION and np.linalg.norm(error[3:]) <= PRECISION:
                return q
            jacobian = pin.computeFrameJacobian(arm.model, arm.data, q, arm.frame)
            square = jacobian @ jacobian.T + (0.01 * error @ error + 1e-8) * np.eye(6)
            q = np.clip(q + jacobian.T @ np.linalg.solve(square, error), arm.low, arm.high)
    return None


def by_mink(arm, goal, random):
    task = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)
    task.set_target(mink.SE3(pin.SE3ToXYZQUAT(goal)[[6, 3, 4, 5, 0, 1, 2]]))
    limits = [mink.ConfigurationLimit(arm.mujoco)]
    for restart in range(RESTARTS + 1):
        q = arm.middle if restart == 0 else random.uniform(arm.low, arm.high)
        configuration = mink.Configuration(arm.mujoco, q)
        for _ in range(ITERATIONS // 2):
            error = task.compute_error(configuration)
            if np.linalg.norm(error[:3]) <= PRECISION and np.linalg.norm(error[3:]) <= PRECISION:
                return configuration.q.copy()
            try:
                velocity = mink.solve_ik(configuration, [task], 1.0, solver="daqp", damping=1e-9, limits=limits)
            except Exception:
                break
            configuration.integrate_inplace(velocity, 1.0)
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=10000)
    parser.add_argument("--others", type=int, default=300)
    options = parser.parse_args()
    print(f"{'arm':8}{'solver':10}{'poses':>8}{'solved':>10}{'median us':>11}")
    for name, tip in ARMS.items():
        arm, random = Arm(name, tip), np.random.default_rng(7)
        goals = [arm.pose(random.uniform(arm.low, arm.high)) for _ in range(options.poses)]
        for solver, solve, count in (("tatu", tatu, options.poses), ("pin", clik, options.others), ("mink", by_mink, options.others)):
            times, solved, starts = [], 0, np.random.default_rng(1)
            for goal in goals[:count]:
                begin = time.perf_counter()
                q = solve(arm, goal, starts)
                times.append(time.perf_counter() - begin)
                solved += arm.solves(q, goal)
            print(f"{name:8}{solver:10}{count:>8}{100 * solved / count:>9.2f}%{1e6 * np.median(times):>11.0f}", flush=True)


if __name__ == "__main__":
    main()
