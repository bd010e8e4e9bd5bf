//! Messages that other plugins build from the readings of their sensors: for a kind of sensor `radar`, by the command
//! `message.ros.radar`, which receives a sensor and returns the type of the message, its fields, and the last part of
//! the topic's name.

use tatu_plugin_api::{
    abi::{TATU_ERR_UNKNOWN, TATU_LOG_WARNING, tatu_object},
    safe::{Fail, Result, Turn, Value},
};

use crate::{
    Props, convert,
    robots::ros_name,
    types::{self, RosVersion},
};

/// The command that builds the messages of a kind of sensor, without the name of the kind.
const PREFIX: &str = "message.ros.";

/// A message that another plugin has built.
pub struct DeclaredMessage {
    /// The last part of the topic's name.
    pub topic: String,
    /// The type of the message, by its name in ROS 1.
    pub kind: String,
    /// The fields of the message.
    fields: Value,
}

impl DeclaredMessage {
    /// Returns the last part of the name and the type of the topic of a sensor, if a plugin builds messages for its kind.
    /// Faulty messages are reported in the log.
    pub fn topic(turn: &Turn<'_>, p: &Props, sensor: tatu_object) -> Option<(String, String)> {
        let checked = || {
            let Some(built) = DeclaredMessage::of(turn, p, sensor)? else { return Ok(None) };
            let topic = (built.topic.clone(), built.kind.clone());
            convert::node(&built.message(Value::Nil), &topic.1, RosVersion::One)?;
            Ok(Some(topic))
        };
        checked().unwrap_or_else(|e: Fail| {
            let path =
                turn.get(sensor, p.alias).ok().and_then(|v| v.as_str().map(|a| a.into_owned())).unwrap_or_default();
            turn.log(TATU_LOG_WARNING, format!("rosbridge: there are no messages of /{path}: {}", e.text()).as_bytes());
            None
        })
    }

    /// Returns the current message of a sensor, or `None` if no plugin builds messages for its kind.
    pub fn of(turn: &Turn<'_>, p: &Props, sensor: tatu_object) -> Result<Option<DeclaredMessage>> {
        let kind = turn.get(sensor, p.sensor_kind)?.as_str().map(|k| k.into_owned()).unwrap_or_default();
        let command = format!("{PREFIX}{kind}");
        let results = match turn.call_command(&command, &[Value::Object(sensor)]) {
            Err(e) if e.code() == TATU_ERR_UNKNOWN => return Ok(None),
            results => results?,
        };
        let mut results = results.into_iter();
        let (Some(Value::Text(plain)), Some(fields @ Value::Map(_))) = (results.next(), results.next()) else {
            return Err(Fail::argument(format!(
                "the command `{command}` must return the type of the message and a table with its fields"
            )));
        };
        let topic = match results.next() {
            Some(Value::Text(topic)) if !topic.is_empty() => ros_name(&String::from_utf8_lossy(&topic)),
            _ => ros_name(&kind),
        };
        let kind = types::ros1_name(&String::from_utf8_lossy(&plain));
        Ok(Some(DeclaredMessage { topic, kind, fields }))
    }

    /// Returns the message. A header that its type has and the plugin has not set is that of the sensor.
    pub fn message(self, header: Value) -> Value {
        let has_header = types::fields(&self.kind).is_some_and(|f| f.iter().any(|f| f.name == "header"));
        match self.fields {
            Value::Map(mut fields) if has_header && fields.iter().all(|(k, _)| *k != Value::text("header")) => {
                fields.push((Value::text("header"), header));
                Value::Map(fields)
            }
            fields => fields,
        }
    }
}
