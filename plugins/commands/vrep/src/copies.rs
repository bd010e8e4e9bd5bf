//! Commands that copy and scale objects, and load and save models and scenes.

use crate::{kit::*, lookup::sets, model_paths};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let devices = "Copies of sensors, actuators and scripts start in their initial state.";
    offer.command(
        both(["sim.copyPasteObjects", "simCopyPasteObjects"], NIL, |c| {
            let ids = sets::list(c, 0)?;
            let options = int_or(c, 1, 0)?;
            let out = copy(c, &ids, options & 1 != 0)?;
            c.ret(&out[..]);
            Ok(())
        })
        .param(Param::list("objects").text("handles"))
        .param(Param::int("options").default(0).optional().text("1: the objects are bases of models to be copied"))
        .returns(Param::list("copies").text("in the same order"))
        .text("Copies objects without moving them.")
        .partial(devices),
    );
    offer.command(
        both(["sim.copyPasteSelectedObjects", "simCopyPasteSelectedObjects"], MINUS_ONE, |c| {
            let ids = crate::state::state(c)?.sets.selection.clone();
            let out = copy(c, &ids, false)?;
            let ids = out.iter().filter_map(|h| c.world().look(*h as u64).ok()).map(|o| o.id).collect();
            crate::state::state(c)?.sets.selection = ids;
            c.ret(1_i64);
            Ok(())
        })
        .returns(Param::int("done"))
        .text("Copies the selected objects, and selects the copies.")
        .partial(devices),
    );
    offer.command(
        both(["sim.getObjectSizeFactor", "simGetObjectSizeFactor"], NIL, |c| {
            let id = existing_object(c, 0)?.id;
            let f = tags::number(c, id, "scale")?.unwrap_or(1.0);
            c.ret(f);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::float("factor"))
        .text("Returns the factor by which an object has been scaled since it was created."),
    );
    offer.command(
        both(["sim.getObjectSizeValues", "simGetObjectSizeValues"], NIL, |c| {
            let o = existing_object(c, 0)?;
            let size = tags::number(c, o.id, "scale")?.unwrap_or(1.0);
            c.ret(&[size; 3][..]);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::floats("values", 3))
        .text("Returns the factor by which an object has been scaled along each axis.")
        .partial("The three values are equal, because scaling along single axes changes only the size of a shape."),
    );
    offer.command(
        both(["sim.setObjectSizeValues", "simSetObjectSizeValues"], MINUS_ONE, |c| {
            let (o, v) = (existing_object(c, 0)?, numbers::<3>(c, 1)?);
            let old = tags::number(c, o.id, "scale")?.unwrap_or(1.0);
            scale(c, o, v.map(|x| x / old))?;
            tags::set_number(c, o.id, "scale", v[0])?;
            finish_setter(c)
        })
        .param(object("object"))
        .param(table("values", "{x, y, z}"))
        .text("Sets the scale factors of an object, relative to its original size.")
        .partial("The three values are stored as one factor."),
    );
    offer.command(
        both(["sim.scaleObject", "simScaleObject"], MINUS_ONE, |c| {
            let (o, f) = (existing_object(c, 0)?, [c.f64(1)?, c.f64(2)?, c.f64(3)?]);
            scale(c, o, f)?;
            let old = tags::number(c, o.id, "scale")?.unwrap_or(1.0);
            if f[0] == f[1] && f[1] == f[2] {
                tags::set_number(c, o.id, "scale", old * f[0])?;
            }
            finish_setter(c)
        })
        .param(object("object"))
        .param(Param::float("x"))
        .param(Param::float("y"))
        .param(Param::float("z"))
        .param(Param::int("options").default(0).optional().text("ignored"))
        .text("Scales an object by a factor along each axis.")
        .partial("Changes the sizes of shapes, but not their masses; sensors and joints are unchanged."),
    );
    offer.command(
        both(["sim.scaleObjects", "simScaleObjects"], MINUS_ONE, |c| {
            let (ids, f, places) = (sets::list(c, 0)?, c.f64(1)?, c.arg(2).truthy());
            if f <= 0.0 {
                return Err(Fail::argument("argument 2: the scale factor must be greater than 0"));
            }
            let (w, p) = (c.world(), &c.plugin().p);
            for id in &ids {
                let o = w.look(*id)?;
                scale(c, o, [f; 3])?;
                if o.kind == TATU_KIND_SHAPE {
                    let m = w.f64(*id, p.mass)?;
                    w.set_f64s(*id, p.mass, &[(m * f * f * f).max(1e-7)])?;
                }
                let old = tags::number(c, *id, "scale")?.unwrap_or(1.0);
                tags::set_number(c, *id, "scale", old * f)?;
                if places && ids.contains(&parent(c, *id)?) {
                    let mut pose = w.f64s::<7>(*id, p.local_pose)?;
                    pose[..3].iter_mut().for_each(|x| *x *= f);
                    w.set_f64s(*id, p.local_pose, &pose)?;
                }
            }
            finish_setter(c)
        })
        .param(Param::list("objects").text("handles"))
        .param(Param::float("factor"))
        .param(Param::any("positions").text("true: also scales the distances between the objects"))
        .text("Scales objects with their masses, and the distances within their trees.")
        .partial("Changes the sizes, masses and positions of shapes; sensors and joint forces are unchanged."),
    );
    files(offer);
}

/// Returns whether `id` is the id of a model that a plugin or a model folder provides.
fn is_model(c: &Call<'_, Vrep>, id: &[u8]) -> Result<bool> {
    for at in 0.. {
        match c.world().model(at)? {
            Some(model) if model.get("id").and_then(|v| v.as_bytes()) == Some(id) => return Ok(true),
            Some(_) => {}
            None => break,
        }
    }
    Ok(false)
}

/// Adds the commands that load and save models and scenes.
fn files(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.loadModel", "simLoadModel"], MINUS_ONE, |c| {
            let file = c.bytes(0)?;
            let w = c.world();
            // `sim.saveModel` may have appended `.toml` to the name.
            let found =
                [file.to_vec(), scene_file(file)].into_iter().find_map(|name| w.file(&name, TATU_FILE_READ).ok());
            let Some(path) = found else {
                if is_model(c, file)? {
                    c.ret(handle(w.load(file, 0)?));
                    return Ok(());
                }
                // In a run without a scene, a substitute object replaces a missing model of V-REP's installation.
                let file = String::from_utf8_lossy(file).into_owned();
                let stem = file.rsplit(['/', '\\']).next().unwrap_or_default();
                let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
                if let Some(made) = w.stand_in(0, &format!("/{stem}"), "") {
                    c.ret(handle(made));
                    return Ok(());
                }
                if let Some(own) = model_paths::same_model(&file)
                    && is_model(c, own.as_bytes())?
                {
                    c.ret(handle(w.load(own.as_bytes(), 0)?));
                    return Ok(());
                }
                let missing = match w.file(file.as_bytes(), TATU_FILE_READ) {
                    Err(fail) => fail,
                    Ok(_) => Fail::missing(format!("there is no model file `{file}`")),
                };
                return Err(match model_paths::nearest_model(&file) {
                    Some(own) if file.to_ascii_lowercase().ends_with(".ttm") => missing
                        .help(format!("the nearest of Tatu's own models is `{own}`; `tatu list models` lists all")),
                    _ => missing,
                });
            };
            c.ret(handle(w.load(&path, 0)?));
            Ok(())
        })
        .param(Param::string("file"))
        .param(Param::any("options").optional())
        .returns(Param::int("model").text("handle of its base"))
        .text(
            "Loads a model: a scene file, a file that an importer reads, such as `.ttm` or `.urdf`, or the id of a \
             model (`tatu list models`). If the file does not exist, the name of a model of V-REP's installation, such \
             as `models/robots/mobile/pioneer p3dx.ttm`, selects the same model of Tatu.",
        )
        .partial("Loading a model from a buffer is not supported; options have no effect."),
    );
    offer.command(
        both(["sim.loadScene", "simLoadScene"], MINUS_ONE, |c| {
            let file = c.world().file(c.bytes(0)?, TATU_FILE_READ)?;
            c.world().open_scene(&String::from_utf8_lossy(&file))?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::string("file"))
        .returns(Param::int("result"))
        .text("Loads another scene once the current one has stopped.")
        .partial("Only `tatu serve` and `tatu open` can change the scene; `tatu run` reports an error."),
    );
    for (names, model) in [(["sim.saveModel", "simSaveModel"], true), (["sim.saveScene", "simSaveScene"], false)] {
        let command = both(names, MINUS_ONE, move |c| {
            let (base, at) = if model { (existing_object(c, 0)?.id, 1) } else { (0, 0) };
            let w = c.world();
            let path = w.file(&scene_file(c.bytes(at)?), TATU_FILE_WRITE)?;
            w.save(&path, base)?;
            c.ret(1_i64);
            Ok(())
        });
        let command = if model { command.param(object("base")) } else { command };
        offer.command(
            command
                .param(Param::string("file"))
                .returns(Param::int("result").text("1"))
                .text("Writes the current state of a scene or model to a scene file.")
                .partial("The format is Tatu's scene format; `.toml` is appended to a name with a different suffix."),
        );
    }
    offer.command(
        both(["sim.closeScene", "simCloseScene"], MINUS_ONE, |c| {
            if bool_of(c, 0, c.plugin().p.running)? {
                c.ret(-1_i64);
                return Ok(());
            }
            c.world().call_command("tatu.newScene", &[])?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::any("arguments").rest())
        .returns(Param::int("result").text("1: closed; -1: not while the simulation runs"))
        .text("Closes the scene of `tatu serve` or `tatu open`, and opens a new one in its place: `tatu.newScene`.")
        .example("assert(sim.closeScene() == -1)"),
    );
}

/// Returns the file name under which a scene is saved: `name`, with `.toml` appended if it has a different suffix.
fn scene_file(name: &[u8]) -> Vec<u8> {
    let mut out = name.to_vec();
    if !out.ends_with(b".toml") {
        out.extend(b".toml");
    }
    out
}

fn copy(c: &Ctx<'_>, ids: &[tatu_object], models: bool) -> Result<Vec<i64>> {
    let w = c.world();
    let mut all: Vec<tatu_object> = Vec::new();
    for id in ids {
        if models {
            all.extend(w.list(*id, 0, 0)?.into_iter().filter(|o| !all.contains(o)).collect::<Vec<_>>());
        } else if !all.contains(id) {
            all.push(*id);
        }
    }
    // Scripts are copied with the object to which they belong; the host refuses to copy a script alone.
    all.retain(|o| ids.contains(o) || w.look(*o).is_ok_and(|o| o.kind != TATU_KIND_SCRIPT));
    let copies = w.copy(&all)?;
    Ok(ids
        .iter()
        .filter_map(|id| all.iter().position(|o| o == id).and_then(|i| copies.get(i)))
        .map(|o| handle(*o))
        .collect())
}

/// Scales a shape by one factor per axis without changing its mass, with its centre of mass and its inertia; objects of
/// other kinds remain unchanged.
fn scale(c: &Ctx<'_>, o: Object, f: [f64; 3]) -> Result {
    if f.iter().any(|x| *x <= 0.0) {
        return Err(Fail::argument("the scale factors must be greater than 0"));
    }
    if o.kind != TATU_KIND_SHAPE {
        return Ok(());
    }
    let (w, p) = (c.world(), &c.plugin().p);
    let mass = w.f64(o.id, p.mass)?;
    let matter = || Result::Ok((w.f64s::<3>(o.id, p.com)?, w.f64s::<9>(o.id, p.inertia)?));
    let (com, inertia) = matter()?;
    if text_of(c, o.id, p.primitive)? == "mesh" {
        let v = w.get(o.id, p.surface)?.to_value()?;
        if let Value::List(lists) = v
            && let [Value::Floats(points), places] = lists.as_slice()
        {
            let points = points.iter().enumerate().map(|(i, x)| x * f[i % 3]).collect();
            w.set(o.id, p.surface, &Value::List(vec![Value::Floats(points), places.clone()]))?;
        }
    } else {
        let size = w.f64s::<3>(o.id, p.size)?;
        w.set_f64s(o.id, p.size, &[size[0] * f[0], size[1] * f[1], size[2] * f[2]])?;
    }
    w.set_f64s(o.id, p.mass, &[mass])?;
    // Values that were not set explicitly are derived from the form, so they have changed with it.
    let (new_com, new_inertia) = matter()?;
    if new_com == com && com != [0.0; 3] {
        w.set_f64s(o.id, p.com, &[com[0] * f[0], com[1] * f[1], com[2] * f[2]])?;
    }
    if new_inertia == inertia && f != [1.0; 3] {
        w.set(o.id, p.inertia, &Value::Floats(scaled_inertia(&inertia, f).to_vec()))?;
    }
    Ok(())
}

/// Returns the inertia of a body, by rows, whose points have been scaled by one factor per axis about its centre of
/// mass.
fn scaled_inertia(inertia: &[f64; 9], f: [f64; 3]) -> [f64; 9] {
    let trace = |m: &[f64; 9]| m[0] + m[4] + m[8];
    // The second moments of mass, sum(m x y), are scaled by both factors; the inertia is their trace minus them.
    let half = 0.5 * trace(inertia);
    let moments = std::array::from_fn(|i| {
        let own = if i % 4 == 0 { half } else { 0.0 } - inertia[i];
        own * f[i / 3] * f[i % 3]
    });
    std::array::from_fn(|i| if i % 4 == 0 { trace(&moments) } else { 0.0 } - moments[i])
}
