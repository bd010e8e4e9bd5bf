//! Packets of rays, built once for each set of directions.

use nalgebra::Vector3;

/// Number of rays in a packet.
pub(super) const LANES: usize = 16;
/// Number of packet groups in a part, such that its intermediate results fit into the processor's L1 cache.
pub(super) const GROUPS: usize = 8;
/// Maximum number of rays in a part.
const MAX_RAYS_PER_PART: usize = GROUPS * LANES * LANES;

/// 16 adjacent values, aligned to a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct LaneArray(pub [f32; LANES]);

/// The directions of 16 rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayPacket {
    pub x: LaneArray,
    pub y: LaneArray,
    pub z: LaneArray,
}

/// The bounding cones of 16 packets or groups, with their apex at the sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundingCones {
    pub x: LaneArray,
    pub y: LaneArray,
    pub z: LaneArray,
    pub cos: LaneArray,
    pub sin: LaneArray,
}

/// A part of a bundle: up to 2048 consecutive rays.
#[derive(Debug, Clone)]
pub(super) struct BundlePart {
    /// Index of the first ray.
    pub first: usize,
    /// For each lane of each packet, the index of its ray relative to the first. Unused lanes repeat a ray.
    pub order: Vec<u16>,
    pub packets: Vec<RayPacket>,
    /// Bounding cones of packets, 16 packets per group.
    pub cones: Vec<BoundingCones>,
    /// Bounding cones of groups.
    pub groups: BoundingCones,
    rays: usize,
}

/// The directions of a sensor's rays, prepared for [`BeamScene::cast_bundle`](super::BeamScene::cast_bundle).
///
/// It should be built once and shared by all sensors with the same rays, since it needs about 40 bytes per ray.
#[derive(Debug, Clone)]
pub struct RayBundle {
    directions: Vec<Vector3<f64>>,
    parts: Vec<BundlePart>,
}

impl RayBundle {
    /// Builds a bundle from directions in the sensor's frame. They need not be unit vectors. A ray whose direction is
    /// zero or not finite hits nothing.
    pub fn new(directions: &[[f64; 3]]) -> Self {
        let unit = |d: &[f64; 3]| {
            let d = Vector3::from(*d);
            d.try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite())).unwrap_or(Vector3::repeat(f64::NAN))
        };
        let directions: Vec<_> = directions.iter().map(unit).collect();
        let parts = directions.len().div_ceil(MAX_RAYS_PER_PART);
        let parts = (0..parts).map(|i| {
            let at = |i: usize| (directions.len() * i / parts).next_multiple_of(LANES).min(directions.len());
            BundlePart::new(at(i), &directions[at(i)..at(i + 1)])
        });
        Self { parts: parts.collect(), directions }
    }

    /// Returns the number of rays.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Returns whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// Returns the directions, unit vectors in the sensor's frame.
    pub fn directions(&self) -> &[Vector3<f64>] {
        &self.directions
    }

    pub(super) fn parts(&self) -> &[BundlePart] {
        &self.parts
    }
}

impl BundlePart {
    fn new(first: usize, directions: &[Vector3<f64>]) -> Self {
        let given: Vec<u16> = (0..directions.len() as u16).collect();
        let mut sorted = given.clone();
        sort(&mut sorted, directions);
        // The given order is retained if its packets are narrow enough, since most scanners list adjacent rays
        // consecutively.
        let width =
            |order: &[u16]| order.chunks(LANES).map(|p| 1.0 - BoundingCone::enclosing(p, directions).cos).sum::<f64>();
        let mut order = if width(&given) <= 1.1 * width(&sorted) { given } else { sorted };
        let rays = order.len();
        let last = order.last().copied().unwrap_or(0);
        order.resize(rays.next_multiple_of(LANES), last);

        let packets = order.chunks(LANES).map(|packet| {
            let axis = |axis: usize| {
                let mut lanes = LaneArray([0.0; LANES]);
                lanes.0.iter_mut().zip(packet).for_each(|(lane, ray)| *lane = directions[*ray as usize][axis] as f32);
                lanes
            };
            RayPacket { x: axis(0), y: axis(1), z: axis(2) }
        });
        let cones = order.chunks(LANES * LANES).map(|group| {
            let around: Vec<BoundingCone> =
                group.chunks(LANES).map(|p| BoundingCone::enclosing(p, directions)).collect();
            BoundingCones::new(&around)
        });
        let groups: Vec<BoundingCone> =
            order.chunks(LANES * LANES).map(|g| BoundingCone::enclosing(g, directions)).collect();
        Self {
            first,
            packets: packets.collect(),
            cones: cones.collect(),
            groups: BoundingCones::new(&groups),
            order,
            rays,
        }
    }

    pub fn rays(&self) -> usize {
        self.rays
    }
}

/// Sorts rays such that rays with similar directions are consecutive, by recursively halving the set along its widest
/// axis down to packets.
fn sort(rays: &mut [u16], directions: &[Vector3<f64>]) {
    if rays.len() <= LANES {
        return;
    }
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for ray in &*rays {
        low = low.inf(&directions[*ray as usize]);
        high = high.sup(&directions[*ray as usize]);
    }
    let axis = (high - low).imax();
    let unit = if rays.len() > LANES * LANES { LANES * LANES } else { LANES };
    let half = (rays.len() / 2).next_multiple_of(unit).min(rays.len() - 1);
    let at = |ray: &u16| directions[*ray as usize][axis];
    rays.select_nth_unstable_by(half, |a, b| at(a).total_cmp(&at(b)).then(a.cmp(b)));
    let (left, right) = rays.split_at_mut(half);
    sort(left, directions);
    sort(right, directions);
}

/// A bounding cone of directions.
#[derive(Debug, Clone, Copy)]
struct BoundingCone {
    axis: Vector3<f64>,
    cos: f64,
}

impl BoundingCone {
    fn enclosing(rays: &[u16], directions: &[Vector3<f64>]) -> Self {
        let all = || rays.iter().map(|ray| &directions[*ray as usize]).filter(|d| d.x.is_finite());
        let axis = all().sum::<Vector3<f64>>().try_normalize(1e-9).unwrap_or_else(Vector3::z);
        // Near 1, the cosine is computed more accurately from the chord than as a dot product.
        let widest = all().map(|d| (d - axis).norm_squared()).fold(0.0, f64::max);
        Self { axis, cos: 1.0 - 0.5 * widest }
    }
}

impl BoundingCones {
    /// Packs cones into lanes; lanes without a cone are never used.
    fn new(cones: &[BoundingCone]) -> Self {
        let lane = |of: fn(&BoundingCone) -> f64| {
            let mut lanes = LaneArray([0.0; LANES]);
            lanes.0.iter_mut().zip(cones).for_each(|(lane, cone)| *lane = of(cone) as f32);
            lanes
        };
        // A cone that is at least as wide as a half-space may contain any target, so its axis is set to zero, with
        // which the test always passes.
        Self {
            x: lane(|c| if c.cos > 0.0 { c.axis.x } else { 0.0 }),
            y: lane(|c| if c.cos > 0.0 { c.axis.y } else { 0.0 }),
            z: lane(|c| if c.cos > 0.0 { c.axis.z } else { 0.0 }),
            cos: lane(|c| c.cos.max(0.0)),
            sin: lane(|c| if c.cos > 0.0 { (1.0 - c.cos * c.cos).max(0.0).sqrt() } else { 0.0 }),
        }
    }
}
