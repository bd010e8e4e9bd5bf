//! The command `tatu.drive`, which moves a wheeled robot at a given velocity.

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Fail, Offer, Param, World},
};
use tatu_robots_drivetrain::{Drivetrain, Props};

use crate::plugin::{Cmd, Tatu};

/// Returns the path of an object, for messages.
fn path(world: &World<'_>, object: tatu_object) -> String {
    let found = world.get(object, world.host().prop("object.path"));
    found.ok().and_then(|v| v.as_str().map(|s| s.into_owned())).unwrap_or_default()
}

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.drive", |c| {
            let world = c.world();
            let base = world.look(c.i64(0)? as u64)?.id;
            let p = Props::new(world.host());
            let twist = [c.f64(1)?, c.f64(2)?, c.f64(3)?];
            let train = Drivetrain::of(&world, &p, base)?.ok_or_else(|| {
                Fail::missing(format!("`{}` has no drive", path(&world, base)))
                    .help("set the property `object.drive` of the object, which declares the wheels that move it")
            })?;
            train.drive(&world, &p, twist)
        })
        .param(Param::int("robot").text("the handle of an object whose property `object.drive` is set"))
        .param(Param::float("ahead").unit("m/s"))
        .param(Param::float("left").unit("m/s").text("requires wheels with rollers"))
        .param(Param::float("turn").unit("rad/s").text("counter-clockwise, seen from above"))
        .text(
            "Sets the target velocities of the joints of a robot's drive, so that the middle of its axle moves at this \
             velocity, until the next call.",
        )
        .example("local robot = tatu.addModel('pioneer_p3dx')\ntatu.drive(robot, 0.3, 0, 0.2)"),
    );
}
