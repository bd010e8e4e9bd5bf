//! Commands on floating views and banners. Views are stored so that scripts can query and remove them, but are never
//! shown, because there is no window.

use crate::kit::*;

/// Signal kind under which views are stored; scripts cannot access signals of this kind.
const VIEW_SIGNAL_KIND: u32 = 64;
/// Option of `sim.adjustView` that only queries whether the view exists.
const QUERY_EXISTENCE: i64 = 256;
/// Option of `sim.adjustView` that queries which object the view shows.
const QUERY_OBJECT: i64 = 512;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let command = |names: CommandNames, run: fn(&mut Ctx<'_>) -> Result| both(names, MINUS_ONE, run);
    offer.command(
        command(["sim.floatingViewAdd", "simFloatingViewAdd"], |c| {
            let world = c.world();
            let used = |n: i64| world.signal(VIEW_SIGNAL_KIND, name(n).as_bytes()).is_ok_and(|v| !v.is_nil());
            let view = (1..).find(|n| !used(*n)).unwrap_or(1);
            store_view(c, view, -1)?;
            c.ret(view);
            Ok(())
        })
        .param(Param::any("posX").optional().text("ignored, as are the following arguments"))
        .param(Param::any("more").rest())
        .returns(Param::int("view"))
        .text("Adds a floating view. Nothing is shown, because there is no window.")
        .partial("Nothing is shown, because there is no window.")
        .example("view = sim.floatingViewAdd(0.5, 0.5, 0.3, 0.3, 0)"),
    );
    offer.command(
        command(["sim.floatingViewRemove", "simFloatingViewRemove"], |c| {
            let there = c.world().clear_signal(VIEW_SIGNAL_KIND, name(c.i64(0)?).as_bytes())? > 0;
            c.ret(i64::from(there));
            Ok(())
        })
        .param(Param::int("view"))
        .returns(Param::int("result").text("1; 0: there is no such view"))
        .text("Removes a floating view.")
        .example("sim.floatingViewRemove(view)"),
    );
    offer.command(
        command(["sim.adjustView", "simAdjustView"], |c| {
            let (view, options) = (c.i64(0)?, int_or(c, 2, 0)?);
            let shown = c.world().signal(VIEW_SIGNAL_KIND, name(view).as_bytes())?.as_i64();
            if options & QUERY_OBJECT != 0 {
                c.ret(shown.unwrap_or(-1));
            } else if options & QUERY_EXISTENCE != 0 {
                c.ret(if shown.is_some() { 2_i64 } else { 1 });
            } else {
                if shown.is_some() {
                    store_view(c, view, int_or(c, 1, -1)?)?;
                }
                c.ret(1_i64);
            }
            Ok(())
        })
        .param(Param::int("view").text("a floating view, or the index of a view of the page"))
        .param(Param::int("object").default(-1).optional().text("the object to show; -1: none"))
        .param(Param::int("options").default(0).optional().text("256: only checks; 512: returns the object shown"))
        .param(Param::string("label").optional().text("ignored"))
        .returns(Param::int("result").text("1; with 256: 2 if the view exists; with 512: the object shown, or -1"))
        .text("Sets which object a view shows. Nothing is shown, because there is no window.")
        .partial("Nothing is shown, because there is no window.")
        .example("sim.adjustView(view, -1, 0)"),
    );
    offer.command(
        command(["sim.addBanner", "simAddBanner"], |c| {
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::any("label").optional())
        .param(Param::any("more").rest())
        .returns(Param::int("banner").text("1"))
        .text("Accepts a string for display in the scene. Nothing is shown, because there is no window.")
        .stub("Nothing is shown, because there is no window.")
        .example("sim.addBanner('hello', 0.1, 0)"),
    );
    offer.command(
        command(["sim.removeBanner", "simRemoveBanner"], |c| {
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::any("banner").optional())
        .returns(Param::int("result").text("1"))
        .text("Removes a banner.")
        .stub("Nothing is shown, because there is no window.")
        .example("sim.removeBanner(sim.handle_all)"),
    );
}

fn name(view: i64) -> String {
    format!("{view}")
}

fn store_view(c: &Ctx<'_>, view: i64, shown: i64) -> Result {
    let raw = tatu_value { tag: TATU_I64, reserved: 0, u: tatu_payload { i: shown } };
    // SAFETY: the tag is `TATU_I64`, so the payload is an integer and not a pointer; the value borrows nothing.
    let value = unsafe { ValueRef::new(raw) };
    c.world().set_signal(VIEW_SIGNAL_KIND, name(view).as_bytes(), value)
}
