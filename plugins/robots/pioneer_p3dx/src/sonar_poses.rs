//! Positions and headings of the sonars, with the sources of `presets`.

/// x, y in the base frame, m; heading, degrees, left positive.
pub type Pose = [f64; 3];

/// V-REP's model, sensors 1 to 16. Numbers 2 and 3 do not exactly mirror 7 and 6; this is copied unchanged.
#[rustfmt::skip]
pub const AS_VREP: [Pose; 16] = [
    [ 0.1064,  0.1382,   90.0], [ 0.1554,  0.1250,   50.0], [ 0.1906,  0.0831,   30.0], [ 0.2092,  0.0273,   10.0],
    [ 0.2092, -0.0273,  -10.0], [ 0.1905, -0.0785,  -30.0], [ 0.1555, -0.1202,  -50.0], [ 0.1064, -0.1381,  -90.0],
    [-0.1103, -0.1382,  -90.0], [-0.1596, -0.1202, -130.0], [-0.1946, -0.0785, -150.0], [-0.2132, -0.0273, -170.0],
    [-0.2132,  0.0273,  170.0], [-0.1946,  0.0785,  150.0], [-0.1596,  0.1203,  130.0], [-0.1103,  0.1382,   90.0],
];

/// ARIA's `SonarUnit` 0 to 15 of the P3-DX: mm from the middle of the axle, and degrees.
#[rustfmt::skip]
const ARIA: [Pose; 16] = [
    [  69.0,  136.0,   90.0], [ 114.0,  119.0,   50.0], [ 148.0,   78.0,   30.0], [ 166.0,   27.0,   10.0],
    [ 166.0,  -27.0,  -10.0], [ 148.0,  -78.0,  -30.0], [ 114.0, -119.0,  -50.0], [  69.0, -136.0,  -90.0],
    [-157.0, -136.0,  -90.0], [-203.0, -119.0, -130.0], [-237.0,  -78.0, -150.0], [-255.0,  -27.0, -170.0],
    [-255.0,   27.0,  170.0], [-237.0,   78.0,  150.0], [-203.0,  119.0,  130.0], [-157.0,  136.0,   90.0],
];

/// Returns ARIA's table in the base frame, whose origin is `axle_x` behind the axle.
pub fn aria(axle_x: f64) -> [Pose; 16] {
    ARIA.map(|[x, y, heading]| [x / 1000.0 + axle_x, y / 1000.0, heading])
}
