//! Commands for scene editors: edits that can be undone, saving, new scenes and recovery.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Result, Value},
};

use crate::plugin::{Cmd, Ctx, Tatu};

/// Name of a new scene until it is saved under a different name.
const UNTITLED: &str = "untitled";
/// Maximum number of scenes named `untitled` in a folder.
const MAX_UNTITLED: usize = 1000;

/// Executes one call of an edit. `entry` is a list of the command's name and its arguments.
fn call(c: &Ctx<'_>, entry: &Value) -> Result<Value> {
    let wrong = || Fail::argument("argument 2: each call must be a list {name, arguments...}");
    let Value::List(parts) = entry else { return Err(wrong()) };
    let Some((Value::Text(name), args)) = parts.split_first() else { return Err(wrong()) };
    let name = String::from_utf8_lossy(name);
    c.world().call_command(&name, args).map(Value::List)
}

fn execute_edit(c: &mut Ctx<'_>) -> Result {
    let (label, merge) = (c.text(0)?, if c.has(2) { c.text(2)? } else { String::new() });
    let calls = match c.arg(1).to_value()? {
        Value::List(calls) if !calls.is_empty() => calls,
        _ => return Err(Fail::argument("argument 2: expected a list of at least one call {name, arguments...}")),
    };
    let results = c.world().edit(&label, &merge, || calls.iter().map(|e| call(c, e)).collect::<Result<Vec<_>>>())?;
    c.ret(Value::List(results));
    Ok(())
}

/// Undoes the last edit, or redoes the last edit that was undone.
fn step_back(c: &mut Ctx<'_>, redo: bool) -> Result {
    let label = c.world().step_back(redo)?;
    c.ret(label.map_or(Value::Nil, Value::text));
    Ok(())
}

/// Opens a new scene under the first unused file name.
fn new_scene(c: &mut Ctx<'_>) -> Result {
    let world = c.world();
    for n in 1..=MAX_UNTITLED {
        let name = if n == 1 { format!("{UNTITLED}.toml") } else { format!("{UNTITLED}-{n}.toml") };
        if world.file(name.as_bytes(), TATU_FILE_READ).is_ok_and(|path| exists(&path)) {
            continue;
        }
        let path = world.file(name.as_bytes(), TATU_FILE_WRITE)?;
        world.open_as(&path, TATU_OPEN_NEW)?;
        c.ret(String::from_utf8_lossy(&path).into_owned());
        return Ok(());
    }
    Err(Fail::new(format!("the folder already contains {MAX_UNTITLED} scenes named `{UNTITLED}`"))
        .help("save some of them under other names, or remove them"))
}

fn exists(path: &[u8]) -> bool {
    std::path::Path::new(&*String::from_utf8_lossy(path)).symlink_metadata().is_ok()
}

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.edit", execute_edit)
            .param(Param::string("label").text("a description of the edit that can follow \"Undo\": `Move cup`"))
            .param(Param::any("calls").text("a list of command calls, each `{name, arguments...}`"))
            .param(
                Param::string("merge").optional().text(
                    "consecutive edits with the same label and the same `merge` are undone together, as in a drag",
                ),
            )
            .returns(Param::any("results").text("a list per call, with its results"))
            .text(
                "Calls commands as one edit, which `tatu.undo` undoes as a whole: removed objects are restored with \
                 their handles, names, order and scripts. If one of the calls fails, the others are undone. While the \
                 simulation runs, edits cannot be undone; a stop reverts them, except for script texts.",
            )
            .example(
                "local floor = tatu.list('shape')[1]\n\
                 local name = tatu.get(floor, 'object.alias')\n\
                 tatu.edit('Rename floor', {{'tatu.set', floor, 'object.alias', 'ground'}})\n\
                 assert(tatu.get(floor, 'object.alias') == 'ground')\n\
                 tatu.set(floor, 'object.alias', name)",
            ),
    );
    offer.command(
        Cmd::new("tatu.undo", |c| step_back(c, false))
            .returns(Param::string("label").optional().text("of the undone edit; nil: there was nothing to undo"))
            .text("Undoes the last edit. Fails while the simulation runs, and in callbacks of scripts.")
            .example("assert(not pcall(tatu.undo))"),
    );
    offer.command(
        Cmd::new("tatu.redo", |c| step_back(c, true))
            .returns(Param::string("label").optional().text("of the redone edit; nil: there was nothing to redo"))
            .text("Redoes the edit that `tatu.undo` undid last, unless another edit was made since.")
            .example("assert(not pcall(tatu.redo))"),
    );
    offer.command(
        Cmd::new("tatu.edits", |c| {
            let edits = c.world().edits()?.to_value()?;
            c.ret(edits);
            Ok(())
        })
        .returns(Param::any("edits").text(
            "a table: undo and redo (labels, the next one last), unsaved, revision (a number that identifies the \
             state), file, on_disk, recovery (Unix time of a copy with unsaved edits, in s)",
        ))
        .text("Returns which edits can be undone and redone, and whether the scene differs from its file.")
        .example("assert(tatu.edits().unsaved == false)"),
    );
    offer.command(
        Cmd::new("tatu.saveScene", |c| {
            let over = c.arg(1).truthy();
            let file = match c.has(0) {
                true => c.text(0)?,
                false => String::new(),
            };
            if file.is_empty() {
                return c.world().save_edits(b"", over);
            }
            let path = c.world().file(file.as_bytes(), TATU_FILE_WRITE)?;
            c.world().save_edits(&path, over)
        })
        .param(Param::string("file").optional().text(
            "a file with the suffix .toml, in a folder that scripts may use, which becomes the scene's file; omitted: \
             the scene's current file, which only remote clients and the page may write",
        ))
        .param(
            Param::bool("over")
                .optional()
                .text("true: replaces the file even if it has changed on disk since it was opened"),
        )
        .text(
            "Saves the scene in its stopped state. In the scene's own file, everything that edits did not change is \
             preserved as written: comments, order, units. Changes made by scripts in a run are not saved.",
        )
        .example("tatu.saveScene('example_scene.toml')"),
    );
    offer.command(
        Cmd::new("tatu.newScene", new_scene)
            .returns(Param::string("file").text("its file name until it is saved under another name"))
            .text("Opens a new scene that contains only a floor. Supported only by `tatu serve` and `tatu open`.")
            .example("assert(not pcall(tatu.newScene))"),
    );
    offer.command(
        Cmd::new("tatu.recover", |c| {
            let keep = c.arg(0).truthy();
            let file = c.world().get(0, c.world().host().prop("scene.file"))?;
            let file = file.as_str().map(|s| s.into_owned()).unwrap_or_default();
            match keep {
                true => c.world().open_as(file.as_bytes(), TATU_OPEN_RECOVERED),
                false => c.world().discard_copy(),
            }
        })
        .param(Param::bool("keep").text("true: opens the copy; false: removes it"))
        .text(
            "Opens or removes the copy with unsaved edits that a program left next to the scene's file when it \
             terminated unexpectedly.",
        )
        .example("assert(not pcall(tatu.recover, true))"),
    );
}
