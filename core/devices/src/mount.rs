//! Mounts of devices: the nearest dynamic shape above a device, and the nearest joint between the two.

use nalgebra::{Isometry3, Vector3};
use tatu_physics::{BodyId, BodyWrench, Engine, JointId, JointState};
use tatu_scene::{Dynamics, JointType, Object, ObjectVariant, Scene};

/// The pose and velocity of a mount in the world frame, and the state of its joint, in SI units.
pub(crate) struct MountMotion {
    pub pose: Isometry3<f64>,
    pub twist: [f64; 6],
    /// Position and velocity of the mount's joint; zeros if it has no joint.
    pub joint: [f64; 2],
}

/// A joint that exists in the engine.
#[derive(Clone, Copy)]
struct MountJoint {
    joint: JointId,
    slides: bool,
    /// The bodies above and below the joint.
    bodies: (BodyId, BodyId),
    /// The joint's frame in the body above it.
    frame_in_a: Isometry3<f64>,
}

/// The attachment of a device to a body and a joint. It is rebuilt for each advance, since objects may have been moved
/// or reparented.
pub(crate) struct Mount {
    /// The body that the device is attached to.
    carrier: Option<BodyId>,
    joint: Option<MountJoint>,
    /// Position and velocity of the mount's joint, if the engine does not move it.
    static_joint: [f64; 2],
    /// Transform from the carrier (or the world) to the joint, or to the device itself if there is no joint of the
    /// engine between them.
    to_joint: Isometry3<f64>,
    /// Transform from the moving frame of that joint to the device.
    from_joint: Isometry3<f64>,
    /// Velocity of the device if no body carries it, derived from its last motion.
    twist: [f64; 6],
}

impl Mount {
    /// Finds the mount of an object. The engine must be in sync with the scene. `twist` returns the velocity of an
    /// object that no body carries.
    pub fn of(scene: &Scene, dynamics: &Dynamics, slot: u32, twist: impl Fn(u32) -> [f64; 6]) -> Mount {
        let above = scene.get(slot).map_or(0, |o| o.parent);
        Self::from(scene, dynamics, (slot, above), twist)
    }

    /// Like [`Mount::of`], but a dynamic shape is attached to its own body.
    pub fn at_or_above(scene: &Scene, dynamics: &Dynamics, slot: u32, twist: impl Fn(u32) -> [f64; 6]) -> Mount {
        let is_body = |o: &Object| o.shape().is_some_and(|s| s.dynamic);
        match scene.get(slot) {
            Some(o) if is_body(o) => Self::from(scene, dynamics, (slot, slot), twist),
            _ => Self::of(scene, dynamics, slot, twist),
        }
    }

    /// Finds the mount of an object, with a search that begins at `first`.
    fn from(scene: &Scene, dynamics: &Dynamics, (slot, first): (u32, u32), twist: impl Fn(u32) -> [f64; 6]) -> Mount {
        let world = scene.world(slot);
        let (mut joint, mut carrier) = (None, None);
        let mut at = first;
        while let Some(o) = scene.get(at) {
            match &o.data {
                ObjectVariant::Joint(_) if joint.is_none() => joint = Some(at),
                ObjectVariant::Shape(s) if s.dynamic => {
                    carrier = s.body.0.map(|body| (body, scene.world(at)));
                    break;
                }
                _ => {}
            }
            at = o.parent;
        }
        let base = carrier.map_or(Isometry3::identity(), |(_, pose)| pose);
        let mut mount = Mount {
            carrier: carrier.map(|(body, _)| body),
            joint: None,
            static_joint: [0.0; 2],
            to_joint: base.inverse() * world,
            from_joint: Isometry3::identity(),
            twist: if carrier.is_some() { [0.0; 6] } else { twist(slot) },
        };
        if let Some((at, j)) = joint.and_then(|s| Some((s, scene.get(s)?.joint()?))) {
            mount.static_joint = [j.position, j.velocity];
            // A spherical joint has no single axis.
            let tied = j.id.filter(|_| j.kind != JointType::Spherical);
            if let Some((joint, (bodies, frame_in_a))) = tied.and_then(|id| Some((id, dynamics.bodies_of_joint(id)?))) {
                mount.joint = Some(MountJoint { joint, slides: j.kind == JointType::Prismatic, bodies, frame_in_a });
                mount.to_joint = base.inverse() * scene.world(at);
                mount.from_joint = scene.frame(at).inverse() * world;
            }
        }
        mount
    }

    /// Returns the current pose and velocity of the mount, and the state of its joint.
    pub fn motion(&self, engine: &dyn Engine) -> MountMotion {
        let base = self.carrier.map_or(Isometry3::identity(), |body| engine.pose(body));
        let state = self.joint.map(|h| (h, engine.joint_state(h.joint)));
        let pose = match state {
            Some((h, s)) => base * self.to_joint * h.motion(&s) * self.from_joint,
            None => base * self.to_joint,
        };
        let twist = self.carrier.map_or(self.twist, |body| {
            let t = engine.twist(body);
            let v = t.linear + t.angular.cross(&(pose.translation.vector - engine.centre_of_mass(body).coords));
            [v.x, v.y, v.z, t.angular.x, t.angular.y, t.angular.z]
        });
        MountMotion { pose, twist, joint: state.map_or(self.static_joint, |(_, s)| [s.position, s.velocity]) }
    }

    /// Returns the body that the mount is attached to, if any.
    pub fn carrier(&self) -> Option<BodyId> {
        self.carrier
    }

    /// Adds a wrench on the body that the mount is attached to; without one, it has no effect. Zero wrenches are left
    /// out, because applying one would wake the body.
    pub fn push(&self, engine: &dyn Engine, at: &Isometry3<f64>, wrench: &[f64; 6], out: &mut Vec<BodyWrench>) {
        let Some(body) = self.carrier.filter(|_| *wrench != [0.0; 6]) else { return };
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        let torque = Vector3::new(wrench[3], wrench[4], wrench[5]);
        let arm = at.translation.vector - engine.centre_of_mass(body).coords;
        out.push(BodyWrench { body, force, torque: torque + arm.cross(&force) });
    }

    /// Converts a wrench on the mount and an effort of its joint to forces on bodies. Returns an error if there is no
    /// body or joint to act on.
    pub fn pushes(
        &self,
        engine: &dyn Engine,
        at: &Isometry3<f64>,
        wrench: &[f64; 6],
        effort: f64,
        out: &mut Vec<BodyWrench>,
    ) -> Result<(), &'static str> {
        let mut lacks = Ok(());
        if *wrench != [0.0; 6] && self.carrier.is_none() {
            lacks = Err("its force acts on nothing, because there is no dynamic shape above it");
        }
        self.push(engine, at, wrench, out);
        match self.joint {
            _ if effort == 0.0 => {}
            Some(h) => h.push(engine, effort, out),
            None => {
                lacks = Err(
                    "its effort acts on nothing, because there is no dynamic joint between it and the nearest dynamic shape above it",
                )
            }
        }
        lacks
    }
}

impl MountJoint {
    fn motion(&self, s: &JointState) -> Isometry3<f64> {
        if self.slides {
            Isometry3::translation(0.0, 0.0, s.position)
        } else {
            Isometry3::rotation(Vector3::z() * s.position)
        }
    }

    /// Adds equal and opposite pushes on the two bodies: a torque about the joint's axis, or a force along it.
    fn push(&self, engine: &dyn Engine, effort: f64, out: &mut Vec<BodyWrench>) {
        let frame = engine.pose(self.bodies.0) * self.frame_in_a;
        let along = frame.rotation * Vector3::z() * effort;
        for (body, along) in [(self.bodies.0, -along), (self.bodies.1, along)] {
            if self.slides {
                let arm = frame.translation.vector - engine.centre_of_mass(body).coords;
                out.push(BodyWrench { body, force: along, torque: arm.cross(&along) });
            } else {
                out.push(BodyWrench { body, force: Vector3::zeros(), torque: along });
            }
        }
    }
}
