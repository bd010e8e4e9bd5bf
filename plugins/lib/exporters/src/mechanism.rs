//! The bodies and joints that the objects of a scene form, by the rules of physics: a dynamic shape below a joint or
//! force sensor whose parent is a shape is tied to it, any other dynamic shape is free, and everything else moves with
//! what is above it.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Vector3};
use tatu_plugin_api::{
    abi::{
        TATU_KIND_CAMERA, TATU_KIND_DUMMY, TATU_KIND_FORCE_SENSOR, TATU_KIND_JOINT, TATU_KIND_LIGHT, TATU_KIND_SENSOR,
        TATU_KIND_SHAPE, tatu_object,
    },
    safe::Result,
};

use crate::{
    forms::{Form, Look, Surface, forms_of},
    joints::JointProperties,
    objects::{Item, SceneReader},
};

/// Mass, kg, centre of mass, m, and inertia about it, kg m^2, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub struct MassProperties {
    pub mass: f64,
    pub com: Vector3<f64>,
    pub inertia: Matrix3<f64>,
}

/// How a body is attached.
#[derive(Debug, Clone, PartialEq)]
pub enum Tie {
    /// To the world; the first body is the world itself.
    World,
    /// Not at all.
    Free,
    /// By a joint.
    Joint {
        /// Index of the body above the joint.
        parent: usize,
        /// Index of the joint's object.
        item: usize,
        /// The joint's frame in the frame of the body above.
        frame: Isometry3<f64>,
        /// Pose of the body in the frame that the joint moves.
        below: Isometry3<f64>,
        /// The joint.
        joint: Box<JointProperties>,
    },
    /// Rigidly, by a force sensor or because a joint moves several bodies.
    Rigid {
        /// Index of the other body.
        parent: usize,
    },
}

/// A form of a body.
pub struct Part {
    /// Index of the shape's object.
    pub item: usize,
    /// Pose in the frame of the body.
    pub pose: Isometry3<f64>,
    /// The form.
    pub form: Form,
    /// How it looks.
    pub look: Look,
    /// Whether pictures show it.
    pub is_shown: bool,
    /// How it collides, if it does.
    pub surface: Option<Surface>,
}

/// A dummy that moves with a body.
pub struct Frame {
    /// Index of the dummy's object.
    pub item: usize,
    /// Pose in the frame of the body.
    pub pose: Isometry3<f64>,
}

/// A sensor, camera, light or the like that moves with a body.
pub struct Attached {
    /// Index of its object.
    pub item: usize,
    /// Pose in the frame of the body.
    pub pose: Isometry3<f64>,
}

/// A body: what moves as one.
pub struct Body {
    /// Index of the object that stands for the body: its first shape, or the joint that moves it. `None` for the world.
    pub item: Option<usize>,
    /// How the body is attached.
    pub tie: Tie,
    /// Pose in the world, with all joints at 0.
    pub pose: Isometry3<f64>,
    /// Pose in the frame of the body above, or of the world, with all joints at 0. It does not have the rounding errors
    /// of poses in the world.
    pub in_parent: Isometry3<f64>,
    /// Mass of a body that moves.
    pub mass: Option<MassProperties>,
    /// Forms.
    pub parts: Vec<Part>,
    /// Dummies.
    pub frames: Vec<Frame>,
    /// Other objects.
    pub attached: Vec<Attached>,
}

/// Two dummies that are held together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loop {
    /// Indices of the objects.
    pub dummies: [usize; 2],
}

/// The bodies of a scene or of an object with all that is below it. Bodies precede those that they carry.
pub struct Mechanisms {
    /// The objects.
    pub items: Vec<Item>,
    /// The bodies; the first is the world.
    pub bodies: Vec<Body>,
    /// Index of the body that each object belongs to.
    pub body_of: Vec<usize>,
    /// Pairs of dummies that are held together.
    pub loops: Vec<Loop>,
}

impl Mechanisms {
    /// Reads an object with all that is below it, or the whole scene if `base` is 0.
    pub fn read(reader: &SceneReader<'_>, base: tatu_object) -> Result<Self> {
        let items = reader.items(base)?;
        let world = Body {
            item: None,
            tie: Tie::World,
            pose: Isometry3::identity(),
            in_parent: Isometry3::identity(),
            mass: None,
            parts: Vec::new(),
            frames: Vec::new(),
            attached: Vec::new(),
        };
        let mut work = Work {
            reader,
            at: vec![Isometry3::identity(); items.len()],
            in_body: vec![Isometry3::identity(); items.len()],
            stands_for: vec![None; items.len()],
            all: Mechanisms { body_of: vec![0; items.len()], items, bodies: vec![world], loops: Vec::new() },
        };
        for item in 0..work.all.items.len() {
            work.place(item)?;
        }
        work.loops();
        work.all.drop_empty();
        Ok(work.all)
    }

    /// Returns the name of the object that stands for a body.
    pub fn name_of(&self, body: usize) -> &str {
        self.bodies[body].item.map_or("world", |item| &self.items[item].alias)
    }

    /// Returns the path of the object that stands for a body.
    pub fn path_of(&self, body: usize) -> &str {
        self.bodies[body].item.map_or("/", |item| &self.items[item].path)
    }

    /// Returns the index of the body above a body: that at the other end of its joint, or the world.
    pub fn parent_of(&self, body: usize) -> usize {
        match self.bodies[body].tie {
            Tie::World | Tie::Free => 0,
            Tie::Joint { parent, .. } | Tie::Rigid { parent } => parent,
        }
    }

    /// Returns the topmost body that carries a body.
    pub fn top_of(&self, body: usize) -> usize {
        let mut at = body;
        while let Tie::Joint { parent, .. } | Tie::Rigid { parent } = self.bodies[at].tie
            && parent != 0
        {
            at = parent;
        }
        at
    }

    /// Returns the bodies that each body carries.
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = vec![Vec::new(); self.bodies.len()];
        for body in 1..self.bodies.len() {
            children[self.parent_of(body)].push(body);
        }
        children
    }

    /// Returns the objects that joints lead, by object: the index of each joint's item.
    pub fn item_of(&self, object: tatu_object) -> Option<usize> {
        self.items.iter().position(|item| item.id == object)
    }

    /// Drops bodies below joints without anything that could be exported.
    fn drop_empty(&mut self) {
        let mut is_used: Vec<bool> = self
            .bodies
            .iter()
            .enumerate()
            .map(|(i, b)| {
                let holds = !b.parts.is_empty() || !b.frames.is_empty() || !b.attached.is_empty();
                i == 0 || b.mass.is_some() || holds || !matches!(b.tie, Tie::Joint { .. })
            })
            .collect();
        for body in (1..self.bodies.len()).rev() {
            if is_used[body] {
                is_used[self.parent_of(body)] = true;
            }
        }
        let mut next = 0;
        let new: Vec<usize> = is_used
            .iter()
            .map(|used| {
                let at = next;
                next += usize::from(*used);
                at
            })
            .collect();
        // What belongs to a dropped body is only the joint itself.
        let parents: Vec<usize> = (0..self.bodies.len()).map(|b| self.parent_of(b)).collect();
        for body in &mut self.body_of {
            *body = if is_used[*body] { new[*body] } else { new[parents[*body]] };
        }
        for body in &mut self.bodies {
            if let Tie::Joint { parent, .. } | Tie::Rigid { parent } = &mut body.tie {
                *parent = new[*parent];
            }
        }
        let mut used = is_used.iter();
        self.bodies.retain(|_| *used.next().unwrap_or(&true));
    }
}

/// A reading in progress.
struct Work<'r, 'w> {
    reader: &'r SceneReader<'w>,
    /// Pose of each object in the world, with all joints at 0.
    at: Vec<Isometry3<f64>>,
    /// Pose of each object in the frame of its body.
    in_body: Vec<Isometry3<f64>>,
    /// For shapes that stand for the body of a joint: the body.
    stands_for: Vec<Option<usize>>,
    all: Mechanisms,
}

impl Work<'_, '_> {
    fn kind(&self, item: usize) -> i32 {
        self.all.items[item].kind
    }

    fn is_dynamic(&self, item: usize) -> bool {
        self.kind(item) == TATU_KIND_SHAPE && self.reader.bool(self.all.items[item].id, "shape.dynamic")
    }

    /// Returns whether a joint or force sensor ties dynamic shapes below it to the shape above it.
    fn ties(&self, item: usize) -> bool {
        let Item { id, kind, parent, .. } = &self.all.items[item];
        let below_shape = parent.is_some_and(|above| self.kind(above) == TATU_KIND_SHAPE);
        below_shape
            && match *kind {
                TATU_KIND_JOINT => self.reader.text(*id, "joint.mode") != "kinematic",
                TATU_KIND_FORCE_SENSOR => !self.reader.bool(*id, "force_sensor.broken"),
                _ => false,
            }
    }

    fn add(&mut self, item: usize, tie: Tie, in_parent: Isometry3<f64>) -> usize {
        self.all.bodies.push(Body {
            item: Some(item),
            tie,
            pose: self.at[item],
            in_parent,
            mass: None,
            parts: Vec::new(),
            frames: Vec::new(),
            attached: Vec::new(),
        });
        self.all.bodies.len() - 1
    }

    /// Adds an object to the body that moves it.
    fn place(&mut self, item: usize) -> Result {
        let Item { parent, pose, kind, .. } = self.all.items[item];
        self.at[item] = parent.map_or(pose, |above| self.at[above] * pose);
        let above = parent.map_or(0, |above| self.all.body_of[above]);
        let in_above = parent.map_or(pose, |above| self.in_body[above] * pose);
        match kind {
            TATU_KIND_SHAPE => self.shape(item, above, in_above)?,
            TATU_KIND_JOINT => self.joint(item, above, in_above),
            kind => {
                (self.all.body_of[item], self.in_body[item]) = (above, in_above);
                let body = &mut self.all.bodies[above];
                match kind {
                    TATU_KIND_DUMMY => body.frames.push(Frame { item, pose: in_above }),
                    TATU_KIND_SENSOR | TATU_KIND_CAMERA | TATU_KIND_LIGHT | TATU_KIND_FORCE_SENSOR => {
                        body.attached.push(Attached { item, pose: in_above });
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn joint(&mut self, item: usize, above: usize, frame: Isometry3<f64>) {
        let joint = Box::new(JointProperties::read(self.reader, self.all.items[item].id));
        let ties = self.ties(item);
        let shapes: Vec<usize> =
            self.all.items[item].children.iter().copied().filter(|c| self.kind(*c) == TATU_KIND_SHAPE).collect();
        let first = shapes.iter().find(|shape| ties && self.is_dynamic(**shape));
        let first = first.or_else(|| shapes.iter().find(|shape| !self.is_dynamic(**shape))).copied();
        // The frame of the body is that of the shape, or without one that of the joint.
        let below = first.map_or(Isometry3::identity(), |shape| self.all.items[shape].pose);
        let body = self.add(item, Tie::Joint { parent: above, item, frame, below, joint }, frame * below);
        (self.all.body_of[item], self.in_body[item]) = (body, below.inverse());
        if let Some(shape) = first {
            self.all.bodies[body].item = Some(shape);
            self.all.bodies[body].pose = self.at[item] * below;
            self.stands_for[shape] = Some(body);
        }
    }

    fn shape(&mut self, item: usize, above: usize, in_above: Isometry3<f64>) -> Result {
        let parent = self.all.items[item].parent;
        let is_dynamic = self.is_dynamic(item);
        let at = self.at[item];
        let body = match self.stands_for[item] {
            Some(body) => body,
            None if is_dynamic && parent.is_some_and(|tie| self.ties(tie)) => {
                self.add(item, Tie::Rigid { parent: above }, in_above)
            }
            None if is_dynamic => self.add(item, Tie::Free, at),
            // What carries others needs a name, which the world has not.
            None if above == 0 && self.carries(item) => self.add(item, Tie::World, at),
            None => above,
        };
        let is_own = self.all.bodies[body].item == Some(item);
        let pose = if is_own { Isometry3::identity() } else { in_above };
        (self.all.body_of[item], self.in_body[item]) = (body, pose);
        let moves = is_dynamic || self.stands_for[item].is_some();
        if moves {
            self.all.bodies[body].mass = Some(self.mass(self.all.items[item].id));
        }
        for form in forms_of(self.reader, self.all.items[item].id)? {
            self.all.bodies[body].parts.push(Part {
                item,
                pose: pose * form.pose,
                form: form.form,
                look: form.look,
                is_shown: form.is_shown,
                surface: form.surface,
            });
        }
        Ok(())
    }

    fn carries(&self, item: usize) -> bool {
        let ties = |c: &usize| matches!(self.kind(*c), TATU_KIND_JOINT | TATU_KIND_FORCE_SENSOR);
        self.all.items[item].children.iter().any(ties)
    }

    fn mass(&self, shape: tatu_object) -> MassProperties {
        let inertia = self.reader.array::<9>(shape, "shape.inertia").unwrap_or([0.0; 9]);
        MassProperties {
            mass: self.reader.f64(shape, "shape.mass"),
            com: self.reader.array::<3>(shape, "shape.com").unwrap_or_default().into(),
            inertia: Matrix3::from_row_slice(&inertia),
        }
    }

    fn loops(&mut self) {
        let by_id: BTreeMap<tatu_object, usize> =
            self.all.items.iter().enumerate().map(|(i, item)| (item.id, i)).collect();
        for (i, item) in self.all.items.iter().enumerate() {
            if item.kind != TATU_KIND_DUMMY {
                continue;
            }
            let other = self.reader.target(item.id, "dummy.link").and_then(|other| by_id.get(&other).copied());
            // Both dummies can name each other.
            if let Some(other) = other.filter(|other| *other != i) {
                let pair = Loop { dummies: [i.min(other), i.max(other)] };
                if !self.all.loops.contains(&pair) {
                    self.all.loops.push(pair);
                }
            }
        }
    }
}
