//! The services of `/rosapi`, which list topics and services and access parameters, and those that control the
//! simulation.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result},
};

use crate::types::{self, ArrayLength, RosVersion};

/// The name under which this service appears as a ROS node.
const NODE_NAME: &str = "/tatu";

/// The topics and services that can be listed.
pub struct RosGraph<'a> {
    /// Types (by their names in ROS 1) of all topics, by topic.
    pub topics: &'a BTreeMap<String, String>,
    /// Topics that this service publishes.
    pub publishes: &'a [String],
    /// Topics that this service subscribes to.
    pub subscribes: &'a [String],
    /// Types of all services, by service.
    pub services: &'a BTreeMap<String, String>,
    /// Simulation time, s.
    pub time: f64,
    /// The version of ROS that determines the names of types.
    pub ros: RosVersion,
}

/// The services of `/rosapi` and their types.
pub const SERVICES: &[(&str, &str)] = &[
    ("/rosapi/topics", "rosapi/Topics"),
    ("/rosapi/topic_type", "rosapi/TopicType"),
    ("/rosapi/topics_for_type", "rosapi/TopicsForType"),
    ("/rosapi/services", "rosapi/Services"),
    ("/rosapi/service_type", "rosapi/ServiceType"),
    ("/rosapi/nodes", "rosapi/Nodes"),
    ("/rosapi/node_details", "rosapi/NodeDetails"),
    ("/rosapi/publishers", "rosapi/Publishers"),
    ("/rosapi/subscribers", "rosapi/Subscribers"),
    ("/rosapi/message_details", "rosapi/MessageDetails"),
    ("/rosapi/get_time", "rosapi/GetTime"),
    ("/rosapi/get_param", "rosapi/GetParam"),
    ("/rosapi/set_param", "rosapi/SetParam"),
    ("/rosapi/has_param", "rosapi/HasParam"),
    ("/rosapi/delete_param", "rosapi/DeleteParam"),
    ("/rosapi/get_param_names", "rosapi/GetParamNames"),
];

/// The services that control the simulation, and the requests that they make.
pub const CONTROL_SERVICES: &[(&str, u32)] = &[
    ("/simulation/start", TATU_REQUEST_START),
    ("/simulation/pause", TATU_REQUEST_PAUSE),
    ("/simulation/stop", TATU_REQUEST_STOP),
];

/// Returns whether a service is one of those in this module.
pub fn is_own_service(service: &str) -> bool {
    SERVICES.iter().any(|(s, _)| *s == service) || CONTROL_SERVICES.iter().any(|(s, _)| *s == service)
}

/// Executes a service of `/rosapi` and returns its response. Returns `None` if there is no such service.
pub fn call(
    g: &RosGraph<'_>,
    params: &mut BTreeMap<String, String>,
    service: &str,
    args: &Json,
) -> Option<Result<Json>> {
    // Arguments are passed by name, or as an array.
    let arg =
        |name: &str, i: usize| args.get(name).or_else(|| args.get(i)).and_then(Json::as_str).unwrap_or("").to_owned();
    let named = |kind: &str| if kind.is_empty() { String::new() } else { g.ros.name(kind) };
    let known = |topic: &str| g.topics.get(topic).map_or("", String::as_str).to_owned();
    let us =
        |topics: &[String], topic: &str| if topics.iter().any(|t| t == topic) { json!([NODE_NAME]) } else { json!([]) };
    let all: Vec<&String> = g.topics.keys().collect();
    Some(Ok(match service.strip_prefix("/rosapi/")? {
        "topics" => json!({ "topics": all, "types": g.topics.values().map(|k| named(k)).collect::<Vec<_>>() }),
        "topic_type" => json!({ "type": named(&known(&arg("topic", 0))) }),
        "topics_for_type" => {
            let kind = types::ros1_name(&arg("type", 0));
            json!({ "topics": g.topics.iter().filter(|(_, k)| **k == kind).map(|(t, _)| t).collect::<Vec<_>>() })
        }
        "services" => json!({ "services": g.services.keys().collect::<Vec<_>>() }),
        "service_type" => json!({ "type": g.services.get(&arg("service", 0)).cloned().unwrap_or_default() }),
        "nodes" => json!({ "nodes": [NODE_NAME] }),
        "node_details" => json!({
            "publishing": g.publishes, "subscribing": g.subscribes,
            "services": SERVICES.iter().map(|(s, _)| s).collect::<Vec<_>>(),
        }),
        "publishers" => json!({ "publishers": us(g.publishes, &arg("topic", 0)) }),
        "subscribers" => json!({ "subscribers": us(g.subscribes, &arg("topic", 0)) }),
        "message_details" => return Some(message_details(&arg("type", 0), g.ros)),
        "get_time" => {
            let (whole, part) = (g.time.floor(), g.time.fract());
            let [a, b] = if g.ros == RosVersion::One { ["secs", "nsecs"] } else { ["sec", "nanosec"] };
            json!({ "time": { a: whole as i64, b: (part * 1e9) as i64 } })
        }
        // Values of parameters are stored as clients send them: as strings that contain JSON.
        "get_param" => {
            let fallback = arg("default", 1);
            json!({ "value": params.get(&stored_param_name(params, arg("name", 0))).cloned().unwrap_or(fallback) })
        }
        "set_param" => {
            params.insert(stored_param_name(params, arg("name", 0)), arg("value", 1));
            json!({})
        }
        "has_param" => json!({ "exists": params.contains_key(&stored_param_name(params, arg("name", 0))) }),
        "delete_param" => {
            params.remove(&stored_param_name(params, arg("name", 0)));
            json!({})
        }
        "get_param_names" => json!({ "names": params.keys().collect::<Vec<_>>() }),
        _ => return None,
    }))
}

/// Returns the name under which a parameter is stored. The names `x`, `/x` and, as for ROS 2 nodes, `/node:x` refer to
/// the same parameter if it exists.
fn stored_param_name(params: &BTreeMap<String, String>, name: String) -> String {
    let last = name.rsplit(':').next().unwrap_or("").trim_start_matches('/');
    let known = [name.clone(), last.to_owned(), format!("/{last}")];
    known.into_iter().find(|n| params.contains_key(n)).unwrap_or(name)
}

/// Returns the definitions of a message type and of all types that it contains.
fn message_details(name: &str, ros: RosVersion) -> Result<Json> {
    let first = types::ros1_name(name);
    let mut ahead = vec![first.clone()];
    let mut done: Vec<Json> = Vec::new();
    let mut seen = Vec::new();
    while let Some(plain) = ahead.pop() {
        if seen.contains(&plain) {
            continue;
        }
        let fields = types::fields(&plain)
            .ok_or_else(|| Fail::missing(format!("the message type `{plain}` is not supported")))?;
        let here: Vec<_> = fields.iter().filter(|f| ros.field(&plain, &f.name).is_some()).collect();
        let length = |many| match many {
            ArrayLength::One => -1,
            ArrayLength::Any => 0,
            ArrayLength::Exactly(n) => n as i64,
        };
        done.push(json!({
            "type": ros.name(&plain),
            "fieldnames": here.iter().map(|f| ros.field(&plain, &f.name)).collect::<Vec<_>>(),
            "fieldtypes": here.iter().map(|f| match &f.element {
                types::FieldElementType::Message(inner) => ros.name(inner),
                _ => f.written_type.clone(),
            }).collect::<Vec<_>>(),
            "fieldarraylen": here.iter().map(|f| length(f.length)).collect::<Vec<_>>(),
            "examples": here.iter().map(|_| "").collect::<Vec<_>>(),
        }));
        for field in here {
            if let types::FieldElementType::Message(inner) = &field.element {
                ahead.push(inner.clone());
            }
        }
        seen.push(plain);
    }
    Ok(json!({ "typedefs": done }))
}
