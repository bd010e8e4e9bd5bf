//! SVG drawings.

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{Fail, Offer, Param, Result},
};
use xml::{ParserConfig, reader::XmlEvent};

use crate::{
    node::WidgetNode,
    plugin::{Ctx, MINUS_ONE, SimUi, both},
    window::{borrow_windows, set, widget},
};

/// Maximum length of a drawing, in bytes.
const MAX_BYTES: usize = 4 << 20;

/// Returns the text of a drawing, or an empty string if it is not well-formed XML with a single `<svg>` element. Views
/// show nothing for an empty string.
fn read(bytes: &[u8]) -> Result<String> {
    if bytes.len() > MAX_BYTES {
        return Err(Fail::argument(format!("the drawing has {} bytes; at most {MAX_BYTES} are accepted", bytes.len())));
    }
    let Ok(text) = std::str::from_utf8(bytes) else { return Ok(String::new()) };
    let text = text.trim();
    // The text must be a single `<svg>` element.
    let (mut roots, mut depth, mut good) = (0, 0_usize, true);
    for event in ParserConfig::new().create_reader(text.as_bytes()) {
        match event {
            Ok(XmlEvent::StartElement { name, .. }) => {
                if depth == 0 {
                    roots += 1;
                    good &= name.local_name == "svg";
                }
                depth += 1;
            }
            Ok(XmlEvent::EndElement { .. }) => depth = depth.saturating_sub(1),
            Ok(_) => {}
            Err(_) => return Ok(String::new()),
        }
    }
    Ok(if good && roots == 1 { text.to_owned() } else { String::new() })
}

fn read_file(c: &Ctx<'_>, name: &[u8]) -> Result<String> {
    read(&c.world().read_file(name, MAX_BYTES as u64)?)
}

/// Reads the SVG files to which a description refers. If a file cannot be read, a warning is logged, and its element
/// remains empty.
pub(crate) fn load(c: &Ctx<'_>, nodes: &mut [WidgetNode]) {
    for node in nodes.iter_mut().filter(|n| n.element == "svg") {
        let Some(name) = node.values.get("file").and_then(Json::as_str) else { continue };
        match read_file(c, name.as_bytes()) {
            Ok(data) => drop(node.values.insert("data".into(), json!(data))),
            Err(why) => {
                c.world().host().log(TATU_LOG_WARNING, &format!("simUI: <svg file=\"{name}\">: {}", why.text()));
            }
        }
    }
}

/// Returns the window and the `<svg>` element that arguments 0 and 1 identify.
fn drawing(c: &Ctx<'_>) -> Result<(i64, usize)> {
    let (window, n) = widget(c)?;
    let element = borrow_windows(c)?.window_mut(window)?.nodes[n].element.clone();
    if element == "svg" {
        return Ok((window, n));
    }
    Err(Fail::argument(format!("argument 2: expected an <svg>, found a <{element}>")))
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    for (name, from_file) in [("simUI.svgLoadData", false), ("simUI.svgLoadFile", true)] {
        offer.command(
            both(name, MINUS_ONE, move |c| {
                let at = drawing(c)?;
                let data = if from_file { read_file(c, c.bytes(2)?)? } else { read(c.bytes(2)?)? };
                set(c, at, &[("data", json!(data))])?;
                c.ret(1_i64);
                Ok(())
            })
            .param(Param::int("window"))
            .param(Param::any("svg").text("its id"))
            .param(if from_file {
                Param::string("file").text("its name, in the folder of the scene or of the run")
            } else {
                Param::string("data").text("the source text of the drawing")
            })
            .returns(Param::int("done"))
            .text("Shows an SVG drawing; if it is invalid, nothing is shown.")
            .example(if from_file {
                "local ui = simUI.create('<ui><svg id=\"1\"/><label id=\"2\"/></ui>')\n\
                 assert(not pcall(simUI.svgLoadFile, ui, 1, 'nowhere.svg'))\n\
                 assert(not pcall(simUI.svgLoadFile, ui, 2, 'nowhere.svg'))"
            } else {
                "local ui = simUI.create('<ui><svg id=\"1\"/></ui>')\n\
                 simUI.svgLoadData(ui, 1, '<svg xmlns=\"http://www.w3.org/2000/svg\"><circle r=\"9\"/></svg>')\n\
                 for _, window in ipairs(tatu.windows()) do\n  \
                   if window.window == ui then assert(window.widgets[2].values.data:find('circle')) end\n\
                 end"
            }),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_drawing_is_read_as_empty() {
        let good = "<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0'/></svg>";
        assert_eq!(read(good.as_bytes()).unwrap(), good);
        for none in ["", "words", "<html/>", "<svg><g></svg>", "<svg/><svg/>"] {
            assert_eq!(read(none.as_bytes()).unwrap(), "", "{none}");
        }
        assert_eq!(read(&[0xff, 0xfe]).unwrap(), "");
        assert!(read(&vec![b' '; MAX_BYTES + 1]).is_err());
    }
}
