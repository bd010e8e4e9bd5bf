"""Builds the model of a mechanism for Pinocchio, from the properties of a world's objects."""

import numpy as np
import pinocchio as pin


def se3(pose):
    """Returns a pose x y z qx qy qz qw."""
    return pin.XYZQUATToSE3(np.asarray(pose, float))


class PinMechanism:
    """The mechanism below an object: `model` for Pinocchio, and `owners`, the handles of its joints in the same order."""

    def __init__(self, world, base):
        self.world, self.base = world, base
        self.model = pin.Model()
        self.model.gravity.linear = np.array(world.call("tatu.get", 0, "scene.gravity"), float)
        self.owners, self.kinds, self.carriers, self.frames = [], [], {}, {}
        handles = [int(h) for h in world.call("sim.getObjectsInTree", base)]
        parents = {h: int(self.get(h, "object.parent") or 0) for h in handles}
        kinds = {h: self.get(h, "object.kind") for h in handles}
        carries = set()
        for h in handles:
            if kinds[h] == "joint":
                while parents.get(h) in kinds:
                    h = parents[h]
                    carries.add(h)
        ordered, rest = [], list(handles)
        while rest:
            ready = [h for h in rest if parents[h] not in kinds or parents[h] in ordered]
            ordered.append(ready[0])
            rest.remove(ready[0])
        # The order of the command's joints, which this file does not decide.
        wanted = [int(h) for h in world.call("tatu.kin.joints", base)[0]]
        rank = {h: i for i, h in enumerate(wanted)}
        self._walk(base, 0, se3([0, 0, 0, 0, 0, 0, 1]), False, parents, kinds, carries, rank)
        assert sorted(self.owners) == sorted(wanted), (self.owners, wanted)

    def get(self, handle, key):
        return self.world.call("tatu.get", handle, key)

    def _walk(self, h, joint, frame, tied, parents, kinds, carries, rank):
        """Adds an object and those below it. `frame` is the world pose of the joint's moved frame."""
        pose = se3(self.get(h, "object.world_pose"))
        dynamic = kinds[h] == "shape" and bool(self.get(h, "shape.dynamic"))
        if kinds[h] == "joint":
            kind = self.get(h, "joint.type")
            shape = {"revolute": pin.JointModelRZ, "prismatic": pin.JointModelPZ, "spherical": pin.JointModelSpherical}[kind]
            joint = self._add(joint, shape(), frame.inverse() * pose, h, kind)
            armature = self.get(h, "joint.armature")
            nv = self.model.joints[joint].nv
            self.model.armature[self.model.joints[joint].idx_v:][:nv] = armature
            frame = pose * self._motion(h, kind)
        elif dynamic and not tied:
            if h not in carries and (joint != 0 or self.owners):
                return
            joint = self._add(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), h, "free")
            frame = pose
        if dynamic and joint:
            inertia = np.array(self.get(h, "shape.inertia"), float)
            inertia = np.diag(inertia) if inertia.size == 3 else inertia.reshape(3, 3)
            body = pin.Inertia(float(self.get(h, "shape.mass")), np.array(self.get(h, "shape.com"), float), inertia)
            self.model.appendBodyToJoint(joint, body, frame.inverse() * pose)
        self.carriers[h], self.frames[h] = joint, frame.inverse() * pose
        ties = kinds[h] in ("joint", "force_sensor")
        below = [c for c in parents if parents[c] == h]
        # Objects below which are the first joints of the command come first.
        for c in below:
            self._walk(c, joint, frame, ties, parents, kinds, carries, rank)

    def _add(self, parent, kind, placement, h, name):
        self.owners.append(h)
        self.kinds.append(name)
        return self.model.addJoint(parent, kind, placement, f"{name}{h}")

    def _motion(self, h, kind):
        if kind == "spherical":
            return se3([0, 0, 0, *self.get(h, "joint.rotation")])
        q = float(self.get(h, "joint.position"))
        if kind == "prismatic":
            return pin.SE3(np.eye(3), np.array([0, 0, q]))
        return pin.SE3(pin.utils.rotate("z", q), np.zeros(3))

    def order(self, wanted):
        """Returns the indices of Pinocchio's positions and velocities in the order of the joints `wanted`."""
        q, v = [], []
        for h in wanted:
            joint = self.model.joints[self.owners.index(h) + 1]
            q += range(joint.idx_q, joint.idx_q + joint.nq)
            v += range(joint.idx_v, joint.idx_v + joint.nv)
        return np.array(q), np.array(v)
