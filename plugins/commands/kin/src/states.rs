//! Commands for the state of a mechanism.

use tatu_plugin_api::safe::{Offer, Param, Result};

use crate::{
    plugin::{CallMechanism, Cmd, Ctx, Kin, model},
    state,
};

fn set_state(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 1)?;
    call.take_qd(c, 2)?;
    state::write(&c.world(), &c.plugin().props, &call.mechanism, &call.tree, &call.state)
}

pub fn offer(offer: &mut Offer<Kin>) {
    offer.command(
        Cmd::new("tatu.getState", |c| {
            let call = CallMechanism::read(c)?;
            c.ret(call.q());
            c.ret(call.state.v);
            Ok(())
        })
        .param(model())
        .returns(Param::floats("q", 0).text("rad or m: positions in the order of `tatu.kin.joints`; of a base that is not fixed: x y z and the quaternion x y z w",
        ))
        .returns(Param::floats("qd", 0).text("rad/s or m/s: velocities; of a base that is not fixed: that of its origin along the axes of the world, then the angular \
             velocity about its own axes",
        ))
        .text("Returns the positions and velocities of a mechanism after the last step."),
    );
    offer.command(
        Cmd::new("tatu.setState", set_state)
            .param(model())
            .param(Param::floats("q", 0).optional().text("rad or m: positions; omitted: present"))
            .param(Param::floats("qd", 0).optional().text("rad/s or m/s: velocities; omitted: present"))
            .text(
                "Moves a mechanism to positions and velocities, laid out as in `tatu.getState`. Joints stop at their limits; \
                 velocities of joints in kinematic mode are ignored.",
            ),
    );
}
