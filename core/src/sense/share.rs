//! Many sensors of a few rays each, by several threads: each handles some from their places to their readings.
//!
//! Where sensors have many rays or pixels, threads share those instead (`beams`).

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, PoisonError},
};

use super::{
    Device, Sensing, Targets,
    cast::FEWEST,
    measure::{Around, Failed, Job, Part, Scratch, in_batches},
};
use crate::host::watchdog::Watch;

/// Sensors that a thread takes at a time.
const SOME: usize = 256;

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

/// What all threads share.
struct Table<'a> {
    job: &'a Job<'a>,
    around: &'a Around<'a>,
    targets: &'a Targets,
    left: Mutex<VecDeque<Share<'a>>>,
    failed: Mutex<Vec<(usize, Vec<Failed>)>>,
}

// SAFETY: scene, registry and targets are looked at only; a share and its instances belong to the thread that took it,
// which plugins allow for (`[parallel]`). What devices share, their layouts, is not cloned meanwhile.
unsafe impl Sync for Table<'_> {}

/// Whether to share a job: there are enough sensors, each with but a few rays, in the order in which they lie.
pub(super) fn pays(sensing: &Sensing, job: &Job<'_>, around: &Around<'_>) -> bool {
    let few = |i: &usize| {
        let plan = &sensing.devices[*i].layout.plan;
        plan.image.is_none() && !plan.aimed && plan.directions.len() < FEWEST
    };
    around.pool.current_num_threads() > 1
        && job.devices.len() >= 2 * SOME
        && job.devices.is_sorted()
        && job.devices.iter().all(few)
}

/// Handles sensors of one kind with all threads; those that failed, in order.
pub(super) fn measure(sensing: &mut Sensing, job: &Job<'_>, around: &Around<'_>) -> Vec<Failed> {
    let Sensing { devices, targets, scratch, helpers, .. } = sensing;
    let (mut left, mut rest, mut begin) = (VecDeque::new(), &mut devices[..], 0);
    for (number, indices) in job.devices.chunks(SOME).enumerate() {
        let (Some(first), Some(last)) = (indices.first(), indices.last()) else { continue };
        let (_, after) = rest.split_at_mut(first - begin);
        let (devices, after) = after.split_at_mut(last + 1 - first);
        (rest, begin) = (after, last + 1);
        left.push_back(Share { number, indices, devices });
    }
    let others = (around.pool.current_num_threads() - 1).min(left.len() - 1);
    while helpers.len() < others {
        let watch = around.watch.beside(&around.registry.watches);
        helpers.push(Helper { scratch: Scratch::default(), watch });
    }
    let table = Table { job, around, targets, left: Mutex::new(left), failed: Mutex::default() };
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
    let mut failed = table.failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.sort_by_key(|(number, _)| *number);
    failed.into_iter().flat_map(|(_, failed)| failed).collect()
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
            let failed = in_batches(&mut part, &Job { devices: indices, ..*self.job }, &around);
            if !failed.is_empty() {
                self.failed.lock().unwrap_or_else(PoisonError::into_inner).push((number, failed));
            }
        }
    }
}
