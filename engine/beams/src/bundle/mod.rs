//! Bundles of rays with a common origin, many of which are cast at a time.
//!
//! The rays are stored in packets of 16, which fit into the processor's wide registers. Targets are visited one by one,
//! near ones first. A target's bounding sphere is compared with the cones around 16 packets at once, and only packets
//! that may hit it and have no nearer hit are tested against its form. Computations use 32-bit floats in the frame of
//! the target, whose pose relative to the sensor is computed in 64 bits. A distance whose error is relevant, as on
//! surfaces at grazing angles, is recomputed in 64 bits.
//!
//! - `query`: queries and their results;
//! - `pack`: packets of a bundle and the cones around them, built once; `lanes`: 16 adjacent values;
//! - `cast`: traversal of the targets; `packet`: intermediate results of packets, and the limits of a cast;
//! - `forms`: 16 rays against each analytic form;
//! - `mesh`: 16 rays against triangles;
//! - `finish`: conversion of packet results.

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

/// Minimum number of rays that are cast on several threads.
const MIN_PARALLEL_RAYS: usize = 256;

impl BeamScene {
    /// Casts a bundle on this thread.
    ///
    /// # Panics
    /// Panics if an array of `hits` is neither empty nor as long as the bundle.
    pub fn cast_bundle(&self, cast: &BundleCast<'_>, hits: BundleHits<'_>) {
        self.cast_bundle_at(super::simd::level(), cast, hits);
    }

    /// Casts many bundles, of one sensor or of several, on rayon's current pool. The results of each bundle are
    /// independent of the others.
    ///
    /// # Panics
    /// Panics if an array of results is neither empty nor as long as its bundle.
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
        if jobs.len() < 2 || rays < MIN_PARALLEL_RAYS {
            jobs.into_iter().for_each(|(cast, part, hits)| cast::cast_part(self, level, &cast, part, hits));
        } else {
            jobs.into_par_iter().for_each(|(cast, part, hits)| cast::cast_part(self, level, &cast, part, hits));
        }
    }

    /// Casts a bundle like `cast_bundle`, but at the given SIMD level.
    pub(super) fn cast_bundle_at(&self, level: fearless_simd::Level, cast: &BundleCast<'_>, hits: BundleHits<'_>) {
        hits.check(cast.bundle.len());
        let mut rest = hits;
        for part in 0..cast.bundle.parts().len() {
            let (first, others) = rest.split(cast.bundle.parts()[part].rays());
            cast::cast_part(self, level, cast, part, first);
            rest = others;
        }
    }
}
