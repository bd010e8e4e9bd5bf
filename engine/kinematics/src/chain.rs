//! The joints that move given frames, compiled so that poses and Jacobians cost little and allocate nothing.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::linkage::{FrameId, JointType, Linkage};

/// Why joints cannot be compiled to a [`Chain`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChainError {
    /// No frames are given, or one does not exist.
    NoFrame,
    /// Frames are attached to each other in a circle.
    Cycle,
    /// This joint is spherical, which has no single position.
    Spherical(FrameId),
    /// A pose, limit, factor or lead is not finite.
    NotFinite(FrameId),
}

impl std::fmt::Display for ChainError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ChainError::NoFrame => write!(f, "there is no such frame"),
            ChainError::Cycle => write!(f, "frames are attached to each other in a circle"),
            ChainError::Spherical(id) => {
                write!(f, "joint {} is spherical; expected revolute or prismatic joints", id.0)
            }
            ChainError::NotFinite(id) => write!(f, "a value of frame {} is not finite", id.0),
        }
    }
}

impl std::error::Error for ChainError {}

/// How a column moves a segment: its position is `ratio` times that of the column, plus `offset`.
#[derive(Debug, Clone, Copy)]
struct SegmentJoint {
    column: usize,
    ratio: f64,
    offset: f64,
    /// `None` for a prismatic joint; otherwise the lead, m/rad.
    lead: Option<f64>,
}

/// A frame with a joint; frames without one are merged into the next segment.
#[derive(Debug, Clone)]
struct Segment {
    parent: Option<usize>,
    rotation: Matrix3<f64>,
    place: Vector3<f64>,
    joint: SegmentJoint,
    turned: Matrix3<f64>,
    at: Vector3<f64>,
}

/// A frame that shall reach a target.
#[derive(Debug, Clone)]
struct Tip {
    segment: Option<usize>,
    rotation: Matrix3<f64>,
    place: Vector3<f64>,
    /// Segments from this tip to the world, its own first.
    path: Vec<usize>,
}

/// The joints that move some frames, with their positions in one array: a column for each joint that is moved.
#[derive(Debug, Clone)]
pub struct Chain {
    segments: Vec<Segment>,
    tips: Vec<Tip>,
    columns: Vec<FrameId>,
    limits: Vec<[f64; 2]>,
    turns: Vec<bool>,
}

/// Maximum number of frames between a tip and the world; more are a cycle.
const MAX_DEPTH: usize = 10_000;

impl Chain {
    /// Compiles the joints above some frames. Joints with the role `Fixed` stay at their present positions; those that
    /// depend on another joint move with the column of that joint.
    ///
    /// # Errors
    ///
    /// Fails if there is no such frame, if a joint that moves is spherical, or if a value is not finite.
    pub fn new(linkage: &Linkage, tips: &[FrameId]) -> Result<Self, ChainError> {
        let mut chain = Chain { segments: vec![], tips: vec![], columns: vec![], limits: vec![], turns: vec![] };
        let mut compiled: Vec<(FrameId, usize)> = Vec::new();
        for tip in tips {
            chain.add_tip(linkage, *tip, &mut compiled)?;
        }
        if chain.tips.is_empty() { Err(ChainError::NoFrame) } else { Ok(chain) }
    }

    fn add_tip(
        &mut self,
        linkage: &Linkage,
        tip: FrameId,
        compiled: &mut Vec<(FrameId, usize)>,
    ) -> Result<(), ChainError> {
        if !linkage.contains(tip) {
            return Err(ChainError::NoFrame);
        }
        let mut above: Vec<FrameId> = linkage.above(tip).take(MAX_DEPTH).collect();
        if above.len() == MAX_DEPTH {
            return Err(ChainError::Cycle);
        }
        above.reverse();
        let (mut segment, mut pose) = (None, Isometry3::identity());
        let mut path = Vec::new();
        for id in above {
            pose *= linkage.local_pose(id);
            if !pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite()) {
                return Err(ChainError::NotFinite(id));
            }
            // The frame of the tip is that without the motion of its own joint.
            if id == tip {
                break;
            }
            let Some(joint) = linkage.joint(id) else { continue };
            let Some((ratio, column)) = self.column(linkage, id)? else {
                pose *= linkage.motion(id);
                continue;
            };
            if joint.kind == JointType::Spherical {
                return Err(ChainError::Spherical(id));
            }
            let index = match compiled.iter().find(|(other, _)| *other == id) {
                Some((_, index)) => *index,
                None => {
                    // The position is linear in that of the column.
                    let offset = linkage.position(id) - ratio * linkage.position(self.columns[column]);
                    if ![offset, ratio, joint.lead].iter().all(|x| x.is_finite()) {
                        return Err(ChainError::NotFinite(id));
                    }
                    let lead = (joint.kind == JointType::Revolute).then_some(joint.lead);
                    self.turns[column] &= lead == Some(0.0) && (ratio.fract() == 0.0);
                    self.segments.push(Segment {
                        parent: segment,
                        rotation: pose.rotation.to_rotation_matrix().into_inner(),
                        place: pose.translation.vector,
                        joint: SegmentJoint { column, ratio, offset, lead },
                        turned: Matrix3::identity(),
                        at: Vector3::zeros(),
                    });
                    compiled.push((id, self.segments.len() - 1));
                    self.segments.len() - 1
                }
            };
            path.push(index);
            (segment, pose) = (Some(index), Isometry3::identity());
        }
        path.reverse();
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        self.tips.push(Tip { segment, rotation, place: pose.translation.vector, path });
        Ok(())
    }

    /// Returns the ratio and the column of the joint that moves a joint, which is added if it is new.
    fn column(&mut self, linkage: &Linkage, id: FrameId) -> Result<Option<(f64, usize)>, ChainError> {
        let Some((mover, ratio)) = linkage.mover(id) else {
            let is_finite = linkage.position(id).is_finite();
            return if is_finite { Ok(None) } else { Err(ChainError::NotFinite(id)) };
        };
        if let Some(column) = self.columns.iter().position(|c| *c == mover) {
            return Ok(Some((ratio, column)));
        }
        let Some(joint) = linkage.joint(mover) else { return Ok(None) };
        let [low, high] = joint.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        if low.is_nan() || high.is_nan() || low > high || !joint.position.is_finite() {
            return Err(ChainError::NotFinite(mover));
        }
        self.columns.push(mover);
        self.limits.push([low, high]);
        self.turns.push(true);
        Ok(Some((ratio, self.columns.len() - 1)))
    }

    /// Returns the joints that are moved, from base to tip: one for each position.
    pub fn joints(&self) -> &[FrameId] {
        &self.columns
    }
    /// Returns the limits of the positions, rad or m; infinite if a joint has none.
    pub fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
    /// Returns whether a full turn of a joint changes nothing.
    pub(crate) fn repeats(&self, column: usize) -> bool {
        self.turns[column]
    }
    /// Returns the number of tips.
    pub fn tips(&self) -> usize {
        self.tips.len()
    }

    /// Computes the poses of all segments.
    pub fn place(&mut self, q: &[f64]) {
        for i in 0..self.segments.len() {
            let (done, rest) = self.segments.split_at_mut(i);
            let own = &mut rest[0];
            let joint = own.joint;
            let position = joint.ratio * q[joint.column] + joint.offset;
            let (above, base) = match own.parent {
                Some(parent) => (done[parent].turned * own.rotation, done[parent].at + done[parent].turned * own.place),
                None => (own.rotation, own.place),
            };
            match joint.lead {
                Some(lead) => {
                    let (sine, cosine) = libm::sincos(position);
                    let (x, y, z) = (above.column(0), above.column(1), above.column(2));
                    own.turned = Matrix3::from_columns(&[x * cosine + y * sine, y * cosine - x * sine, z.into_owned()]);
                    own.at = if lead == 0.0 { base } else { base + z * (lead * position) };
                }
                None => {
                    own.turned = above;
                    own.at = base + above.column(2) * position;
                }
            }
        }
    }

    /// Returns the rotation and the place of a tip, after [`place`](Self::place).
    pub(crate) fn tip(&self, tip: usize) -> (Matrix3<f64>, Vector3<f64>) {
        let own = &self.tips[tip];
        match own.segment.map(|s| &self.segments[s]) {
            Some(segment) => (segment.turned * own.rotation, segment.at + segment.turned * own.place),
            None => (own.rotation, own.place),
        }
    }

    /// Returns the pose of a tip in the world, m, after [`place`](Self::place); `None` if there is no such tip.
    pub fn pose(&self, tip: usize) -> Option<Isometry3<f64>> {
        (tip < self.tips.len()).then(|| {
            let (rotation, at) = self.tip(tip);
            let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
            Isometry3::from_parts(at.into(), turned)
        })
    }

    /// Calls `write` with each column that moves a tip, the velocity of the tip's origin and its angular velocity, both in
    /// world axes, for a velocity of 1 of the column.
    pub(crate) fn each_motion(&self, tip: usize, mut write: impl FnMut(usize, Vector3<f64>, Vector3<f64>)) {
        let at = self.tip(tip).1;
        for segment in self.tips[tip].path.iter().map(|i| &self.segments[*i]) {
            let axis: Vector3<f64> = segment.turned.column(2).into();
            let SegmentJoint { column, ratio, lead, .. } = segment.joint;
            match lead {
                Some(lead) => {
                    let linear = axis.cross(&(at - segment.at)) + axis * lead;
                    write(column, linear * ratio, axis * ratio);
                }
                None => write(column, axis * ratio, Vector3::zeros()),
            }
        }
    }

    /// Returns the place of the first joint that moves a tip, after [`place`](Self::place).
    pub(crate) fn root(&self, tip: usize) -> Option<Vector3<f64>> {
        self.tips[tip].path.last().map(|i| self.segments[*i].at)
    }
}
