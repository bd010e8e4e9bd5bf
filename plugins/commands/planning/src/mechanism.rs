//! What the numbers of a state move: frames, and shapes attached to them.

use std::{cell::OnceCell, collections::BTreeMap};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::{Form, SolidPart};
use tatu_kinematics_common::pose_of;
use tatu_physics::PreparedSolid;
use tatu_planning::spheres::{Body, BodyChecker, Confirm, FrameMotion, FrameTree, MovingFrame, SphereCache};
use tatu_plugin_api::{
    abi::{TATU_KIND_JOINT, TATU_KIND_SHAPE, tatu_object},
    safe::{Fail, Result, World},
};

use crate::{
    forms::{forms_of, parts_of},
    spaces::euler_parts,
    state::{ObjectSpace, Planning, SpaceKind},
};

const TURN: f64 = 2.0 * std::f64::consts::PI;
/// Maximum depth of objects.
const MAX_DEPTH: usize = 10_000;

/// Reads which objects a state moves, and how.
pub struct Mechanism<'w> {
    world: World<'w>,
    props: &'w Planning,
    spaces: &'w [ObjectSpace],
    pub frames: FrameTree,
    /// The present poses of the frames in the world, after their motion.
    present: Vec<Isometry3<f64>>,
    parents: Vec<Option<usize>>,
    /// For objects that have been looked at, the frame to which their children are attached.
    known: BTreeMap<tatu_object, Option<usize>>,
    bodies: Vec<Body>,
    /// The shape of each body.
    pub shapes: Vec<tatu_object>,
}

impl<'w> Mechanism<'w> {
    pub fn new(world: World<'w>, props: &'w Planning, spaces: &'w [ObjectSpace]) -> Result<Self> {
        let (frames, known) = (FrameTree::default(), BTreeMap::new());
        let (present, parents, bodies, shapes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut all = Mechanism { world, props, spaces, frames, present, parents, known, bodies, shapes };
        for space in spaces {
            all.frame_of(space.object, 0)?;
        }
        Ok(all)
    }

    fn pose(&self, object: tatu_object) -> Result<Isometry3<f64>> {
        Ok(pose_of(self.world.pose(object, 0)?))
    }

    fn parent(&self, object: tatu_object) -> Result<Option<tatu_object>> {
        let parent = self.world.get(object, self.props.parent)?.as_object().unwrap_or(0);
        if parent == 0 { Ok(None) } else { Ok(Some(self.world.look(parent)?.id)) }
    }

    /// Adds a frame: its pose before its motion in the world, and its present pose.
    fn add(
        &mut self,
        parent: Option<usize>,
        before: &Isometry3<f64>,
        motion: FrameMotion,
        present: Isometry3<f64>,
    ) -> Option<usize> {
        let above = parent.map_or_else(Isometry3::identity, |p| self.present[p]);
        let frame = self.frames.add(MovingFrame { parent, pose: above.inverse() * before, motion });
        self.present.push(present);
        self.parents.push(parent);
        frame
    }

    /// Returns the frame to which an object, if it is moved itself, and otherwise its parent is attached.
    pub fn frame_of(&mut self, object: tatu_object, depth: usize) -> Result<Option<usize>> {
        if let Some(known) = self.known.get(&object) {
            return Ok(*known);
        }
        if depth > MAX_DEPTH {
            return Err(Fail::new("the objects of the scene are nested too deeply"));
        }
        let mut first = 0;
        let mut own = None;
        for space in self.spaces {
            if space.object == object {
                own = Some((space, first));
            }
            first += space.kind.dimension();
        }
        let frame = match own {
            Some((space, first)) if !space.kind.is_joint() => self.moved_object(space, first, depth)?,
            Some((_, first)) => self.joint(object, first, 1.0, 0.0, depth)?,
            None => {
                let above = match self.parent(object)? {
                    Some(parent) => self.frame_of(parent, depth + 1)?,
                    None => None,
                };
                self.follower(object, above, depth)?
            }
        };
        self.known.insert(object, frame);
        Ok(frame)
    }

    fn moved_object(&mut self, space: &ObjectSpace, first: usize, depth: usize) -> Result<Option<usize>> {
        let present = self.pose(space.object)?;
        let (reference, base) = match space.reference {
            Some(object) => (self.frame_of(object, depth + 1)?, self.pose(object)?),
            None => (None, Isometry3::identity()),
        };
        // The reference is an object: states are relative to its pose, which its own frame moves.
        let holder = self.add(reference, &base, FrameMotion::Fixed, base);
        let pose = base.inverse() * present;
        Ok(match space.kind {
            SpaceKind::Pose3 => self.add(holder, &base, FrameMotion::Pose { first }, present),
            SpaceKind::Position3 | SpaceKind::Position2 => {
                let count = space.kind.dimension();
                self.add(holder, &present, FrameMotion::Place { first, count }, present)
            }
            _ => {
                let (tilt, _) = euler_parts(&pose.rotation);
                let placed = base * Isometry3::from_parts(pose.translation, tilt);
                let place = self.add(holder, &placed, FrameMotion::Place { first, count: 2 }, placed);
                let motion = FrameMotion::Turn { number: first + 2, factor: 1.0, offset: 0.0, lead: 0.0 };
                self.add(place, &placed, motion, present)
            }
        })
    }

    fn joint(
        &mut self,
        object: tatu_object,
        number: usize,
        factor: f64,
        offset: f64,
        depth: usize,
    ) -> Result<Option<usize>> {
        let above = match self.parent(object)? {
            Some(parent) => self.frame_of(parent, depth + 1)?,
            None => None,
        };
        let before = self.pose(object)?;
        let position = self.world.f64(object, self.props.joint_position)?;
        let slides = self.world.get(object, self.props.joint_type)?.as_str().as_deref() == Some("prismatic");
        if slides {
            let present = before * Isometry3::translation(0.0, 0.0, position);
            return Ok(self.add(above, &before, FrameMotion::Slide { number, factor, offset }, present));
        }
        let lead = self.world.f64(object, self.props.joint_lead).unwrap_or(0.0) / TURN;
        let turned = Isometry3::from_parts(
            Translation3::new(0.0, 0.0, lead * position),
            UnitQuaternion::from_scaled_axis(Vector3::z() * position),
        );
        Ok(self.add(above, &before, FrameMotion::Turn { number, factor, offset, lead }, before * turned))
    }

    /// Returns the frame of an object that no number moves itself: that of a joint that follows one that is moved, or
    /// the one above.
    fn follower(&mut self, object: tatu_object, above: Option<usize>, depth: usize) -> Result<Option<usize>> {
        if self.world.look(object)?.kind != TATU_KIND_JOINT {
            return Ok(above);
        }
        let path = self.world.get(object, self.props.joint_follows)?.as_str().unwrap_or_default().into_owned();
        let Some(master) = (!path.is_empty()).then(|| self.world.find(object, &path)).and_then(|r| r.ok()) else {
            return Ok(above);
        };
        let master = self.world.look(master)?.id;
        let mut first = 0;
        for space in self.spaces {
            if space.object == master && space.kind.is_joint() {
                let factor = self.world.f64(object, self.props.joint_follow_factor)?;
                let offset = self.world.f64(object, self.props.joint_follow_offset)?;
                return self.joint(object, first, factor, offset, depth);
            }
            first += space.kind.dimension();
        }
        Ok(above)
    }

    /// Returns the frame that carries an object, and the object's pose in it.
    pub fn attachment(&mut self, object: tatu_object) -> Result<(Option<usize>, Isometry3<f64>)> {
        let frame = self.frame_of(object, 0)?;
        let above = frame.map_or_else(Isometry3::identity, |f| self.present[f]);
        Ok((frame, above.inverse() * self.pose(object)?))
    }

    /// Attaches an object that is carried, though it is no child, to the frame of another one.
    pub fn carry(&mut self, object: tatu_object, by: tatu_object) -> Result {
        let frame = self.frame_of(by, 0)?;
        self.known.insert(object, frame);
        Ok(())
    }

    /// Adds a shape, once, and returns the index of its body, or `None` if the object is no shape.
    pub fn body(&mut self, object: tatu_object) -> Result<Option<usize>> {
        if let Some(known) = self.shapes.iter().position(|s| *s == object) {
            return Ok(Some(known));
        }
        if self.world.look(object)?.kind != TATU_KIND_SHAPE {
            return Ok(None);
        }
        let (frame, pose) = self.attachment(object)?;
        let forms: Vec<(Isometry3<f64>, Form)> =
            forms_of(&self.world, self.props, object)?.into_iter().map(|(own, form)| (pose * own, form)).collect();
        self.shapes.push(object);
        self.bodies.push(Body { frame, forms });
        Ok(Some(self.bodies.len() - 1))
    }

    pub fn frame_of_body(&self, body: usize) -> Option<usize> {
        self.bodies[body].frame
    }

    /// Returns whether two frames are the same, or one carries the other; `None` is what stays.
    pub fn are_neighbours(&self, a: Option<usize>, b: Option<usize>) -> bool {
        let above = |frame: Option<usize>| frame.map(|f| self.parents[f]);
        a == b || above(a) == Some(b) || above(b) == Some(a)
    }

    /// Returns whether the exact forms of two bodies touch, for the poses of all frames.
    pub fn is_touching(&self, pair: [usize; 2], poses: &[Isometry3<f64>]) -> bool {
        let [a, b] = pair.map(|i| {
            let body = &self.bodies[i];
            let pose = body.frame.and_then(|f| poses.get(f)).copied().unwrap_or_else(Isometry3::identity);
            (PreparedSolid::new(&parts_of(&body.forms)), pose)
        });
        a.0.is_touching(&a.1, &b.0, &b.1)
    }

    /// Returns a test in which these pairs of bodies may not touch, nor come nearer than a margin, m, if one of them
    /// stays and is not among `own`, the bodies of the robot.
    pub fn checker(
        &self,
        pairs: &[[usize; 2]],
        (margin, own): (f64, &[usize]),
        cache: &mut SphereCache,
    ) -> BodyChecker<ExactTest> {
        let exact = |(i, b): (usize, &Body)| {
            let (parts, stays) = (parts_of(&b.forms), b.frame.is_none() && !own.contains(&i));
            ExactBody { parts, prepared: OnceCell::new(), stays }
        };
        let test = ExactTest { bodies: self.bodies.iter().enumerate().map(exact).collect(), margin };
        BodyChecker::confirmed(self.frames.clone(), &self.bodies, pairs, cache, test).with_margin(margin)
    }
}

/// A body whose exact form is prepared when it is first needed: most are never tested exactly.
struct ExactBody {
    parts: Vec<SolidPart>,
    prepared: OnceCell<PreparedSolid>,
    /// Whether it is an obstacle that stays.
    stays: bool,
}

impl ExactBody {
    fn solid(&self) -> &PreparedSolid {
        self.prepared.get_or_init(|| PreparedSolid::new(&self.parts))
    }
}

/// Tests the exact forms of bodies, as `sim.checkCollision` does.
pub struct ExactTest {
    bodies: Vec<ExactBody>,
    margin: f64,
}

impl Confirm for ExactTest {
    fn is_touching(&mut self, [a, b]: [usize; 2], poses: [&Isometry3<f64>; 2]) -> bool {
        let (first, second) = (&self.bodies[a], &self.bodies[b]);
        let margin = if first.stays != second.stays { self.margin } else { 0.0 };
        first.solid().is_within(margin, poses[0], second.solid(), poses[1])
    }
}
