//! The frames of a mechanism, for eight states at once.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use super::lanes::{LANES, Lane, LanePose, sines_and_cosines};

/// How a frame moves with the numbers of a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameMotion {
    /// It is fixed to its parent.
    Fixed,
    /// It turns about its z axis, by `factor` times a number of the state plus `offset`, rad, and moves along it by
    /// `lead` for each rad.
    Turn {
        /// Which number of the state.
        number: usize,
        /// See above.
        factor: f64,
        /// See above.
        offset: f64,
        /// See above; m/rad.
        lead: f64,
    },
    /// It moves along its z axis, by `factor` times a number of the state plus `offset`, m.
    Slide {
        /// Which number of the state.
        number: usize,
        /// See above.
        factor: f64,
        /// See above.
        offset: f64,
    },
    /// Its position in the parent is two or three numbers of the state; with two, z is that of its pose.
    Place {
        /// The first of the numbers.
        first: usize,
        /// How many: 2 or 3.
        count: usize,
    },
    /// Its pose in the parent is seven numbers of the state: x y z, and a quaternion x y z w.
    Pose {
        /// The first of the numbers.
        first: usize,
    },
}

/// A frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingFrame {
    /// The frame to whose motion it is attached: one before it in the tree; `None`: the world.
    pub parent: Option<usize>,
    /// Its pose in the parent, before its own motion.
    pub pose: Isometry3<f64>,
    /// Its own motion.
    pub motion: FrameMotion,
}

/// Frames, of which parents come before their children.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameTree {
    frames: Vec<MovingFrame>,
    /// Their poses in their parents, by rows of the rotation, then the translation.
    local: Vec<[f64; 12]>,
}

impl FrameTree {
    /// Adds a frame, and returns its number, or `None` if its parent does not exist.
    pub fn add(&mut self, frame: MovingFrame) -> Option<usize> {
        if frame.parent.is_some_and(|p| p >= self.frames.len()) {
            return None;
        }
        let (r, t) = (frame.pose.rotation.to_rotation_matrix(), frame.pose.translation);
        let r = r.matrix();
        self.local.push(std::array::from_fn(|i| if i < 9 { r[(i / 3, i % 3)] } else { t.vector[i - 9] }));
        self.frames.push(frame);
        Some(self.frames.len() - 1)
    }

    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Returns whether there are no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Returns the count of numbers that a state must have.
    pub fn dimension(&self) -> usize {
        let need = |f: &MovingFrame| match f.motion {
            FrameMotion::Fixed => 0,
            FrameMotion::Turn { number, .. } | FrameMotion::Slide { number, .. } => number + 1,
            FrameMotion::Place { first, count } => first + count,
            FrameMotion::Pose { first } => first + 7,
        };
        self.frames.iter().map(need).max().unwrap_or(0)
    }

    /// Returns the poses of all frames in the world, for one state.
    pub fn poses(&self, state: &[f64]) -> Vec<Isometry3<f64>> {
        let columns: Vec<Lane> = state.iter().map(|x| [*x; LANES]).collect();
        let mut poses = Vec::new();
        self.lane_poses(&columns, &mut poses);
        poses.iter().map(|p| pose_of(p, 0)).collect()
    }

    /// Computes the poses of all frames; `columns` has the numbers of the states.
    #[inline(always)]
    pub(super) fn lane_poses(&self, columns: &[Lane], out: &mut Vec<LanePose>) {
        out.clear();
        for (frame, local) in self.frames.iter().zip(&self.local) {
            let parent = frame.parent.map_or(LanePose::IDENTITY, |p| out[p]);
            let mut pose = attached(&parent, local);
            match frame.motion {
                FrameMotion::Fixed => {}
                FrameMotion::Turn { number, factor, offset, lead } => {
                    let mut angles = columns[number];
                    for angle in &mut angles {
                        *angle = *angle * factor + offset;
                    }
                    if lead != 0.0 {
                        slide(&mut pose, &angles, lead);
                    }
                    turn(&mut pose, &angles);
                }
                FrameMotion::Slide { number, factor, offset } => {
                    let mut lengths = columns[number];
                    for length in &mut lengths {
                        *length = *length * factor + offset;
                    }
                    slide(&mut pose, &lengths, 1.0);
                }
                FrameMotion::Place { first, count } => {
                    let place =
                        std::array::from_fn(|i| if i < count { columns[first + i] } else { [local[9 + i]; LANES] });
                    pose.translation = placed(&parent, &place);
                }
                FrameMotion::Pose { first } => {
                    pose.translation = placed(&parent, &[columns[first], columns[first + 1], columns[first + 2]]);
                    let own =
                        rotations(&[columns[first + 3], columns[first + 4], columns[first + 5], columns[first + 6]]);
                    for row in 0..3 {
                        for column in 0..3 {
                            for l in 0..LANES {
                                pose.rotation[3 * row + column][l] = (parent.rotation[3 * row][l] * own[column][l]
                                    + parent.rotation[3 * row + 1][l] * own[3 + column][l])
                                    + parent.rotation[3 * row + 2][l] * own[6 + column][l];
                            }
                        }
                    }
                }
            }
            out.push(pose);
        }
    }
}

/// Returns the pose of one of the states.
pub(super) fn pose_of(pose: &LanePose, lane: usize) -> Isometry3<f64> {
    let r = Matrix3::from_fn(|row, column| pose.rotation[3 * row + column][lane]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r));
    let [x, y, z] = pose.translation.map(|lane_values| lane_values[lane]);
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

#[inline(always)]
fn attached(parent: &LanePose, local: &[f64; 12]) -> LanePose {
    let mut out = LanePose { rotation: parent.rotation, translation: parent.translation };
    for row in 0..3 {
        let [a, b, c] = [parent.rotation[3 * row], parent.rotation[3 * row + 1], parent.rotation[3 * row + 2]];
        for column in 0..3 {
            for l in 0..LANES {
                out.rotation[3 * row + column][l] =
                    (a[l] * local[column] + b[l] * local[3 + column]) + c[l] * local[6 + column];
            }
        }
        for l in 0..LANES {
            out.translation[row][l] += (a[l] * local[9] + b[l] * local[10]) + c[l] * local[11];
        }
    }
    out
}

#[inline(always)]
fn placed(parent: &LanePose, place: &[Lane; 3]) -> [Lane; 3] {
    let mut out = parent.translation;
    for row in 0..3 {
        for l in 0..LANES {
            out[row][l] += (parent.rotation[3 * row][l] * place[0][l] + parent.rotation[3 * row + 1][l] * place[1][l])
                + parent.rotation[3 * row + 2][l] * place[2][l];
        }
    }
    out
}

#[inline(always)]
fn turn(pose: &mut LanePose, angles: &Lane) {
    let (sines, cosines) = sines_and_cosines(angles);
    for row in 0..3 {
        for l in 0..LANES {
            let (x, y) = (pose.rotation[3 * row][l], pose.rotation[3 * row + 1][l]);
            pose.rotation[3 * row][l] = x * cosines[l] + y * sines[l];
            pose.rotation[3 * row + 1][l] = y * cosines[l] - x * sines[l];
        }
    }
}

#[inline(always)]
fn slide(pose: &mut LanePose, lengths: &Lane, factor: f64) {
    for row in 0..3 {
        for l in 0..LANES {
            pose.translation[row][l] += pose.rotation[3 * row + 2][l] * (lengths[l] * factor);
        }
    }
}

/// Returns the rotation matrices of quaternions x y z w, which are normalised.
#[inline(always)]
fn rotations(q: &[Lane; 4]) -> [Lane; 9] {
    let mut out = [[0.0; LANES]; 9];
    for l in 0..LANES {
        let [x, y, z, w] = [q[0][l], q[1][l], q[2][l], q[3][l]];
        let s = 2.0 / (x * x + y * y + z * z + w * w);
        let rows = [
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (x * z + y * w),
            s * (x * y + z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z - x * w),
            s * (x * z - y * w),
            s * (y * z + x * w),
            1.0 - s * (x * x + y * y),
        ];
        for (o, value) in out.iter_mut().zip(rows) {
            o[l] = value;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use nalgebra::{Quaternion, Vector3};

    use super::*;

    fn turned(angle: f64) -> Isometry3<f64> {
        Isometry3::rotation(Vector3::z() * angle)
    }

    #[test]
    fn poses_agree_with_products_of_isometries() {
        let a = Isometry3::new(Vector3::new(0.1, -0.4, 0.3), Vector3::new(0.3, 1.0, -0.2));
        let b = Isometry3::new(Vector3::new(-0.2, 0.5, 0.1), Vector3::new(-1.3, 0.4, 0.6));
        let mut tree = FrameTree::default();
        let mut add = |parent, pose, motion| tree.add(MovingFrame { parent, pose, motion }).unwrap();
        let base = add(None, a, FrameMotion::Turn { number: 0, factor: 2.0, offset: 0.1, lead: 0.05 });
        let slider = add(Some(base), b, FrameMotion::Slide { number: 1, factor: 1.0, offset: 0.0 });
        add(Some(slider), a, FrameMotion::Fixed);
        add(Some(base), b, FrameMotion::Place { first: 2, count: 2 });
        add(Some(base), b, FrameMotion::Pose { first: 2 });
        assert_eq!(tree.dimension(), 9);
        let state = [0.7, -0.3, 1.0, 2.0, 3.0, 0.5, -0.5, 0.1, 0.7];
        let angle = 2.0 * 0.7 + 0.1;
        let first = a * Isometry3::translation(0.0, 0.0, 0.05 * angle) * turned(angle);
        let second = first * b * Isometry3::translation(0.0, 0.0, -0.3);
        let place = Isometry3::from_parts(Translation3::new(1.0, 2.0, b.translation.z), b.rotation);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(0.7, 0.5, -0.5, 0.1));
        let pose = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), rotation);
        let expected = [first, second, second * a, first * place, first * pose];
        for (own, other) in tree.poses(&state).iter().zip(expected) {
            assert!((own.to_homogeneous() - other.to_homogeneous()).norm() < 1e-12);
        }
        assert_eq!(tree.add(MovingFrame { parent: Some(9), pose: a, motion: FrameMotion::Fixed }), None);
    }
}
