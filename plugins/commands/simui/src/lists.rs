//! Combo boxes, tables and trees.

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Offer, Param, Result, ValueRef};

use crate::{
    plugin::{Ctx, MINUS_ONE, NIL, SimUi, both},
    window::{get, set, value, widget},
};

/// Maximum number of rows, columns or entries of a widget.
const MAX_ENTRIES: usize = 10_000;

fn list(json: Json) -> Vec<Json> {
    match json {
        Json::Array(a) => a,
        _ => Vec::new(),
    }
}

fn text(v: ValueRef<'_>) -> Json {
    match v.as_str() {
        Some(t) => json!(t),
        None => v.as_f64().map_or(json!(""), |x| json!(format!("{x}"))),
    }
}

fn texts(c: &Ctx<'_>, i: usize) -> Vec<Json> {
    let all = c.arg(i);
    match all.list() {
        Some(all) => all.iter().copied().map(text).collect(),
        None => all.numbers().unwrap_or_default().iter().map(|x| json!(format!("{x}"))).collect(),
    }
}

/// Returns argument `i` as a zero-based index into `len` entries.
fn entry_index(c: &Ctx<'_>, i: usize, len: usize) -> Result<usize> {
    let at = c.i64(i)?;
    let found = usize::try_from(at).ok().filter(|at| *at < len);
    found.ok_or_else(|| Fail::argument(format!("there is no entry {at}; expected 0 to {}", len as i64 - 1)))
}

fn count(c: &Ctx<'_>, i: usize) -> Result<usize> {
    let n = c.i64(i)?;
    let wrong = || Fail::argument(format!("argument {}: expected 0 to {MAX_ENTRIES}, found {n}", i + 1));
    usize::try_from(n).ok().filter(|n| *n <= MAX_ENTRIES).ok_or_else(wrong)
}

fn return_success(c: &mut Ctx<'_>) -> Result {
    c.ret(1_i64);
    Ok(())
}

/// Applies `f` to the list that a widget stores under a key, and publishes the change.
fn change(c: &mut Ctx<'_>, key: &str, f: impl FnOnce(&Ctx<'_>, &mut Vec<Json>) -> Result) -> Result {
    let at = widget(c)?;
    let mut all = list(get(c, at, key)?);
    f(c, &mut all)?;
    set(c, at, &[(key, Json::Array(all))])?;
    return_success(c)
}

/// Returns the cell in a row and column of a table, or `None` if the table has no such cell.
fn cells(rows: &mut [Json], row: usize, column: usize) -> Option<&mut Json> {
    let Json::Array(cells) = rows.get_mut(row)? else { return None };
    cells.get_mut(column)
}

fn columns(rows: &[Json], headers: &Json) -> usize {
    let widest = rows.iter().filter_map(Json::as_array).map(Vec::len).max().unwrap_or(0);
    widest.max(headers.as_array().map_or(0, Vec::len))
}

const COMBOBOX_EXAMPLE: &str =
    "local ui = simUI.create('<ui><combobox id=\"1\"><item>red</item><item>blue</item></combobox></ui>')\n";
const TABLE_EXAMPLE: &str = "local ui = simUI.create('<ui><table id=\"1\"/></ui>')\nsimUI.setRowCount(ui, 1, 2)\n\
    simUI.setColumnCount(ui, 1, 3)\n";
const TREE_EXAMPLE: &str =
    "local ui = simUI.create('<ui><tree id=\"1\"/></ui>')\nsimUI.addTreeItem(ui, 1, 5, {'arm'}, 0, true)\n";

struct WidgetCommands<'a>(&'a mut Offer<SimUi>);

impl WidgetCommands<'_> {
    /// Adds a command that changes the widget identified by its first two arguments.
    fn set(&mut self, name: &str, params: &[Param], text: &str, example: String, f: fn(&mut Ctx<'_>) -> Result) {
        let mut command =
            both(name, MINUS_ONE, f).param(Param::int("window")).param(Param::any("widget").text("its id"));
        for p in params {
            command = command.param(p.clone());
        }
        self.0.command(command.returns(Param::int("done")).text(text).example(example));
    }
    /// Adds a command that reads from the widget identified by its first two arguments.
    fn get(
        &mut self,
        name: &str,
        params: &[Param],
        result: Param,
        text: &str,
        example: String,
        f: fn(&mut Ctx<'_>) -> Result,
    ) {
        let mut command = both(name, NIL, f).param(Param::int("window")).param(Param::any("widget").text("its id"));
        for p in params {
            command = command.param(p.clone());
        }
        self.0.command(command.returns(result).text(text).example(example));
    }
}

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    let add = &mut WidgetCommands(offer);
    combobox_commands(add);
    table_commands(add);
    tree_commands(add);
}

fn combobox_commands(add: &mut WidgetCommands<'_>) {
    let index = || Param::int("index").text("from 0");
    add.set(
        "simUI.setComboboxItems",
        &[Param::any("items").text("a list of strings"), Param::int("index").default(0).optional()],
        "Sets the entries of a combo box, and selects one of them.",
        format!(
            "{COMBOBOX_EXAMPLE}simUI.setComboboxItems(ui, 1, {{'a', 'b', 'c'}}, 2)\nassert(simUI.getComboboxItemCount(ui, 1) == 3)"
        ),
        |c| {
            let at = widget(c)?;
            let index = if c.has(3) { c.i64(3)? } else { 0 };
            set(c, at, &[("items", Json::Array(texts(c, 2))), ("index", json!(index))])?;
            return_success(c)
        },
    );
    add.set(
        "simUI.insertComboboxItem",
        &[index(), Param::string("text")],
        "Inserts an entry before another one in a combo box.",
        format!(
            "{COMBOBOX_EXAMPLE}simUI.insertComboboxItem(ui, 1, 1, 'green')\nassert(simUI.getComboboxItemText(ui, 1, 1) == 'green')"
        ),
        |c| {
            change(c, "items", |c, items| {
                if items.len() >= MAX_ENTRIES {
                    return Err(Fail::argument(format!("a combo box can have at most {MAX_ENTRIES} entries")));
                }
                let at = usize::try_from(c.i64(2)?).unwrap_or(0).min(items.len());
                items.insert(at, json!(c.text(3)?));
                Ok(())
            })
        },
    );
    add.set(
        "simUI.removeComboboxItem",
        &[index()],
        "Removes an entry from a combo box.",
        format!("{COMBOBOX_EXAMPLE}simUI.removeComboboxItem(ui, 1, 0)\nassert(simUI.getComboboxItemText(ui, 1, 0) == 'blue')"),
        |c| {
            change(c, "items", |c, items| {
                let at = entry_index(c, 2, items.len())?;
                items.remove(at);
                Ok(())
            })
        },
    );
    add.get(
        "simUI.getComboboxItemCount",
        &[],
        Param::int("count"),
        "Returns the number of entries of a combo box.",
        format!("{COMBOBOX_EXAMPLE}assert(simUI.getComboboxItemCount(ui, 1) == 2)"),
        |c| {
            let n = list(get(c, widget(c)?, "items")?).len();
            c.ret(n as i64);
            Ok(())
        },
    );
    add.get(
        "simUI.getComboboxItemText",
        &[index()],
        Param::string("text"),
        "Returns an entry of a combo box.",
        format!("{COMBOBOX_EXAMPLE}assert(simUI.getComboboxItemText(ui, 1, 1) == 'blue')"),
        |c| {
            let items = list(get(c, widget(c)?, "items")?);
            let at = entry_index(c, 2, items.len())?;
            c.ret(items[at].as_str().unwrap_or(""));
            Ok(())
        },
    );
    add.get(
        "simUI.getComboboxItems",
        &[],
        Param::any("items"),
        "Returns the entries of a combo box.",
        format!("{COMBOBOX_EXAMPLE}assert(simUI.getComboboxItems(ui, 1)[1] == 'red')"),
        |c| {
            let items = get(c, widget(c)?, "items")?;
            c.ret(value(&items));
            Ok(())
        },
    );
}

fn table_commands(add: &mut WidgetCommands<'_>) {
    let (row, column) = (|| Param::int("row").text("from 0"), || Param::int("column").text("from 0"));
    add.set("simUI.clearTable", &[], "Empties a table.", format!("{TABLE_EXAMPLE}simUI.clearTable(ui, 1)"), |c| {
        let at = widget(c)?;
        set(c, at, &[("rows", json!([])), ("headers", json!([]))])?;
        return_success(c)
    });
    add.set(
        "simUI.setRowCount",
        &[Param::int("count")],
        "Sets the number of rows of a table.",
        TABLE_EXAMPLE.into(),
        |c| {
            let at = widget(c)?;
            let (n, mut rows) = (count(c, 2)?, list(get(c, at, "rows")?));
            let wide = columns(&rows, &get(c, at, "headers")?);
            rows.resize(n, json!(vec![""; wide]));
            set(c, at, &[("rows", Json::Array(rows))])?;
            return_success(c)
        },
    );
    add.set(
        "simUI.setColumnCount",
        &[Param::int("count")],
        "Sets the number of columns of a table.",
        TABLE_EXAMPLE.into(),
        |c| {
            let at = widget(c)?;
            let (n, mut rows, mut headers) = (count(c, 2)?, list(get(c, at, "rows")?), list(get(c, at, "headers")?));
            if rows.len().saturating_mul(n) > MAX_ENTRIES * 10 {
                return Err(Fail::argument(format!("a table can have at most {} cells", MAX_ENTRIES * 10)));
            }
            rows.iter_mut().filter_map(Json::as_array_mut).for_each(|r| r.resize(n, json!("")));
            headers.resize(n, json!(""));
            set(c, at, &[("rows", Json::Array(rows)), ("headers", Json::Array(headers))])?;
            return_success(c)
        },
    );
    for (name, of_rows) in [("simUI.getRowCount", true), ("simUI.getColumnCount", false)] {
        let f: fn(&mut Ctx<'_>) -> Result = if of_rows {
            |c| {
                let n = list(get(c, widget(c)?, "rows")?).len();
                c.ret(n as i64);
                Ok(())
            }
        } else {
            |c| {
                let at = widget(c)?;
                let n = columns(&list(get(c, at, "rows")?), &get(c, at, "headers")?);
                c.ret(n as i64);
                Ok(())
            }
        };
        let (what, n) = if of_rows { ("rows", 2) } else { ("columns", 3) };
        let text = format!("Returns the number of {what} of a table.");
        add.get(name, &[], Param::int("count"), &text, format!("{TABLE_EXAMPLE}assert({name}(ui, 1) == {n})"), f);
    }
    add.set(
        "simUI.setItem",
        &[row(), column(), Param::string("text")],
        "Sets the text of a cell of a table.",
        format!("{TABLE_EXAMPLE}simUI.setItem(ui, 1, 0, 2, 'x')\nassert(simUI.getItem(ui, 1, 0, 2) == 'x')"),
        |c| {
            change(c, "rows", |c, rows| {
                let (row, column) = (count(c, 2)?, count(c, 3)?);
                let cell = cells(rows, row, column);
                *cell
                    .ok_or_else(|| Fail::argument(format!("the table has no cell in row {row}, column {column}")))? =
                    json!(c.text(4)?);
                Ok(())
            })
        },
    );
    add.get(
        "simUI.getItem",
        &[row(), column()],
        Param::string("text"),
        "Returns the text of a cell of a table.",
        format!("{TABLE_EXAMPLE}assert(simUI.getItem(ui, 1, 1, 0) == '')"),
        |c| {
            let (mut rows, row, column) = (list(get(c, widget(c)?, "rows")?), count(c, 2)?, count(c, 3)?);
            let cell = cells(&mut rows, row, column);
            let cell =
                cell.ok_or_else(|| Fail::argument(format!("the table has no cell in row {row}, column {column}")))?;
            c.ret(cell.as_str().unwrap_or(""));
            Ok(())
        },
    );
    add.set(
        "simUI.setColumnHeaderText",
        &[column(), Param::string("text")],
        "Sets the header of a column of a table.",
        format!("{TABLE_EXAMPLE}simUI.setColumnHeaderText(ui, 1, 0, 'name')"),
        |c| {
            change(c, "headers", |c, headers| {
                let at = entry_index(c, 2, headers.len())?;
                headers[at] = json!(c.text(3)?);
                Ok(())
            })
        },
    );
}

fn tree_commands(add: &mut WidgetCommands<'_>) {
    let item = || Param::int("item").text("its number, chosen by the script");
    add.set(
        "simUI.addTreeItem",
        &[
            item(),
            Param::any("texts").text("one for each column"),
            Param::int("parent").default(0).optional().text("0: none"),
            Param::any("expanded").optional(),
        ],
        "Adds an item to a tree.",
        TREE_EXAMPLE.into(),
        |c| {
            change(c, "rows", |c, rows| {
                if rows.len() >= MAX_ENTRIES {
                    return Err(Fail::argument(format!("a tree can have at most {MAX_ENTRIES} items")));
                }
                let above = if c.has(4) { c.i64(4)? } else { 0 };
                rows.push(json!({
                    "id": c.i64(2)?, "texts": texts(c, 3), "above": above, "open": c.arg(5).truthy(),
                }));
                Ok(())
            })
        },
    );
    add.set(
        "simUI.updateTreeItemText",
        &[item(), Param::any("texts").text("one for each column")],
        "Changes the texts of an item of a tree.",
        format!("{TREE_EXAMPLE}simUI.updateTreeItemText(ui, 1, 5, {{'leg'}})"),
        |c| {
            change(c, "rows", |c, rows| {
                let id = c.i64(2)?;
                let found = rows.iter_mut().find(|r| r["id"] == id);
                found.ok_or_else(|| Fail::missing(format!("the tree has no item {id}")))?["texts"] = json!(texts(c, 3));
                Ok(())
            })
        },
    );
    add.set(
        "simUI.removeTreeItem",
        &[item()],
        "Removes an item from a tree.",
        format!("{TREE_EXAMPLE}simUI.removeTreeItem(ui, 1, 5)"),
        |c| {
            change(c, "rows", |c, rows| {
                let id = c.i64(2)?;
                rows.retain(|r| r["id"] != id);
                Ok(())
            })
        },
    );
    add.set("simUI.clearTree", &[], "Empties a tree.", format!("{TREE_EXAMPLE}simUI.clearTree(ui, 1)"), |c| {
        change(c, "rows", |_, rows| {
            rows.clear();
            Ok(())
        })
    });
    for (name, open) in [("simUI.expandAll", true), ("simUI.collapseAll", false)] {
        let f: fn(&mut Ctx<'_>) -> Result = if open { |c| fold(c, true) } else { |c| fold(c, false) };
        let text = if open { "Expands all items of a tree." } else { "Collapses all items of a tree." };
        add.set(name, &[], text, format!("{TREE_EXAMPLE}{name}(ui, 1)"), f);
    }
}

fn fold(c: &mut Ctx<'_>, open: bool) -> Result {
    change(c, "rows", |_, rows| {
        rows.iter_mut().for_each(|r| r["open"] = json!(open));
        Ok(())
    })
}
