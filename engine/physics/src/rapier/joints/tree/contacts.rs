//! Contacts of trees: reading them from rapier's narrow phase or from `detect`, and recording their impulses.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapier3d::{
    dynamics::RigidBody,
    geometry::{ColliderHandle, ContactManifold, ContactPair, PairContacts, SolverContact},
    math::{Pose, Vector},
};
use tatu_mechanisms::{ContactPoint, ContactSide};

use super::{
    records::{ContactKey, DetectedFace, FacePoint, WarmStartImpulse, collider_index},
    table::TreeJoints,
};
use crate::{
    BodyId, convert,
    rapier::{
        bodies::Bodies,
        contacts::{TreeContact, masks},
    },
};

/// Maximum distance of a contact between bodies that do not approach each other, m: more than an acceleration of 100
/// m/s^2 covers in a step of 5 ms.
const MAX_CONTACT_DISTANCE: f64 = 2e-3;

/// A contact, with the data needed to report it.
pub(super) struct DetectedContact {
    pub contact: ContactPoint,
    pub key: ContactKey,
    /// Index of the contact face; all points of a face are reported as one contact.
    pub face: usize,
    pub bodies: (BodyId, BodyId),
    /// Contact point in the world frame, m.
    pub place: Vector3<f64>,
    /// Sum of the contact's impulses over the step, N s.
    pub total: Vector3<f64>,
    /// Speeds at the beginning of the step at which the surfaces approach each other and slide, m/s.
    pub approach: f64,
    pub slip: f64,
}

/// One of the two bodies of a contact.
struct ContactPartner {
    body: BodyId,
    /// Mechanism and link, or `None` if no tree moves the body.
    side: Option<ContactSide>,
    /// Pose at the time of collision detection.
    pose: Isometry3<f64>,
    /// Linear and angular velocity, m/s and rad/s.
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    is_fixed: bool,
}

impl ContactPartner {
    fn velocity_at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(&(point - self.pose.translation.vector))
    }
}

impl TreeJoints {
    /// Returns the contacts of all links, in an order that depends only on the bodies and their colliders.
    pub(super) fn find_contacts(&self, bodies: &Bodies) -> Vec<DetectedContact> {
        match &self.detection {
            Some(detection) => self.read_detected_faces(bodies, &detection.faces),
            None => self.read_narrow_phase(bodies),
        }
    }

    fn read_detected_faces(&self, bodies: &Bodies, faces: &[DetectedFace]) -> Vec<DetectedContact> {
        let mut found = Vec::new();
        for face in faces {
            let [Some(a), Some(b)] = face.colliders.map(|c| self.contact_partner(bodies, c)) else { continue };
            let index = found.last().map_or(0, |f: &DetectedContact| f.face + 1);
            for point in &face.points {
                self.add_point(bodies, point, [&a, &b], index, &mut found);
            }
        }
        found
    }

    fn read_narrow_phase(&self, bodies: &Bodies) -> Vec<DetectedContact> {
        let mut found = Vec::new();
        let mut pairs: Vec<&ContactPair> = Vec::new();
        for body in self.links.keys() {
            let Some(record) = bodies.record(*body) else { continue };
            pairs.clear();
            for collider in bodies.world.bodies[record.handle].colliders() {
                pairs.extend(bodies.world.narrow_phase.contact_pairs_with(*collider));
            }
            // Most pairs are of neighbouring links, which do not collide.
            pairs.retain(|pair| has_points(pair));
            // Rapier's order of pairs depends on earlier steps.
            pairs.sort_by_key(|p| (collider_index(p.collider1), collider_index(p.collider2)));
            for pair in pairs.drain(..) {
                let (Some(a), Some(b)) =
                    (self.contact_partner(bodies, pair.collider1), self.contact_partner(bodies, pair.collider2))
                else {
                    continue;
                };
                let other = if a.body == *body { &b } else { &a };
                // A pair of two links is found twice, once from each link.
                if a.body != b.body && (other.side.is_none() || *body < other.body) {
                    self.read_pair(bodies, pair, [&a, &b], &mut found);
                }
            }
        }
        found
    }

    fn contact_partner(&self, bodies: &Bodies, collider: ColliderHandle) -> Option<ContactPartner> {
        let id = masks::body_of(&bodies.world, collider)?;
        let body = bodies.body(id)?;
        let side = self.links.get(&id).copied();
        let dt = bodies.world.integration_parameters.dt;
        let (linear, angular) = (convert::vector_back(body.linvel()), convert::vector_back(body.angvel()));
        // Rapier has moved its bodies since collision detection, but not the links.
        let pose = match side {
            Some(side) => self.link_pose(side)?,
            None => pose_before(bodies, id, body, dt),
        };
        Some(ContactPartner { body: id, side, pose, linear, angular, is_fixed: body.is_fixed() })
    }

    /// Returns the pose that rapier's body of a link had at the beginning of the step.
    fn link_pose(&self, side: ContactSide) -> Option<Isometry3<f64>> {
        Some(*self.mechanisms.get(side.member)?.built.as_ref()?.poses.get(side.link)?)
    }

    fn read_pair(
        &self,
        bodies: &Bodies,
        pair: &ContactPair,
        partners: [&ContactPartner; 2],
        found: &mut Vec<DetectedContact>,
    ) {
        let PairContacts::Rigid(rigid) = &pair.contacts else { return };
        for manifold in rigid.solver_manifolds() {
            let face = found.last().map_or(0, |f: &DetectedContact| f.face + 1);
            for at in &manifold.data.solver_contacts {
                if let Some(point) = face_point(pair, manifold, at, partners) {
                    self.add_point(bodies, &point, partners, face, found);
                }
            }
        }
    }

    /// Adds a point of the face with the index `face`, unless it is too far away to touch in this step.
    fn add_point(
        &self,
        bodies: &Bodies,
        point: &FacePoint,
        [a, b]: [&ContactPartner; 2],
        face: usize,
        found: &mut Vec<DetectedContact>,
    ) {
        let ([first, second], normal) = (point.places, point.normal);
        // Parry has no normal for forms that touch exactly.
        if normal.norm_squared() < 0.5 {
            return;
        }
        let dt = bodies.world.integration_parameters.dt;
        let relative = a.velocity_at(&first) - b.velocity_at(&second);
        let approach = relative.dot(&normal);
        let distance = (second - first).dot(&normal);
        if distance > MAX_CONTACT_DISTANCE + 2.0 * dt * approach.max(0.0) {
            return;
        }
        let middle = (first + second) / 2.0;
        let arms = [a, b].map(|partner| match partner.side {
            Some(side) => {
                let built = self.mechanisms[side.member].built.as_ref();
                built.map_or_else(Vector3::zeros, |built| middle - built.origins[side.link])
            }
            None => Vector3::zeros(),
        });
        let outside = |partner: &ContactPartner, point: &Vector3<f64>| match partner.side {
            Some(_) => Vector3::zeros(),
            None => partner.velocity_at(point),
        };
        let numbers = &bodies.world.integration_parameters;
        let spring =
            if a.is_fixed || b.is_fixed { &numbers.static_contact_softness } else { &numbers.contact_softness };
        let mut key = point.key;
        // Some forms use feature 0 for all points, so equal keys must be distinguished by a counter.
        while found.iter().rev().take_while(|f| f.key[..2] == key[..2]).any(|f| f.key == key) {
            key[6] += 1;
        }
        let last = self.warm_start.binary_search_by_key(&key, |k| k.key).ok();
        let contact = ContactPoint {
            sides: [a.side, b.side],
            arms,
            distance,
            drift: outside(b, &second) - outside(a, &first),
            normal,
            slide: point.slide,
            friction: point.friction,
            restitution: point.restitution,
            recovery: spring.erp_inv_dt(bodies.usual_substep()),
            impulse: last.map_or_else(Vector3::zeros, |i| self.warm_start[i].impulse),
        };
        found.push(DetectedContact {
            contact,
            key,
            face,
            bodies: (a.body, b.body),
            place: middle,
            total: Vector3::zeros(),
            approach,
            slip: (relative - normal * approach + point.slide).norm(),
        });
    }

    /// Discards the stored contacts of a body that is about to be removed, because rapier can reuse the indices of its
    /// colliders.
    pub fn discard_contacts(&mut self, bodies: &Bodies, body: BodyId) {
        let Some(handle) = bodies.record(body).map(|r| r.handle) else { return };
        let gone: Vec<u32> = bodies.world.bodies[handle].colliders().iter().map(|c| collider_index(*c)).collect();
        self.warm_start.retain(|k| !gone.contains(&k.key[0]) && !gone.contains(&k.key[1]));
        self.last_normals.retain(|n| !n.pair.iter().any(|c| gone.contains(c)));
        self.touches.retain(|t| t.bodies.0 != body && t.bodies.1 != body);
    }

    /// Stores the impulses of contacts, for reports and for warm starting the next step.
    pub(super) fn store_contacts(&mut self, bodies: &Bodies, found: &[DetectedContact]) {
        let dt = bodies.world.integration_parameters.dt;
        self.warm_start.clear();
        self.warm_start.extend(
            found
                .iter()
                .filter(|f| f.contact.impulse != Vector3::zeros())
                .map(|f| WarmStartImpulse { key: f.key, impulse: f.contact.impulse }),
        );
        self.warm_start.sort_by_key(|k| k.key);
        self.touches.clear();
        for face in found.chunk_by(|a, b| a.face == b.face) {
            let normal = face[0].contact.normal;
            let (mut force, mut place, mut sum) = (0.0, Vector3::zeros(), Vector3::zeros());
            for point in face {
                let along = point.total.dot(&normal);
                force += along;
                place += point.place * along;
                sum += point.total;
            }
            if force > 0.0 {
                self.touches.push(TreeContact {
                    bodies: face[0].bodies,
                    point: place / force,
                    normal,
                    force: force / dt,
                    friction: (sum - normal * force) / dt,
                });
            }
        }
    }
}

/// Reads a solver contact of rapier.
fn face_point(
    pair: &ContactPair,
    manifold: &ContactManifold,
    at: &SolverContact,
    [a, b]: [&ContactPartner; 2],
) -> Option<FacePoint> {
    let data = &manifold.data;
    let feature = manifold.points.get((at.contact_id[0] & 0x7fff_ffff) as usize)?;
    // Rapier stores the anchor of a side in the world frame if the contact can move only the other side.
    let place = |partner: &ContactPartner, anchor: Vector, own: bool| {
        let anchor = convert::vector_back(anchor);
        if own { (partner.pose * Point3::from(anchor)).coords } else { anchor }
    };
    let [c1, c2] = [pair.collider1, pair.collider2].map(collider_index);
    Some(FacePoint {
        places: [
            place(a, at.anchor1, data.relative_dominance <= 0),
            place(b, at.anchor2, data.relative_dominance >= 0),
        ],
        normal: convert::vector_back(data.normal),
        slide: convert::vector_back(at.tangent_velocity),
        friction: data.friction,
        restitution: data.restitution,
        key: [c1, c2, manifold.subshape1, manifold.subshape2, feature.fid1.0, feature.fid2.0, 0],
    })
}

fn has_points(pair: &ContactPair) -> bool {
    let PairContacts::Rigid(rigid) = &pair.contacts else { return false };
    rigid.solver_manifolds().iter().any(|manifold| !manifold.data.solver_contacts.is_empty())
}

/// Returns the pose that a body moved by rapier had at the time of collision detection.
fn pose_before(bodies: &Bodies, id: BodyId, body: &RigidBody, dt: f64) -> Isometry3<f64> {
    if let Some(Some(seen)) = bodies.previous.get(id.0 as usize).filter(|_| body.is_dynamic()) {
        return convert::pose_back(&Pose { translation: seen.place, rotation: seen.rotation });
    }
    let mut pose = convert::pose_back(body.position());
    pose.translation.vector -= convert::vector_back(body.linvel()) * dt;
    pose.rotation = UnitQuaternion::new(convert::vector_back(body.angvel()) * -dt) * pose.rotation;
    pose
}
