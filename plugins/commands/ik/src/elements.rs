//! Commands for the elements of groups. An element is a tip that must reach a target.

use std::cell::RefMut;

use tatu_kinematics::{Constraints, IkTask};
use tatu_plugin_api::{
    abi::{tatu_object, tatu_slot},
    safe::{Command, Fail, Offer, Param, Result, Value},
};

use crate::{
    arguments::{HANDLE_WORLD, frame, frame_or_world, handle_of, handle_or_world},
    constants::TIP_FLAG,
    environment::{Ctx, Environment, Ik, environment},
    groups::group_command,
};

/// Returns the task of the element that argument 3 identifies: by its own handle, or by the handle of its tip plus
/// [`TIP_FLAG`].
fn task<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, IkTask>> {
    let (group, element) = (c.i64(1)?, c.i64(2)?);
    let mut environment = environment(c)?;
    let group = environment.group(group)?;
    let index = match element >= TIP_FLAG {
        true => group.group.tasks.iter().position(|t| handle_of(t.tip) == element - TIP_FLAG),
        false => group.elements.iter().position(|e| *e == element),
    };
    let missing = || Fail::argument(format!("argument 3: there is no element with handle {element} in this group"));
    let index = index.ok_or_else(missing)?;
    let number = c.i64(1)?;
    RefMut::filter_map(environment, |e: &mut Environment| e.groups.get_mut(&number)?.group.tasks.get_mut(index))
        .map_err(|_| missing())
}

fn element_command(name: &str, run: impl Fn(&mut Ctx<'_>) -> Result + Send + Sync + 'static) -> Command<Ik> {
    group_command(name, run).param(Param::int("element"))
}

/// Adds an element to the group in argument 2, and returns its handle.
fn add(c: &Ctx<'_>, environment: &mut Environment, task: IkTask) -> Result<i64> {
    environment.check_room()?;
    let handle = environment.next_handle();
    let group = environment.group(c.i64(1)?)?;
    group.group.tasks.push(task);
    group.elements.push(handle);
    Ok(handle)
}

fn constraints(c: &Ctx<'_>, i: usize) -> Result<Constraints> {
    let mask = c.i64(i)?;
    if (0..32).contains(&mask) {
        return Ok(Constraints(mask as u32));
    }
    Err(Fail::argument(format!("argument {}: expected a sum of constraints from 0 to 31, found {mask}", i + 1)))
}

pub fn offer(offer: &mut Offer<Ik>) {
    creation(offer);
    targets(offer);
    settings(offer);
}

fn creation(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("addElement", |c| {
            let made = {
                let mut environment = environment(c)?;
                let tip = frame(c, &environment, 2)?;
                let target = environment.groups.values().flat_map(|g| &g.group.tasks).find(|t| t.tip == tip);
                let target = target.map_or(tip, |t| t.target);
                add(c, &mut environment, IkTask::new(tip, target))?
            };
            c.ret(made);
            Ok(())
        })
        .alias("simIK.addIkElement")
        .param(Param::int("tip"))
        .returns(Param::int("element"))
        .text("Adds an element for a tip. By default, its base is the world, and the whole pose is constrained."),
    );
    offer.command(
        group_command("addElementFromScene", |c| {
            let (base, tip, target) = (c.i64(2)?, c.i64(3)?, c.i64(4)?);
            let constraints = constraints(c, 5)?;
            let (made, to_copies, to_objects) = {
                let (world, props) = (c.world(), &c.plugin().props);
                let mut environment = environment(c)?;
                environment.check_room()?;
                let id = |handle: i64| world.look(handle as tatu_object).map(|o| o.id);
                let base = (base != HANDLE_WORLD).then(|| id(base)).transpose()?;
                let tip = environment.copy.copy_chain(&world, props, base, id(tip)?)?;
                let target = if target < 0 { tip } else { environment.copy.copy_frame(&world, props, id(target)?)? };
                let base = base.and_then(|base| environment.copy.copy_of(base));
                let made = add(c, &mut environment, IkTask { base, constraints, ..IkTask::new(tip, target) })?;
                let pairs = environment.copy.objects.iter().map(|(copy, object)| (i64::from(tatu_slot(*object)), handle_of(*copy)));
                let map = |pairs: Vec<(i64, i64)>| {
                    Value::Map(pairs.into_iter().map(|(k, v)| (Value::Int(k), Value::Int(v))).collect())
                };
                let pairs: Vec<(i64, i64)> = pairs.collect();
                let turned = pairs.iter().map(|(object, copy)| (*copy, *object)).collect();
                (made, map(pairs), map(turned))
            };
            c.ret(made);
            c.ret(to_copies);
            c.ret(to_objects);
            Ok(())
        })
        .alias("simIK.addIkElementFromScene")
        .param(Param::int("base").text("an object of the scene, or -1 for the world"))
        .param(Param::int("tip").text("an object of the scene"))
        .param(Param::int("target").text("an object of the scene"))
        .param(Param::int("constraints").text("a sum of constants, such as `simIK.constraint_pose`"))
        .returns(Param::int("element"))
        .returns(Param::map("copies").text("for each object of the scene, the handle of its copy"))
        .returns(Param::map("objects").text("for each copy, the handle of its object in the scene"))
        .text("Copies the kinematic chain from a base to a tip of the scene, and adds an element for it. All joints of the chain move."),
    );
}

fn targets(offer: &mut Offer<Ik>) {
    offer.command(
        crate::arguments::command("setTargetDummy", |c| {
            let mut environment = environment(c)?;
            let tip = frame(c, &environment, 1)?;
            let target = frame_or_world(c, &environment, 2)?.unwrap_or(tip);
            for group in environment.groups.values_mut() {
                group.group.tasks.iter_mut().filter(|t| t.tip == tip).for_each(|t| t.target = target);
            }
            Ok(())
        })
        .alias("simIK.setLinkedDummy")
        .param(Param::int("tip"))
        .param(Param::int("target").text("-1: none"))
        .text("Sets the target of all elements with the given tip."),
    );
    offer.command(
        crate::arguments::command("getTargetDummy", |c| {
            let target = {
                let environment = environment(c)?;
                let tip = frame(c, &environment, 1)?;
                let mut tasks = environment.groups.values().flat_map(|g| &g.group.tasks);
                tasks.find(|t| t.tip == tip).map(|t| t.target).filter(|t| *t != tip)
            };
            c.ret(handle_or_world(target));
            Ok(())
        })
        .alias("simIK.getLinkedDummy")
        .param(Param::int("tip"))
        .returns(Param::int("target"))
        .text("Returns the target of a tip; -1: none."),
    );
    offer.command(
        element_command("setElementBase", |c| {
            let (base, axes) = {
                let environment = environment(c)?;
                (frame_or_world(c, &environment, 3)?, frame_or_world(c, &environment, 4)?)
            };
            let mut task = task(c)?;
            (task.base, task.axes) = (base, axes);
            Ok(())
        })
        .alias("simIK.setIkElementBase")
        .param(Param::int("base").text("-1: the world"))
        .param(Param::int("axes").optional().text("the object whose axes constraints use; default: the base"))
        .text("Sets the base of an element: only joints between base and tip move."),
    );
    offer.command(
        element_command("getElementBase", |c| {
            let (base, axes) = {
                let task = task(c)?;
                (handle_or_world(task.base), handle_or_world(task.axes))
            };
            c.ret(base);
            c.ret(axes);
            Ok(())
        })
        .alias("simIK.getIkElementBase")
        .returns(Param::int("base"))
        .returns(Param::int("axes"))
        .text(
            "Returns the base of an element, and the object whose axes its constraints use; -1: the world or the base.",
        ),
    );
}

/// Adds a getter and a setter for a pair of numbers of an element, one for its position and one for its orientation.
fn pair(offer: &mut Offer<Ik>, name: &str, text: &str, get: fn(&mut IkTask) -> &mut [f64; 2]) {
    let set = move |c: &mut Ctx<'_>| {
        let numbers = c.arg(3).numbers().filter(|n| matches!(n.len(), 2 | 3) && n.iter().all(|x| *x >= 0.0));
        let wrong = || {
            Fail::argument(
                "argument 4: expected two numbers of at least 0, one for the position and one for the orientation",
            )
        };
        let numbers = numbers.ok_or_else(wrong)?;
        // Since 4.5, a third number multiplies both.
        let overall = numbers.get(2).copied().unwrap_or(1.0);
        *get(&mut *task(c)?) = [numbers[0] * overall, numbers[1] * overall];
        Ok(())
    };
    offer.command(
        element_command(&format!("setElement{name}"), set)
            .alias(format!("simIK.setIkElement{name}"))
            .param(Param::floats("numbers", 0).text("for position and orientation"))
            .text(format!("Sets {text} of an element.")),
    );
    let read = move |c: &mut Ctx<'_>| {
        let found = *get(&mut *task(c)?);
        c.ret(found);
        Ok(())
    };
    offer.command(
        element_command(&format!("getElement{name}"), read)
            .alias(format!("simIK.getIkElement{name}"))
            .returns(Param::floats("numbers", 2).text("for position and orientation"))
            .text(format!("Returns {text} of an element.")),
    );
}

fn settings(offer: &mut Offer<Ik>) {
    pair(offer, "Precision", "the accepted distance, m, and angle, rad,", |t| &mut t.precision);
    pair(offer, "Weights", "the weights", |t| &mut t.weights);
    offer.command(
        element_command("setElementConstraints", |c| {
            let mask = constraints(c, 3)?;
            task(c)?.constraints = mask;
            Ok(())
        })
        .alias("simIK.setIkElementConstraints")
        .param(Param::int("constraints").text("a sum of constants, such as `simIK.constraint_pose`"))
        .text("Sets the degrees of freedom in which the tip must match its target."),
    );
    offer.command(
        element_command("getElementConstraints", |c| {
            let mask = task(c)?.constraints.0;
            c.ret(i64::from(mask));
            Ok(())
        })
        .alias("simIK.getIkElementConstraints")
        .returns(Param::int("constraints"))
        .text("Returns the degrees of freedom in which the tip must match its target."),
    );
    offer.command(
        element_command("setElementFlags", |c| {
            let flags = c.i64(3)?;
            task(c)?.enabled = flags & 1 != 0;
            Ok(())
        })
        .alias("simIK.setIkElementFlags")
        .param(Param::int("flags").text("1: enabled"))
        .text("Enables or disables an element."),
    );
    offer.command(
        element_command("getElementFlags", |c| {
            let enabled = task(c)?.enabled;
            c.ret(i64::from(enabled));
            Ok(())
        })
        .alias("simIK.getIkElementFlags")
        .returns(Param::int("flags"))
        .text("Returns 1 if an element is enabled, otherwise 0."),
    );
}
