//! The mechanism below an object of the scene, as a tree of links.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_kinematics_common::pose_of;
use tatu_mechanisms::{Joint, Link, Tree};
use tatu_plugin_api::{
    abi::{TATU_KIND_FORCE_SENSOR, TATU_KIND_JOINT, TATU_KIND_SHAPE, tatu_object},
    safe::{Fail, Host, Prop, Result, World},
};

/// The properties that describe mechanisms.
pub struct MechanismProps {
    pub parent: Prop,
    pub gravity: Prop,
    path: Prop,
    mass: Prop,
    inertia: Prop,
    com: Prop,
    dynamic: Prop,
    pub kind: Prop,
    pub position: Prop,
    pub rotation: Prop,
    pub velocity: Prop,
    lead: Prop,
    armature: Prop,
    pub damping: Prop,
    pub spring: [Prop; 2],
}

impl MechanismProps {
    /// Looks up the properties.
    pub fn new(host: &Host) -> Self {
        MechanismProps {
            parent: host.prop("object.parent"),
            gravity: host.prop("scene.gravity"),
            path: host.prop("object.path"),
            mass: host.prop("shape.mass"),
            inertia: host.prop("shape.inertia"),
            com: host.prop("shape.com"),
            dynamic: host.prop("shape.dynamic"),
            kind: host.prop("joint.type"),
            position: host.prop("joint.position"),
            rotation: host.prop("joint.rotation"),
            velocity: host.prop("joint.velocity"),
            lead: host.prop("joint.lead"),
            armature: host.prop("joint.armature"),
            damping: host.prop("joint.damping"),
            spring: [host.prop("joint.stiffness"), host.prop("joint.rest_position")],
        }
    }
}

/// A dynamic shape that is part of a link.
pub struct LinkBody {
    pub object: tatu_object,
    /// Centre of mass in the frame of the link, m.
    pub center: Vector3<f64>,
}

/// What moves a link, and the shapes that are part of it.
pub struct LinkRecord {
    /// The joint; for a link that moves freely, its shape.
    pub owner: tatu_object,
    pub bodies: Vec<LinkBody>,
    /// Pose of the link's frame in the world at present.
    pub pose: Isometry3<f64>,
}

/// A mechanism: its links with their records, in the same order, and where objects are attached.
pub struct Mechanism {
    pub links: Vec<Link>,
    pub records: Vec<LinkRecord>,
    /// The link that carries each object below the model; `None`: nothing moves it.
    pub carriers: BTreeMap<tatu_object, Option<usize>>,
}

/// Returns the moved frame of a joint relative to its own frame.
fn motion(world: &World<'_>, p: &MechanismProps, joint: tatu_object, kind: &Joint) -> Result<Isometry3<f64>> {
    Ok(match kind {
        Joint::Prismatic(_) => Isometry3::translation(0.0, 0.0, world.f64(joint, p.position)?),
        Joint::Spherical => {
            let [x, y, z, w] = world.f64s::<4>(joint, p.rotation)?;
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
        }
        _ => {
            let (sine, cosine) = libm::sincos(0.5 * world.f64(joint, p.position)?);
            let turned = UnitQuaternion::new_unchecked(Quaternion::new(cosine, 0.0, 0.0, sine));
            Isometry3::from_parts(Translation3::identity(), turned)
        }
    })
}

impl Mechanism {
    /// Reads the mechanism below an object.
    ///
    /// # Errors
    ///
    /// Fails if the object does not exist, if nothing below it can move, or if a joint is a screw.
    pub fn read(world: &World<'_>, p: &MechanismProps, model: tatu_object) -> Result<Self> {
        let below = world.list(model, 0, 0)?;
        let mut all = Mechanism { links: Vec::new(), records: Vec::new(), carriers: BTreeMap::new() };
        // The objects with a joint below them.
        let mut parents = BTreeMap::new();
        let mut carries = BTreeMap::new();
        for object in &below {
            parents
                .insert(*object, world.look(world.get(*object, p.parent)?.as_object().unwrap_or(0)).ok().map(|o| o.id));
        }
        for object in &below {
            if world.look(*object)?.kind == TATU_KIND_JOINT {
                let mut at = parents.get(object).copied().flatten();
                while let Some(above) = at
                    && carries.insert(above, ()).is_none()
                {
                    at = parents.get(&above).copied().flatten();
                }
            }
        }
        let mut ties: BTreeMap<tatu_object, bool> = BTreeMap::new();
        for object in &below {
            let above = parents.get(object).copied().flatten();
            let carrier = match above.and_then(|a| all.carriers.get(&a)) {
                Some(carrier) => *carrier,
                // A body that is not part of the mechanism, unless this is the first object.
                None if *object != model => continue,
                None => None,
            };
            let tied = above.and_then(|a| ties.get(&a)).copied().unwrap_or(false);
            let kind = world.look(*object)?.kind;
            let mut own = carrier;
            if kind == TATU_KIND_JOINT {
                own = Some(all.add_joint(world, p, *object, carrier)?);
            } else if kind == TATU_KIND_SHAPE && world.get(*object, p.dynamic)?.as_bool() == Some(true) && !tied {
                if !carries.contains_key(object) && (carrier.is_some() || !all.links.is_empty()) {
                    continue;
                }
                own = Some(all.add_free(world, *object)?);
            }
            if kind == TATU_KIND_SHAPE
                && let Some(link) = own
                && world.get(*object, p.dynamic)?.as_bool() == Some(true)
            {
                all.add_body(world, p, *object, link)?;
            }
            ties.insert(*object, matches!(kind, TATU_KIND_JOINT | TATU_KIND_FORCE_SENSOR));
            all.carriers.insert(*object, own);
        }
        if all.links.is_empty() {
            let path = path(world, p, model);
            return Err(Fail::argument(format!("`{path}` has no joint below it, and is no dynamic shape"))
                .help("pass the handle of the model's base, or of any object above its joints"));
        }
        Ok(all)
    }

    fn add_joint(
        &mut self,
        world: &World<'_>,
        p: &MechanismProps,
        object: tatu_object,
        parent: Option<usize>,
    ) -> Result<usize> {
        let kind = match world.get(object, p.kind)?.as_str().as_deref() {
            Some("prismatic") => Joint::Prismatic(Vector3::z()),
            Some("spherical") => Joint::Spherical,
            _ => Joint::Revolute(Vector3::z()),
        };
        if matches!(kind, Joint::Revolute(_)) && world.f64(object, p.lead).unwrap_or(0.0) != 0.0 {
            return Err(Fail::unsupported(format!("joint `{}` is a screw", path(world, p, object)))
                .help("these commands support revolute, prismatic and spherical joints"));
        }
        let own = pose_of(world.pose(object, 0)?);
        let frame = parent.map_or(own, |i| self.records[i].pose.inverse() * own);
        let pose = own * motion(world, p, object, &kind)?;
        let mut link = Link::new(parent, frame, kind, 0.0, Vector3::zeros(), Matrix3::zeros());
        link.armature = world.f64(object, p.armature).unwrap_or(0.0);
        link.damping = world.f64(object, p.damping).unwrap_or(0.0);
        self.links.push(link);
        self.records.push(LinkRecord { owner: object, bodies: Vec::new(), pose });
        Ok(self.links.len() - 1)
    }

    fn add_free(&mut self, world: &World<'_>, object: tatu_object) -> Result<usize> {
        let pose = pose_of(world.pose(object, 0)?);
        let free = Link::new(None, Isometry3::identity(), Joint::Free, 0.0, Vector3::zeros(), Matrix3::zeros());
        self.links.push(free);
        self.records.push(LinkRecord { owner: object, bodies: Vec::new(), pose });
        Ok(self.links.len() - 1)
    }

    /// Adds the mass of a shape to a link.
    fn add_body(&mut self, world: &World<'_>, p: &MechanismProps, object: tatu_object, link: usize) -> Result {
        let record = &mut self.records[link];
        let in_link = record.pose.inverse() * pose_of(world.pose(object, 0)?);
        let center = (in_link * Point3::from(world.f64s::<3>(object, p.com)?)).coords;
        record.bodies.push(LinkBody { object, center });
        let inertia = match world.get(object, p.inertia)?.numbers() {
            Some(n) if n.len() == 3 => Matrix3::from_diagonal(&Vector3::new(n[0], n[1], n[2])),
            Some(n) if n.len() == 9 => Matrix3::from_row_slice(&n),
            _ => return Err(Fail::new(format!("the inertia of `{}` cannot be read", path(world, p, object)))),
        };
        let turn = in_link.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * inertia * turn.matrix().transpose();
        let link = &mut self.links[link];
        let mass = world.f64(object, p.mass)?;
        if link.mass == 0.0 {
            (link.mass, link.center, link.inertia) = (mass, center, inertia);
            return Ok(());
        }
        let total = link.mass + mass;
        let middle = (link.center * link.mass + center * mass) / total;
        let about = |mass: f64, from: Vector3<f64>| {
            (Matrix3::identity() * from.norm_squared() - from * from.transpose()) * mass
        };
        link.inertia += about(link.mass, link.center - middle) + inertia + about(mass, center - middle);
        (link.mass, link.center) = (total, middle);
        Ok(())
    }

    /// Returns the tree, and the links whose joints move no mass: these get an armature of 1, which does not affect
    /// positions, and which the commands subtract from masses and forces.
    ///
    /// # Errors
    ///
    /// Fails if a value is not that of a rigid body.
    pub fn tree(&self) -> Result<(Tree, Vec<usize>)> {
        let mut links = self.links.clone();
        let mut carried: Vec<f64> = links.iter().map(|l| l.mass).collect();
        let mut massless = Vec::new();
        for i in (0..links.len()).rev() {
            if carried[i] == 0.0 && links[i].armature == 0.0 {
                links[i].armature = 1.0;
                massless.push(i);
            }
            if let Some(parent) = links[i].parent {
                carried[parent] += carried[i];
            }
        }
        let tree = Tree::with_any_inertia(links);
        Ok((tree.map_err(|e| Fail::argument(format!("the mechanism cannot be computed: {e}")))?, massless))
    }

    /// Returns an error that names the first of the links that move no mass, if there is one.
    pub fn refuse_massless(&self, world: &World<'_>, p: &MechanismProps, massless: &[usize]) -> Result {
        let Some(link) = massless.last() else { return Ok(()) };
        let path = path(world, p, self.records[*link].owner);
        Err(Fail::argument(format!("joint `{path}` moves no mass, so its acceleration is undefined"))
            .help("attach a dynamic shape to it, or set `joint.armature`"))
    }

    /// Returns the link that carries an object, which must be below the model.
    pub fn link_of(&self, world: &World<'_>, p: &MechanismProps, object: tatu_object) -> Result<usize> {
        match self.carriers.get(&object) {
            Some(Some(link)) => Ok(*link),
            Some(None) => Err(Fail::argument(format!("no joint moves `{}`", path(world, p, object)))),
            None => Err(Fail::argument(format!("`{}` is not part of the mechanism", path(world, p, object)))
                .help("pass an object that is attached to one of its joints")),
        }
    }
}

/// Returns the path of an object, for messages.
pub fn path(world: &World<'_>, p: &MechanismProps, object: tatu_object) -> String {
    world.get(object, p.path).ok().and_then(|v| v.as_str().map(|s| s.into_owned())).unwrap_or_default()
}
