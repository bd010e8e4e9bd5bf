//! A plugin in Rust that breaks those rules of the traits that only their documentation states. Nothing that it does
//! may access memory that it does not own.
//!
//! `tests/program/plugins/misbehaves_safely.rs` tests it.

mod devices;
mod service;

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use tatu_plugin_api::{abi::*, safe::*};

/// The plugin, which offers one item of each kind in this crate.
pub struct MisbehavesPlugin;

impl Plugin for MisbehavesPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(MisbehavesPlugin)
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<devices::GrowingSensor>();
        offer.sensor::<devices::AimingSensor>();
        offer.actuator::<devices::GrowingActuator>();
        offer.model::<devices::GrowingModel>();
        offer.service::<service::LingeringService>();
        offer.command(
            Command::new("misbehaves_safely.hold", |c| {
                let (world, sensor) = (c.world(), c.i64(0)? as tatu_object);
                let field = world.host().prop("misbehaves_safely.grown");
                let before = world.reading(sensor, field)?;
                let held = before.f64s();
                world.sense_now(sensor, 0)?;
                world.remove(&[world.look(sensor)?.id])?;
                let seen = held[0];
                c.ret(seen);
                Ok(())
            })
            .param(Param::int("sensor"))
            .text("Returns a value of a reading that was taken before its sensor measured again and was removed."),
        );
        offer.command(
            Command::side_by_side("misbehaves_safely.set", |c| {
                let (world, object) = (c.world(), c.i64(0)? as tatu_object);
                world.set(object, world.host().prop("object.alias"), &Value::text("other"))
            })
            .param(Param::int("object"))
            .text("Renames an object; may be called on any thread."),
        );
    }
}

/// Returns one element more at each call.
fn one_more_per_call<T>(calls: &AtomicUsize, one: impl Fn(usize) -> T) -> Vec<T> {
    (0..=calls.fetch_add(1, Relaxed)).map(one).collect()
}

tatu_plugin_api::tatu_plugin! {
    plugin: MisbehavesPlugin,
    id: "tatu.testing.misbehaves_safely",
    name: "Misbehaves safely",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
