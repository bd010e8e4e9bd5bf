//! Tests of services: their `barrier` must not block, and their threads must not access a world.

use std::{
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use tatu_core::{Session, World, document::ServiceSpec, errors::Error};

use super::{
    finding::{self, error, note, warning},
    stage,
    subject::TestedPlugin,
};

/// Number of steps of a run.
const RUN_STEPS: usize = 8;
/// Number of barriers that must be slow: a busy machine may interrupt one or two.
const BLOCKED_BARRIERS: usize = 3;
/// Number of slow barriers after which the test ends.
const MAX_BLOCKED_BARRIERS: usize = 5;

/// Runs the test `services`.
pub fn run(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for (kind, s) in subject.registry.services.iter().enumerate().filter(|(_, s)| s.plugin == subject.plugin) {
        let place = format!("service `{}`", s.id);
        let required = s.params.iter().filter(|p| !p.optional());
        let params: Option<Vec<_>> =
            required.map(|p| Some((p.key.clone(), stage::valid_values(p).into_iter().next()?))).collect();
        let Some(params) = params else {
            note(&place, "it is not tested: no valid value is known for a required parameter");
            continue;
        };
        finding::report_activity(&place, "when it is started");
        let spec = ServiceSpec { kind, params, place: None };
        let session = match Session::new(subject.registry.clone(), std::slice::from_ref(&spec)) {
            Ok(session) => session,
            Err(e) => {
                let text = format!("it cannot be started with its defaults: {}", e.text);
                // E404 may be due to this machine, such as a port in use; violations of rules have other codes.
                if e.code == "E404" {
                    warning(&place, text)
                } else {
                    error(&place, text)
                }
                continue;
            }
        };
        let world = subject.world(&stage::scene("", ""), &[], 1)?;
        session.join(&world);
        finding::report_activity(&place, "in its `barrier`");
        *lock(&subject.spy.barriers) = Default::default();
        world.start();
        let mut hashes = Vec::new();
        for _ in 0..RUN_STEPS {
            world.step();
            hashes.push(world.hash().total);
            if lock(&subject.spy.barriers).slow >= MAX_BLOCKED_BARRIERS {
                break;
            }
            // Give the service's threads time to run.
            std::thread::sleep(Duration::from_millis(20));
        }
        {
            let barriers = lock(&subject.spy.barriers);
            if barriers.slow >= BLOCKED_BARRIERS {
                let text = format!(
                    "its `barrier` blocks: {} of {} calls took longer than 0.1 s, the longest {:.1} s",
                    barriers.slow,
                    barriers.calls,
                    barriers.longest.as_secs_f64()
                );
                error(&place, text);
            }
            if barriers.holds > 0 {
                note(&place, format!("it held the session in {} of {} barriers", barriers.holds, barriers.calls));
            }
        }
        let log = Arc::from(world.input_log().records());
        finding::report_activity(&place, "when the run ends");
        world.stop();
        world.end();
        subject.report_faults(&world);
        for e in session.end() {
            error(&place, e.text);
        }
        finding::report_activity(&place, "when its run is replayed");
        replay(&subject, &place, |world| world.attach_log(log), &hashes)?;
    }
    Ok(())
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Repeats a run without the service, from its input log: everything that the service has changed must be in the log.
fn replay(subject: &TestedPlugin, place: &str, attach_log: impl FnOnce(&World), hashes: &[u64]) -> Result<(), Error> {
    let world = subject.world(&stage::scene("", ""), &[], 1)?;
    attach_log(&world);
    world.start();
    for (step, hash) in (1..).zip(hashes) {
        world.step();
        if world.hash().total != *hash {
            let text = format!(
                "a replay of the input log differs after {step} steps: the service has changed the world by calls that \
                 the log does not contain; use commands or `session.request`"
            );
            error(place, text);
            break;
        }
    }
    world.end();
    Ok(())
}
