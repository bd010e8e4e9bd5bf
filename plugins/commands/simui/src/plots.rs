//! Plots and images.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result, Value};

use crate::{
    plugin::{Ctx, MINUS_ONE, SimUi, both},
    window::{WINDOW_EVENT, borrow_windows, get, publish_in_call, set, widget},
};

/// Maximum number of points per curve if a plot does not set `max-buffer-size`.
const DEFAULT_POINTS: usize = 1000;
const MAX_POINTS: usize = 100_000;
const MAX_CURVES: usize = 50;
/// Maximum number of pixels of an image.
const MAX_PIXELS: usize = 1 << 21;

const PLOT_EXAMPLE: &str =
    "local ui = simUI.create('<ui><plot id=\"1\"/></ui>')\nsimUI.addCurve(ui, 1, 0, 'v', {200, 0, 0}, 1, {})\n";

/// Applies `f` to the curves of a plot. Views receive the change when the script calls `simUI.replot`.
fn edit_curves(c: &mut Ctx<'_>, f: impl FnOnce(&Ctx<'_>, &mut Vec<Json>, usize) -> Result) -> Result {
    let (window, n) = widget(c)?;
    let mut held = match get(c, (window, n), "curves")? {
        Json::Array(held) => held,
        _ => return Err(Fail::argument("argument 2: expected the id of a plot")),
    };
    let buffer =
        get(c, (window, n), "max-buffer-size")?.as_f64().map_or(DEFAULT_POINTS, |x| x as usize).min(MAX_POINTS);
    f(c, &mut held, buffer)?;
    borrow_windows(c)?.window_mut(window)?.nodes[n].values.insert("curves".into(), Json::Array(held));
    c.ret(1_i64);
    Ok(())
}

fn curve_by_name<'a>(c: &Ctx<'_>, curves: &'a mut [Json], i: usize) -> Result<&'a mut Json> {
    let name = c.text(i)?;
    let found = curves.iter_mut().find(|k| k["name"] == name.as_str());
    found.ok_or_else(|| Fail::missing(format!("the plot has no curve `{name}`")))
}

fn add_points(c: &mut Ctx<'_>, xs: usize) -> Result {
    edit_curves(c, |c, all, buffer| {
        let curve = curve_by_name(c, all, 2)?;
        let numbers = |i: usize| c.arg(i).numbers().or_else(|| c.arg(i).as_f64().map(|x| vec![x])).unwrap_or_default();
        let (x, y) = (numbers(xs), numbers(xs + 1));
        if x.len() != y.len() {
            return Err(Fail::argument(format!(
                "{} x values and {} y values: expected the same number of each",
                x.len(),
                y.len()
            )));
        }
        for (key, new) in [("x", x), ("y", y)] {
            if let Json::Array(held) = &mut curve[key] {
                held.extend(new.into_iter().map(|v| json!(v)));
                let over = held.len().saturating_sub(buffer);
                held.drain(..over);
            }
        }
        Ok(())
    })
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    let (window, plot) = (|| Param::int("window"), || Param::any("plot").text("its id"));
    let curve = || Param::string("curve").text("its name");
    offer.command(
        both("simUI.addCurve", MINUS_ONE, |c| {
            edit_curves(c, |c, all, _| {
                if all.len() >= MAX_CURVES {
                    return Err(Fail::argument(format!("a plot can have at most {MAX_CURVES} curves")));
                }
                let name = c.text(3)?;
                let color: Vec<f64> = c.arg(4).numbers().unwrap_or_else(|| vec![200.0, 0.0, 0.0]);
                all.retain(|k| k["name"] != name.as_str());
                all.push(json!({
                    "name": name, "kind": c.i64(2)?, "color": color, "style": c.arg(5).as_i64(), "x": [], "y": [],
                }));
                Ok(())
            })
        })
        .param(window())
        .param(plot())
        .param(Param::int("type").text("simUI.curve_type: time or xy"))
        .param(curve())
        .param(Param::any("color").text("red, green, blue, 0 to 255"))
        .param(Param::any("style").optional().text("simUI.curve_style"))
        .param(Param::any("options").optional().text("ignored"))
        .returns(Param::int("done"))
        .text("Adds a curve to a plot.")
        .example(PLOT_EXAMPLE),
    );
    offer.command(
        both("simUI.addCurveTimePoints", MINUS_ONE, |c| add_points(c, 3))
            .param(window())
            .param(plot())
            .param(curve())
            .param(Param::any("times").unit("s"))
            .param(Param::any("values"))
            .returns(Param::int("done"))
            .text("Adds points to a curve over time; `simUI.replot` shows them.")
            .example(format!(
                "{PLOT_EXAMPLE}simUI.addCurveTimePoints(ui, 1, 'v', {{0, 1}}, {{2, 3}})\nsimUI.replot(ui, 1)"
            )),
    );
    offer.command(
        both("simUI.addCurveXYPoints", MINUS_ONE, |c| add_points(c, 4))
            .param(window())
            .param(plot())
            .param(curve())
            .param(Param::any("order").text("ignored: points are joined in the order in which they were added"))
            .param(Param::any("x"))
            .param(Param::any("y"))
            .returns(Param::int("done"))
            .text("Adds points to an xy curve; `simUI.replot` shows them.")
            .example(format!("{PLOT_EXAMPLE}simUI.addCurveXYPoints(ui, 1, 'v', {{1}}, {{0}}, {{2}})")),
    );
    for (name, gone) in [("simUI.clearCurve", false), ("simUI.removeCurve", true)] {
        offer.command(
            both(name, MINUS_ONE, move |c| {
                edit_curves(c, |c, all, _| {
                    let found = curve_by_name(c, all, 2)?;
                    (found["x"], found["y"]) = (json!([]), json!([]));
                    let name = found["name"].clone();
                    all.retain(|k| !gone || k["name"] != name);
                    Ok(())
                })
            })
            .param(window())
            .param(plot())
            .param(curve())
            .returns(Param::int("done"))
            .text(if gone { "Removes a curve." } else { "Removes all points of a curve." })
            .example(format!("{PLOT_EXAMPLE}{name}(ui, 1, 'v')")),
        );
    }
    offer.command(
        both("simUI.replot", MINUS_ONE, |c| {
            let (window, n) = widget(c)?;
            let held = get(c, (window, n), "curves")?;
            publish_in_call(c, json!({ "window": window, "n": n, "set": { "curves": held } }))?;
            c.ret(1_i64);
            Ok(())
        })
        .param(window())
        .param(plot())
        .returns(Param::int("done"))
        .text("Shows the current points of all curves of a plot.")
        .example(format!("{PLOT_EXAMPLE}simUI.replot(ui, 1)")),
    );
    offer.command(
        both("simUI.setImageData", MINUS_ONE, |c| {
            let at = widget(c)?;
            let (data, width, height) = (c.bytes(2)?, c.i64(3)?, c.i64(4)?);
            let pixels = (width.max(0) as usize).saturating_mul(height.max(0) as usize);
            if pixels == 0 || pixels > MAX_PIXELS || data.len() != pixels * 3 {
                return Err(Fail::argument(format!(
                    "an image of {width} x {height} pixels requires {} bytes, found {}; at most {MAX_PIXELS} pixels",
                    pixels.saturating_mul(3),
                    data.len()
                )));
            }
            // JSON cannot contain bytes, so the pixels are published in a separate event and are not saved.
            set(c, at, &[("columns", json!(width)), ("rows", json!(height))])?;
            let map = |entries: [(&str, Value); 4]| Value::Map(entries.map(|(k, v)| (Value::text(k), v)).into());
            let pixels = Value::Map(vec![(Value::text("pixels"), Value::Bytes(data.to_vec()))]);
            c.world().publish_value(
                WINDOW_EVENT,
                &map([
                    ("window", at.0.into()),
                    ("n", (at.1 as i64).into()),
                    ("set", pixels),
                    ("act", "tatu.actOnWindow".into()),
                ]),
            )?;
            c.ret(1_i64);
            Ok(())
        })
        .param(window())
        .param(Param::any("image").text("its id"))
        .param(Param::string("data").text("red, green and blue bytes of each pixel, top row first"))
        .param(Param::int("width"))
        .param(Param::int("height"))
        .returns(Param::int("done"))
        .text("Shows an image.")
        .example(
            "local ui = simUI.create('<ui><image id=\"1\"/></ui>')\n\
             simUI.setImageData(ui, 1, string.rep('\\255\\0\\0', 4), 2, 2)",
        ),
    );
}
