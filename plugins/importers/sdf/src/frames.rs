//! The frames of a file: those of models, links, joints and of elements `<frame>`, and their poses relative to each other.
//!
//! Full names have the names of the models around in front: `robot::arm::hand`. The world's frame has an empty name.

use std::{cell::RefCell, collections::BTreeMap};

use nalgebra::Isometry3;
use tatu_importers_robots::Element;
use tatu_plugin_api::safe::{Fail, Result};

/// Maximum number of frames from one to the world's.
const MAX_DEPTH: usize = 500;

/// The number of a frame.
pub type FrameIndex = usize;

/// The world's frame.
pub const WORLD: FrameIndex = 0;

/// What a frame belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameKind {
    World,
    /// A model, with its canonical link.
    Model(Option<FrameIndex>),
    /// A link, with its number.
    Link(usize),
    /// A joint, or an element `<frame>`, which is attached to another frame.
    Attached,
}

/// A frame. The names of others are resolved when they are needed, since they may follow in the file.
#[derive(Debug)]
struct Frame {
    kind: FrameKind,
    /// Pose relative to the frame `base`.
    pose: Isometry3<f64>,
    base: FrameReference,
    /// The frame to which it is attached.
    attached_to: FrameReference,
    /// For models: the frame of the model that is put at the pose.
    placement: Option<FrameReference>,
    line: u64,
}

/// A frame by its number, or by its name in a scope.
#[derive(Debug, Clone, PartialEq)]
pub enum FrameReference {
    Known(FrameIndex),
    Named(ModelScope, String),
}

/// The model in which names are looked up.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelScope {
    /// What precedes the names in it.
    pub prefix: String,
    /// The frame of the model.
    pub model: FrameIndex,
}

/// All frames.
pub struct FrameTable {
    frames: Vec<Frame>,
    /// The poses of models with placement frames that have been computed, since each may depend on those inside.
    placed: RefCell<BTreeMap<FrameIndex, Isometry3<f64>>>,
    by_name: BTreeMap<String, FrameIndex>,
}

/// Where an element `<pose>` puts something.
pub struct StatedPose {
    pub pose: Isometry3<f64>,
    /// The name of the frame to which it is relative.
    pub relative_to: Option<String>,
}

impl StatedPose {
    /// Reads the pose of an element. Without one, it is the identity.
    pub fn read(element: &Element) -> Result<StatedPose> {
        let Some(tag) = element.child("pose") else {
            return Ok(StatedPose { pose: Isometry3::identity(), relative_to: None });
        };
        let named = tag.attribute("relative_to").or_else(|| tag.attribute("frame")).filter(|name| !name.is_empty());
        Ok(StatedPose { pose: tag.own_pose()?, relative_to: named.map(str::to_owned) })
    }
}

impl FrameTable {
    /// Creates the table with the world's frame.
    pub fn new() -> Self {
        let world = FrameReference::Known(WORLD);
        let frame = Frame {
            kind: FrameKind::World,
            pose: Isometry3::identity(),
            base: world.clone(),
            attached_to: world,
            placement: None,
            line: 0,
        };
        FrameTable { frames: vec![frame], placed: RefCell::default(), by_name: BTreeMap::new() }
    }

    /// Adds a frame. `scope` is the one in which the names are looked up. Returns its number.
    pub fn add(
        &mut self,
        name: Option<String>,
        kind: FrameKind,
        stated: StatedPose,
        (default, scope): (FrameReference, &ModelScope),
        line: u64,
    ) -> FrameIndex {
        let base = match stated.relative_to {
            Some(name) => FrameReference::Named(scope.clone(), name),
            None => default.clone(),
        };
        let index = self.frames.len();
        self.frames.push(Frame { kind, pose: stated.pose, base, attached_to: default, placement: None, line });
        if let Some(name) = name {
            // Old files give a link and a joint the same name; the link, which comes first, has the frame.
            self.by_name.entry(name).or_insert(index);
        }
        index
    }

    /// Returns whether a full name is in use.
    pub fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Sets the canonical link of a model.
    pub fn set_canonical(&mut self, model: FrameIndex, link: Option<FrameIndex>) {
        self.frames[model].kind = FrameKind::Model(link);
    }

    /// Lets a frame of a model be the one that is put at the model's pose.
    pub fn set_placement(&mut self, model: FrameIndex, frame: FrameReference) {
        self.frames[model].placement = Some(frame);
    }

    /// Finds a frame.
    pub fn find(&self, reference: &FrameReference) -> Option<FrameIndex> {
        match reference {
            FrameReference::Known(index) => Some(*index),
            FrameReference::Named(scope, name) => match name.as_str() {
                "__model__" => Some(scope.model),
                "world" | "__root__" => Some(WORLD),
                // Before 1.8, names could have the name of their own model in front.
                _ => {
                    let full = format!("{}{name}", scope.prefix);
                    let without = || {
                        let own = scope.prefix.strip_suffix("::")?.rsplit("::").next()?;
                        Some(format!("{}{}", scope.prefix, name.strip_prefix(own)?.strip_prefix("::")?))
                    };
                    let of = |name: &str| self.by_name.get(name).copied();
                    of(&full).or_else(|| of(&without()?))
                }
            },
        }
    }

    fn required(&self, reference: &FrameReference, line: u64) -> Result<FrameIndex> {
        self.find(reference).ok_or_else(|| {
            let name = match reference {
                FrameReference::Named(_, name) => name.as_str(),
                FrameReference::Known(_) => "",
            };
            Fail::argument(format!("there is no link, joint, model or frame named `{name}`")).at("", line)
        })
    }

    /// Returns the pose of a frame in the world.
    pub fn world(&self, frame: FrameIndex) -> Result<Isometry3<f64>> {
        self.relative(frame, WORLD, 0)
    }

    /// Returns the pose of a frame relative to another.
    pub fn between(&self, from: FrameIndex, to: FrameIndex) -> Result<Isometry3<f64>> {
        // A frame inside of a model does not depend on where the model is.
        match self.relative(to, from, 0) {
            Ok(pose) => Ok(pose),
            Err(_) => Ok(self.world(from)?.inverse() * self.world(to)?),
        }
    }

    /// Returns the pose of a frame relative to one of those that it is relative to.
    fn relative(&self, frame: FrameIndex, origin: FrameIndex, depth: usize) -> Result<Isometry3<f64>> {
        let (mut pose, mut at) = (Isometry3::identity(), frame);
        for step in depth..MAX_DEPTH {
            if at == origin {
                return Ok(pose);
            }
            if at == WORLD {
                break;
            }
            let own = &self.frames[at];
            pose = self.placed(at, step)? * pose;
            at = self.required(&own.base, own.line)?;
        }
        let line = self.frames[frame].line;
        let text =
            if at == WORLD { "a pose depends on a frame outside of its model" } else { "poses depend on each other" };
        Err(Fail::argument(text).at("", line))
    }

    /// Returns the pose of a frame in its base, with the placement frame of a model at the stated pose.
    fn placed(&self, frame: FrameIndex, depth: usize) -> Result<Isometry3<f64>> {
        let own = &self.frames[frame];
        let Some(placement) = &own.placement else { return Ok(own.pose) };
        if let Some(known) = self.placed.borrow().get(&frame) {
            return Ok(*known);
        }
        let inside = self.required(placement, own.line)?;
        let pose = own.pose * self.relative(inside, frame, depth + 1)?.inverse();
        self.placed.borrow_mut().insert(frame, pose);
        Ok(pose)
    }

    /// Returns the link to which a frame is attached; `None` for the world.
    pub fn link(&self, frame: FrameIndex) -> Result<Option<usize>> {
        let mut at = frame;
        for _ in 0..MAX_DEPTH {
            let own = &self.frames[at];
            at = match own.kind {
                FrameKind::World => return Ok(None),
                FrameKind::Link(link) => return Ok(Some(link)),
                FrameKind::Model(Some(canonical)) => canonical,
                FrameKind::Model(None) => {
                    return Err(Fail::argument("a frame is attached to a model without links").at("", own.line));
                }
                FrameKind::Attached => self.required(&own.attached_to, own.line)?,
            };
        }
        Err(Fail::argument("frames are attached to each other in a circle").at("", self.frames[frame].line))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::xml::parse;

    #[test]
    fn poses_are_read_in_all_notations() {
        let read = |text: &str| StatedPose::read(&parse(&format!("<a>{text}</a>"), 0).unwrap()).map(|p| p.pose);
        let wanted = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::z() * std::f64::consts::FRAC_PI_2);
        for text in [
            "<pose>1 2 3 0 0 1.5707963267948966</pose>",
            "<pose degrees='true'>1 2 3 0 0 90</pose>",
            "<pose rotation_format='quat_xyzw'>1 2 3 0 0 1 1</pose>",
        ] {
            assert!((read(text).unwrap().to_homogeneous() - wanted.to_homogeneous()).norm() < 1e-15, "{text}");
        }
        assert_eq!(read("<pose/>").unwrap(), Isometry3::identity());
        for flawed in
            ["<pose>1 2 3</pose>", "<pose>a</pose>", "<pose>1e13 0 0 0 0 0</pose>", "<pose>nan 0 0 0 0 0</pose>"]
        {
            assert!(read(flawed).is_err(), "{flawed}");
        }
    }

    #[test]
    fn frames_that_depend_on_each_other_are_an_error() {
        let mut table = FrameTable::new();
        let scope = ModelScope { prefix: String::new(), model: WORLD };
        let mut add = |name: &str, to: &str| {
            let stated = StatedPose { pose: Isometry3::translation(1.0, 0.0, 0.0), relative_to: Some(to.to_owned()) };
            let default = FrameReference::Named(scope.clone(), to.to_owned());
            table.add(Some(name.to_owned()), FrameKind::Attached, stated, (default, &scope), 7)
        };
        let (a, _, c, d, e) = (add("a", "b"), add("b", "a"), add("c", "d"), add("d", "world"), add("e", "x"));
        assert!(table.world(a).is_err() && table.link(a).is_err() && table.world(e).is_err());
        assert_eq!(table.world(c).unwrap().translation.x, 2.0);
        assert_eq!(table.between(d, c).unwrap().translation.x, 1.0);
        assert_eq!(table.link(c).unwrap(), None);
    }
}
