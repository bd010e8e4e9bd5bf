//! Reads data of all objects of a type, such as names, poses and sensor readings.

use tatu_plugin_api::safe::{Fail, Result, Turn, Value};

use crate::{
    ask::call_command,
    values::{LittleEndianWriter, bytes, float, floats, int},
};

/// The object types that select all objects: in requests from clients, and in commands.
const ALL_OBJECT_TYPES: (i64, i64) = (109, -2);
/// Handle that selects the world frame.
const WORLD_FRAME: i64 = -1;
/// Handle that selects the frame of the parent.
const PARENT_FRAME: i64 = -11;

/// The data of all objects, consecutively.
#[derive(Default)]
struct GroupValues {
    ints: Vec<i64>,
    numbers: Vec<f64>,
    texts: Vec<Vec<u8>>,
}

/// Returns the data of type `what` of all objects of type `kind`.
pub fn read(turn: &Turn<'_>, kind: i64, what: i64) -> Result<Vec<u8>> {
    let kind = if kind == ALL_OBJECT_TYPES.0 { ALL_OBJECT_TYPES.1 } else { kind };
    let found = call_command(turn, "sim.getObjectsInTree", &[Value::Int(-12), Value::Int(kind), Value::Int(0)])?;
    let objects: Vec<i64> = floats(found.first())?.into_iter().map(|x| x as i64).collect();
    let mut group = GroupValues::default();
    for &object in &objects {
        append_object(turn, object, what, &mut group)?;
    }
    let mut out = LittleEndianWriter::default();
    for n in [objects.len(), group.ints.len(), group.numbers.len(), group.texts.len()] {
        out.i32(n as i64);
    }
    for x in objects.iter().chain(&group.ints) {
        out.i32(*x);
    }
    out.f32s(&group.numbers);
    for t in &group.texts {
        out.text(t);
    }
    Ok(out.0)
}

/// Appends the data of an object.
fn append_object(turn: &Turn<'_>, object: i64, what: i64, group: &mut GroupValues) -> Result {
    let own = Value::Int(object);
    let get = |name: &str| call_command(turn, name, std::slice::from_ref(&own));
    let of = |name: &str, frame: i64| -> Result<Vec<f64>> {
        floats(call_command(turn, name, &[own.clone(), Value::Int(frame)])?.first())
    };
    // Poses of data types with odd numbers are relative to the world, and those with even numbers to the parent.
    let frame = if what % 2 == 1 { WORLD_FRAME } else { PARENT_FRAME };
    match what {
        0 | 20 => group.texts.push(bytes(get("sim.getObjectName")?.first())?.to_vec()),
        1 => group.ints.push(int(get("sim.getObjectType")?.first())?),
        2 => group.ints.push(int(get("sim.getObjectParent")?.first())?),
        3 | 4 => group.numbers.extend(of("sim.getObjectPosition", frame)?),
        5 | 6 => group.numbers.extend(of("sim.getObjectOrientation", frame)?),
        7 | 8 => group.numbers.extend(of("sim.getObjectQuaternion", frame)?),
        9 | 10 => {
            group.numbers.extend(of("sim.getObjectPosition", frame)?);
            group.numbers.extend(of("sim.getObjectOrientation", frame)?);
        }
        11 | 12 => {
            group.numbers.extend(of("sim.getObjectPosition", frame)?);
            group.numbers.extend(of("sim.getObjectQuaternion", frame)?);
        }
        13 => {
            let three = |v: Option<&Value>| floats(v).ok().filter(|p| p.len() == 3).unwrap_or_else(|| vec![0.0; 3]);
            match get("sim.readProximitySensor") {
                Ok(v) => {
                    group.ints.extend([int(v.first())?, int(v.get(3)).unwrap_or(-1)]);
                    group.numbers.extend([three(v.get(2)), three(v.get(4))].concat());
                }
                // Objects of other types have placeholders.
                Err(_) => {
                    group.ints.extend([-1, -1]);
                    group.numbers.extend([0.0; 6]);
                }
            }
        }
        14 => match get("sim.readForceSensor") {
            Ok(v) => {
                group.ints.push(int(v.first())?);
                for value in [v.get(1), v.get(2)] {
                    group.numbers.extend(floats(value).unwrap_or_else(|_| vec![0.0; 3]));
                }
            }
            Err(_) => {
                group.ints.push(-1);
                group.numbers.extend([0.0; 6]);
            }
        },
        15 => {
            let of_joint = |name: &str| get(name).and_then(|v| float(v.first())).unwrap_or(0.0);
            group.numbers.extend([of_joint("sim.getJointPosition"), of_joint("sim.getJointForce")]);
        }
        16 => {
            let of_joint = |name: &str| get(name).and_then(|v| int(v.first())).unwrap_or(-1);
            group.ints.extend([of_joint("sim.getJointType"), of_joint("sim.getJointMode")]);
            let limits = get("sim.getJointInterval").unwrap_or_default();
            let cyclic = int(limits.first()).unwrap_or(0) != 0;
            let range = floats(limits.get(1)).ok().filter(|r| r.len() == 2).unwrap_or_else(|| vec![0.0; 2]);
            group.numbers.extend([range[0], if cyclic { -1.0 } else { range[1] }]);
        }
        17..=19 => {
            let v = get("sim.getObjectVelocity")?;
            let (linear, angular) = (floats(v.first())?, floats(v.get(1))?);
            if what != 18 {
                group.numbers.extend(linear);
            }
            if what != 17 {
                group.numbers.extend(angular);
            }
        }
        _ => return Err(Fail::unsupported(format!("the data type {what} of object groups is not supported"))),
    }
    Ok(())
}
