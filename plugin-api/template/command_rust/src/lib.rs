//! my_plugin: commands for scripts, in Rust.
//!
//! - `metres = my_plugin.travelled(object)`: distance that an object has moved since the first call for it
//! - `my_plugin.reset()`: forgets all objects
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use std::{cell::RefCell, collections::BTreeMap};

use tatu_plugin_api::{abi::tatu_object, safe::*, tatu_plugin};

/// The plugin. All worlds and their threads share one value, so it must not change.
struct ThisPlugin;

/// The distance that an object has travelled, m, and its position at the last call, m.
struct Odometer {
    last_position: [f64; 3],
    distance_m: f64,
}

/// The state of a world: an odometer for each object.
#[derive(Default)]
struct Odometers(RefCell<BTreeMap<tatu_object, Odometer>>);

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        // The host has checked that the arguments have the types that are declared here.
        offer.command(
            Command::<Self>::new("my_plugin.travelled", |c| {
                let object = c.world().look(c.arg(0).as_object().unwrap_or_default())?.id;
                let [x, y, z, ..] = c.world().pose(object, 0)?;
                let mut odometers = c.instance().0.borrow_mut();
                let odometer = odometers.entry(object).or_insert(Odometer { last_position: [x, y, z], distance_m: 0.0 });
                let [x0, y0, z0] = odometer.last_position;
                odometer.distance_m += (x - x0).hypot(y - y0).hypot(z - z0);
                odometer.last_position = [x, y, z];
                c.ret(odometer.distance_m);
                Ok(())
            })
            .param(Param::object("object").text("The object."))
            .returns(Param::float("metres").unit("m").text("Distance moved since the first call for it."))
            .text("Returns the distance an object has moved.")
            .subject("my_plugin")
            .example(
                "local box = sim.createDummy(0.1)
my_plugin.travelled(box)
sim.setObjectPosition(box, sim.handle_world, {3, 4, 0})
assert(math.abs(my_plugin.travelled(box) - 5) < 1e-9)",
            ),
        );
        offer.command(
            Command::<Self>::new("my_plugin.reset", |c| {
                c.instance().0.borrow_mut().clear();
                Ok(())
            })
            .text("Forgets all objects.")
            .subject("my_plugin")
            .example("my_plugin.reset()"),
        );
    }
}

impl PerWorld for ThisPlugin {
    type World = Odometers;

    fn world(&self, _: &World<'_>) -> Result<Odometers> {
        Ok(Odometers::default())
    }

    // A snapshot stores for each odometer the object, the position and the distance: 5 words of 8 bytes.
    const STATE_VERSION: u32 = 1;
    fn save(world: &Odometers) -> Result<Vec<u8>> {
        let mut out = Vec::new();
        for (object, odometer) in world.0.borrow().iter() {
            out.extend(object.to_le_bytes());
            [&odometer.last_position[..], &[odometer.distance_m]].concat().iter().for_each(|x| out.extend(x.to_le_bytes()));
        }
        Ok(out)
    }
    fn load(world: &Odometers, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION || !bytes.len().is_multiple_of(40) {
            return Err(Fail::unsupported("the snapshot was written by a different version of my_plugin"));
        }
        let words: Vec<[u8; 8]> = bytes.chunks_exact(8).filter_map(|word| word.try_into().ok()).collect();
        let odometers = words.chunks_exact(5).map(|w| {
            let number = |k: usize| f64::from_le_bytes(w[k]);
            (u64::from_le_bytes(w[0]), Odometer { last_position: [number(1), number(2), number(3)], distance_m: number(4) })
        });
        *world.0.borrow_mut() = odometers.collect();
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
