//! The command that an exporter offers: `export.SUFFIX`, by which `tatu export` finds it.

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Command, Fail, Param, Plugin, Result, Value, World},
};

use crate::{objects::SceneReader, report::ExportReport};

/// What an exporter gets and returns.
pub struct Export<'a> {
    /// The scene.
    pub reader: SceneReader<'a>,
    /// The object to export with all that is below it; 0: the whole scene.
    pub base: tatu_object,
    /// Name for what has none of its own.
    pub name: String,
    /// What the file does not hold.
    pub report: ExportReport,
    /// Files beside the exported one, by name, relative to it.
    pub files: BTreeMap<String, String>,
}

/// Maximum size of all files of an export, bytes: what the host can take as results of one call, and some more.
const MAX_BYTES: usize = 240 << 20;

/// Declares the command of an exporter. `write` returns the text of the exported file.
pub fn export_command<P: Plugin>(
    name: &str,
    write: impl Fn(&mut Export<'_>) -> Result<String> + Send + Sync + 'static,
) -> Command<P> {
    let run = move |c: &mut tatu_plugin_api::safe::Call<'_, P>| {
        let world: World<'_> = c.world();
        let base = match c.has(0) {
            true => c.arg(0).as_object().ok_or_else(|| Fail::argument("argument 1: expected an object or nil"))?,
            false => 0,
        };
        let base = if base == 0 { 0 } else { world.look(base)?.id };
        let name = if c.has(1) { c.text(1)? } else { String::new() };
        let reader = SceneReader { world };
        let mut export = Export { reader, base, name, report: ExportReport::default(), files: BTreeMap::new() };
        let text = write(&mut export)?;
        let bytes = text.len() + export.files.values().map(String::len).sum::<usize>();
        if bytes > MAX_BYTES {
            return Err(Fail::new(format!(
                "the exported files would have {} MB; expected at most {} MB",
                bytes >> 20,
                MAX_BYTES >> 20
            ))
            .help("export one robot, or one with fewer triangles"));
        }
        let files =
            export.files.into_iter().map(|(name, text)| (Value::from(name.as_str()), Value::Text(text.into_bytes())));
        let files: Vec<(Value, Value)> = files.collect();
        let report = export.report.value();
        c.ret(text);
        c.ret(Value::Map(files));
        c.ret(report);
        Ok(())
    };
    Command::new(name, run)
        .param(
            Param::object("object")
                .optional()
                .text("the object to export with all that is below it; nil: the whole scene"),
        )
        .param(
            Param::string("name")
                .optional()
                .text("name for what has none of its own, such as the name of the file without its suffix"),
        )
        .returns(Param::string("text").text("the file"))
        .returns(Param::map("files").text("further files by name, relative to the first: text of each"))
        .returns(Param::list("report").text(
            "what the file holds differently or not: a table each, with `lost` (whether something is lost), `text` and \
             `objects` (paths)",
        ))
}
