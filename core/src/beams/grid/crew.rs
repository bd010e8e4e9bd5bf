//! Threads that draw the segments of an image, two each.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use fearless_simd::Level;

use super::bands::{Band, Segment};
use super::camera::Camera;
use super::draw::{draw, finish};
use super::image::Part;
use super::jobs::look_for;
use super::raster::{Buffer, Raster};
use super::ready::Ready;
use super::shade::Shader;

/// Work is waited for so many times as long as what another thread is about to do.
const PATIENCE: usize = 8;

/// What all bands need.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    pub ready: &'a Ready<'a>,
    pub camera: &'a Camera,
    pub shader: &'a Shader<'a>,
    pub level: Level,
}

/// A segment while it is drawn.
pub(super) struct Work<'a, const ID: bool> {
    sight: Sight<'a>,
    segment: &'a Segment,
    /// Bands that nobody has begun.
    left: Mutex<VecDeque<Task<'a>>>,
    /// Buffers of threads that have not come yet; the first begins with the first band, the second with the last.
    places: Mutex<(usize, &'a mut [Buffer])>,
    /// Where both have met: what the first of them to be done has left.
    seam: Mutex<Option<Half<'a, ID>>>,
    /// What both know, when both have come.
    met: OnceLock<Met<'a, ID>>,
}

struct Task<'a> {
    number: usize,
    part: Part<'a>,
}

/// What a thread knows of rows that both have drawn.
enum Half<'a, const ID: bool> {
    /// The one that came from below.
    Below(Raster<'a, ID>),
    /// The one that came from above, which also has what is to be filled in, band by band.
    Above(VecDeque<(Task<'a>, Raster<'a, ID>)>),
}

/// Rows that two threads have drawn: what the one that came from below saw there, and bands of the other.
type Met<'a, const ID: bool> = (Raster<'a, ID>, Mutex<VecDeque<(Task<'a>, Raster<'a, ID>)>>);

/// Makes an image with the calling thread, which leads, and `helpers` others of rayon's current pool; which of them draws which
/// band does not change the image.
///
/// The others come at once: they `assist` as long as there is something to be made ready, and wait for the `work` that
/// `lead` gives.
pub(super) fn run<'a, const ID: bool>(
    helpers: usize,
    work: &OnceLock<Vec<Work<'a, ID>>>,
    assist: &(impl Fn() -> bool + Sync),
    lead: impl FnOnce() -> &'a [Work<'a, ID>] + Send,
) {
    if helpers == 0 {
        return help(lead(), 0);
    }
    let busy = &AtomicUsize::new(helpers);
    rayon::in_place_scope(|scope| {
        for helper in 1..=helpers {
            scope.spawn(move |_| {
                come(work, assist, helper);
                busy.fetch_sub(1, Ordering::Release);
            });
        }
        let work = lead();
        // Who has waited for too long has gone.
        let gone = helpers - busy.load(Ordering::Acquire).min(helpers);
        busy.fetch_add(gone, Ordering::Relaxed);
        for helper in 1..=gone {
            scope.spawn(move |_| {
                help(work, helper);
                busy.fetch_sub(1, Ordering::Release);
            });
        }
        help(work, 0);
        look_for(|| busy.load(Ordering::Acquire) == 0);
    });
}

/// A thread that helps.
fn come<const ID: bool>(work: &OnceLock<Vec<Work<'_, ID>>>, assist: &impl Fn() -> bool, helper: usize) {
    for _ in 0..PATIENCE {
        look_for(|| {
            while assist() {}
            work.get().is_some()
        });
        if let Some(work) = work.get() {
            return help(work, helper);
        }
        std::thread::yield_now();
    }
    if let Some(work) = work.get() {
        help(work, helper);
    }
}

/// Draws wherever a thread is missing, beginning with the thread's own segment.
fn help<const ID: bool>(work: &[Work<'_, ID>], thread: usize) {
    for i in 0..work.len() {
        let segment = &work[(thread + i) % work.len()];
        while let Some((number, buffer)) = segment.place() {
            if number == 0 { segment.upward(buffer) } else { segment.downward(buffer) }
        }
    }
}

impl<'a, const ID: bool> Work<'a, ID> {
    /// `part` holds the rows of the segment; there is a buffer for each thread.
    pub fn new(sight: Sight<'a>, segment: &'a Segment, part: Part<'a>, buffers: &'a mut [Buffer]) -> Self {
        let mut rest = part;
        let mut left = VecDeque::with_capacity(segment.bands.len());
        for (number, band) in segment.bands.iter().enumerate() {
            let (part, after) = rest.split((band.rows.1 - band.rows.0) * sight.camera.columns);
            rest = after;
            left.push_back(Task { number, part });
        }
        let (left, places) = (Mutex::new(left), Mutex::new((0, buffers)));
        Self { sight, segment, left, places, seam: Mutex::new(None), met: OnceLock::new() }
    }

    /// A place for one more thread, if there is something left to do.
    fn place(&self) -> Option<(usize, &'a mut Buffer)> {
        if lock(&self.left).is_empty() {
            return None;
        }
        let mut places = lock(&self.places);
        let (buffer, rest) = std::mem::take(&mut places.1).split_first_mut()?;
        places.1 = rest;
        places.0 += 1;
        Some((places.0 - 1, buffer))
    }

    /// From the first band on. What is drawn here reaches only into bands that are still to come, so that each is finished
    /// at once.
    fn upward(&self, buffer: &'a mut Buffer) {
        let mut raster = Raster::new(buffer, self.sight.camera, self.segment.rows);
        let (mut cleared, mut last) = (self.segment.rows.0, None);
        loop {
            let next = lock(&self.left).pop_front();
            let Some(task) = next else { break };
            let band = &self.segment.bands[task.number];
            raster.clear(self.sight.camera, (cleared, band.reach));
            cleared = band.reach;
            self.draw(&mut raster, band, band.reach);
            self.finish(&raster, task);
            last = Some(band);
        }
        if let Some(band) = last
            && band.reach > band.rows.1
        {
            self.meet(Half::Below(raster.part(band.rows.1, band.reach)));
        }
    }

    /// From the last band on. A band is finished as soon as none before it reaches into it.
    fn downward(&self, buffer: &'a mut Buffer) {
        let mut raster = Raster::new(buffer, self.sight.camera, self.segment.rows);
        let (mut drawn, mut meeting) = (VecDeque::new(), self.segment.rows.1);
        loop {
            let next = lock(&self.left).pop_back();
            let Some(task) = next else { break };
            let band = &self.segment.bands[task.number];
            raster.clear(self.sight.camera, band.rows);
            self.draw(&mut raster, band, self.segment.rows.1);
            meeting = band.rows.0;
            let reach = task.number.checked_sub(1).map_or(0, |before| self.segment.bands[before].reach);
            drawn.push_front(task);
            while drawn.back().is_some_and(|task: &Task<'_>| self.segment.bands[task.number].rows.0 >= reach) {
                if let Some(task) = drawn.pop_back() {
                    self.finish(&raster, task);
                }
            }
        }
        let (mut halves, mut rest) = (VecDeque::with_capacity(drawn.len()), raster.part(meeting, self.segment.rows.1));
        for task in drawn {
            let (rows, after) = rest.split(self.segment.bands[task.number].rows.1);
            rest = after;
            halves.push_back((task, rows));
        }
        if !halves.is_empty() {
            self.meet(Half::Above(halves));
        }
    }

    /// Puts together what this thread and the other know of the rows that both have drawn; then they share what is left.
    fn meet(&self, half: Half<'a, ID>) {
        let mut seam = lock(&self.seam);
        match (half, seam.take()) {
            (Half::Below(below), Some(Half::Above(bands))) | (Half::Above(bands), Some(Half::Below(below))) => {
                let _ = self.met.set((below, Mutex::new(bands)));
            }
            (half, _) => {
                *seam = Some(half);
                drop(seam);
                // The other has begun its last band.
                look_for(|| self.met.get().is_some());
            }
        }
        let Some((below, bands)) = self.met.get() else { return };
        loop {
            let next = lock(bands).pop_front();
            let Some((task, mut raster)) = next else { return };
            raster.merge(below);
            self.finish(&raster, task);
        }
    }

    /// Draws a band; triangles that begin in it, up to row `reach`.
    fn draw(&self, raster: &mut Raster<'_, ID>, band: &Band, reach: usize) {
        let Sight { ready, level, .. } = self.sight;
        draw(level, ready, self.segment, band, reach, raster);
    }

    fn finish(&self, raster: &Raster<'_, ID>, mut task: Task<'_>) {
        let rows = self.segment.bands[task.number].rows;
        finish(self.sight.level, self.sight.camera, raster, rows.0, task.part.depth);
        if ID {
            self.sight.shader.shade(raster, rows, &mut task.part);
        }
    }
}

fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
