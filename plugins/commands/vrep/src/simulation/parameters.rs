//! Commands on parameters of the simulator by number, as in `sim.getInt32Param(sim.intparam_program_version)`.
//!
//! Setting a read-only parameter to its current value is not an error.

use crate::{
    kit::*,
    model_paths::{MODEL_FOLDER, SCENE_FOLDER},
    state::state,
};

/// The parameters of one type: the name of the type, the names of the getter and setter, a parameter that the example
/// uses, and the functions that read and set parameters.
struct ParameterFamily {
    name: &'static str,
    getter: ParameterCommandNames,
    setter: ParameterCommandNames,
    sample: &'static str,
    get: ParameterGetter,
    set: Option<ParameterSetter>,
}

/// The current name of a command, the previous one, and the flat ones.
type ParameterCommandNames = (&'static str, &'static str, &'static [&'static str]);
type ParameterGetter = fn(&Ctx<'_>, i64) -> Result<Option<Value>>;
/// A function that sets a parameter, and returns whether the parameter can be set.
type ParameterSetter = fn(&Ctx<'_>, i64) -> Result<bool>;

const FAMILIES: [ParameterFamily; 5] = [
    ParameterFamily {
        name: "Bool",
        getter: ("sim.getBoolParam", "sim.getBoolParameter", &["simGetBoolParameter", "simGetBooleanParameter"]),
        setter: ("sim.setBoolParam", "sim.setBoolParameter", &["simSetBoolParameter", "simSetBooleanParameter"]),
        sample: "sim.boolparam_headless",
        get: get_bool,
        set: None,
    },
    ParameterFamily {
        name: "Int32",
        getter: ("sim.getInt32Param", "sim.getInt32Parameter", &["simGetInt32Parameter", "simGetIntegerParameter"]),
        setter: ("sim.setInt32Param", "sim.setInt32Parameter", &["simSetInt32Parameter", "simSetIntegerParameter"]),
        sample: "sim.intparam_program_version",
        get: get_int,
        set: Some(set_int),
    },
    ParameterFamily {
        name: "Float",
        getter: ("sim.getFloatParam", "sim.getFloatParameter", &["simGetFloatParameter", "simGetFloatingParameter"]),
        setter: ("sim.setFloatParam", "sim.setFloatParameter", &["simSetFloatParameter", "simSetFloatingParameter"]),
        sample: "sim.floatparam_simulation_time_step",
        get: get_float,
        set: None,
    },
    ParameterFamily {
        name: "String",
        getter: ("sim.getStringParam", "sim.getStringParameter", &["simGetStringParameter"]),
        setter: ("sim.setStringParam", "sim.setStringParameter", &["simSetStringParameter"]),
        sample: "sim.stringparam_scene_name",
        get: get_string,
        set: None,
    },
    ParameterFamily {
        name: "Array",
        getter: ("sim.getArrayParam", "sim.getArrayParameter", &["simGetArrayParameter"]),
        setter: ("sim.setArrayParam", "sim.setArrayParameter", &["simSetArrayParameter"]),
        sample: "sim.arrayparam_gravity",
        get: get_array,
        set: Some(set_array),
    },
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for family in &FAMILIES {
        get_and_set(offer, family);
    }
    offer.command(
        Cmd::new("sim.getRandom", |c| {
            let x = random(c)?;
            c.ret(x);
            Ok(())
        })
        .param(Param::any("seed").optional().text("ignored: the scene's seed is used"))
        .returns(Param::float("x").text("0 <= x < 1"))
        .text("Returns a random number; the sequence is the same in every run with the same scene and seed.")
        .example("x = sim.getRandom()"),
    );
}

fn get_and_set(offer: &mut Offer<Vrep>, family: &'static ParameterFamily) {
    let ParameterFamily { name, sample, getter, setter, .. } = *family;
    let value = match name {
        "Bool" => Param::any("value").text("true or false"),
        "Int32" => Param::int("value"),
        "Float" => Param::float("value"),
        "String" => Param::string("value"),
        _ => table("value", "numbers"),
    };
    let id = || Param::int("parameter").text("a number from the tables of constants");
    let named = |(_, before, flat): ParameterCommandNames, on_error: [Value; 1], command: Cmd| {
        let all = flat.iter().fold(command, |command, name| command.old_name(*name, on_error.clone()));
        all.alias(before)
    };
    let get = Cmd::new(getter.0, |c| {
        let v = read(c, family)?;
        c.ret(v);
        Ok(())
    });
    offer.command(
        named(getter, NIL, get)
            .param(id())
            .returns(value.clone())
            .text("Returns a parameter of the simulator.")
            .example(format!("v = {}({sample})", getter.0)),
    );
    let set = Cmd::new(setter.0, |c| {
        let (n, wanted) = (c.i64(0)?, c.arg(1).to_value()?);
        let set = match family.set {
            Some(set) => set(c, n)?,
            None => false,
        };
        if !set {
            let is = read(c, family)?;
            if !same(&is, &wanted) {
                store_without_effect(c, family, n, &is, &wanted)?;
            }
        }
        c.ret(1_i64);
        Ok(())
    });
    offer.command(
        named(setter, MINUS_ONE, set)
            .param(id())
            .param(value)
            .returns(Param::int("done"))
            .text("Sets a parameter of the simulator.")
            .example(format!("{}({sample}, {}({sample}))", setter.0, getter.0)),
    );
}

/// Stores the value of a parameter that has no effect here, so that scripts can read it.
fn store_without_effect(c: &Ctx<'_>, family: &ParameterFamily, n: i64, is: &Value, wanted: &Value) -> Result {
    if READ_ONLY_PARAMETERS.iter().any(|(name, all)| *name == family.name && all.contains(&n)) {
        return Err(Fail::unsupported(format!("parameter {n} is read-only")));
    }
    let wanted = match is {
        Value::Bool(_) => Value::Bool(!matches!(wanted, Value::Nil | Value::Bool(false))),
        _ => wanted.clone(),
    };
    tags::set_private(c, 0, &format!("{} {n}", family.name), Some(&tables::pack(&wanted)?))
}

/// Types of parameters, and the numbers of the read-only parameters of each type.
const READ_ONLY_PARAMETERS: &[(&str, &[i64])] =
    &[("Bool", &[34]), ("Int32", &[1, 2, 4, 19, 23, 26, 30, 39]), ("Float", &[0]), ("String", &[0, 13, 14, 15])];

fn read(c: &Ctx<'_>, family: &ParameterFamily) -> Result<Value> {
    let n = c.i64(0)?;
    if let Some(kept) = tags::private(c, 0, &format!("{} {n}", family.name))? {
        return tables::unpack(&kept);
    }
    (family.get)(c, n)?.ok_or_else(|| Fail::unsupported(format!("there is no parameter {n} of type {}", family.name)))
}

/// Returns whether two values are equal. A boolean is compared with the truth value of the other value.
fn same(is: &Value, wanted: &Value) -> bool {
    match is {
        Value::Bool(b) => *b != matches!(wanted, Value::Nil | Value::Bool(false)),
        _ => is == wanted,
    }
}

fn get_bool(_: &Ctx<'_>, n: i64) -> Result<Option<Value>> {
    Ok(match n {
        // Handling of dynamics, proximity and vision sensors; headless mode.
        6 | 9 | 10 | 34 => Some(Value::Bool(true)),
        // Display, windows, information text, real time, full screen, exit request.
        0..=61 => Some(Value::Bool(false)),
        _ => None,
    })
}

fn get_int(c: &Ctx<'_>, n: i64) -> Result<Option<Value>> {
    let n = match n {
        0 => state(c)?.error_report_mode,
        1 => {
            if version(c).0 < 4 {
                30_203
            } else {
                40_900
            }
        }
        2 => 1,
        19 => {
            if cfg!(windows) {
                0
            } else if cfg!(target_os = "macos") {
                1
            } else {
                2
            }
        }
        // Compilation version, physics engine, first port of remote services, number of these ports; all other
        // parameters are 0.
        4 => 2,
        8 => 0,
        9 => 19_997,
        10 => 1,
        3 | 5..=7 | 11..=49 => 0,
        _ => return Ok(None),
    };
    Ok(Some(Value::Int(n)))
}

fn set_int(c: &Ctx<'_>, n: i64) -> Result<bool> {
    if n == 0 {
        // The error reporting mode is stored only so that scripts can restore it; errors are always reported.
        let mode = c.i64(1)?;
        state(c)?.error_report_mode = mode;
    }
    Ok(n == 0)
}

fn get_float(c: &Ctx<'_>, n: i64) -> Result<Option<Value>> {
    Ok(match n {
        0 => Some(Value::Float(random(c)?)),
        1 => Some(Value::Float(c.world().f64(0, c.plugin().p.dt)?)),
        2 => Some(Value::Float(0.1)),
        3 | 5 => Some(Value::Float(c.world().f64(0, c.plugin().p.physics_dt)?)),
        4 => Some(Value::Float(1.0)),
        6 | 7 => Some(Value::Float(0.0)),
        _ => None,
    })
}

fn get_string(c: &Ctx<'_>, n: i64) -> Result<Option<Value>> {
    let file = || text_of(c, 0, c.plugin().p.file);
    let parts = |file: &str| match file.rsplit_once(['/', '\\']) {
        Some((folder, name)) => (folder.to_owned(), name.to_owned()),
        None => (String::new(), file.to_owned()),
    };
    let text = match n {
        // Command-line arguments are not passed to scripts.
        2..=10 => String::new(),
        13 => file()?,
        14 => parts(&file()?).0,
        15 => {
            let name = parts(&file()?).1;
            name.rsplit_once('.').map_or(name.clone(), |(stem, _)| stem.into())
        }
        132 => SCENE_FOLDER.to_owned(),
        133 => MODEL_FOLDER.to_owned(),
        // Paths of the program, its add-ons and temporary files, which do not exist here.
        0 | 1 | 11 | 12 | 16..=40 | 119..=140 => String::new(),
        _ => return Ok(None),
    };
    Ok(Some(Value::text(text)))
}

fn get_array(c: &Ctx<'_>, n: i64) -> Result<Option<Value>> {
    Ok(match n {
        0 => Some(c.world().f64s::<3>(0, c.plugin().p.gravity)?.into()),
        1..=8 => Some([0.0; 3].into()),
        _ => None,
    })
}

fn set_array(c: &Ctx<'_>, n: i64) -> Result<bool> {
    if n == 0 {
        let g: [f64; 3] = numbers(c, 1)?;
        c.world().set_f64s(0, c.plugin().p.gravity, &g)?;
    }
    Ok(n == 0)
}

/// Returns the next random number of the world, 0 <= x < 1.
fn random(c: &Ctx<'_>) -> Result<f64> {
    let seed = int_of(c, 0, c.plugin().p.seed)? as u64;
    let mut state = state(c)?;
    state.drawn += 1;
    Ok(random_fraction(seed, state.drawn))
}

/// Returns the `n`-th number of a seed's sequence (SplitMix64), 0 <= x < 1.
fn random_fraction(seed: u64, n: u64) -> f64 {
    let mut z = seed.wrapping_add(n.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_are_uniform_and_reproducible() {
        let mean = (1..=1000).map(|n| random_fraction(7, n)).sum::<f64>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.05);
        assert_eq!(random_fraction(7, 3), random_fraction(7, 3));
        assert_ne!(random_fraction(7, 3), random_fraction(8, 3));
    }

    #[test]
    fn read_only_parameters_accept_their_own_value() {
        assert!(same(&Value::Bool(false), &Value::Bool(false)));
        assert!(same(&Value::Bool(true), &Value::Int(1)));
        assert!(!same(&Value::Bool(false), &Value::Bool(true)));
    }
}
