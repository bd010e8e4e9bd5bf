//! Commands for ROS parameters, which the scripts of a world share.

use tatu_plugin_api::safe::{Offer, Param};

use crate::{
    RosPlugin as Plugin,
    scripts::{add_command, for_version},
};

/// Adds the commands for parameters.
pub(crate) fn params(offer: &mut Offer<Plugin>) {
    for kind in ["String", "Int", "Double", "Bool"] {
        add_command(
            offer,
            [&format!("getParam{kind}"); 2],
            |c, _| {
                let name = c.text(0)?;
                let found = c.instance().state()?.params.get(&name).cloned();
                c.ret(found.is_some());
                match found {
                    Some(value) => c.ret(tatu_services_common::json::read(&value)?),
                    None => c.ret(c.arg(1).to_value()?),
                }
                Ok(())
            },
            |cmd, ros| {
                let module = for_version(ros, "simROS", "simROS2");
                cmd.param(Param::string("name"))
                    .param(Param::any("default").optional())
                    .returns(Param::bool("exists"))
                    .returns(Param::any("value"))
                    .text("Returns a parameter that a script of this world has set.")
                    .example(format!(
                        "local exists, value = {module}.getParam{kind}('nowhere', 7)\nassert(not exists and value == 7)"
                    ))
            },
        );
        add_command(
            offer,
            [&format!("setParam{kind}"); 2],
            |c, _| {
                let value = tatu_services_common::json::write(&c.arg(1).to_value()?);
                let name = c.text(0)?;
                c.instance().state()?.params.insert(name, value);
                Ok(())
            },
            |cmd, ros| {
                let module = for_version(ros, "simROS", "simROS2");
                cmd.param(Param::string("name"))
                    .param(Param::any("value"))
                    .text("Sets a parameter, for scripts of this world.")
                    .example(format!(
                        "{module}.setParam{kind}('gain', 2)\nassert(select(2, {module}.getParam{kind}('gain')) == 2)"
                    ))
            },
        );
    }
    add_command(
        offer,
        ["hasParam"; 2],
        |c, _| {
            let name = c.text(0)?;
            let has = c.instance().state()?.params.contains_key(&name);
            c.ret(has);
            Ok(())
        },
        |cmd, ros| {
            let module = for_version(ros, "simROS", "simROS2");
            cmd.param(Param::string("name"))
                .returns(Param::bool("exists"))
                .text("Returns whether a script has set a parameter.")
                .example(format!("assert(not {module}.hasParam('nowhere'))"))
        },
    );
    add_command(
        offer,
        ["deleteParam"; 2],
        |c, _| {
            let name = c.text(0)?;
            c.instance().state()?.params.remove(&name);
            Ok(())
        },
        |cmd, ros| {
            let module = for_version(ros, "simROS", "simROS2");
            cmd.param(Param::string("name"))
                .text("Removes a parameter.")
                .example(format!("{module}.deleteParam('nowhere')"))
        },
    );
}
