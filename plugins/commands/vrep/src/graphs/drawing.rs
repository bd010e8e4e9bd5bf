//! Commands on drawing objects and particles: items in space that images and services display.

use super::curves::color;
use crate::kit::*;

// Flags that scripts add to the type number of a drawing.
const ITEM_COLORS: i64 = 32;
const VERTEX_COLORS: i64 = 64;
const ITEM_SIZES: i64 = 128;
const CYCLIC: i64 = 4096;
const ITEM_TRANSPARENCY: i64 = 0x80000;
const PERSISTENT: i64 = 0x100000;

/// The types of drawings, in the order of their numbers, each with the number of points per item.
const DRAWING_TYPES: [(&str, i64); 13] = [
    ("points", 1),
    ("lines", 2),
    ("triangles", 3),
    ("triangle_points", 1),
    ("quad_points", 1),
    ("disc_points", 1),
    ("cube_points", 1),
    ("sphere_points", 1),
    ("line_strip", 1),
    // Since V-REP 4.2, point markers have a second set of type numbers.
    ("triangle_points", 1),
    ("quad_points", 1),
    ("disc_points", 1),
    ("cube_points", 1),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let command = |names: CommandNames, run: fn(&mut Ctx<'_>) -> Result| both(names, MINUS_ONE, run);
    offer.command(
        command(["sim.addDrawingObject", "simAddDrawingObject"], add)
            .param(Param::int("type").text("sim.drawing_..., plus attributes"))
            .param(Param::float("size").text("for points and lines: pixels; for others: m"))
            .param(Param::float("duplicateTolerance").unit("m").text("an item closer than this to another is omitted"))
            .param(Param::int("parent").text("the object with which the drawing moves; -1: the world"))
            .param(Param::int("maxItemCount").text("0: the greatest possible number"))
            .param(table("color", "red, green, blue, 0 to 1").optional())
            .param(Param::any("reserved").optional())
            .param(Param::any("specular").optional().text("ignored"))
            .param(Param::any("emission").optional().text("ignored"))
            .returns(Param::int("drawing"))
            .text("Adds a drawing: a container of items in space. Unless persistent, it is removed after the run.")
            .example("lines = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 1000, {1, 0, 0})"),
    );
    offer.command(
        command(["sim.addDrawingObjectItem", "simAddDrawingObjectItem"], |c| {
            let drawing = c.i64(0)? & HANDLE_BITS;
            let mut items = if c.has(1) { c.arg(1).numbers().unwrap_or_default() } else { Vec::new() };
            if c.has(1) && items.is_empty() {
                return Err(Fail::argument("argument 2: expected a table of numbers or nil"));
            }
            // V-REP reads one item and ignores the remaining numbers. Scripts rely on this when they pass the result of
            // `sim.checkDistance`, which is a segment followed by its length.
            let figure = c.world().figure(0, drawing, false).ok();
            if let Some((stride, oriented)) = figure.and_then(|f| Some((stride(f)?, is_oriented(f)))) {
                items = complete_items(items, stride, oriented);
            }
            let taken = c.world().put_figure(0, drawing, &items)?;
            c.ret(i64::from(items.is_empty() || taken > 0));
            Ok(())
        })
        .param(Param::int("drawing"))
        .param(Param::any("item").optional().text("numbers of an item, in the world frame; nil: empties the drawing"))
        .returns(Param::int("result").text("1: added; 0: full, or too close to another item"))
        .text("Adds an item to a drawing. The item is stored relative to the drawing's parent.")
        .example("sim.addDrawingObjectItem(lines, {0, 0, 0, 1, 0, 0})"),
    );
    offer.command(
        command(["sim.removeDrawingObject", "simRemoveDrawingObject"], remove)
            .param(Param::int("drawing").text("its number, or sim.handle_all"))
            .returns(Param::int("result").text("1"))
            .text("Removes a drawing.")
            .example("sim.removeDrawingObject(lines)"),
    );
    particles(offer);
}

/// Returns the number of values per item of a drawing.
fn stride(drawing: ValueRef<'_>) -> Option<usize> {
    drawing.get("stride")?.as_f64().map(|x| x as usize).filter(|n| *n > 0)
}

/// Returns whether the items of a drawing have a normal.
fn is_oriented(drawing: ValueRef<'_>) -> bool {
    let form = drawing.get("form").and_then(|f| f.as_str().map(|f| f.into_owned())).unwrap_or_default();
    form.ends_with("_points") && form != "sphere_points"
}

/// Converts items to the layout of a drawing with `stride` values per item. Marks have a normal, which scripts leave
/// out if the marks face the camera, or replace by a quaternion since V-REP 4.2. If the numbers do not form whole
/// items, only the first item is used.
fn complete_items(mut items: Vec<f64>, stride: usize, oriented: bool) -> Vec<f64> {
    let whole = |n: usize| !items.is_empty() && items.len().is_multiple_of(n);
    if oriented && !whole(stride) {
        let normal = |rest: &[f64]| match *rest {
            // The z axis of the quaternion x y z w.
            [x, y, z, w, ..] => [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w + z * z - x * x - y * y],
            _ => [0.0, 0.0, 1.0],
        };
        for (n, turned) in [(stride + 1, 4), (stride - 3, 0)] {
            if whole(n) {
                let item = |i: &[f64]| [&i[..3], &normal(&i[3..3 + turned])[..], &i[3 + turned..]].concat();
                return items.chunks_exact(n).flat_map(item).collect();
            }
        }
    }
    if items.len() > stride && !whole(stride) {
        items.truncate(stride);
    }
    items
}

fn keys_of(form: &str, more: Vec<(&str, Value)>) -> Value {
    let first = ("form", Value::text(form));
    Value::Map(std::iter::once(first).chain(more).map(|(k, v)| (Value::text(k), v)).collect())
}

fn add(c: &mut Ctx<'_>) -> Result {
    let kind = c.i64(0)?;
    let (form, points) = *usize::try_from(kind & 31)
        .ok()
        .and_then(|i| DRAWING_TYPES.get(i))
        .ok_or_else(|| Fail::argument(format!("argument 1: there is no drawing type {}", kind & 31)))?;
    let has = |flag: i64| kind & flag != 0;
    let colors = if has(VERTEX_COLORS) { 3 * points } else { 3 * i64::from(has(ITEM_COLORS)) };
    let extra = colors + i64::from(has(ITEM_SIZES)) + i64::from(has(ITEM_TRANSPARENCY));
    let mut all = vec![
        ("size", Value::Float(c.f64(1)?)),
        ("tolerance", Value::Float(c.f64(2)?.max(0.0))),
        ("capacity", Value::Int(c.i64(4)?.clamp(0, 1_000_000))),
        ("cyclic", Value::Bool(has(CYCLIC))),
        ("persistent", Value::Bool(has(PERSISTENT))),
        ("extra", Value::Int(extra)),
    ];
    if c.i64(3)? >= 0 {
        all.push(("parent", Value::Object(existing_object(c, 3)?.id)));
    }
    if c.has(5) {
        all.push(("color", color(c, 5)?));
    }
    let id = c.world().add_figure(0, TATU_FIGURE_DRAWING, &keys_of(form, all))?;
    c.ret(id);
    Ok(())
}

fn remove(c: &mut Ctx<'_>) -> Result {
    match c.i64(0)? {
        HANDLE_ALL => {
            for id in c.world().figures(0, TATU_FIGURE_DRAWING)? {
                c.world().remove_figure(0, id)?;
            }
        }
        one => c.world().remove_figure(0, one & HANDLE_BITS)?,
    }
    c.ret(1_i64);
    Ok(())
}

/// Adds the particle commands. Particles remain where they are created: they neither move nor collide.
fn particles(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.addParticleObject", |c| {
            let capacity = c.i64(5)?;
            let mut all = vec![
                ("size", Value::Float(c.f64(1)?)),
                ("capacity", Value::Int(if capacity <= 0 { 10_000 } else { capacity.min(1_000_000) })),
                ("cyclic", Value::Bool(true)),
            ];
            if c.has(6) {
                all.push(("color", color(c, 6)?));
            }
            let id = c.world().add_figure(0, TATU_FIGURE_DRAWING, &keys_of("sphere_points", all))?;
            c.ret(id);
            Ok(())
        })
        .old_name("simAddParticleObject", MINUS_ONE)
        .param(Param::int("type"))
        .param(Param::float("size").unit("m"))
        .param(Param::any("density").optional().text("ignored: particles have no mass here"))
        .param(Param::any("parameters").optional().text("ignored"))
        .param(Param::any("lifeTime").optional().text("ignored: particles remain until newer ones displace them"))
        .param(Param::int("maxItemCount").default(0).optional())
        .param(table("color", "red, green, blue, 0 to 1").optional())
        .param(Param::any("more").rest().text("ignored"))
        .returns(Param::int("particles"))
        .text("Adds a container of particles.")
        .partial("Particles remain where they are created; they neither move nor collide.")
        .example("dust = sim.addParticleObject(0, 0.01, 1000, nil, 1, 100, {1, 1, 0})"),
    );
    offer.command(
        Cmd::new("sim.addParticleObjectItem", |c| {
            let (particles, item) = (c.i64(0)?, c.arg(1).numbers().unwrap_or_default());
            if c.has(1) && item.len() < 3 {
                return Err(Fail::argument("argument 2: expected a table of at least 3 numbers, or nil"));
            }
            c.world().put_figure(0, particles, item.get(..3).unwrap_or(&[]))?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simAddParticleObjectItem", MINUS_ONE)
        .param(Param::int("particles"))
        .param(Param::any("item").optional().text("position, and velocity, which is ignored; nil: removes all"))
        .returns(Param::int("result").text("1"))
        .text("Adds a particle.")
        .partial("Particles remain where they are created; they neither move nor collide.")
        .example("sim.addParticleObjectItem(dust, {0, 0, 1, 0, 0, 0})"),
    );
    offer.command(
        Cmd::new("sim.removeParticleObject", remove)
            .old_name("simRemoveParticleObject", MINUS_ONE)
            .param(Param::int("particles"))
            .returns(Param::int("result").text("1"))
            .text("Removes a container of particles.")
            .example("sim.removeParticleObject(dust)"),
    );
}

#[cfg(test)]
mod tests {
    use super::complete_items;

    #[test]
    fn marks_get_a_normal_from_a_quaternion_or_upwards() {
        // Position, normal, colour, size.
        let whole = vec![1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.9, 0.8, 0.7, 0.05];
        assert_eq!(complete_items(whole.clone(), 10, true), whole);
        assert_eq!(complete_items(vec![1.0, 2.0, 3.0, 0.9, 0.8, 0.7, 0.05], 10, true), whole);
        // A rotation by 180 degrees about x points the normal down.
        let turned = complete_items(vec![1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.9, 0.8, 0.7, 0.05], 10, true);
        assert_eq!(turned, [1.0, 2.0, 3.0, 0.0, 0.0, -1.0, 0.9, 0.8, 0.7, 0.05]);
    }

    #[test]
    fn numbers_behind_the_first_item_are_ignored() {
        assert_eq!(complete_items(vec![0.0; 7], 6, false).len(), 6);
        assert_eq!(complete_items(vec![0.0; 12], 6, false).len(), 12);
    }
}
