//! Tests of models: by construction, with their defaults and with other values of their parameters, and in a short run.

use std::path::Path;

use tatu_core::{World, beams::bounds, errors::Error, plugins::Model, scene::visible_parts, state::fingerprint};

use super::{
    finding::{self, error, note, untested},
    stage,
    subject::TestedPlugin,
};

/// Tolerance for the height of a model's lowest point above or below the floor, m.
const FLOOR_TOLERANCE_M: f64 = 0.003;
/// Sizes of a model below or above which it is probably in another unit, m.
const SMALLEST_M: f64 = 0.001;
const LARGEST_M: f64 = 200.0;
/// Maximum number of values tried per parameter.
const MAX_VALUES: usize = 4;
/// Number of steps of the run on a floor, and the distance below the floor and from the origin that is an error, m.
const RUN_STEPS: usize = 20;
const SUNK_M: f64 = 0.05;
const LOST_M: f64 = 50.0;

const FLOOR: &str = "\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nsize_m = [40.0, 40.0, 0.1]\nposition_m = [0.0, 0.0, \
                     -0.05]\nrespondable = true\n";

/// Runs the test `models`.
pub fn models(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for m in subject.registry.model_offers.models.iter().filter(|m| m.plugin == subject.plugin) {
        let place = format!("model `{}`", m.id);
        let Some(lines) = stage::required(&m.params) else {
            untested(&place, "it is not tested: a required parameter cannot be set in a scene");
            continue;
        };
        model(&subject, m, &place, &lines)?;
    }
    Ok(())
}

fn scene(m: &Model, lines: &str) -> String {
    format!("format = 1\n[[model]]\nmodel = \"{}\"\n{lines}", m.id)
}

fn model(subject: &TestedPlugin, m: &Model, place: &str, lines: &str) -> Result<(), Error> {
    finding::report_activity(place, "when it is built");
    declarations(m, place);
    let world = match subject.world(&scene(m, lines), &[], 1) {
        Ok(world) => world,
        Err(e) => {
            error(place, format!("it cannot be built with its defaults: {}", e.text));
            return Ok(());
        }
    };
    construction(&world, place, "");
    let (first, second) = (hash_of(&world), hash_of(&subject.world(&scene(m, lines), &[], 1)?));
    if first != second {
        error(place, "two equal builds give different objects");
    }
    finding::report_activity(place, "when it runs");
    world.start();
    (0..10).for_each(|_| {
        world.step();
    });
    subject.report_faults(&world);
    world.end();
    for p in &m.params {
        let (mut tried, mut effects) = (0, 0);
        for value in stage::valid_values(p).into_iter().filter(|v| *v != p.fallback).take(MAX_VALUES) {
            let Some(line) = stage::line(p, &value) else { continue };
            let key = line.split(' ').next().unwrap_or_default();
            let rest: String =
                lines.lines().filter(|l| l.split(' ').next() != Some(key)).map(|l| format!("{l}\n")).collect();
            let setting = line.trim();
            finding::report_activity(place, format!("when it is built with `{setting}`"));
            match subject.world(&scene(m, &format!("{rest}{line}")), &[], 1) {
                Ok(world) => {
                    construction(&world, place, &format!(" with `{setting}`"));
                    tried += 1;
                    effects += usize::from(hash_of(&world) != first);
                    world.start();
                    (0..3).for_each(|_| {
                        world.step();
                    });
                    subject.report_faults(&world);
                    world.end();
                }
                Err(e) => {
                    let text = format!("it cannot be built with `{setting}`, which its declaration allows: {}", e.text);
                    error(place, text);
                    break;
                }
            }
        }
        if (tried, effects) == (tried.max(1), 0) {
            note(place, format!("its parameter `{}` changes no object", p.key));
        }
    }
    standing(subject, m, place, lines)
}

/// Returns a hash of everything that was built.
fn hash_of(world: &World) -> u64 {
    fingerprint(&world.document())
}

/// Tests the tables of a model against each other.
fn declarations(m: &Model, place: &str) {
    for n in m.numbers.iter().filter(|n| n.source.trim().is_empty()) {
        error(place, format!("its number `{}` has no source", n.name));
    }
}

/// Tests the objects of a world that contains only the model.
fn construction(world: &World, place: &str, with: &str) {
    let (low, high, count) = world.with_scene(|scene, _| {
        let shapes = scene.slots().filter_map(|(slot, o)| Some((slot, o.shape()?)));
        let parts = shapes.flat_map(|(slot, shape)| {
            visible_parts(shape).into_iter().filter_map(move |p| bounds(&p.form, &(scene.world(slot) * p.pose)))
        });
        let mut all = (f64::INFINITY, 0.0f64, 0);
        for [a, b] in parts {
            let size = (b - a).iter().fold(0.0f64, |m, x| m.max(x.abs()));
            all = (all.0.min(a.z), all.1.max(size), all.2 + 1);
        }
        all
    });
    if count == 0 {
        return;
    }
    if low < -FLOOR_TOLERANCE_M {
        let text =
            format!("its lowest point is {:.1} mm below the floor z = 0, on which models must stand", -1000.0 * low);
        error(place, format!("{text}{with}"));
    } else if low > FLOOR_TOLERANCE_M {
        note(place, format!("its lowest point is {:.1} mm above the floor z = 0{with}", 1000.0 * low));
    }
    if !(SMALLEST_M..LARGEST_M).contains(&high) {
        error(place, format!("its largest part has a size of {high} m{with}: is it in another unit?"));
    }
}

/// Lets a model stand on a floor.
fn standing(subject: &TestedPlugin, m: &Model, place: &str, lines: &str) -> Result<(), Error> {
    finding::report_activity(place, "when it stands on a floor");
    let scene = format!("format = 1\n{FLOOR}\n[[model]]\nmodel = \"{}\"\n{lines}", m.id);
    let Ok(world) = subject.world(&scene, &[], 1) else { return Ok(()) };
    world.start();
    for _ in 0..RUN_STEPS {
        world.step();
    }
    let worst = world.with_scene(|scene, _| {
        let centers = scene.slots().map(|(slot, _)| scene.world(slot).translation.vector);
        centers.fold((0.0f64, 0.0f64), |(low, far), c| (low.min(c.z), if c.norm() < far { far } else { c.norm() }))
    });
    let (low, far) = worst;
    if far.is_nan() || far >= LOST_M {
        error(place, format!("within {RUN_STEPS} steps on a floor, a part of it is {far:.1} m away: it is unstable"));
    } else if low < -SUNK_M - 0.05 {
        error(place, format!("within {RUN_STEPS} steps, a part of it has sunk {:.2} m below the floor", -low));
    }
    subject.report_faults(&world);
    world.end();
    Ok(())
}
