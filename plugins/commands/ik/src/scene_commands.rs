//! Commands for groups that belong to the scene, as in versions before 4.1.

use tatu_kinematics::{
    Constraints, IkTask, JointRole, SearchSettings, find_configuration, group_jacobian, random_configuration,
};
use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Command, Fail, Offer, Param, Result, Value},
};

use crate::{
    environment::{Ctx, Ik, scene_groups},
    jacobians::manipulability,
    methods::{MAX_ITERATIONS, method, result_number},
    scene_groups::{SceneGroup, joints},
    searches::{alternatives, between},
};

/// Return value of a failed call by an old name.
const MINUS_ONE: [Value; 1] = [Value::Int(-1)];
const NIL: [Value; 1] = [Value::Nil];
/// Handle that stands for all groups.
const HANDLE_ALL: i64 = -2;
const HANDLE_ALL_EXCEPT_EXPLICIT: i64 = -3;

/// Handles that lookups return in runs without a scene, in place of groups that do not exist.
const STAND_INS: std::ops::RangeInclusive<i64> = 0x8_0000..=0x8_FFFF;

/// Builds a command whose first parameter is a group, under its current and its old name.
fn group_command(
    name: &str,
    on_error: [Value; 1],
    run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static,
) -> Command<Ik> {
    let mut old: Vec<char> = name.chars().collect();
    old[0] = old[0].to_ascii_uppercase();
    let old: String = old.into_iter().collect();
    Command::new(format!("sim.{name}"), run).old_name(format!("sim{old}"), on_error).param(Param::int("group"))
}

/// Copies joint positions, and the poses of bases and targets, from the scene.
fn refresh(c: &Ctx<'_>) -> Result {
    let mut groups = scene_groups(c)?;
    let targets: Vec<_> = groups.groups.iter().flat_map(|g| &g.group.tasks).map(|t| t.target).collect();
    groups.copy.take_from_scene(&c.world(), &c.plugin().props, &targets)
}

/// Solves one or several groups, and moves their joints in the scene.
fn handle(c: &mut Ctx<'_>) -> Result {
    let wanted = c.i64(0)?;
    if STAND_INS.contains(&wanted) && c.world().makes_stand_ins() {
        c.ret(0_i64);
        return Ok(());
    }
    let result = {
        let mut groups = scene_groups(c)?;
        let handles: Vec<i64> = match wanted {
            HANDLE_ALL => groups.groups.iter().map(|g| g.handle).collect(),
            HANDLE_ALL_EXCEPT_EXPLICIT => groups.automatic(&c.world(), &c.plugin().props)?,
            handle => vec![groups.group(handle)?.handle],
        };
        let performed = groups.handle(&c.world(), &c.plugin().props, &handles)?;
        if wanted < 0 { performed } else { groups.group(wanted)?.result }
    };
    c.ret(result);
    Ok(())
}

pub fn offer(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("handleIkGroup", MINUS_ONE, handle)
            .returns(Param::int("result").text("0: not performed, 1: success, 2: failure; for several groups, how many"))
            .text("Solves a group, all groups, or all that are not solved on request only, and moves their joints.")
            .notes(
                "Dynamic joints are moved by their target positions. The default main script calls this after all other \
                 scripts have acted; scenes with groups have a script for it.",
            ),
    );
    settings(offer);
    creation(offer);
    results(offer);
    searches(offer);
}

fn settings(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("setIkGroupProperties", MINUS_ONE, |c| {
            let (number, iterations, damping) = (c.i64(1)?, c.i64(2)?, c.f64(3)?);
            let iterations = u32::try_from(iterations).ok().filter(|n| *n <= MAX_ITERATIONS);
            let wrong = || Fail::argument(format!("argument 3: expected 0 to {MAX_ITERATIONS} iterations"));
            let mut groups = scene_groups(c)?;
            let group = &mut groups.group(c.i64(0)?)?.group;
            group.max_iterations = iterations.ok_or_else(wrong)?;
            (group.method, group.damping) = method(number, damping);
            Ok(())
        })
        .param(Param::int("method").text("0: pseudo-inverse, 1: damped least squares, 2: Jacobian transpose"))
        .param(Param::int("iterations"))
        .param(Param::float("damping"))
        .text("Sets the solver method of a group, its maximum number of iterations, and its damping.")
        .notes("The iterations come before the damping, unlike in `simIK.setGroupCalculation`."),
    );
    offer.command(
        group_command("setIkElementProperties", MINUS_ONE, |c| {
            let (tip, mask) = (c.i64(1)?, c.i64(2)?);
            let pair = |i: usize| c.has(i).then(|| c.array::<2>(i)).transpose();
            let (precision, weights) = (pair(3)?, pair(4)?);
            if [precision, weights].iter().flatten().flatten().any(|x| !x.is_finite() || *x < 0.0) {
                return Err(Fail::argument("arguments 4 and 5: expected two finite numbers of at least 0 each"));
            }
            let mut groups = scene_groups(c)?;
            let copy = groups.copy.copy_of(c.world().look(tip as tatu_object)?.id);
            let group = &mut groups.group(c.i64(0)?)?.group;
            let task = group.tasks.iter_mut().find(|t| Some(t.tip) == copy);
            let task =
                task.ok_or_else(|| Fail::argument(format!("argument 2: the group has no element for tip {tip}")))?;
            task.constraints = Constraints(mask as u32 & 31);
            task.precision = precision.unwrap_or(task.precision);
            task.weights = weights.unwrap_or(task.weights);
            Ok(())
        })
        .param(Param::int("tip"))
        .param(Param::int("constraints"))
        .param(Param::floats("precision", 2).optional().text("distance, m, and angle, rad"))
        .param(Param::floats("weights", 2).optional().text("of position and orientation"))
        .text("Sets the constraints of the element of a group that has a tip."),
    );
}

fn creation(offer: &mut Offer<Ik>) {
    offer.command(
        Command::new("sim.createIkGroup", |c: &mut Ctx<'_>| {
            let options = c.i64(0)?;
            let [kind, iterations] = if c.has(1) { c.array::<2>(1)? } else { [0.0, 3.0] };
            let damping = if c.has(2) { c.arg(2).number(0).unwrap_or(0.1) } else { 0.1 };
            let made = {
                let mut groups = scene_groups(c)?;
                let made = groups.groups.iter().map(|g| g.handle).max().unwrap_or(FIRST_HANDLE).max(FIRST_HANDLE) + 1;
                groups.groups.push(SceneGroup::created(made, options, (kind as i64, iterations, damping)));
                made
            };
            c.ret(made);
            Ok(())
        })
        .old_name("simCreateIkGroup", MINUS_ONE)
        .param(
            Param::int("options")
                .text("1: inactive; 4, 8: restore joints; 16: largest steps apply; 32: on request only"),
        )
        .param(Param::floats("calculation", 2).optional().text("method and iterations"))
        .param(Param::floats("numbers", 0).optional().text("damping"))
        .returns(Param::int("group"))
        .text("Creates a group without elements."),
    );
    offer.command(
        group_command("createIkElement", MINUS_ONE, |c| {
            let options = c.i64(1)?;
            let [tip, base, axes, mask] = c.array::<4>(2)?;
            let numbers = c.arg(3).numbers().unwrap_or_default();
            let (world, props) = (c.world(), &c.plugin().props);
            let mut groups = scene_groups(c)?;
            groups.group(c.i64(0)?)?;
            let id = |handle: f64| world.look(handle as i64 as tatu_object).map(|o| o.id);
            let base = (base >= 0.0).then(|| id(base)).transpose()?;
            let (tip, axes) = (id(tip)?, (axes >= 0.0).then(|| id(axes)).transpose()?);
            let known = groups.copy.objects.keys().copied().collect::<Vec<_>>();
            let copied = groups.copy.copy_chain(&world, props, base, tip)?;
            let target = match linked_dummy(c, tip)? {
                Some(target) => groups.copy.copy_frame(&world, props, target)?,
                None => copied,
            };
            let axes = axes.map(|axes| groups.copy.copy_frame(&world, props, axes)).transpose()?;
            // Inverse kinematics moves the new joints that physics does not move.
            for (frame, object) in groups.copy.objects.clone().iter().filter(|(frame, _)| !known.contains(frame)) {
                let is_dynamic = world.is_dynamic(*object).unwrap_or(false);
                let joint = groups.copy.linkage.joint_mut(*frame).filter(|j| is_dynamic && j.role == JointRole::Moved);
                if let Some(joint) = joint {
                    joint.role = JointRole::Fixed;
                }
            }
            let base = base.and_then(|base| groups.copy.copy_of(base));
            let mut task =
                IkTask { base, axes, constraints: Constraints(mask as u32 & 31), ..IkTask::new(copied, target) };
            task.enabled = options & 1 == 0;
            if let [distance, angle, position, orientation] = numbers[..] {
                (task.precision, task.weights) = ([distance, angle], [position, orientation]);
            }
            groups.group(c.i64(0)?)?.group.tasks.push(task);
            Ok(())
        })
        .param(Param::int("options").text("1: inactive"))
        .param(Param::floats("objects", 4).text("tip, base or -1, object with the axes or -1, constraints"))
        .param(Param::floats("numbers", 4).optional().text("precision: m and rad; weights of position and orientation"))
        .text("Adds an element to a group. Its target is the dummy that is linked to the tip."),
    );
    offer.command(
        group_command("removeIkGroup", MINUS_ONE, |c| {
            let handle = c.i64(0)?;
            let mut groups = scene_groups(c)?;
            groups.group(handle)?;
            groups.groups.retain(|g| g.handle != handle);
            Ok(())
        })
        .text("Removes a group."),
    );
}

/// Lower bound of the handles of groups that scripts create. Like V-REP's, these handles are greater than any object
/// handle.
const FIRST_HANDLE: i64 = 2_030_000;

/// Returns the dummy to which a dummy is linked, if any.
fn linked_dummy(c: &Ctx<'_>, dummy: tatu_object) -> Result<Option<tatu_object>> {
    let world = c.world();
    let path = world.get(dummy, c.plugin().props.dummy_link)?.as_str().unwrap_or_default().into_owned();
    if path.is_empty() { Ok(None) } else { Ok(Some(world.look(world.find(dummy, &path)?)?.id)) }
}

fn results(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("checkIkGroup", MINUS_ONE, |c| {
            let names = c
                .arg(1)
                .numbers()
                .ok_or_else(|| Fail::argument("argument 2: expected a table with the handles of joints"))?;
            refresh(c)?;
            let (result, positions) = {
                let mut groups = scene_groups(c)?;
                let joints = joints(&groups, &names)?;
                let group = groups.group(c.i64(0)?)?.group.clone();
                let mut linkage = groups.copy.linkage.clone();
                let outcome = tatu_kinematics::solve(&mut linkage, &[&group]);
                let positions: Vec<f64> = joints.iter().map(|j| linkage.position(*j)).collect();
                (outcome.result, positions)
            };
            c.ret(result_number(result));
            c.ret(positions);
            Ok(())
        })
        .param(Param::floats("joints", 0))
        .param(Param::floats("options", 0).optional())
        .returns(Param::int("result").text("0: not performed, 1: success, 2: failure"))
        .returns(Param::floats("positions", 0).text("of the joints"))
        .text("Solves a group, and returns the positions of joints, without moving anything."),
    );
    offer.command(
        group_command("computeJacobian", MINUS_ONE, |c| {
            refresh(c)?;
            let handle = c.i64(0)?;
            let mut groups = scene_groups(c)?;
            let tasks = groups.group(handle)?.group.tasks.clone();
            let found = group_jacobian(&groups.copy.linkage, &tasks);
            // Rows are joints from tip to base, columns are constraints; the matrix is returned column by column.
            let (m, n) = found.matrix.shape();
            let numbers = (0..m).flat_map(|row| (0..n).rev().map(move |column| (row, column)));
            let numbers = numbers.map(|at| found.matrix[at]).collect();
            groups.matrices.insert(handle, (numbers, [n as i64, m as i64], manipulability(&found)));
            Ok(())
        })
        .param(Param::int("options").optional())
        .text("Computes the Jacobian of a group at the present positions, for `sim.getIkGroupMatrix`."),
    );
    offer.command(
        group_command("getIkGroupMatrix", NIL, |c| {
            let (numbers, size, manipulability) = {
                let groups = scene_groups(c)?;
                let stored = groups.matrices.get(&c.i64(0)?).cloned();
                stored.ok_or_else(|| {
                    Fail::new("no Jacobian was computed for this group").help("call sim.computeJacobian first")
                })?
            };
            match c.i64(1)? {
                0 => {
                    c.ret(numbers);
                    c.ret(size);
                }
                1 => {
                    c.ret([manipulability]);
                    c.ret([1_i64, 1]);
                }
                n => {
                    return Err(Fail::argument(format!(
                        "argument 2: expected 0 (Jacobian) or 1 (manipulability), found {n}"
                    )));
                }
            }
            Ok(())
        })
        .param(Param::int("what").text("0: Jacobian, 1: manipulability"))
        .returns(Param::floats("matrix", 0).text("column by column; rows are the joints from tip to base"))
        .returns(Param::ints("size", 2).text("rows and columns"))
        .text("Returns the Jacobian that `sim.computeJacobian` has computed, or its manipulability."),
    );
}

fn searches(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("getConfigForTipPose", NIL, |c| {
            refuse_pairs(c, 5)?;
            let names = c
                .arg(1)
                .numbers()
                .ok_or_else(|| Fail::argument("argument 2: expected a table with the handles of joints"))?;
            let number = {
                let mut state = c.instance().borrow()?;
                state.searches += 1;
                state.searches
            };
            refresh(c)?;
            let time = if c.has(3) { c.f64(3)? } else { 10.0 };
            let attempts = ((time * ATTEMPTS_PER_MS) as u64).clamp(1, MAX_ATTEMPTS);
            let found = {
                let mut groups = scene_groups(c)?;
                let joints = joints(&groups, &names)?;
                let tasks = groups.group(c.i64(0)?)?.group.tasks.clone();
                let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
                (0..attempts).find_map(|n| {
                    let mut linkage = groups.copy.linkage.clone();
                    random_configuration(&mut linkage, &tasks, number, n);
                    let found = find_configuration(&mut linkage, &tasks, &settings).is_ok();
                    found.then(|| joints.iter().map(|j| linkage.position(*j)).collect::<Vec<f64>>())
                })
            };
            match found {
                Some(found) => c.ret(found),
                None => c.ret(Value::Nil),
            }
            Ok(())
        })
        .param(Param::floats("joints", 0))
        .param(Param::float("threshold").optional())
        .param(Param::float("time").optional().unit("ms"))
        .param(Param::floats("metric", 4).optional())
        .param(Param::any("pairs").optional())
        .param(Param::any("others").rest())
        .returns(Param::floats("configuration", 0).optional())
        .text("Returns a random configuration of joints for which the tips of a group are at their targets, within all limits, or nil.")
        .partial("pairs of objects that must not collide are refused; the time is converted to a number of attempts"),
    );
    offer.command(
        group_command("generateIkPath", NIL, |c| {
            refuse_pairs(c, 3)?;
            let names = c
                .arg(1)
                .numbers()
                .ok_or_else(|| Fail::argument("argument 2: expected a table with the handles of joints"))?;
            let points = c.i64(2)?;
            if !(2..=MAX_POINTS).contains(&points) {
                return Err(Fail::argument(format!("argument 3: expected 2 to {MAX_POINTS} points, found {points}")));
            }
            refresh(c)?;
            let path = {
                let mut groups = scene_groups(c)?;
                let joints = joints(&groups, &names)?;
                let tasks = groups.group(c.i64(0)?)?.group.tasks.clone();
                let mut linkage = groups.copy.linkage.clone();
                let ways: Vec<_> =
                    tasks.iter().map(|t| (t.target, linkage.pose(t.tip), linkage.pose(t.target))).collect();
                let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
                let rows = (0..points).map(|i| {
                    for (target, from, to) in &ways {
                        linkage.set_pose(*target, &between(from, to, i as f64 / (points - 1) as f64));
                    }
                    find_configuration(&mut linkage, &tasks, &settings).ok()?;
                    Some(joints.iter().map(|j| linkage.position(*j)).collect::<Vec<f64>>())
                });
                rows.collect::<Option<Vec<_>>>()
            };
            match path {
                Some(path) => c.ret(path.concat()),
                None => c.ret(Value::Nil),
            }
            Ok(())
        })
        .param(Param::floats("joints", 0))
        .param(Param::int("points").text("at least 2"))
        .param(Param::any("pairs").optional())
        .param(Param::any("options").optional())
        .returns(Param::floats("path", 0).optional().text("the positions of all joints, point by point"))
        .text("Returns the configurations of a straight motion of the tips from their current poses to their targets, or nil.")
        .partial("pairs of objects that must not collide are refused"),
    );
    offer.command(
        Command::new("sim.getAlternateConfigs", |c: &mut Ctx<'_>| {
            let numbers = |i: usize| c.arg(i).numbers().unwrap_or_default();
            let all = {
                let groups = scene_groups(c)?;
                let joints = joints(&groups, &numbers(0))?;
                alternatives(&groups.copy.linkage, &joints, &numbers(1), &numbers(3), &numbers(4))
            };
            c.ret(all.concat());
            Ok(())
        })
        .old_name("simGetAlternateConfigs", NIL)
        .param(Param::floats("joints", 0))
        .param(Param::floats("configuration", 0))
        .param(Param::int("tip").optional())
        .param(Param::floats("low", 0).optional())
        .param(Param::floats("ranges", 0).optional())
        .returns(Param::floats("configurations", 0).text("one after the other"))
        .text("Returns the configurations that equal one except for full turns of joints, within their limits."),
    );
}

/// Number of attempts per millisecond of the time that a script allows. A search counts attempts instead of measuring
/// time, so that its results are the same in every run.
const ATTEMPTS_PER_MS: f64 = 0.5;
const MAX_ATTEMPTS: u64 = 1000;
const MAX_POINTS: i64 = 10_000;

/// Returns an error if argument `i` lists pairs of objects that must not collide: collisions are not checked, and a
/// configuration in which they collide would be wrong.
fn refuse_pairs(c: &Ctx<'_>, i: usize) -> Result {
    match c.arg(i).is_empty() || c.arg(i).is_nil() {
        true => Ok(()),
        false => Err(Fail::unsupported(format!(
            "argument {}: checking pairs of objects for collisions is not supported",
            i + 1
        ))
        .help("pass nil, and check the configurations with sim.checkCollision")),
    }
}
