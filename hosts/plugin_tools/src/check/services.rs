//! Tests of services: their `barrier` must not block, and their threads must not access a world.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_core::{Session, document::ServiceSpec, errors::Error};

use super::{
    finding::{self, error, note, warning},
    stage,
    subject::TestedPlugin,
};

/// Number of steps of a run.
const RUN_STEPS: usize = 8;
/// Real time of a step above which `barrier` may block. A hold, which is allowed, ends after 0.1 s.
const BLOCKING_THRESHOLD: Duration = Duration::from_millis(700);
/// Number of steps that must take so long: a busy machine may interrupt a step or two.
const BLOCKED_STEPS: usize = 3;

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
        let session = match Session::new(subject.registry.clone(), &[ServiceSpec { kind, params, place: None }]) {
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
        world.start();
        let mut blocked = 0;
        for _ in 0..RUN_STEPS {
            let begin = Instant::now();
            world.step();
            let took = begin.elapsed();
            blocked += usize::from(took > BLOCKING_THRESHOLD);
            if blocked == BLOCKED_STEPS {
                error(&place, format!("its `barrier` blocks: a step took {:.1} s", took.as_secs_f64()));
                break;
            }
            // Give the service's threads time to run.
            std::thread::sleep(Duration::from_millis(20));
        }
        finding::report_activity(&place, "when the run ends");
        world.stop();
        world.end();
        subject.report_faults(&world);
        for e in session.end() {
            error(&place, e.text);
        }
    }
    Ok(())
}
