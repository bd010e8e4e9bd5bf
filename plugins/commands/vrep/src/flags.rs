//! Commands on the bit masks of objects (object, model and special properties, explicit handling), and on references to
//! other objects that are stored with an object.

use crate::{kit::*, lookup::registered::is_stand_in, state::state};

/// Handles of groups for inverse kinematics that scripts have created.
const SCRIPT_IK_GROUPS: std::ops::Range<i64> = 2_030_000..2_040_000;

/// Returns whether a number is the handle of a group for inverse kinematics.
fn is_ik_group(c: &Ctx<'_>, which: i64) -> Result<bool> {
    let of_file = state(c)?.registered.ik_groups.iter().any(|group| group.handle == which);
    Ok(of_file || SCRIPT_IK_GROUPS.contains(&which))
}

/// Default object property: selectable.
const DEFAULT_OBJECT_PROPERTY: i64 = 32;
/// Default special property: collidable, measurable, detectable, renderable.
const DEFAULT_SPECIAL_PROPERTY: i64 = 1 | 2 | DETECTABLE | 0x200;
pub(crate) const DETECTABLE: i64 = 0x1F0;
/// Mask of all wave types of the core, to which the bits of `DETECTABLE` correspond.
const ALL_WAVES: i64 = TATU_WAVES_ALL as i64;
const NOT_MODEL_BITS: i64 = 0xF000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let bits = || Param::int("property").text("bits");
    offer.command(
        both(["sim.getObjectProperty", "simGetObjectProperty"], MINUS_ONE, |c| {
            let id = existing_object(c, 0)?.id;
            let bits = tags::number(c, id, "object property")?.map_or(DEFAULT_OBJECT_PROPERTY, |x| x as i64);
            c.ret(bits);
            Ok(())
        })
        .param(object("object"))
        .returns(bits())
        .text("Returns the property bits of an object: sim.objectproperty_..."),
    );
    offer.command(
        both(["sim.setObjectProperty", "simSetObjectProperty"], MINUS_ONE, |c| {
            let (id, bits) = (existing_object(c, 0)?.id, c.i64(1)?);
            tags::set_number(c, id, "object property", bits as f64)?;
            finish_setter(c)
        })
        .param(object("object"))
        .param(bits())
        .text("Sets the property bits of an object: sim.objectproperty_...")
        .partial("The bits are only stored and returned, because they affect windows, which do not exist here."),
    );
    offer.command(
        both(["sim.getModelProperty", "simGetModelProperty"], MINUS_ONE, |c| {
            let id = existing_object(c, 0)?.id;
            let bits = match bool_of(c, id, c.plugin().p.model_base)? {
                true => tags::number(c, id, "model property")?.map_or(0, |x| x as i64),
                false => NOT_MODEL_BITS,
            };
            c.ret(bits);
            Ok(())
        })
        .param(object("object"))
        .returns(bits())
        .text(
            "Returns the property bits of a model: sim.modelproperty_...; sim.modelproperty_not_model if the object \
               is not the base of a model.",
        ),
    );
    offer.command(
        both(["sim.setModelProperty", "simSetModelProperty"], MINUS_ONE, |c| {
            let (id, bits) = (existing_object(c, 0)?.id, c.i64(1)?);
            let base = bits & NOT_MODEL_BITS != NOT_MODEL_BITS;
            c.world().set(id, c.plugin().p.model_base, &Value::Bool(base))?;
            tags::set_number(c, id, "model property", (bits & !NOT_MODEL_BITS) as f64)?;
            finish_setter(c)
        })
        .param(object("object"))
        .param(bits())
        .text("Sets the property bits of a model, and thereby whether an object is the base of a model.")
        .partial(
            "Only the bit that makes the object a base has an effect; those that override properties of the model's \
                  parts are only stored.",
        ),
    );
    offer.command(
        both(["sim.getObjectSpecialProperty", "simGetObjectSpecialProperty"], MINUS_ONE, |c| {
            let o = existing_object(c, 0)?;
            let mut bits = tags::number(c, o.id, "special property")?.map_or(DEFAULT_SPECIAL_PROPERTY, |x| x as i64);
            if o.kind == TATU_KIND_SHAPE {
                let p = &c.plugin().p;
                let waves = c.world().get(o.id, p.detectable_mask)?.as_i64().unwrap_or(DETECTABLE);
                let seen = if bool_of(c, o.id, p.detectable)? { waves & DETECTABLE } else { 0 };
                bits = bits & !DETECTABLE | seen;
            }
            c.ret(bits);
            Ok(())
        })
        .param(object("object"))
        .returns(bits())
        .text("Returns how sensors and commands treat an object: sim.objectspecialproperty_..."),
    );
    offer.command(
        both(["sim.setObjectSpecialProperty", "simSetObjectSpecialProperty"], MINUS_ONE, |c| {
            let (o, bits) = (existing_object(c, 0)?, c.i64(1)?);
            if o.kind == TATU_KIND_SHAPE {
                let (p, seen) = (&c.plugin().p, bits & DETECTABLE);
                c.world().set(o.id, p.detectable, &Value::Bool(seen != 0))?;
                if seen != 0 {
                    // Also set the bits of all other wave types, because sensors with such waves always detect the
                    // object.
                    c.world().set(o.id, p.detectable_mask, &Value::Int(seen | !DETECTABLE & ALL_WAVES))?;
                }
            }
            tags::set_number(c, o.id, "special property", bits as f64)?;
            finish_setter(c)
        })
        .param(object("object"))
        .param(bits())
        .text("Sets how sensors and commands treat an object: sim.objectspecialproperty_...")
        .partial(
            "Only the bits that determine which kinds of sensors detect a shape are used; others are only stored.",
        ),
    );
    explicit(offer);
    references(offer);
    links(offer);
}

fn explicit(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.getExplicitHandling", "simGetExplicitHandling"], MINUS_ONE, |c| {
            let which = id(c, 0)? as i64;
            if is_ik_group(c, which)? {
                let on = tags::number(c, 0, &format!("explicit group {which}"))?;
                c.ret(i64::from(on.unwrap_or(0.0) != 0.0));
                return Ok(());
            }
            let o = existing_object(c, 0)?;
            let on = match o.kind {
                TATU_KIND_SENSOR => bool_of(c, o.id, c.plugin().p.sensor_explicit)?,
                _ => tags::number(c, o.id, "explicit")?.unwrap_or(0.0) != 0.0,
            };
            c.ret(i64::from(on));
            Ok(())
        })
        .param(object("object"))
        .returns(Param::int("flags").text("1: explicit handling, only on request of a script"))
        .text("Returns whether a sensor is handled only at the request of a script."),
    );
    offer.command(
        both(["sim.setExplicitHandling", "simSetExplicitHandling"], MINUS_ONE, |c| {
            let which = id(c, 0)? as i64;
            if is_stand_in(c, which) {
                return finish_setter(c);
            }
            if is_ik_group(c, which)? {
                tags::set_number(c, 0, &format!("explicit group {which}"), f64::from(u8::from(c.i64(1)? & 1 != 0)))?;
                return finish_setter(c);
            }
            let (o, on) = (existing_object(c, 0)?, c.i64(1)? & 1 != 0);
            match o.kind {
                TATU_KIND_SENSOR => c.world().set(o.id, c.plugin().p.sensor_explicit, &Value::Bool(on))?,
                _ => tags::set_number(c, o.id, "explicit", f64::from(u8::from(on)))?,
            }
            finish_setter(c)
        })
        .param(object("object"))
        .param(Param::int("flags").text("1: explicit handling, only on request of a script"))
        .text("Sets whether a sensor, or a group for inverse kinematics, is handled only at the request of a script."),
    );
}

/// Adds commands on handles stored with an object. Handles are stored as full ids, so a removed object can be
/// recognised and reported as -1.
fn references(offer: &mut Offer<Vrep>) {
    let key = |tag: &str| format!("handles {tag}");
    // Imported files refer to objects by their paths.
    let imported = |tag: &str| format!("paths {tag}");
    let listed = move |c: &Ctx<'_>, id: tatu_object, tag: &str| -> Result<Vec<i64>> {
        let w = c.world();
        if let Some(kept) = tags::private(c, id, &key(tag))? {
            let kept = String::from_utf8_lossy(&kept).into_owned();
            let ids = kept.split(' ').filter_map(|t| t.parse::<u64>().ok());
            return Ok(ids.map(|o| if o != 0 && w.look(o).is_ok() { handle(o) } else { -1 }).collect());
        }
        let Some(kept) = tags::private(c, id, &imported(tag))? else { return Ok(Vec::new()) };
        let kept = String::from_utf8_lossy(&kept).into_owned();
        let found = |path: &str| if path.is_empty() { None } else { w.find(id, path).ok() };
        Ok(kept.split('\n').map(|path| found(path).map_or(-1, handle)).collect())
    };
    let tag = |c: &Ctx<'_>, i: usize| if c.has(i) { c.text(i) } else { Ok(String::new()) };
    offer.command(
        both(["sim.setReferencedHandles", "simSetReferencedHandles"], MINUS_ONE, move |c| {
            let (id, tag) = (existing_object(c, 0)?.id, tag(c, 2)?);
            let v = c.arg(1);
            let ids: Vec<String> = (0..v.len())
                .map(|i| {
                    let n = v.number(i).unwrap_or(-1.0);
                    let found =
                        if n > 0.0 { c.world().look(n as u64 & HANDLE_BITS as u64).map_or(0, |o| o.id) } else { 0 };
                    found.to_string()
                })
                .collect();
            let text = ids.join(" ");
            tags::set_private(c, id, &key(&tag), (!text.is_empty()).then_some(text.as_bytes()))?;
            tags::set_private(c, id, &imported(&tag), None)?;
            finish_setter(c)
        })
        .param(object("object"))
        .param(Param::list("handles"))
        .param(Param::string("tag").default("").optional())
        .text("Stores handles of other objects with an object."),
    );
    offer.command(
        both(["sim.getReferencedHandles", "simGetReferencedHandles"], NIL, move |c| {
            let (id, tag) = (existing_object(c, 0)?.id, tag(c, 1)?);
            let out = listed(c, id, &tag)?;
            c.ret(&out[..]);
            Ok(())
        })
        .param(object("object"))
        .param(Param::string("tag").default("").optional())
        .returns(Param::list("handles").text("-1 for objects that were removed"))
        .text("Returns the handles stored with an object."),
    );
    offer.command(
        Cmd::new("sim.getReferencedHandle", move |c| {
            let (id, tag) = (existing_object(c, 0)?.id, tag(c, 1)?);
            let first = listed(c, id, &tag)?.first().copied().filter(|h| *h > 0);
            c.ret(first.ok_or_else(|| Fail::missing(format!("no handle is stored under the tag `{tag}`")))?);
            Ok(())
        })
        .param(object("object"))
        .param(Param::string("tag").default("").optional())
        .returns(Param::int("handle"))
        .text("Returns the first handle stored with an object."),
    );
    offer.command(
        Cmd::new("sim.getReferencedHandlesTags", |c| {
            let id = existing_object(c, 0)?.id;
            let tags = tags::all(c, id)?.into_iter();
            let prefixes: [&[u8]; 2] = [b"\x01handles ", b"\x01paths "];
            let tags = tags.filter_map(|(k, _)| prefixes.iter().find_map(|p| k.strip_prefix(*p)).map(<[u8]>::to_vec));
            let tags: Vec<Value> = tags.map(Value::Text).collect();
            c.ret(Value::List(tags));
            Ok(())
        })
        .param(object("object"))
        .returns(Param::list("tags"))
        .text("Lists the tags under which handles are stored with an object."),
    );
}

/// Adds commands that link dummies.
fn links(offer: &mut Offer<Vrep>) {
    let id_of_note = |c: &Ctx<'_>, id: tatu_object| -> Result<tatu_object> {
        let kept = tags::private(c, id, "link")?.and_then(|t| String::from_utf8(t).ok()?.parse::<u64>().ok());
        Ok(kept.filter(|o| c.world().look(*o).is_ok()).unwrap_or(0))
    };
    offer.command(
        both(["sim.getLinkDummy", "simGetLinkDummy"], MINUS_ONE, move |c| {
            let dummy = of_kind(c, 0, TATU_KIND_DUMMY)?;
            let other = id_of_note(c, dummy)?;
            c.ret(handle(other));
            Ok(())
        })
        .param(object("dummy"))
        .returns(Param::int("other").text("-1: none"))
        .text("Returns the dummy to which a dummy is linked."),
    );
    offer.command(
        both(["sim.setLinkDummy", "simSetLinkDummy"], MINUS_ONE, move |c| {
            let dummy = of_kind(c, 0, TATU_KIND_DUMMY)?;
            let other = if c.i64(1)? == -1 { 0 } else { of_kind(c, 1, TATU_KIND_DUMMY)? };
            // A dummy has at most one partner, so unlink both dummies from their previous partners.
            for d in [dummy, other].into_iter().filter(|d| *d != 0) {
                match id_of_note(c, d)? {
                    0 => {}
                    old => {
                        tags::set_private(c, old, "link", None)?;
                        c.world().set(old, c.plugin().p.link, &"".into())?;
                    }
                }
                tags::set_private(c, d, "link", None)?;
                c.world().set(d, c.plugin().p.link, &"".into())?;
            }
            if other != 0 {
                tags::set_private(c, dummy, "link", Some(other.to_string().as_bytes()))?;
                tags::set_private(c, other, "link", Some(dummy.to_string().as_bytes()))?;
                let path = text_of(c, other, c.plugin().p.path)?;
                c.world().set(dummy, c.plugin().p.link, &path.as_str().into())?;
            }
            finish_setter(c)
        })
        .param(object("dummy"))
        .param(Param::int("other").text("-1: none"))
        .text(
            "Links or unlinks two dummies. A link joins the dynamic shapes above them at the dummies, closing a loop.",
        ),
    );
    offer.command(
        Cmd::new("sim.getObjectHierarchyOrder", |c| {
            let id = existing_object(c, 0)?.id;
            let up = parent(c, id)?;
            let all = c.world().list(up, 0, TATU_LIST_CHILDREN | TATU_LIST_SKIP_BASE)?;
            c.ret(all.iter().position(|o| *o == id).map_or(-1, |i| i as i64));
            c.ret(all.len() as i64);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::int("order").text("from 0"))
        .returns(Param::int("count").text("number of siblings, including the object"))
        .text("Returns the position of an object among its siblings."),
    );
}
