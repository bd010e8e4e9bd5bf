//! Windows that scripts describe in XML: `simUI.create` and the other `simUI` commands. This plugin stores the content
//! of windows; views receive it in the event `ui.window`, display it, and report user actions by `tatu.actOnWindow`.
//!
//! - `xml`: parses the description; `window`: the content of windows (`node`: their elements) and the event; `actions`:
//!   user actions, and callbacks into scripts;
//! - `program`: whole windows; `fields`: single values of widgets; `lists`: combo boxes, tables and trees; `plots`:
//!   curves and images; `svg`: drawings;
//! - `neutral`: commands that are accepted and do nothing, and constants.

mod actions;
mod fields;
mod lists;
mod neutral;
mod node;
mod plots;
mod plugin;
mod program;
mod svg;
mod window;
mod xml;

use plugin::SimUi;
use tatu_plugin_api::{
    abi::TATU_ERR_BUSY,
    safe::{Event, Fail, Host, Offer, Param, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

/// The V-REP version since which commands called by old names raise errors instead of returning -1 or nil.
const OLD_NAMES_RAISE: &str = "4.2";

impl Plugin for SimUi {
    fn start(_: &Host) -> Result<Self> {
        Ok(SimUi)
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("simui", program::offer);
        offer.subject("simui", actions::offer);
        offer.subject("widgets", fields::offer);
        offer.subject("plots", plots::offer);
        offer.subject("plots", svg::offer);
        offer.subject("lists", lists::offer);
        offer.subject("stubs", neutral::offer);
        offer.each_command(|c| c.old_names_until(OLD_NAMES_RAISE));
        offer.event(
            Event::new(window::WINDOW_EVENT)
                .text("A window was opened, changed or closed.")
                .field(Param::int("window").text("its number"))
                .field(Param::string("act").text("the command that reports a user's action on the window"))
                .field(
                    Param::list("widgets").optional().text(
                        "opened: a map per widget: element, values, and above (the index of the containing widget)",
                    ),
                )
                .field(Param::int("n").optional().text("changed: the index of the widget"))
                .field(Param::bool("asks").optional().text("opened: the script waits for the user's answer"))
                .field(Param::map("set").optional().text("changed: the new values"))
                .field(Param::bool("closed").optional().text("closed")),
        );
    }
}

impl PerWorld for SimUi {
    type World = window::Windows;

    fn world(&self, _: &World<'_>) -> Result<window::Windows> {
        Ok(window::Windows::default())
    }

    const OUTLIVES_RUNS: bool = true;
    fn end_run(&self, windows: &window::Windows, world: &World<'_>) -> Result<()> {
        windows.end_run(world)
    }

    const STATE_VERSION: u32 = 1;
    fn save(world: &window::Windows) -> Result<Vec<u8>> {
        let all = world.0.try_borrow().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "a command is using the windows"))?;
        serde_json::to_vec(&*all).map_err(|e| Fail::new(format!("the windows could not be saved: {e}")))
    }
    fn load(world: &window::Windows, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            return Err(Fail::unsupported(format!(
                "the windows were saved in format version {version}; this program reads version {}",
                Self::STATE_VERSION
            )));
        }
        let all =
            serde_json::from_slice(bytes).map_err(|e| Fail::new(format!("the saved windows are damaged: {e}")))?;
        *world.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "a command is using the windows"))? = all;
        Ok(())
    }
}

tatu_plugin! {
    plugin: SimUi,
    id: "tatu.commands.simui",
    name: "Script windows",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
