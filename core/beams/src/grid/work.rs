//! A segment while two threads draw it, one from its first rows on, the other from its last.
//!
//! The band where they meet is drawn by both, group by group, so that neither waits for long. What both have drawn is then
//! put together, and they share what is left.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use fearless_simd::Level;

use super::bands::{Band, Segment};
use super::camera::Camera;
use super::draw::{finish, groups, surfaces};
use super::image::Part;
use super::jobs::look_for;
use super::raster::{Buffer, Raster};
use super::ready::{Group, Ready};
use super::shade::Shader;

/// Rows of the band in the middle that a thread draws in one go, without groups.
const ROWS: usize = 8;
/// Groups of that band that it draws in one go.
const GROUPS: usize = 4;
/// Rows that both have drawn which it puts together in one go.
const MET_ROWS: usize = 16;

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
    left: Mutex<Left<'a>>,
    /// Buffers of the thread that begins with the first band and of the one that begins with the last, until they come.
    places: Mutex<[Option<&'a mut Buffer>; 2]>,
    /// The last band that was left when both had come.
    middle: OnceLock<Middle<'a>>,
    /// Where both have met: what the first of them to be done has left.
    seam: Mutex<Option<Half<'a, ID>>>,
    /// What both know, when both have come.
    met: OnceLock<Met<'a, ID>>,
}

/// Bands that nobody has begun.
struct Left<'a> {
    bands: VecDeque<Task<'a>>,
    /// Threads that have begun one.
    came: usize,
}

struct Task<'a> {
    band: &'a Band,
    /// The row after the last that groups reach which are drawn with bands before it.
    reach: usize,
    part: Part<'a>,
}

/// A band that two threads draw.
struct Middle<'a> {
    band: &'a Band,
    groups: Vec<Group<'a>>,
    /// The first of its jobs that nobody has begun: some rows without groups each, then some groups each.
    next: AtomicUsize,
    task: Mutex<Option<Task<'a>>>,
}

/// What a thread knows of rows that both have drawn.
enum Half<'a, const ID: bool> {
    /// The one that came from below.
    Below(Raster<'a, ID>),
    /// The one that came from above, which also has what is to be filled in.
    Above(VecDeque<(Part<'a>, Raster<'a, ID>)>),
}

/// Rows that two threads have drawn: what the one that came from below saw there, and what the other did.
type Met<'a, const ID: bool> = (Raster<'a, ID>, Mutex<VecDeque<(Part<'a>, Raster<'a, ID>)>>);

impl<'a, const ID: bool> Work<'a, ID> {
    /// `part` holds the rows of the segment; there is a buffer for each thread.
    pub fn new(sight: Sight<'a>, segment: &'a Segment, part: Part<'a>, buffers: [&'a mut Buffer; 2]) -> Self {
        let mut rest = part;
        let (mut bands, mut reach) = (VecDeque::with_capacity(segment.bands.len()), 0);
        for band in &segment.bands {
            let (part, after) = rest.split((band.rows.1 - band.rows.0) * sight.camera.columns);
            bands.push_back(Task { band, reach, part });
            (rest, reach) = (after, band.reach);
        }
        let (left, places) = (Mutex::new(Left { bands, came: 0 }), Mutex::new(buffers.map(Some)));
        let (middle, seam, met) = (OnceLock::new(), Mutex::new(None), OnceLock::new());
        Self { sight, segment, left, places, middle, seam, met }
    }

    /// Draws as much of it as is left, if a thread is missing: from the end that is wanted, or else from the other. Who
    /// draws the same rows in each frame has them still in its cache.
    pub fn help(&self, from_above: bool) {
        if lock(&self.left).bands.is_empty() {
            return;
        }
        let wanted = usize::from(from_above);
        let free = |place: usize| Some((place, lock(&self.places)[place].take()?));
        if let Some((place, buffer)) = free(wanted).or_else(|| free(1 - wanted)) {
            let raster = Raster::new(buffer, self.sight.camera, self.segment.rows);
            if place == 0 { self.upward(raster) } else { self.downward(raster) }
        }
    }

    /// A band for this thread alone, its first or one more. What is left last when both have come is for both.
    fn begin(&self, came: &mut bool, take: fn(&mut VecDeque<Task<'a>>) -> Option<Task<'a>>) -> Option<Task<'a>> {
        let mut left = lock(&self.left);
        let task = take(&mut left.bands)?;
        left.came += usize::from(!*came);
        *came = true;
        if left.bands.is_empty() && left.came > 1 {
            let band = task.band;
            let groups = self.sight.ready.of_band(band).collect();
            let _ = self.middle.set(Middle { band, groups, next: AtomicUsize::new(0), task: Mutex::new(Some(task)) });
            return None;
        }
        Some(task)
    }

    /// From the first band on. What is drawn here reaches only into bands that are still to come, so that each is finished
    /// at once.
    fn upward(&self, mut raster: Raster<'a, ID>) {
        let (mut came, mut cleared) = (false, self.segment.rows.0);
        while let Some(task) = self.begin(&mut came, VecDeque::pop_front) {
            let band = task.band;
            raster.clear(self.sight.camera, (cleared, band.reach));
            cleared = band.reach;
            self.draw(&mut raster, band, band.reach);
            self.finish(&raster, band.rows, task.part);
        }
        if let Some(middle) = self.middle.get().filter(|_| came) {
            let (band, reach) = (middle.band, middle.band.reach);
            raster.clear(self.sight.camera, (cleared, reach));
            self.share(&mut raster, middle, reach);
            self.meet(Half::Below(raster.part(band.rows.0, reach).trimmed(self.sight.camera)));
        }
    }

    /// From the last band on. A band is finished as soon as none before it reaches into it.
    fn downward(&self, mut raster: Raster<'a, ID>) {
        let (mut came, end) = (false, self.segment.rows.1);
        let mut drawn: VecDeque<Task<'_>> = VecDeque::new();
        while let Some(task) = self.begin(&mut came, VecDeque::pop_back) {
            let (band, reach) = (task.band, task.reach);
            raster.clear(self.sight.camera, band.rows);
            self.draw(&mut raster, band, end);
            drawn.push_front(task);
            while let Some(task) = drawn.pop_back_if(|task| task.band.rows.0 >= reach) {
                self.finish(&raster, task.band.rows, task.part);
            }
        }
        if let Some(middle) = self.middle.get().filter(|_| came) {
            raster.clear(self.sight.camera, middle.band.rows);
            self.share(&mut raster, middle, end);
            let all = lock(&middle.task).take().into_iter().chain(drawn);
            self.meet(Half::Above(self.in_parts(all, raster.part(middle.band.rows.0, end))));
        }
    }

    /// What has been drawn from above, in parts of few rows.
    fn in_parts(
        &self,
        drawn: impl Iterator<Item = Task<'a>>,
        mut rest: Raster<'a, ID>,
    ) -> VecDeque<(Part<'a>, Raster<'a, ID>)> {
        let mut parts = VecDeque::new();
        for Task { band, part: mut pixels, .. } in drawn {
            for row in (band.rows.0..band.rows.1).step_by(MET_ROWS) {
                let end = band.rows.1.min(row + MET_ROWS);
                let (part, after) = pixels.split((end - row) * self.sight.camera.columns);
                let (rows, above) = rest.split(end);
                parts.push_back((part, rows));
                (pixels, rest) = (after, above);
            }
        }
        parts
    }

    /// Draws what is left of the band that both draw; groups up to a row.
    fn share(&self, raster: &mut Raster<'_, ID>, middle: &Middle<'_>, end: usize) {
        let Sight { ready, level, .. } = self.sight;
        let (first, last) = middle.band.rows;
        let jobs = (last - first).div_ceil(ROWS);
        loop {
            let job = middle.next.fetch_add(1, Ordering::Relaxed);
            if job < jobs {
                let row = first + job * ROWS;
                surfaces(level, ready, (row, last.min(row + ROWS)), raster);
            } else {
                let from = (job - jobs) * GROUPS;
                let Some(some) = middle.groups.get(from..) else { return };
                groups(level, some.iter().copied().take(GROUPS), (first, end), raster);
            }
        }
    }

    /// Puts together what this thread and the other know of the rows that both have drawn; then they share what is left.
    fn meet(&self, half: Half<'a, ID>) {
        let mut seam = lock(&self.seam);
        match (half, seam.take()) {
            (Half::Below(below), Some(Half::Above(parts))) | (Half::Above(parts), Some(Half::Below(below))) => {
                let _ = self.met.set((below, Mutex::new(parts)));
            }
            (half, _) => {
                *seam = Some(half);
                drop(seam);
                // The other draws its last group.
                look_for(|| self.met.get().is_some());
            }
        }
        let Some((below, parts)) = self.met.get() else { return };
        loop {
            let next = lock(parts).pop_front();
            let Some((part, mut raster)) = next else { return };
            raster.merge(self.sight.level, below);
            self.finish(&raster, (raster.first, raster.end), part);
        }
    }

    /// Draws a band; groups that begin in it, up to a row.
    fn draw(&self, raster: &mut Raster<'_, ID>, band: &Band, end: usize) {
        let Sight { ready, level, .. } = self.sight;
        surfaces(level, ready, band.rows, raster);
        groups(level, ready.of_band(band), (band.rows.0, end), raster);
    }

    /// Fills in what has been drawn of some rows.
    fn finish(&self, raster: &Raster<'_, ID>, rows: (usize, usize), mut part: Part<'_>) {
        finish(self.sight.level, self.sight.camera, raster, rows.0, part.depth);
        if ID {
            self.sight.shader.shade(raster, rows, &mut part);
        }
    }
}

fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
