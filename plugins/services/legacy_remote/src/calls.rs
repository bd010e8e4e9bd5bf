//! Maps the commands of the protocol to commands of the world, and converts their arguments and results.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Turn, Value},
};

use crate::{
    ask::call_command,
    files::TransferredFiles,
    groups,
    values::{LittleEndianReader, LittleEndianWriter, bytes, float, floats, int},
};

/// Handle that the protocol uses if there is no object, as when a proximity sensor detects nothing.
const NO_OBJECT: i64 = -1;

/// Executes the command with number `raw` on the subject `of` with the argument `data`. Returns the data of the answer.
pub fn call(turn: &Turn<'_>, files: &mut TransferredFiles, raw: u16, of: &[u8], data: &[u8]) -> Result<Vec<u8>> {
    let (mut of, mut data) = (LittleEndianReader(of), LittleEndianReader(data));
    match raw {
        0x0001..=0x0FFF => call_without_subject(turn, raw, &mut data),
        0x1001..=0x1FFF => call_with_number(turn, raw, of.i32()?.into(), &mut data),
        // This is the only command in this range with a single number, that of a window, as its subject.
        0x2003 => event_button(turn, of.i32()?.into()),
        0x2001..=0x2FFF => call_with_two_numbers(turn, raw, of.i32()?.into(), of.i32()?.into(), &mut data),
        0x3002..=0x3006 => call_with_file(turn, files, raw, &of.text()?, &mut data),
        0x3001..=0x33FF => call_with_name(turn, raw, &of.text()?, &mut data),
        0x3401 => call_script_function(turn, &mut of, &mut data),
        _ => Err(unknown(raw)),
    }
}

/// Builds the error for a command number that is not supported.
fn unknown(raw: u16) -> Fail {
    Fail::unsupported(format!("the command {raw:#06x} is not supported"))
}

/// Builds an answer without data.
fn empty_answer(_: Vec<Value>) -> Result<Vec<u8>> {
    Ok(Vec::new())
}
/// Encodes the first value as an integer.
fn integer(values: Vec<Value>) -> Result<Vec<u8>> {
    Ok(std::mem::take(LittleEndianWriter::default().i32(int(values.first())?)).0)
}
/// Encodes the first value as a float.
fn number(values: Vec<Value>) -> Result<Vec<u8>> {
    Ok(std::mem::take(LittleEndianWriter::default().f32(float(values.first())?)).0)
}
/// Encodes the numbers in all values as consecutive floats.
fn numbers(values: Vec<Value>) -> Result<Vec<u8>> {
    let mut out = LittleEndianWriter::default();
    for value in &values {
        out.f32s(&floats(Some(value))?);
    }
    Ok(out.0)
}
/// Encodes the first value, a list of handles, as integers that are preceded by their count.
fn handles(values: Vec<Value>) -> Result<Vec<u8>> {
    let all = floats(values.first())?;
    let mut out = LittleEndianWriter::default();
    out.i32(all.len() as i64);
    for x in all {
        out.i32(x as i64);
    }
    Ok(out.0)
}
/// Encodes the first value as a zero-terminated string.
fn text(values: Vec<Value>) -> Result<Vec<u8>> {
    Ok(std::mem::take(LittleEndianWriter::default().text(bytes(values.first())?)).0)
}

/// Executes a command that has no subject, by its number.
fn call_without_subject(turn: &Turn<'_>, raw: u16, data: &mut LittleEndianReader<'_>) -> Result<Vec<u8>> {
    match raw {
        0x0005 => call_command(turn, "sim.closeScene", &[]).and_then(empty_answer),
        0x0006 => call_command(turn, "sim.getObjectSelection", &[]).and_then(|v| {
            // For an empty selection, the command returns nil instead of an empty table.
            if matches!(v.first(), None | Some(Value::Nil)) {
                handles(vec![Value::List(Vec::new())])
            } else {
                handles(v)
            }
        }),
        0x0009 => call_command(turn, "sim.createDummy", &[data.float()?]).and_then(integer),
        _ => Err(unknown(raw)),
    }
}

/// Executes commands with one number as the subject, such as the handle of an object or the id of a parameter.
fn call_with_number(turn: &Turn<'_>, raw: u16, which: i64, data: &mut LittleEndianReader<'_>) -> Result<Vec<u8>> {
    let own = Value::Int(which);
    let get = |name: &str| call_command(turn, name, std::slice::from_ref(&own));
    let set = |name: &str, value: Value| call_command(turn, name, &[own.clone(), value]).and_then(empty_answer);
    match raw {
        0x1001 => get("sim.getJointPosition").and_then(number),
        0x1002 => set("sim.setJointPosition", data.float()?),
        0x1003 | 0x1004 => image(turn, which, raw == 0x1003),
        0x1005 | 0x1006 => {
            let args = [own.clone(), Value::Bytes(data.rest()), Value::Int(i64::from(raw == 0x1005))];
            call_command(turn, "sim.setVisionSensorImg", &args).and_then(empty_answer)
        }
        0x1007 => {
            turn.request(match which {
                0 => TATU_REQUEST_START,
                1 => TATU_REQUEST_PAUSE,
                _ => TATU_REQUEST_STOP,
            })?;
            Ok(Vec::new())
        }
        0x1008 => set("sim.setJointTargetVelocity", data.float()?),
        0x1009 => proximity(get("sim.readProximitySensor")?),
        0x100A => get("sim.getJointMatrix").and_then(numbers),
        0x100B => set("sim.setSphericalJointMatrix", data.f32s(12)?),
        0x100C => set("sim.setJointTargetPosition", data.float()?),
        0x100D => get("sim.getJointForce").and_then(number),
        0x100E => set("sim.setJointMaxForce", data.float()?),
        0x100F => {
            let v = get("sim.readForceSensor")?;
            let mut out = LittleEndianWriter::default();
            out.u8(int(v.first())? as u8);
            for value in [v.get(1), v.get(2)] {
                out.f32s(&floats(value).unwrap_or_else(|_| vec![0.0; 3]));
            }
            Ok(out.0)
        }
        0x1010 => get("sim.breakForceSensor").and_then(empty_answer),
        0x1011 => {
            let v = get("sim.readVisionSensor")?;
            let packets = v.iter().skip(1).map(|p| floats(Some(p))).collect::<Result<Vec<_>>>()?;
            let mut out = LittleEndianWriter::default();
            out.u8(int(v.first())? as u8).i32(packets.len() as i64);
            for p in &packets {
                out.i32(p.len() as i64);
            }
            packets.iter().for_each(|p| {
                out.f32s(p);
            });
            Ok(out.0)
        }
        0x1012 => get("sim.getObjectParent").and_then(integer),
        0x1014 => get("sim.auxiliaryConsoleClose").and_then(empty_answer),
        0x1015 => match data.text()? {
            text if text.is_empty() => get("sim.auxiliaryConsolePrint").and_then(empty_answer),
            text => set("sim.auxiliaryConsolePrint", Value::Text(text)),
        },
        0x1016 => set("sim.auxiliaryConsoleShow", Value::Bool(data.i32()? != 0)),
        0x1017 => {
            let v = call_command(turn, "sim.getVisionSensorDepth", &[own, Value::Int(0)])?;
            encode_image(&v)
        }
        0x1018 => call_command(turn, "sim.getObjectOrientation", &[own, data.int()?]).and_then(numbers),
        0x1019 => call_command(turn, "sim.getObjectPosition", &[own, data.int()?]).and_then(numbers),
        0x101A => {
            call_command(turn, "sim.setObjectOrientation", &[own, data.int()?, data.f32s(3)?]).and_then(empty_answer)
        }
        0x101B => {
            call_command(turn, "sim.setObjectPosition", &[own, data.int()?, data.f32s(3)?]).and_then(empty_answer)
        }
        0x101C => {
            let (parent, keep) = (data.int()?, data.take(1)? != [0]);
            call_command(turn, "sim.setObjectParent", &[own, parent, Value::Bool(keep)]).and_then(empty_answer)
        }
        0x101D => get("sim.getArrayParameter").and_then(numbers),
        0x101E => set("sim.setArrayParameter", data.f32s(3)?),
        0x101F => get("sim.getBoolParameter").and_then(integer),
        0x1020 => set("sim.setBoolParameter", Value::Bool(data.i32()? != 0)),
        0x1021 => get("sim.getInt32Parameter").and_then(integer),
        0x1022 => set("sim.setInt32Parameter", data.int()?),
        0x1023 => get("sim.getFloatParameter").and_then(number),
        0x1024 => set("sim.setFloatParameter", data.float()?),
        0x1025 => get("sim.getStringParameter").and_then(text),
        0x1026 => get("sim.readCollision").and_then(integer),
        0x1027 => {
            let v = get("sim.readDistance")?;
            // A distance object has no distance if nothing is in range, or if it is handled explicitly and has not been
            // handled yet.
            let distance = v.get(1).filter(|_| int(v.first()).is_ok_and(|found| found != 0));
            let none = || {
                Fail::missing(format!(
                    "the distance object {which} has no result: no objects are in range, or it was never handled"
                ))
            };
            number(vec![distance.cloned().ok_or_else(none)?])
        }
        0x1028 => get("sim.removeObject").and_then(empty_answer),
        0x1029 => get("sim.removeUI").and_then(empty_answer),
        0x102A => call_command(turn, "sim.getObjectsInTree", &[Value::Int(-12), own, Value::Int(0)]).and_then(handles),
        0x102B => get("sim.endDialog").and_then(empty_answer),
        0x102C => get("sim.getDialogInput").and_then(text),
        0x102D => get("sim.getDialogResult").and_then(integer),
        0x102E => call_command(turn, "sim.copyPasteObjects", &[data.ints()?, Value::Int(0)]).and_then(handles),
        0x102F => call_command(turn, "sim.setObjectSel", &[data.ints()?]).and_then(empty_answer),
        0x1034 => get("sim.getModelProperty").and_then(integer),
        0x1035 => set("sim.setModelProperty", data.int()?),
        0x1036 => get("sim.getObjectVelocity").and_then(numbers),
        0x1037 => get("sim.removeModel").and_then(empty_answer),
        0x1038 => get("sim.getJointMaxForce").and_then(number),
        0x1801 => {
            call_command(turn, "sim.setObjectQuaternion", &[own, data.int()?, data.f32s(4)?]).and_then(empty_answer)
        }
        _ => Err(unknown(raw)),
    }
}

/// Encodes the state, detected point, detected object and surface normal of a proximity sensor.
fn proximity(v: Vec<Value>) -> Result<Vec<u8>> {
    let zero = || vec![0.0; 3];
    let mut out = LittleEndianWriter::default();
    out.u8(u8::from(int(v.first())? > 0));
    out.f32s(&floats(v.get(2)).ok().filter(|p| p.len() == 3).unwrap_or_else(zero));
    out.i32(int(v.get(3)).unwrap_or(NO_OBJECT));
    out.f32s(&floats(v.get(4)).ok().filter(|p| p.len() == 3).unwrap_or_else(zero));
    Ok(out.0)
}

/// Encodes a colour, grey or depth image: the number of columns, the number of rows, and the bytes.
fn encode_image(v: &[Value]) -> Result<Vec<u8>> {
    let size = floats(v.get(1))?;
    let mut out = LittleEndianWriter::default();
    for x in size.iter().take(2) {
        out.i32(*x as i64);
    }
    out.bytes(bytes(v.first())?);
    Ok(out.0)
}

/// Reads and encodes the image of a vision sensor.
fn image(turn: &Turn<'_>, sensor: i64, grey: bool) -> Result<Vec<u8>> {
    encode_image(&call_command(turn, "sim.getVisionSensorImg", &[Value::Int(sensor), Value::Int(i64::from(grey))])?)
}

/// Executes commands with two numbers as the subject, such as the handles of two objects.
fn call_with_two_numbers(
    turn: &Turn<'_>,
    raw: u16,
    first: i64,
    second: i64,
    data: &mut LittleEndianReader<'_>,
) -> Result<Vec<u8>> {
    let both = [Value::Int(first), Value::Int(second)];
    let get = |name: &str| call_command(turn, name, &both);
    let set = |name: &str, value: Value| {
        call_command(turn, name, &[both[0].clone(), both[1].clone(), value]).and_then(empty_answer)
    };
    match raw {
        0x2001 => get("sim.getUISlider").and_then(integer),
        0x2002 => set("sim.setUISlider", data.int()?),
        0x2004 => get("sim.getUIButtonProperty").and_then(integer),
        0x2005 => set("sim.setUIButtonProperty", data.int()?),
        0x2006 => {
            let (up, down) = (Value::Text(data.text()?), Value::Text(data.text()?));
            call_command(turn, "sim.setUIButtonLabel", &[both[0].clone(), both[1].clone(), up, down])
                .and_then(empty_answer)
        }
        0x2007 => get("sim.getObjectFloatParameter").and_then(number),
        0x2008 => get("sim.getObjectInt32Parameter").and_then(integer),
        0x2009 => set("sim.setObjectFloatParameter", data.float()?),
        0x200A => set("sim.setObjectInt32Parameter", data.int()?),
        0x200B => get("sim.getObjectChild").and_then(integer),
        0x200C => groups::read(turn, first, second),
        0x200D => get("sim.getObjectOrientation").and_then(numbers),
        0x200E => get("sim.getObjectPosition").and_then(numbers),
        0x200F => get("sim.checkCollision").and_then(integer),
        0x2010 => {
            let found =
                call_command(turn, "sim.checkDistance", &[both[0].clone(), both[1].clone(), Value::Float(0.0)])?;
            let data = floats(found.get(1))?;
            let distance =
                data.get(6).ok_or_else(|| Fail::missing("the distance between the objects could not be measured"))?;
            Ok(std::mem::take(LittleEndianWriter::default().f32(*distance)).0)
        }
        0x2801 => get("sim.getObjectQuaternion").and_then(numbers),
        _ => Err(unknown(raw)),
    }
}

/// Encodes the button that was pressed last in a window, and the two values reported with it.
fn event_button(turn: &Turn<'_>, window: i64) -> Result<Vec<u8>> {
    let v = call_command(turn, "sim.getUIEventButton", &[Value::Int(window)])?;
    let values = floats(v.get(1)).unwrap_or_default();
    let mut out = LittleEndianWriter::default();
    // The client library sends a subject of four bytes but expects one of eight bytes in the answer, so four bytes are
    // inserted before the data.
    out.i32(0).i32(int(v.first())?);
    for i in 0..2 {
        out.i32(values.get(i).map_or(0, |x| *x as i64));
    }
    Ok(out.0)
}

/// Executes commands with the name of a file as the subject.
fn call_with_file(
    turn: &Turn<'_>,
    files: &mut TransferredFiles,
    raw: u16,
    name: &[u8],
    data: &mut LittleEndianReader<'_>,
) -> Result<Vec<u8>> {
    let mut load = |command: &str| {
        files.mark_loaded(name);
        let path = files.path(name);
        call_command(turn, command, &[Value::Text(path.clone())]).map_err(|e| {
            let named = Fail::with_code(e.code(), format!("`{}`: {}", String::from_utf8_lossy(&path), e.text()));
            e.help_text().into_iter().fold(named, |fail, help| fail.help(help))
        })
    };
    match raw {
        0x3002 => load("sim.loadScene").and_then(empty_answer),
        0x3003 => load("sim.loadModel").and_then(integer),
        0x3004 => files.transfer(turn, name, data.0).and_then(|()| empty_answer(Vec::new())),
        0x3006 => files.erase(turn, name).and_then(|()| empty_answer(Vec::new())),
        _ => Err(Fail::unsupported(
            "windows of buttons cannot be loaded from files, because the file format is not supported",
        )
        .help(
            "open a V-REP scene (`.ttt`) that contains the window, or create the window by a script with `simCreateUI`",
        )),
    }
}

/// Executes commands with a name or another string as the subject.
fn call_with_name(turn: &Turn<'_>, raw: u16, name: &[u8], data: &mut LittleEndianReader<'_>) -> Result<Vec<u8>> {
    let own = Value::Text(name.to_vec());
    let get = |command: &str| call_command(turn, command, std::slice::from_ref(&own));
    let set = |command: &str, value: Value| call_command(turn, command, &[own.clone(), value]).and_then(empty_answer);
    // An empty name refers to all signals of the type.
    let clear = |command: &str| {
        if name.is_empty() { call_command(turn, command, &[]) } else { get(command) }.and_then(empty_answer)
    };
    let signal = || match get("sim.getStringSignal")?.into_iter().next() {
        Some(Value::Text(text) | Value::Bytes(text)) => Ok(Some(text)),
        _ => Ok::<_, Fail>(None),
    };
    let gone = || Fail::missing(format!("there is no signal `{}`", String::from_utf8_lossy(name)));
    match raw {
        0x3001 if matches!(name.first(), Some(b'/' | b'.' | b':')) => get("sim.getObject").and_then(integer),
        0x3001 => get("sim.getObjectHandle").and_then(integer),
        0x3007 => get("sim.getUIHandle").and_then(integer),
        0x3008 => get("sim.addStatusbarMessage").and_then(empty_answer),
        0x3009 => {
            let (lines, mode) = (data.int()?, data.int()?);
            call_command(turn, "sim.auxiliaryConsoleOpen", &[own, lines, mode]).and_then(integer)
        }
        0x300A => get("sim.getCollisionHandle").and_then(integer),
        0x300B => get("sim.getDistanceHandle").and_then(integer),
        0x300C => {
            let (main, style, initial) = (data.text()?, data.int()?, data.text()?);
            let args = [own, Value::Text(main), style, Value::Bool(false), Value::Text(initial)];
            let v = call_command(turn, "sim.displayDialog", &args)?;
            let mut out = LittleEndianWriter::default();
            out.i32(int(v.first())?).i32(int(v.get(1)).unwrap_or(-1));
            Ok(out.0)
        }
        0x300D => clear("sim.clearFloatSignal"),
        0x300E => clear("sim.clearIntegerSignal"),
        0x300F => clear("sim.clearStringSignal"),
        0x3010 => get("sim.getFloatSignal").and_then(number),
        0x3011 => get("sim.getIntegerSignal").and_then(integer),
        0x3012 => signal()?.ok_or_else(gone),
        0x3013 => set("sim.setFloatSignal", data.float()?),
        0x3014 => set("sim.setIntegerSignal", data.int()?),
        0x3015 => set("sim.setStringSignal", Value::Bytes(data.rest())),
        0x3016 => {
            let mut whole = signal()?.unwrap_or_default();
            whole.extend(data.rest());
            set("sim.setStringSignal", Value::Bytes(whole))
        }
        0x3017 | 0x3018 => match signal()? {
            Some(text) => {
                clear("sim.clearStringSignal")?;
                Ok(text)
            }
            None if raw == 0x3018 => Ok(Vec::new()),
            None => Err(gone()),
        },
        0x3019 => get("sim.getCollectionHandle").and_then(integer),
        _ => Err(unknown(raw)),
    }
}

/// Calls a function of a script. Its arguments and results are a list of integers, a list of floats, a list of strings
/// and a buffer of bytes.
fn call_script_function(
    turn: &Turn<'_>,
    of: &mut LittleEndianReader<'_>,
    data: &mut LittleEndianReader<'_>,
) -> Result<Vec<u8>> {
    let (kind, owner, function) = (of.int()?, of.text()?, of.text()?);
    let mut counts = [0_usize; 4];
    for n in &mut counts {
        *n = usize::try_from(data.i32()?)
            .map_err(|_| Fail::argument("the number of arguments of a script function must not be negative"))?;
    }
    let [ints, numbers, texts, buffer] = counts;
    let ints = data.take(ints.saturating_mul(4)).and_then(|b| LittleEndianReader(b).ints())?;
    let part = data.take(numbers.saturating_mul(4))?;
    let numbers = LittleEndianReader(part).f32s(numbers)?;
    let texts = Value::List((0..texts).map(|_| data.text().map(Value::Text)).collect::<Result<_>>()?);
    let buffer = Value::Bytes(data.take(buffer)?.to_vec());
    let name = [function, owner].join(&b'@');
    let v = call_command(turn, "sim.callScriptFunction", &[Value::Text(name), kind, ints, numbers, texts, buffer])?;
    if v.len() < 4 {
        return Err(Fail::argument(
            "the script function must return four values: tables of integers, of floats and of strings, and a buffer",
        ));
    }
    let empty = |v: &Value| matches!(v, Value::Nil) || matches!(v, Value::Map(m) if m.is_empty());
    let list = |v: &Value| if empty(v) { Ok(Vec::new()) } else { floats(Some(v)) };
    let (ints, numbers) = (list(&v[0])?, list(&v[1])?);
    let texts = match &v[2] {
        Value::List(all) => all.iter().map(|t| bytes(Some(t)).map(<[u8]>::to_vec)).collect::<Result<Vec<_>>>()?,
        _ => Vec::new(),
    };
    let buffer = bytes(v.get(3)).unwrap_or_default();
    let mut out = LittleEndianWriter::default();
    for n in [ints.len(), numbers.len(), texts.len(), buffer.len()] {
        out.i32(n as i64);
    }
    for x in ints {
        out.i32(x as i64);
    }
    out.f32s(&numbers);
    for t in &texts {
        out.text(t);
    }
    out.bytes(buffer);
    Ok(out.0)
}
