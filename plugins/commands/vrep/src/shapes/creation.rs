//! Commands that create shapes and dummies, and access the mass, bounding box and colour of shapes.

use super::{
    appearance::{TRANSPARENCY, set_opacity},
    colors,
};
use crate::kit::{algebra as al, *};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.createPureShape", |c| {
            let (kind, options) = (c.i64(0)?, c.i64(1)?);
            let (primitive, alias) = match kind {
                0 => ("box", "Cuboid"),
                1 => ("sphere", "Sphere"),
                2 => ("cylinder", "Cylinder"),
                3 => ("cone", "Cone"),
                n => {
                    return Err(Fail::unsupported(format!("there is no pure shape type {n}"))
                        .help("use 0 (cuboid), 1 (sphere), 2 (cylinder) or 3 (cone)"));
                }
            };
            let shape = create_primitive(c, primitive, alias, numbers(c, 2)?)?;
            let (w, p) = (c.world(), &c.plugin().p);
            w.set_f64s(shape, p.mass, &[at_least_min_mass(c.f64(3)?)])?;
            w.set(shape, p.respondable, &Value::Bool(options & 8 != 0))?;
            w.set(shape, p.dynamic, &Value::Bool(options & 16 == 0))?;
            c.ret(handle(shape));
            Ok(())
        })
        .old_name("simCreatePureShape", MINUS_ONE)
        .param(Param::int("primitive").text("0: cuboid, 1: sphere, 2: cylinder, 3: cone"))
        .param(Param::int("options").text("8: respondable (collides), 16: static; other bits are ignored"))
        .param(table("sizes", "{x, y, z} full extents, m"))
        .param(Param::float("mass").unit("kg"))
        .param(Param::any("precision").optional().text("ignored: round shapes are exact"))
        .returns(Param::int("shape"))
        .text("Creates a primitive shape, which is dynamic unless the options make it static.")
        .example("box = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 0.5)"),
    );
    offer.command(
        Cmd::new("sim.createPrimitiveShape", |c| {
            let (primitive, alias) = match c.i64(0)? {
                1 => ("plane", "Plane"),
                2 => ("disc", "Disc"),
                3 => ("box", "Cuboid"),
                4 => ("sphere", "Sphere"),
                5 => ("cylinder", "Cylinder"),
                6 => ("cone", "Cone"),
                7 => ("heightfield", "Heightfield"),
                8 => ("capsule", "Capsule"),
                n => {
                    return Err(Fail::unsupported(format!("there is no primitive shape type {n}")).help(
                        "use 1 (plane), 2 (disc), 3 (cuboid), 4 (spheroid), 5 (cylinder), 6 (cone), 7 (heightfield) or \
                         8 (capsule)",
                    ));
                }
            };
            let shape = create_primitive(c, primitive, alias, numbers(c, 1)?)?;
            c.ret(handle(shape));
            Ok(())
        })
        .param(Param::int("primitive").text("sim.primitiveshape_..."))
        .param(table("sizes", "{x, y, z} full extents, m"))
        .param(Param::int("options").default(0).optional().text("ignored: they only affect the appearance"))
        .returns(Param::int("shape"))
        .text("Creates a primitive shape that neither moves nor collides until its parameters are changed.")
        .example("ball = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.2, 0.2})"),
    );
    offer.command(
        Cmd::new("sim.createDummy", |c| {
            let dummy = c.world().create("dummy", 0, "Dummy")?;
            c.ret(handle(dummy));
            Ok(())
        })
        .old_name("simCreateDummy", MINUS_ONE)
        .param(Param::float("size").default(0.01).optional().text("ignored"))
        .param(Param::any("color").optional().text("ignored"))
        .returns(Param::int("dummy"))
        .text("Creates a dummy: a frame without a body.")
        .example("target = sim.createDummy(0.01)"),
    );
    property_commands(offer);
}

fn property_commands(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getShapeMass", |c| {
            let shape = id(c, 0)?;
            let mass = c.world().f64(shape, c.plugin().p.mass);
            c.ret(mass.map_err(|e| explain(c, shape, TATU_KIND_SHAPE, e))?);
            Ok(())
        })
        .old_name("simGetShapeMass", NIL)
        .param(object("shape"))
        .returns(Param::float("mass").unit("kg"))
        .text("Returns the mass of a shape.")
        .example("m = sim.getShapeMass(box)"),
    );
    offer.command(
        Cmd::new("sim.setShapeMass", |c| {
            let (shape, mass) = (id(c, 0)?, at_least_min_mass(c.f64(1)?));
            let set = c.world().set_f64s(shape, c.plugin().p.mass, &[mass]);
            set.map_err(|e| explain(c, shape, TATU_KIND_SHAPE, e))?;
            finish_setter(c)
        })
        .old_name("simSetShapeMass", MINUS_ONE)
        .param(object("shape"))
        .param(Param::float("mass").unit("kg"))
        .text("Sets the mass of a shape.")
        .example("sim.setShapeMass(box, 0.5)"),
    );
    offer.command(
        Cmd::new("sim.getShapeBB", |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let size = c.world().f64s::<3>(shape, c.plugin().p.size)?;
            c.ret(&size[..]);
            c.ret(&al::IDENTITY[..]);
            Ok(())
        })
        .param(object("shape"))
        .returns(Param::floats("size", 3).unit("m"))
        .returns(Param::floats("pose", 7).text("pose of the box in the shape's frame"))
        .text("Returns the bounding box of a shape.")
        .example("size = sim.getShapeBB(box)"),
    );
    offer.command(
        Cmd::new("sim.getShapeColor", |c| {
            let shape =
                colored(c)?.ok_or_else(|| Fail::missing("argument 1: expected the handle of an existing shape"))?;
            let name = c.arg(1).as_str().map(|s| s.into_owned());
            let rgb = match component(c.i64(2)?)? {
                ColorComponent::Diffuse => colors::diffuse(c).get(c, shape, name.as_deref())?,
                ColorComponent::Opacity => [colors::opacity(c).get(c, shape, name.as_deref())?[0], 0.0, 0.0],
                ColorComponent::Stored(tag) => match tags::private(c, shape, &tag)? {
                    Some(data) => stored_rgb(&tables::unpack(&data)?),
                    None => [0.0; 3],
                },
            };
            c.ret(1_i64);
            c.ret(&rgb[..]);
            Ok(())
        })
        .old_name("simGetShapeColor", MINUS_ONE)
        .param(Param::any("shape").text("a handle; models from before 3.1.4 may put `@backCompatibility1:` before it"))
        .param(
            Param::any("colorName").optional().text("name of a colour of an imported compound; nil: of all its parts"),
        )
        .param(
            Param::int("component")
                .text("sim.colorcomponent_...; specular, emission and auxiliary are stored, but not drawn"),
        )
        .returns(Param::int("result").text("1"))
        .returns(Param::floats("rgb", 3).text("0 to 1; for sim.colorcomponent_transparency, the first is the opacity"))
        .text("Returns the colour or the opacity of a shape.")
        .example("result, rgb = sim.getShapeColor(box, nil, 0)"),
    );
    offer.command(
        Cmd::new("sim.setShapeColor", |c| {
            let Some(shape) = colored(c)? else { return finish_setter(c) };
            let name = c.arg(1).as_str().map(|s| s.into_owned());
            match component(c.i64(2)?)? {
                ColorComponent::Diffuse => {
                    let rgb: [f64; 3] = numbers(c, 3)?;
                    colors::diffuse(c).set(c, shape, name.as_deref(), rgb)?;
                }
                ColorComponent::Opacity => set_opacity(c, shape, name.as_deref())?,
                ColorComponent::Stored(tag) => {
                    let given: Vec<f64> = (0..3).map(|i| element(c.arg(3), i).unwrap_or(0.0)).collect();
                    tags::set_private(c, shape, &tag, Some(&tables::pack(&Value::Floats(given))?))?;
                }
            }
            finish_setter(c)
        })
        .old_name("simSetShapeColor", MINUS_ONE)
        .param(Param::any("shape").text("a handle; models from before 3.1.4 may put `@backCompatibility1:` before it"))
        .param(
            Param::any("colorName").optional().text("name of a colour of an imported compound; nil: of all its parts"),
        )
        .param(
            Param::int("component")
                .text("sim.colorcomponent_...; specular, emission and auxiliary are stored, but not drawn"),
        )
        .param(
            Param::list("rgb").text("0 to 1; for sim.colorcomponent_transparency, {opacity}: 0 is invisible, 1 opaque"),
        )
        .text("Sets the colour or the opacity of a shape.")
        .example("sim.setShapeColor(box, nil, 0, {1, 0, 0})"),
    );
}

/// Returns the shape in argument 0, which is a handle, possibly after a prefix with which models from before V-REP
/// 3.1.4 request old behaviour. Returns `None` if the handle after the prefix is not positive.
fn colored(c: &Ctx<'_>) -> Result<Option<tatu_object>> {
    let Some(text) = c.arg(0).as_str() else { return of_kind(c, 0, TATU_KIND_SHAPE).map(Some) };
    let handle = text.rsplit_once(':').map_or(&*text, |(_, n)| n);
    let id = match handle.trim().parse::<f64>() {
        Ok(n) if n > 0.0 => n as u64,
        Ok(_) => return Ok(None),
        Err(_) => return Err(Fail::argument(format!("argument 1: expected a handle, found the string \"{text}\""))),
    };
    let o = c.world().look(id)?;
    let is_shape = o.kind == TATU_KIND_SHAPE || c.world().used_as(o.id, "shape");
    if is_shape { Ok(Some(o.id)) } else { Err(Fail::argument(format!("object {id} is not a shape"))) }
}

/// A component of the colour of a shape.
enum ColorComponent {
    /// Ambient and diffuse, which are the shape's colour.
    Diffuse,
    /// Transparency, whose value is an opacity in V-REP too.
    Opacity,
    /// A component that is not rendered (specular, emission, auxiliary), with the tag under which it is stored.
    Stored(String),
}

fn component(n: i64) -> Result<ColorComponent> {
    match n {
        0 | 1 => Ok(ColorComponent::Diffuse),
        TRANSPARENCY => Ok(ColorComponent::Opacity),
        2..=5 => Ok(ColorComponent::Stored(format!("color {n}"))),
        _ => Err(Fail::argument(format!("argument 3: expected a colour component from 0 to 5, found {n}"))),
    }
}

/// Returns the three values of a stored component.
fn stored_rgb(v: &Value) -> [f64; 3] {
    let Value::List(all) = v else { return [0.0; 3] };
    std::array::from_fn(|i| if let Some(Value::Float(x)) = all.get(i) { *x } else { 0.0 })
}

/// Returns `mass`, but at least 1e-7 kg, the minimum that physics supports.
fn at_least_min_mass(mass: f64) -> f64 {
    mass.max(1e-7)
}

fn create_primitive(c: &Ctx<'_>, primitive: &str, alias: &str, size: [f64; 3]) -> Result<tatu_object> {
    let flat = matches!(primitive, "plane" | "disc" | "heightfield");
    if size[..if flat { 2 } else { 3 }].iter().any(|x| *x <= 0.0) && primitive != "plane" {
        return Err(Fail::argument("all sizes must be greater than 0"));
    }
    let (w, p) = (c.world(), &c.plugin().p);
    let shape = w.create("shape", 0, alias)?;
    let made = match outline(primitive, size) {
        Some((points, places)) => {
            let surface = Value::List(vec![Value::Floats(points), Value::Ints(places)]);
            w.set(shape, p.surface, &surface).and_then(|()| w.set(shape, p.convex, &Value::Bool(!flat)))
        }
        None => w.set(shape, p.primitive, &primitive.into()).and_then(|()| w.set_f64s(shape, p.size, &size)),
    };
    if let Err(e) = made {
        w.remove(&[shape])?;
        return Err(e);
    }
    Ok(shape)
}

/// Returns the points and triangles of a form that is not a primitive: a cone whose tip points up, or a flat disc or
/// rectangle. Their frame is at the centre of their bounding box.
fn outline(form: &str, [x, y, z]: [f64; 3]) -> Option<(Vec<f64>, Vec<i64>)> {
    const SIDES: i64 = 32;
    let (x, y, z) = (x / 2.0, y / 2.0, z / 2.0);
    let ring = |height: f64| {
        (0..SIDES).flat_map(move |i| {
            let turn = std::f64::consts::TAU * i as f64 / SIDES as f64;
            [x * libm::cos(turn), y * libm::sin(turn), height]
        })
    };
    // Triangles between the ring and an apex. They face outwards if the apex is above the ring.
    let fan = |to: i64| (0..SIDES).flat_map(move |i| [i, (i + 1) % SIDES, to]);
    Some(match form {
        "disc" => (ring(0.0).chain([0.0; 3]).collect(), fan(SIDES).collect()),
        "cone" => {
            let below = (0..SIDES).flat_map(|i| [(i + 1) % SIDES, i, SIDES]);
            (ring(-z).chain([0.0, 0.0, -z, 0.0, 0.0, z]).collect(), fan(SIDES + 1).chain(below).collect())
        }
        "heightfield" => (vec![-x, -y, 0.0, x, -y, 0.0, x, y, 0.0, -x, y, 0.0], vec![0, 1, 2, 0, 2, 3]),
        _ => return None,
    })
}
