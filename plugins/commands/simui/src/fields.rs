//! Commands that set and read a single value of a widget.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result};

use crate::{
    actions,
    plugin::{Ctx, MINUS_ONE, NIL, SimUi, both},
    window::{borrow_windows, get, set, widget},
};

/// The type of a field's value.
#[derive(Clone, Copy, PartialEq)]
enum FieldType {
    Text,
    Int,
    Float,
    Truth,
}
use FieldType::*;

struct WidgetField {
    /// The part of the command names after `simUI.set` and `simUI.get`.
    name: &'static str,
    /// Elements that have this value; empty: all elements.
    of: &'static [&'static str],
    key: &'static str,
    value_type: FieldType,
    is_readable: bool,
    text: &'static str,
    /// The element in the generated example; `sample` is its value.
    element: &'static str,
    sample: &'static str,
}

const fn field(
    name: &'static str,
    of: &'static [&'static str],
    (key, holds, gets): (&'static str, FieldType, bool),
    text: &'static str,
    (element, sample): (&'static str, &'static str),
) -> WidgetField {
    WidgetField { name, of, key, value_type: holds, is_readable: gets, text, element, sample }
}

/// Returns the description of a field as the object of a sentence such as "Sets ...".
fn field_phrase(f: &WidgetField) -> String {
    if f.text.starts_with("whether ") { f.text.to_owned() } else { format!("the {}", f.text) }
}

const FIELDS: &[WidgetField] = &[
    field("LabelText", &["label"], ("text", Text, true), "text of a label", ("label", "'fast'")),
    field("ButtonText", &["button"], ("text", Text, true), "text of a button", ("button", "'Stop'")),
    field("Text", &["text-browser"], ("text", Text, true), "text of a text browser", ("text-browser", "'two lines'")),
    field("EditValue", &["edit"], ("value", Text, true), "text of an edit field", ("edit", "'0.5'")),
    field("SliderValue", &["hslider", "vslider"], ("value", Int, true), "value of a slider", ("hslider", "40")),
    field("SpinboxValue", &["spinbox"], ("value", Float, true), "value of a spin box", ("spinbox", "2.0")),
    field(
        "CheckboxValue",
        &["checkbox"],
        ("checked", Int, true),
        "state of a check box: 0 off, 1 partially checked, 2 on",
        ("checkbox", "2"),
    ),
    field(
        "RadiobuttonValue",
        &["radiobutton"],
        ("checked", Int, true),
        "state of a radio button: 0 off, 1 on",
        ("radiobutton", "1"),
    ),
    field("Progress", &["progressbar"], ("value", Float, false), "value of a progress bar", ("progressbar", "30")),
    field(
        "ButtonPressed",
        &["button"],
        ("checked", Truth, false),
        "pressed state of a checkable button",
        ("button", "true"),
    ),
    field("CurrentTab", &["tabs"], ("current", Int, true), "selected tab, from 0", ("tabs", "0")),
    field(
        "ComboboxSelectedIndex",
        &["combobox"],
        ("index", Int, true),
        "selected entry of a combo box, from 0; -1: none",
        ("combobox", "0"),
    ),
    field("Enabled", &[], ("enabled", Truth, false), "whether a widget is enabled", ("button", "false")),
    field("WidgetVisibility", &[], ("visible", Truth, false), "whether a widget is shown", ("label", "false")),
    field("StyleSheet", &[], ("style", Text, false), "colours and font size of a widget", ("label", "'color: red'")),
];

fn check(c: &Ctx<'_>, at: (i64, usize), f: &WidgetField) -> Result {
    let element = borrow_windows(c)?.window_mut(at.0)?.nodes[at.1].element.clone();
    if f.of.is_empty() || f.of.contains(&element.as_str()) {
        return Ok(());
    }
    Err(Fail::argument(format!("only elements of type {} have this value, not {element}", f.of.join(" or "))))
}

fn set_field(c: &mut Ctx<'_>, f: &'static WidgetField) -> Result {
    let at = widget(c)?;
    check(c, at, f)?;
    let value = match f.value_type {
        Text => json!(c.text(2)?),
        Truth => json!(c.arg(2).truthy()),
        Int => json!(c.f64(2)?.round() as i64),
        Float => json!(c.f64(2)?),
    };
    set(c, at, &[(f.key, value.clone())])?;
    // A change by a script calls the callback only if the script passes `suppressEvents = false`.
    if c.has(3) && !c.arg(3).truthy() && f.is_readable {
        actions::call_back(c, at, &[value])?;
    }
    c.ret(1_i64);
    Ok(())
}

fn get_field(c: &mut Ctx<'_>, f: &'static WidgetField) -> Result {
    let at = widget(c)?;
    check(c, at, f)?;
    let value = get(c, at, f.key)?;
    match f.value_type {
        Text => c.ret(value.as_str().unwrap_or("")),
        Truth => c.ret(value == Json::Bool(true)),
        Int => c.ret(value.as_f64().unwrap_or(0.0).round() as i64),
        Float => c.ret(value.as_f64().unwrap_or(0.0)),
    }
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    for f in FIELDS {
        let made = format!("local ui = simUI.create('<ui><{} id=\"1\"/></ui>')\n", f.element);
        let sets = format!("simUI.set{}", f.name);
        let gets = format!("simUI.get{}", f.name);
        let (kind, result): (fn(&str) -> Param, _) = match f.value_type {
            Text => (Param::string, Param::string("value")),
            Int | Float => {
                (Param::float, if f.value_type == Int { Param::int("value") } else { Param::float("value") })
            }
            Truth => (Param::any, Param::bool("value")),
        };
        let equal = if f.is_readable { format!("\nassert({gets}(ui, 1) == {})", f.sample) } else { String::new() };
        let widget = || Param::any("widget").text("its id");
        offer.command(
            both(&sets, MINUS_ONE, move |c| set_field(c, f))
                .param(Param::int("window"))
                .param(widget())
                .param(kind("value"))
                .param(
                    Param::any("suppressEvents")
                        .default(true)
                        .optional()
                        .text("false: also calls the script's callback"),
                )
                .returns(Param::int("done"))
                .text(format!("Sets {}.", field_phrase(f)))
                .example(format!("{made}{sets}(ui, 1, {}){equal}", f.sample)),
        );
        if f.is_readable {
            offer.command(
                both(&gets, NIL, move |c| get_field(c, f))
                    .param(Param::int("window"))
                    .param(widget())
                    .returns(result)
                    .text(format!("Returns {}.", field_phrase(f)))
                    .example(format!("{made}{sets}(ui, 1, {})\nassert({gets}(ui, 1) == {})", f.sample, f.sample)),
            );
        }
    }
}
