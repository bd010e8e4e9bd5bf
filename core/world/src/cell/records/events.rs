//! The events of a world that await delivery, and the subscriptions to events.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeSet, VecDeque},
    rc::Rc,
};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::events::covers;

/// Builds a payload, which is a map with string keys.
pub(crate) fn payload<const N: usize>(fields: [(&str, Value); N]) -> Value {
    Value::Map(fields.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

/// A script function that is called for an event.
#[derive(Debug, Clone)]
pub(crate) struct Subscription {
    pub id: u64,
    pub name: Rc<str>,
    pub handler: tatu_func,
}

/// The events of one world.
#[derive(Default)]
pub(crate) struct EventBus {
    /// Published events that await delivery, in order.
    pub queue: RefCell<VecDeque<(Rc<str>, Value)>>,
    /// Total size of the events that scripts have published since the queue was empty, bytes.
    waiting: Cell<u64>,
    /// Subscriptions, in the order in which they were made.
    pub subscriptions: RefCell<Vec<Subscription>>,
    pub last_id: Cell<u64>,
    /// Pairs of slots that touched after the previous physics stage, the lower slot first.
    pub touching: RefCell<BTreeSet<(u32, u32)>>,
    /// Names of events that parts and plugins receive, or `*`. A name stays in the list as long as the world.
    natives: RefCell<BTreeSet<String>>,
    /// Indices of the plugins whose function for events has failed, which are not called again.
    pub deaf: RefCell<BTreeSet<usize>>,
    /// The event that is being delivered.
    pub delivering: RefCell<Option<Rc<str>>>,
}

impl EventBus {
    /// Clears the data of the previous run, except the subscriptions.
    pub fn begin(&self) {
        self.queue.borrow_mut().clear();
        self.touching.borrow_mut().clear();
    }
    /// Returns whether an event must be queued, because a script, a part or a plugin subscribes to it.
    pub fn has_subscriber(&self, name: &str) -> bool {
        // A handler that prints must not receive its own lines, because this would never end.
        let own = name == "message" && self.delivering.try_borrow().is_ok_and(|n| n.as_deref() == Some(name));
        let scripts = || self.subscriptions.try_borrow().is_ok_and(|s| s.iter().any(|s| covers(&s.name, name)));
        let natives = || self.natives.try_borrow().is_ok_and(|n| n.iter().any(|wanted| covers(wanted, name)));
        !own && (scripts() || natives())
    }
    /// Adds names of events that a part or a plugin receives.
    pub fn add_natives(&self, names: &[String]) {
        self.natives.borrow_mut().extend(names.iter().cloned());
    }
    /// Returns whether there are any subscriptions of scripts.
    pub fn has_listeners(&self) -> bool {
        self.subscriptions.try_borrow().is_ok_and(|s| !s.is_empty())
    }
    /// Returns whether the script with this instance id has a subscription.
    pub fn has_subscription_of(&self, instance: u64) -> bool {
        self.subscriptions.try_borrow().is_ok_and(|s| s.iter().any(|s| s.handler >> 32 == instance))
    }
    /// Returns whether an event of `bytes` bytes fits into `room` bytes with those already queued, and if so, counts
    /// it.
    pub fn try_reserve(&self, bytes: u64, room: u64) -> bool {
        let before = if self.queue.try_borrow().is_ok_and(|q| q.is_empty()) { 0 } else { self.waiting.get() };
        let fits = before.saturating_add(bytes) <= room;
        self.waiting.set(if fits { before + bytes } else { before });
        fits
    }
    /// Adds an event to the queue, for the next delivery.
    pub fn push(&self, name: &str, payload: Value) {
        if let Ok(mut queue) = self.queue.try_borrow_mut() {
            queue.push_back((name.into(), payload));
        }
    }
    /// Adds a subscription and returns its id, or `None` if the list of subscriptions is in use.
    pub fn subscribe(&self, name: &str, handler: tatu_func) -> Option<u64> {
        let mut all = self.subscriptions.try_borrow_mut().ok()?;
        let id = self.last_id.get() + 1;
        self.last_id.set(id);
        all.push(Subscription { id, name: name.into(), handler });
        Some(id)
    }
    /// Removes a subscription and returns its handler, if it existed.
    pub fn unsubscribe(&self, id: u64) -> Option<tatu_func> {
        let mut all = self.subscriptions.try_borrow_mut().ok()?;
        let at = all.iter().position(|s| s.id == id)?;
        Some(all.remove(at).handler)
    }
}

#[cfg(test)]
mod tests {
    use tatu_plugins::events::ALL_EVENTS;

    use super::*;

    #[test]
    fn subscriber_to_all_events_does_not_receive_gathered_events() {
        let bus = EventBus::default();
        assert!(!bus.has_subscriber("fault") && !bus.has_listeners());
        let all = bus.subscribe(ALL_EVENTS, 7).unwrap();
        assert!(bus.has_subscriber("fault") && bus.has_subscriber("gripper.closed") && !bus.has_subscriber("contact"));
        let contacts = bus.subscribe("contact", 8).unwrap();
        assert!(bus.has_subscriber("contact") && !bus.has_subscriber("collision"));
        assert_eq!((bus.unsubscribe(all), bus.unsubscribe(all), bus.unsubscribe(contacts)), (Some(7), None, Some(8)));
        assert!(!bus.has_subscriber("fault") && !bus.has_listeners());
    }

    #[test]
    fn line_printed_by_a_message_handler_is_not_published() {
        let bus = EventBus::default();
        bus.subscribe("message", 1);
        assert!(bus.has_subscriber("message"));
        *bus.delivering.borrow_mut() = Some("message".into());
        assert!(!bus.has_subscriber("message"));
    }
}
