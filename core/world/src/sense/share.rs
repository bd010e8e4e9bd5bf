//! Many sensors of a few rays each, by several threads: each handles some from their places to their readings.
//!
//! Where sensors have many rays or pixels, threads share those instead (`beams`).

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
};

use super::{
    Device, Sensing, Targets,
    measure::{Around, Failed, Job, Part, Scratch, in_batches},
};
use tatu_plugins::{guard, watchdog::Watch};

/// Fewer sensors are handled sooner than others have come.
const FEWEST_DEVICES: usize = 512;

/// What another thread needs: room, and a place where its calls are noted.
pub(super) struct Helper {
    scratch: Scratch,
    watch: Arc<Watch>,
}

// SAFETY: used by one thread at a time; the pointers that it holds are those of the batch in hand.
unsafe impl Send for Helper {}

/// Some sensors that nobody has taken.
struct Share<'a> {
    number: usize,
    indices: &'a [usize],
    /// From the first of them to the last.
    devices: &'a mut [Device],
}

/// What there was to tell of a share.
struct Told {
    number: usize,
    failed: Vec<Failed>,
    lines: Vec<guard::Line>,
}

/// What all threads share.
struct Table<'a> {
    job: &'a Job<'a>,
    around: &'a Around<'a>,
    targets: &'a Targets,
    left: Mutex<VecDeque<Share<'a>>>,
    told: Mutex<Vec<Told>>,
}

// SAFETY: scene, registry and targets are looked at only; a share and its instances belong to the thread that took it,
// which plugins allow for (`[parallel]`). What devices share, their layouts, is not cloned meanwhile.
unsafe impl Sync for Table<'_> {}

/// Whether to share a job: there are enough sensors, each with but a few rays.
pub(super) fn pays(job: &Job<'_>, around: &Around<'_>) -> bool {
    around.pool.current_num_threads() > 1 && job.few && job.devices.len() >= FEWEST_DEVICES && !job.cuts.is_empty()
}

/// Handles sensors of one kind with all threads; those that failed, in order.
pub(super) fn measure(sensing: &mut Sensing, job: &Job<'_>, around: &Around<'_>) -> Vec<Failed> {
    let Sensing { devices, targets, scratch, helpers, .. } = sensing;
    let (mut left, mut rest, mut begin) = (VecDeque::new(), &mut devices[..], 0);
    for (number, indices) in job.shares().enumerate() {
        let (Some(first), Some(last)) = (indices.first(), indices.last()) else { continue };
        let (_, after) = rest.split_at_mut(first - begin);
        let (devices, after) = after.split_at_mut(last + 1 - first);
        (rest, begin) = (after, last + 1);
        left.push_back(Share { number, indices, devices });
    }
    let others = (around.pool.current_num_threads() - 1).min(left.len().saturating_sub(1));
    while helpers.len() < others {
        let watch = around.watch.beside(&around.registry.watches);
        helpers.push(Helper { scratch: Scratch::default(), watch });
    }
    let table = Table { job, around, targets, left: Mutex::new(left), told: Mutex::default() };
    let shared = &table;
    around.pool.in_place_scope(|scope| {
        for helper in &mut helpers[..others] {
            scope.spawn(move |_| {
                let Helper { scratch, watch } = helper;
                shared.work(scratch, watch);
            });
        }
        shared.work(scratch, around.watch);
    });
    let mut told = table.told.into_inner().unwrap_or_else(PoisonError::into_inner);
    told.sort_by_key(|told| told.number);
    let mut failed = Vec::new();
    for told in told {
        failed.extend(told.failed);
        sensing.lines.extend(told.lines);
    }
    failed
}

impl Table<'_> {
    /// Takes shares as long as there are any.
    fn work(&self, scratch: &mut Scratch, watch: &Watch) {
        let around = Around { watch, alone: true, ..*self.around };
        loop {
            let next = self.left.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            let Some(Share { number, indices, devices }) = next else { return };
            let first = indices.first().copied().unwrap_or(0);
            let mut part = Part { devices, first, targets: self.targets, scratch };
            let job = Job { devices: indices, cuts: &[], ..*self.job };
            let (failed, lines) = guard::collect(|| in_batches(&mut part, &job, &around));
            if !failed.is_empty() || !lines.is_empty() {
                self.told.lock().unwrap_or_else(PoisonError::into_inner).push(Told { number, failed, lines });
            }
        }
    }
}
