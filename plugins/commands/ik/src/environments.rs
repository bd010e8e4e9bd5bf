//! Commands that create, copy and erase environments.

use tatu_plugin_api::safe::{Command, Offer, Param, Result, Value};

use crate::{
    arguments::command,
    environment::{Ctx, Environment, Ik, environment},
};

fn handle() -> Param {
    Param::int("handle")
}

/// Erases the environment whose handle is argument 1.
fn erase(c: &mut Ctx<'_>) -> Result {
    let handle = c.i64(0)?;
    let mut state = c.instance().borrow()?;
    state.environment(handle)?;
    state.environments.remove(&handle);
    Ok(())
}

pub fn offer(offer: &mut Offer<Ik>) {
    offer.command(
        Command::new("simIK.createEnvironment", |c: &mut Ctx<'_>| {
            let made = c.instance().borrow()?.add(Environment::default())?;
            c.ret(made);
            Ok(())
        })
        .alias("simIK.createIkEnvironment")
        .param(Param::int("flags").default(0))
        .returns(handle())
        .text("Creates an empty environment."),
    );
    offer.command(
        command("eraseEnvironment", erase)
            .alias("simIK.eraseIkEnvironment")
            .text("Erases an environment, with all its objects and groups."),
    );
    offer.command(
        command("duplicateEnvironment", |c| {
            let copy = environment(c)?.clone();
            let made = c.instance().borrow()?.add(copy)?;
            c.ret(made);
            Ok(())
        })
        .alias("simIK.duplicateIkEnvironment")
        .returns(handle())
        .text("Copies an environment; the handles of its objects and groups remain the same."),
    );
    offer.command(
        command("createDebugOverlay", |c| {
            environment(c)?;
            c.ret(Value::Int(0));
            Ok(())
        })
        .param(Param::any("arguments").rest())
        .returns(handle())
        .text("Returns 0.")
        .stub("there are no overlays"),
    );
    offer.command(
        Command::new("simIK.eraseDebugOverlay", |_: &mut Ctx<'_>| Ok(()))
            .param(Param::int("handle"))
            .text("Does nothing.")
            .stub("there are no overlays"),
    );
}
