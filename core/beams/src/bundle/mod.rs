//! Bundles of rays of one origin, cast many at a time.
//!
//! The rays stand in packets of 16, side by side in the processor's wide registers. Work goes target by target, nearer
//! ones first: a target's bounding ball is compared with the cones around 16 packets at once, and only the packets that
//! may see it, and have seen nothing nearer, are tested against its form. The arithmetic is that of 32-bit numbers in
//! the frame of the target, whose place relative to the sensor is computed in 64 bits; a distance whose error might
//! matter, on surfaces seen at a grazing angle, is computed again in 64 bits.
//!
//! - `query`: what is asked, and where the answers go;
//! - `pack`: a bundle's packets and the cones around them, made once; `lanes`: 16 numbers side by side;
//! - `cast`: the walk through the targets; `packet`: what packets have met so far, and the limits of a cast;
//! - `forms`: 16 rays against each closed form;
//! - `mesh`: 16 rays against triangles;
//! - `finish`: from packets to answers.

mod cast;
mod finish;
mod forms;
mod lanes;
mod mesh;
mod pack;
mod packet;
mod query;

use rayon::prelude::*;

pub(super) use mesh::PacketTree;
pub use pack::RayBundle;
pub use query::{BundleCast, BundleHits};

use super::BeamScene;

/// Fewer rays than this are not worth another thread.
const FEW: usize = 256;

impl BeamScene {
    /// Casts a bundle in this thread.
    ///
    /// # Panics
    /// If an array of `hits` is neither empty nor as long as the bundle.
    pub fn cast_bundle(&self, cast: &BundleCast<'_>, hits: BundleHits<'_>) {
        self.cast_bundle_at(super::simd::level(), cast, hits);
    }

    /// Casts many bundles, of one sensor or of all, on rayon's current pool; what one sees depends on no other.
    ///
    /// # Panics
    /// If an array of answers is neither empty nor as long as its bundle.
    pub fn cast_bundles<'a>(&self, casts: impl IntoIterator<Item = (BundleCast<'a>, BundleHits<'a>)>) {
        let level = super::simd::level();
        let mut jobs = Vec::new();
        let mut rays = 0;
        for (cast, mut rest) in casts {
            rest.check(cast.bundle.len());
            rays += cast.bundle.len();
            for (index, part) in cast.bundle.parts().iter().enumerate() {
                let (first, others) = rest.split(part.rays());
                jobs.push((cast, index, first));
                rest = others;
            }
        }
        if jobs.len() < 2 || rays < FEW {
            jobs.into_iter().for_each(|(cast, part, hits)| cast::part(self, level, &cast, part, hits));
        } else {
            jobs.into_par_iter().for_each(|(cast, part, hits)| cast::part(self, level, &cast, part, hits));
        }
    }

    /// The same with the registers of a given level.
    pub(super) fn cast_bundle_at(&self, level: fearless_simd::Level, cast: &BundleCast<'_>, hits: BundleHits<'_>) {
        hits.check(cast.bundle.len());
        let mut rest = hits;
        for part in 0..cast.bundle.parts().len() {
            let (first, others) = rest.split(cast.bundle.parts()[part].rays());
            cast::part(self, level, cast, part, first);
            rest = others;
        }
    }
}
