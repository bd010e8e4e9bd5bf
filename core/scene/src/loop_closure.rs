//! Detection of loops that linked dummies cannot close. A link constrains all six degrees of freedom, so the joints
//! between two dummies must be able to bring them together in position and orientation. Otherwise a gap remains, and
//! the engine applies forces in every step to close it.

use nalgebra::{DMatrix, DVector, Isometry3, Translation3, UnitQuaternion, Vector3, Vector6};
use tatu_physics::MotionType;

use super::{
    JointType, ObjectVariant, Scene,
    body_rules::{motion_of, tie_of},
    dynamics::links,
};

/// Maximum gap of a closed loop, m and rad.
const CLOSED_GAP_TOLERANCES: (f64, f64) = (1e-3, 1e-2);
/// Number of starting points of the search, each a set of joint positions, and maximum number of iterations from each.
const SEARCH_STARTS: usize = 8;
const MAX_SEARCH_STEPS: usize = 60;

/// A degree of freedom of a joint: its axis in the world frame, and its range of motion relative to the joint's current
/// position.
struct DegreeOfFreedom {
    origin: Vector3<f64>,
    axis: Vector3<f64>,
    /// Rotation (rad) and translation (m) per unit of joint position.
    turns: f64,
    slides: f64,
    limits: (f64, f64),
}

/// The joints from a fixed body, or from the body that both chains share, to a dummy.
struct JointChain {
    freedoms: Vec<DegreeOfFreedom>,
    end: Isometry3<f64>,
}

/// Returns the joints and force sensors that connect the shapes above a dummy, topmost first, and the topmost of these
/// shapes if it is dynamic. Returns `None` if no shape above the dummy has a body.
fn ties(scene: &Scene, dummy: u32) -> Option<(Vec<u32>, Option<u32>)> {
    let mut shape = scene.get(dummy)?.parent;
    while motion_of(scene, shape).is_none() {
        shape = scene.get(shape)?.parent;
    }
    let mut all = Vec::new();
    while let Some((above, tie)) = tie_of(scene, shape) {
        all.insert(0, tie);
        shape = above;
    }
    Some((all, (motion_of(scene, shape) == Some(MotionType::Dynamic)).then_some(shape)))
}

fn freedoms(scene: &Scene, tie: u32) -> Vec<DegreeOfFreedom> {
    let Some(ObjectVariant::Joint(j)) = scene.get(tie).map(|o| &o.data) else { return Vec::new() };
    let frame = scene.world(tie);
    let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let free = |axis: Vector3<f64>, turns: f64, slides: f64, limits| DegreeOfFreedom {
        origin: frame.translation.vector,
        axis: frame.rotation * axis,
        turns,
        slides,
        limits,
    };
    let limits = (low - j.position, high - j.position);
    match j.kind {
        JointType::Revolute => vec![free(Vector3::z(), 1.0, j.lead_per_radian(), limits)],
        JointType::Prismatic => vec![free(Vector3::z(), 0.0, 1.0, limits)],
        JointType::Spherical => {
            let all = (f64::NEG_INFINITY, f64::INFINITY);
            [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| free(axis, 1.0, 0.0, all)).into()
        }
    }
}

impl JointChain {
    /// Returns the pose of the end at the joint displacements `q`, and its Jacobian: the linear and angular velocity
    /// per unit velocity of each degree of freedom.
    fn at(&self, q: &[f64]) -> (Isometry3<f64>, Vec<Vector6<f64>>) {
        let (mut moved, mut axes) = (Isometry3::identity(), Vec::new());
        for (f, q) in self.freedoms.iter().zip(q) {
            axes.push((moved * nalgebra::Point3::from(f.origin), moved.rotation * f.axis));
            let turn = UnitQuaternion::from_scaled_axis(f.axis * (f.turns * q));
            let about = f.origin - turn * f.origin;
            moved *= Isometry3::from_parts(Translation3::from(about + f.axis * (f.slides * q)), turn);
        }
        let end = moved * self.end;
        let columns = axes.iter().zip(&self.freedoms).map(|((origin, axis), f)| {
            let linear = axis.cross(&(end.translation.vector - origin.coords)) * f.turns + axis * f.slides;
            let angular = axis * f.turns;
            Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
        });
        let columns = columns.collect();
        (end, columns)
    }
}

/// A translation (m) and a rotation vector (rad) in the world frame.
type PoseGap = (Vector3<f64>, Vector3<f64>);

/// Returns the gap from the first pose to the second.
fn gap(a: &Isometry3<f64>, b: &Isometry3<f64>) -> PoseGap {
    (b.translation.vector - a.translation.vector, (b.rotation * a.rotation.inverse()).scaled_axis())
}

fn is_closed((way, turn): &PoseGap) -> bool {
    way.norm() <= CLOSED_GAP_TOLERANCES.0 && turn.norm() <= CLOSED_GAP_TOLERANCES.1
}

/// Returns the smallest gap found by moving the joints within their limits (Levenberg-Marquardt).
fn smallest_gap(chains: &[JointChain; 2], reach: f64) -> PoseGap {
    let first = chains[0].freedoms.len();
    let all: Vec<&DegreeOfFreedom> = chains.iter().flat_map(|c| &c.freedoms).collect();
    let look = |q: &DVector<f64>| {
        let (a, ways_a) = chains[0].at(&q.as_slice()[..first]);
        let (b, ways_b) = chains[1].at(&q.as_slice()[first..]);
        let (way, turn) = gap(&a, &b);
        let rest = Vector6::new(way.x, way.y, way.z, turn.x * reach, turn.y * reach, turn.z * reach);
        let columns = ways_a.iter().map(|w| -w).chain(ways_b);
        let scaled = columns.map(|w| Vector6::new(w[0], w[1], w[2], w[3] * reach, w[4] * reach, w[5] * reach));
        ((way, turn), rest, scaled.collect::<Vec<_>>())
    };
    let within = |mut q: DVector<f64>| {
        q.iter_mut().zip(&all).for_each(|(q, f)| *q = q.max(f.limits.0).min(f.limits.1));
        q
    };
    let mut best: Option<(f64, PoseGap)> = None;
    for start in 0..SEARCH_STARTS {
        // The search starts from the current positions, then from positions spread over a full turn or the reach of the
        // loop.
        let spread = |i: usize| ((start * (2 * i + 3)) % SEARCH_STARTS) as f64 / SEARCH_STARTS as f64 - 0.5;
        let from = |(i, f): (usize, &&DegreeOfFreedom)| match start {
            0 => 0.0,
            _ => spread(i) * if f.turns > 0.0 { std::f64::consts::TAU } else { 2.0 * reach },
        };
        let mut q = within(DVector::from_iterator(all.len(), all.iter().enumerate().map(from)));
        let (mut left, mut rest, mut columns) = look(&q);
        let mut damping = 1e-3 * reach * reach;
        for _ in 0..MAX_SEARCH_STEPS {
            if is_closed(&left) || all.is_empty() {
                break;
            }
            let jacobian = DMatrix::from_fn(6, all.len(), |r, c| columns[c][r]);
            let square = jacobian.tr_mul(&jacobian) + DMatrix::from_diagonal_element(all.len(), all.len(), damping);
            let right = -jacobian.tr_mul(&DVector::from_column_slice(rest.as_slice()));
            let Some(step) = square.cholesky().map(|c| c.solve(&right)) else { break };
            let next = within(&q + step);
            let (l, r, c) = look(&next);
            if r.norm_squared() < rest.norm_squared() {
                (q, left, rest, columns) = (next, l, r, c);
                damping = (damping * 0.2).max(1e-12);
            } else {
                damping *= 10.0;
            }
        }
        let size = rest.norm_squared();
        // Among gaps of nearly equal size, the first is preferred, because its search started closest to the current
        // joint positions.
        if best.is_none_or(|(s, _)| size < 0.99 * s) {
            best = Some((size, left));
        }
        if is_closed(&left) {
            break;
        }
    }
    best.map_or((Vector3::zeros(), Vector3::zeros()), |(_, left)| left)
}

/// Returns the names of the world axes along which a vector has a component of more than 10 % of its length.
fn axes(v: &Vector3<f64>) -> String {
    let named: Vec<&str> =
        ["x", "y", "z"].into_iter().zip(v.iter()).filter(|(_, x)| x.abs() > 0.1 * v.norm()).map(|(n, _)| n).collect();
    named.join(", ")
}

impl Scene {
    /// Returns one message for each pair of linked dummies for which no joint positions that bring them together were
    /// found.
    pub fn open_loops(&self) -> Vec<String> {
        links(self).into_iter().filter_map(|pair| self.open_loop(pair)).collect()
    }

    fn open_loop(&self, (one, other): (u32, u32)) -> Option<String> {
        let ends = [self.world(one), self.world(other)];
        if is_closed(&gap(&ends[0], &ends[1])) {
            return None;
        }
        let ((above_one, root_one), (above_other, root_other)) = (ties(self, one)?, ties(self, other)?);
        // A floating body can move to any required pose.
        if root_one != root_other {
            return None;
        }
        let chain = |own: &[u32], others: &[u32], end: Isometry3<f64>| JointChain {
            freedoms: own.iter().filter(|t| !others.contains(t)).flat_map(|t| freedoms(self, *t)).collect(),
            end,
        };
        let chains = [chain(&above_one, &above_other, ends[0]), chain(&above_other, &above_one, ends[1])];
        let all = || chains.iter().flat_map(|c| &c.freedoms);
        let away =
            |f: &DegreeOfFreedom| ends.iter().map(|e| (e.translation.vector - f.origin).norm()).fold(0.0, f64::max);
        let reach = all().map(away).fold(0.1, f64::max);
        let left = smallest_gap(&chains, reach);
        if is_closed(&left) {
            return None;
        }
        let mut parts = Vec::new();
        if left.0.norm() > CLOSED_GAP_TOLERANCES.0 {
            parts.push(format!("{:.4} m along {}", left.0.norm(), axes(&left.0)));
        }
        if left.1.norm() > CLOSED_GAP_TOLERANCES.1 {
            parts.push(format!("{:.4} rad about {}", left.1.norm(), axes(&left.1)));
        }
        Some(format!(
            "the linked dummies {} and {} cannot meet: at any position of the {} joint axes between them, a gap of {} \
             (world axes) remains; a link constrains position and orientation: rotate one of the dummies, or attach \
             one to an additional joint",
            self.path(one),
            self.path(other),
            all().count(),
            parts.join(" and ")
        ))
    }
}
