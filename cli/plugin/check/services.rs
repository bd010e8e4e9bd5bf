//! Services: their barrier never blocks, and their threads touch no world.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_core::{Session, document::ServiceSpec, errors::Error};

use super::{
    finding::{self, error, note, warning},
    stage,
    subject::Subject,
};

/// Steps of a run.
const STEPS: usize = 8;
/// A step that takes longer has waited for something. A hold, which is allowed, ends after 0.1 s.
const LONG: Duration = Duration::from_millis(700);

/// The test `services`.
pub fn run(file: &Path) -> Result<(), Error> {
    let subject = Subject::load(file)?;
    for (kind, s) in subject.registry.services.iter().enumerate().filter(|(_, s)| s.plugin == subject.plugin) {
        let place = format!("service `{}`", s.id);
        let required = s.params.iter().filter(|p| !p.optional());
        let params: Option<Vec<_>> =
            required.map(|p| Some((p.key.clone(), stage::good(p).into_iter().next()?))).collect();
        let Some(params) = params else {
            note(&place, "it is not tried: a required parameter has no value that a command line could give");
            continue;
        };
        finding::at(&place, "when it is started");
        let session = match Session::new(subject.registry.clone(), &[ServiceSpec { kind, params, place: None }]) {
            Ok(session) => session,
            Err(e) => {
                let text = format!("it cannot be started with its defaults: {}", e.text);
                // It may lack something of this machine; a breach has another code.
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
        finding::at(&place, "in its `barrier`");
        world.start();
        for _ in 0..STEPS {
            let begin = Instant::now();
            world.step();
            let took = begin.elapsed();
            if took > LONG {
                error(&place, format!("its `barrier` blocks: a step took {:.1} s", took.as_secs_f64()));
                break;
            }
            // Its threads get a turn.
            std::thread::sleep(Duration::from_millis(20));
        }
        finding::at(&place, "when the run ends");
        world.stop();
        world.end();
        subject.report_faults(&world);
        for e in session.end() {
            error(&place, e.text);
        }
    }
    Ok(())
}
