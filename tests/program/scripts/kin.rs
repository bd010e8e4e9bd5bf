//! Tests of `tatu.kin`, `tatu.getState`, `tatu.setState` and `tatu.linearize`, by closed forms and by what mechanisms do.

use crate::kit::*;

/// Runs a script in a scene, and checks that it prints `it is ok`.
fn ends_well(scene: &str, script: &str, steps: &str) -> String {
    let scene = format!("{scene}\n{}", watcher("w", script));
    let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", steps]).good();
    assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
    done.out
}

/// Runs the body of an initialization in a scene.
fn passes(scene: &str, body: &str) {
    ends_well(scene, &format!("{BEGIN}function sysCall_init()\n{body}\nprint('it is ok')\nend"), "1");
}

const BEGIN: &str = "
local function near(a, b, by) assert(math.abs(a - b) <= by, a .. ' instead of ' .. b) end
local function refused(words, f, ...)
    local done, why = pcall(f, ...)
    assert(not done and why:find(words, 1, true), tostring(why))
end
";

/// A rail along x with a cart of 1 kg, and a pole of 0.2 kg on it, with its centre of mass 0.5 m above and 0.02 kg m^2.
const CART_POLE: &str = "
dt_s = 0.005
[[object]]
kind = \"shape\"
alias = \"rail\"
position_m = [0, 0, 1]
size_m = [4, 0.05, 0.05]
[[object]]
kind = \"joint\"
alias = \"slide\"
parent = \"/rail\"
type = \"prismatic\"
quaternion = [0, 0.7071067811865476, 0, 0.7071067811865476]
control = \"force\"
[[object]]
kind = \"shape\"
alias = \"cart\"
parent = \"/rail/slide\"
quaternion = [0, -0.7071067811865476, 0, 0.7071067811865476]
size_m = [0.2, 0.1, 0.1]
dynamic = true
mass_kg = 1.0
[[object]]
kind = \"joint\"
alias = \"hinge\"
parent = \"/rail/slide/cart\"
quaternion = [-0.7071067811865476, 0, 0, 0.7071067811865476]
[[object]]
kind = \"shape\"
alias = \"pole\"
parent = \"/rail/slide/cart/hinge\"
position_m = [0, -0.5, 0]
quaternion = [0.7071067811865476, 0, 0, 0.7071067811865476]
size_m = [0.02, 0.02, 1.0]
dynamic = true
mass_kg = 0.2
inertia_kg_m2 = [0.02, 0.02, 0.0001]
[[object]]
kind = \"dummy\"
alias = \"top\"
parent = \"/rail/slide/cart/hinge/pole\"
position_m = [0, 0, 0.5]
";

/// With J = I + m l^2 and D = (M + m) J - (m l)^2, the upright pole has the accelerations
/// x'' = (J u - (m l)^2 g a) / D and a'' = ((M + m) m g l a - m l u) / D.
#[test]
fn linear_model_of_a_cart_pole_is_the_closed_form() {
    passes(
        CART_POLE,
        "
local rail, slide, hinge = sim.getObject('/rail'), sim.getObject('/slide'), sim.getObject('/hinge')
local A, B, C, D = tatu.linearize(rail, {slide}, {slide, hinge, sim.getObject('/top')})
local M, m, l, g = 1, 0.2, 0.5, 9.81
local J = 0.02 + m * l * l
local det = (M + m) * J - (m * l) ^ 2
local expected = {
    {0, 0, 1, 0}, {0, 0, 0, 1},
    {0, -(m * l) ^ 2 * g / det, 0, 0}, {0, (M + m) * m * g * l / det, 0, 0},
}
for i = 1, 4 do for k = 1, 4 do near(A[i][k], expected[i][k], 1e-6) end end
local inputs = {0, 0, J / det, -m * l / det}
for i = 1, 4 do near(B[i][1], inputs[i], 1e-9) end
-- The joints, then x, y and z of the top: a turn of 1 rad moves it by 1 m along x.
local outputs = {{1, 0}, {0, 1}, {1, 1}, {0, 0}, {0, 0}}
for i = 1, 5 do near(C[i][1], outputs[i][1], 1e-12) near(C[i][2], outputs[i][2], 1e-12) near(D[i][1], 0, 0) end
local q, qd = tatu.getState(rail)
assert(q[1] == 0 and q[2] == 0 and qd[1] == 0 and qd[2] == 0)",
    );
}

/// Two rods of 1 m and 0.7 m with point masses at their ends, hanging from a hinge about y.
const DOUBLE_PENDULUM: &str = "
dt_s = 0.005
[[object]]
kind = \"shape\"
alias = \"hook\"
position_m = [0, 0, 2]
size_m = [0.05, 0.05, 0.05]
[[object]]
kind = \"joint\"
alias = \"upper\"
parent = \"/hook\"
quaternion = [-0.7071067811865476, 0, 0, 0.7071067811865476]
[[object]]
kind = \"shape\"
alias = \"first\"
parent = \"/hook/upper\"
position_m = [0, 1, 0]
dynamic = true
mass_kg = 1.5
inertia_kg_m2 = [1e-9, 1e-9, 1e-9]
[[object]]
kind = \"joint\"
alias = \"lower\"
parent = \"/hook/upper/first\"
[[object]]
kind = \"shape\"
alias = \"second\"
parent = \"/hook/upper/first/lower\"
position_m = [0, 0.7, 0]
dynamic = true
mass_kg = 0.8
inertia_kg_m2 = [1e-9, 1e-9, 1e-9]
";

/// Hanging: M qdd = -K q, with angles of the first rod and between both:
/// M = [[(m1 + m2) a^2 + 2 m2 a b + m2 b^2, m2 b^2 + m2 a b], [.., m2 b^2]], and
/// K = g [[(m1 + m2) a + m2 b, m2 b], [m2 b, m2 b]].
#[test]
fn linear_model_of_a_double_pendulum_is_the_closed_form() {
    passes(
        DOUBLE_PENDULUM,
        "
local hook = sim.getObject('/hook')
local A, B, C = tatu.linearize(hook, {sim.getObject('/upper'), sim.getObject('/lower')})
local m1, m2, a, b, g, i = 1.5, 0.8, 1, 0.7, 9.81, 1e-9
local M = {{(m1 + m2) * a * a + 2 * m2 * a * b + m2 * b * b + 2 * i, m2 * b * b + m2 * a * b + i}, {0, m2 * b * b + i}}
M[2][1] = M[1][2]
local K = {{g * ((m1 + m2) * a + m2 * b), g * m2 * b}, {g * m2 * b, g * m2 * b}}
local det = M[1][1] * M[2][2] - M[1][2] ^ 2
local inverse = {{M[2][2] / det, -M[1][2] / det}, {-M[1][2] / det, M[1][1] / det}}
for r = 1, 2 do
    for c = 1, 2 do
        near(A[2 + r][c], -(inverse[r][1] * K[1][c] + inverse[r][2] * K[2][c]), 1e-6)
        near(A[2 + r][2 + c], 0, 1e-6)
        near(B[2 + r][c], inverse[r][c], 1e-9)
    end
end
assert(#C == 4 and C[3][3] == 1)
local mass = tatu.kin.massMatrix(hook)
for r = 1, 2 do for c = 1, 2 do near(mass[r][c], M[r][c], 1e-9) end end
-- At 90 degrees, the torque of the weights is that of their levers.
local torques = tatu.kin.gravityTorques(hook, {math.pi / 2, 0})
near(math.abs(torques[1]), g * (m1 * a + m2 * (a + b)), 1e-9)
near(math.abs(torques[2]), g * m2 * b, 1e-9)",
    );
}

/// The gain is the fixed point of the discrete Riccati equation, computed by the script.
#[test]
fn regulator_from_the_linear_model_balances_a_cart_pole() {
    let script = "
local rail, slide, K, largest
local function product(A, B)
    local P = {}
    for i = 1, #A do
        P[i] = {}
        for k = 1, #B[1] do
            local sum = 0
            for j = 1, #B do sum = sum + A[i][j] * B[j][k] end
            P[i][k] = sum
        end
    end
    return P
end
local function transposed(A)
    local T = {}
    for k = 1, #A[1] do T[k] = {} for i = 1, #A do T[k][i] = A[i][k] end end
    return T
end
function sysCall_init()
    rail, slide = sim.getObject('/rail'), sim.getObject('/slide')
    local A, B = tatu.linearize(rail, {slide})
    local dt, R, weights = 0.005, 0.1, {5, 10, 1, 1}
    for i = 1, 4 do
        for k = 1, 4 do A[i][k] = A[i][k] * dt + (i == k and 1 or 0) end
        B[i][1] = B[i][1] * dt
    end
    local P, At, Bt = {}, transposed(A), transposed(B)
    for i = 1, 4 do P[i] = {0, 0, 0, 0} P[i][i] = weights[i] end
    for _ = 1, 3000 do
        local PA = product(P, A)
        K = product(Bt, PA)
        local s = R + product(product(Bt, P), B)[1][1]
        for k = 1, 4 do K[1][k] = K[1][k] / s end
        local next, back = product(At, PA), product(product(At, product(P, B)), K)
        for i = 1, 4 do for k = 1, 4 do P[i][k] = next[i][k] - back[i][k] + (i == k and weights[i] or 0) end end
    end
    tatu.setState(rail, {0.3, 0.2}, {0, 0})
    largest = 0
end
function sysCall_actuation()
    local q, qd = tatu.getState(rail)
    local u = -(K[1][1] * q[1] + K[1][2] * q[2] + K[1][3] * qd[1] + K[1][4] * qd[2])
    tatu.set(slide, 'joint.max_force', u)
    largest = math.max(largest, math.abs(q[2]))
end
function sysCall_cleanup()
    local q, qd = tatu.getState(rail)
    assert(largest < 0.5, 'the pole fell to ' .. largest)
    for _, x in ipairs{q[1], q[2], qd[1], qd[2]} do assert(math.abs(x) < 1e-3, x) end
    print('it is ok')
end";
    ends_well(CART_POLE, script, "2000");
}

#[test]
fn state_that_was_set_is_that_of_the_simulation() {
    let script = format!(
        "{BEGIN}
local hook, energy
function sysCall_init()
    hook = sim.getObject('/hook')
    tatu.setState(hook, {{0.4, -0.9}}, {{1.5, 2.5}})
    local q, qd = tatu.getState(hook)
    near(q[1], 0.4, 0) near(q[2], -0.9, 0) near(qd[1], 1.5, 1e-12) near(qd[2], 2.5, 1e-12)
    local k, p = tatu.kin.energy(hook, {{0.4, -0.9}}, {{1.5, 2.5}})
    energy = k + p
end
function sysCall_sensing()
    local q, qd = tatu.getState(hook)
    local k, p = tatu.kin.energy(hook)
    near(k + p, energy, 2e-3)
    if sim.getSimulationTime() < 0.001 then
        -- After the first step of 5 ms: positions by velocities, velocities by accelerations.
        local a = tatu.kin.forwardDynamics(hook, nil, {{0.4, -0.9}}, {{1.5, 2.5}})
        near(q[1], 0.4 + 1.5 * 0.005 + 0.5 * a[1] * 0.005 ^ 2, 1e-5)
        near(qd[1], 1.5 + a[1] * 0.005, 2e-3)
        near(qd[2], 2.5 + a[2] * 0.005, 2e-3)
        print('it is ok')
    end
end"
    );
    ends_well(DOUBLE_PENDULUM, &script, "200");
}

/// Forces of each step are those of `tatu.kin.gravityTorques` alone.
#[test]
fn arms_stay_where_gravity_is_compensated() {
    for (model, home) in
        [("ur5", "{0.3, -1.2, 1.5, -0.8, 0.9, -0.4}"), ("panda", "{0.4, -0.6, 0.2, -2.2, 0.5, 1.8, -0.9}")]
    {
        let scene = format!("dt_s = 0.005\n[[model]]\nmodel = \"{model}\"\nalias = \"arm\"\ncontroller = false\n");
        let script = format!(
            "
local arm, joints, home
function sysCall_init()
    arm = sim.getObject('/arm')
    joints, home = tatu.kin.joints(arm), {home}
    for _, joint in ipairs(joints) do
        tatu.set(joint, 'joint.control', 'force')
    end
    local q = tatu.getState(arm)
    for i = #home + 1, #q do home[i] = q[i] end
    tatu.setState(arm, home)
end
function sysCall_actuation()
    for i, force in ipairs(tatu.kin.gravityTorques(arm)) do
        tatu.set(joints[i], 'joint.max_force', force)
    end
end
function sysCall_cleanup()
    local q, worst = tatu.getState(arm), 0
    for i = 1, #q do worst = math.max(worst, math.abs(q[i] - home[i])) end
    print('worst', worst)
    assert(worst < 1e-9, worst)
    print('it is ok')
end"
        );
        ends_well(&scene, &script, "2000");
    }
}

/// The callback of each physics step of 5 ms asks for the torques of the wanted motion, with feedback.
#[test]
fn computed_torques_in_a_joint_callback_follow_a_sine() {
    let script = "
local hook, upper, lower, worst, forces
local W, AMPLITUDE = 2 * math.pi * 0.5, 0.5
function sysCall_init()
    hook, upper, lower = sim.getObject('/hook'), sim.getObject('/upper'), sim.getObject('/lower')
    tatu.set(upper, 'joint.control', 'callback')
    tatu.set(lower, 'joint.control', 'callback')
    tatu.setState(hook, {0, 0}, {AMPLITUDE * W, -AMPLITUDE * W})
    worst = 0
end
function sysCall_joint(data)
    if data.handle == upper then
        local t = sim.getSimulationTime()
        local q, qd = tatu.getState(hook)
        local a = {}
        for i, sign in ipairs{1, -1} do
            local s, c = math.sin(W * t) * AMPLITUDE * sign, math.cos(W * t) * AMPLITUDE * sign
            worst = math.max(worst, math.abs(q[i] - s))
            a[i] = -W * W * s + 100 * (s - q[i]) + 20 * (W * c - qd[i])
        end
        forces = tatu.kin.inverseDynamics(hook, q, qd, a)
    end
    local force = data.handle == upper and forces[1] or forces[2]
    return {force = force, vel = force > 0 and 1e9 or -1e9}
end
function sysCall_cleanup()
    print('worst', worst)
    assert(worst > 0 and worst < 0.005 * AMPLITUDE, worst)
    print('it is ok')
end";
    ends_well(DOUBLE_PENDULUM, script, "1200");
}

#[test]
fn positions_for_a_pose_bring_the_tip_there_and_reasons_are_sentences() {
    let scene = "[[model]]\nmodel = \"ur5\"\nalias = \"arm\"\ncontroller = false\n[[object]]\nkind = \"shape\"\nalias = \"wall\"\nposition_m = [0.55, 0, 0.5]\nsize_m = [0.02, 2, 1]\n";
    passes(
        scene,
        "
local arm, tip = sim.getObject('/arm'), sim.getObject('/arm/tool0')
local q, joints, why = tatu.kin.ik(tip, {0.4, 0.2, 0.4, 1, 0, 0, 0})
assert(why == nil and #q == 6 and joints[1] == tatu.kin.joints(arm)[1])
local J, pose = tatu.kin.jacobian(arm, tip, q)
for i, x in ipairs{0.4, 0.2, 0.4} do near(pose[i], x, 1e-6) end
near(math.abs(pose[4]), 1, 1e-6)
local again = tatu.kin.ik(tip, {0.4, 0.2, 0.4, 1, 0, 0, 0})
for i = 1, 6 do assert(q[i] == again[i]) end

q, joints, why = tatu.kin.ik(tip, {1.4, 0.2, 0.4})
assert(q == nil and why.kind == 'out of reach' and why.inside == false and why.by > 0.4, why.text)
assert(why.text:find('too far'), why.text)
assert(#why.nearest == 6)
local reachable, text = tatu.kin.reach(tip, {0, 0, 3})
assert(reachable == false and text:find('too far'), text)
assert(tatu.kin.reach(tip, {0.4, 0.2, 0.4}) == true)

q, joints, why = tatu.kin.ik(tip, {0.6, 0, 0.4}, {avoid = {sim.getObject('/wall')}})
assert(q == nil and why.kind == 'collision' and why.object == sim.getObject('/wall'), why and why.text)

local from = tatu.getState(arm)
q, joints, why = tatu.kin.ik(tip, {0.4, 0.2, 0.4}, {max_change = 0.01})
assert(q == nil and why.kind == 'change', why and why.text)
for i = 1, 6 do assert(math.abs(why.nearest[i] - from[i]) <= 0.01 + 1e-12) end",
    );
}

/// A ball joint has a quaternion and three velocities about the axes of its moved frame.
#[test]
fn state_of_a_spherical_joint_is_that_which_was_set() {
    let scene = DOUBLE_PENDULUM
        .replace("alias = \"lower\"", "alias = \"lower\"\ntype = \"spherical\"\norientation_deg = [10, -30, 70]");
    passes(
        &scene.replace("1e-9, 1e-9, 1e-9", "0.01, 0.02, 0.025"),
        "
local hook = sim.getObject('/hook')
local joints, first_q, first_qd = tatu.kin.joints(hook)
assert(#joints == 2 and first_q[2] == 2 and first_qd[2] == 2)
local q, qd = {0.3, 0.1, 0.2, 0.3, 0}, {0.4, -0.5, 0.6, 0.7}
q[5] = math.sqrt(1 - 0.01 - 0.04 - 0.09)
tatu.setState(hook, q, qd)
local now, speed = tatu.getState(hook)
for i = 1, 5 do near(now[i], q[i], 1e-12) end
for i = 1, 4 do near(speed[i], qd[i], 1e-12) end
-- Forces that cause accelerations cause them.
local qdd = {0.5, -0.4, 0.3, 0.2}
local found = tatu.kin.forwardDynamics(hook, tatu.kin.inverseDynamics(hook, q, qd, qdd), q, qd)
for i = 1, 4 do near(found[i], qdd[i], 1e-9) end
refused('must be a unit quaternion', tatu.setState, hook, {0, 0, 0, 0, 0})
refused('is spherical', tatu.kin.ik, sim.getObject('/second'), {0, 0, 1})",
    );
}

/// All commands but `tatu.setState`, called in each step of a run.
#[test]
fn commands_leave_no_trace_in_the_hash_of_a_run() {
    let run = |calls: &str| {
        let scene = format!(
            "[[model]]\nmodel = \"ur5\"\nalias = \"arm\"\n[[object]]\nkind = \"shape\"\nalias = \"wall\"\n\
             position_m = [0.55, 0, 0.5]\nsize_m = [0.02, 2, 1]\n{}",
            watcher("w", &format!("function sysCall_sensing()\nprint('it is ok')\n{calls}\nend"))
        );
        let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "4"]).good();
        assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
        let all = format!("{}{}", done.out, done.err);
        let (_, hash) = all.split_once("hash ").expect("a summary contains the hash");
        hash.lines().next().map(str::to_owned)
    };
    let calls = "
local arm, tip, wall = sim.getObject('/arm'), sim.getObject('/arm/tool0'), sim.getObject('/wall')
local q, joints, why = tatu.kin.ik(tip, {0.6, 0, 0.4}, {avoid = {wall}})
assert(q == nil and why.kind == 'collision')
tatu.kin.massMatrix(arm) tatu.kin.jacobian(arm, tip) tatu.kin.inverseDynamics(arm) tatu.kin.forwardDynamics(arm)
tatu.linearize(arm, joints, {tip}) tatu.getState(arm) tatu.kin.energy(arm)";
    assert_eq!(run(""), run(calls));
}

#[test]
fn wrong_arguments_are_errors_in_a_sentence() {
    passes(
        DOUBLE_PENDULUM,
        "
local hook, second, upper = sim.getObject('/hook'), sim.getObject('/second'), sim.getObject('/upper')
refused('needs 2: one for each joint', tatu.kin.massMatrix, hook, {1, 2, 3})
refused('number 2 is NaN', tatu.kin.massMatrix, hook, {1, 0 / 0})
refused('`qd` has 1 numbers', tatu.kin.inverseDynamics, hook, {0, 0}, {1})
refused('number 1 is inf', tatu.kin.forwardDynamics, hook, {1 / 0, 0})
refused('not finite', tatu.kin.inverseDynamics, hook, {0, 1}, {1e200, 1e200})
refused('the world itself is not an object', tatu.kin.massMatrix, 0)
refused('not an ancestor of the tip', tatu.kin.ik, second, {0, 0, 0}, {base = second})
refused('there is no option `bass`', tatu.kin.ik, second, {0, 0, 0}, {bass = second})
refused('from 1 to 64', tatu.kin.ik, {}, {})
refused('there is no object', tatu.kin.gravityTorques, 123456)
refused('has no joint below it', tatu.kin.massMatrix, sim.getObject('/w'))
refused('not part of the mechanism', tatu.kin.jacobian, hook, sim.getObject('/w'))
refused('no joint moves', tatu.kin.jacobian, hook, hook)
refused('not a revolute or prismatic joint', tatu.linearize, hook, {second})
refused('`q` has 1 numbers', tatu.linearize, hook, {upper}, nil, {q = {1}})
refused('no joint moves the tip', tatu.kin.ik, hook, {0, 0, 0})
refused('expected the handle of an object, a pose', tatu.kin.ik, second, {0, 0})
refused('expected the handle of an object, a pose', tatu.kin.ik, second, {0, 0, 0 / 0})
refused('`what` is `all`', tatu.kin.ik, second, {0, 0, 0}, {what = 'all'})
refused('`posture` has 1 numbers', tatu.kin.ik, second, {0, 0, 0}, {posture = {1}})
refused('`max_change` must be', tatu.kin.ik, second, {0, 0, 0}, {max_change = -1})
refused('`restarts` must be', tatu.kin.ik, second, {0, 0, 0}, {restarts = -1})
refused('2 poses for 1 tips', tatu.kin.ik, {second}, {{0, 0, 0}, {0, 0, 1}})
refused('`precision` must be', tatu.kin.ik, second, {0, 0, 0}, {precision = {1}})
refused('needs 2: one for each joint', tatu.setState, hook, {1})",
    );
}

#[test]
fn base_that_is_not_fixed_has_positions_and_velocities() {
    let scene = "[[model]]\nmodel = \"quadruped\"\nalias = \"dog\"\n";
    passes(
        scene,
        "
local dog = sim.getObject('/dog')
local joints, first_q, first_qd = tatu.kin.joints(dog)
local q, qd = tatu.getState(dog)
assert(#q == #qd + 1 and first_q[2] == 8 and first_qd[2] == 7)
-- The forces of a free fall are those of the weight.
local M = tatu.kin.massMatrix(dog)
local forces = tatu.kin.gravityTorques(dog)
near(forces[3], M[3][3] * 9.81, 1e-6)
near(M[1][1], M[3][3], 1e-9)
-- A leg below the trunk, whatever the trunk does.
local foot = sim.getObject('/dog/FR_foot')
local at = sim.getObjectPosition(foot)
local leg, joints, why = tatu.kin.ik(foot, {at[1] + 0.03, at[2], at[3] + 0.02}, {base = dog})
assert(why == nil and #joints == 3, why and why.text)
for i, joint in ipairs(joints) do sim.setJointPosition(joint, leg[i]) end
local there = sim.getObjectPosition(foot)
near(there[1], at[1] + 0.03, 2e-6) near(there[2], at[2], 2e-6) near(there[3], at[3] + 0.02, 2e-6)
refused('must be a unit quaternion', tatu.kin.massMatrix, dog, (function() local x = {} for i = 1, #q do x[i] = 0 end return x end)())",
    );
}
