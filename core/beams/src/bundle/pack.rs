//! Rays in packets, made once per sensor.

use nalgebra::Vector3;

/// Rays of a packet.
pub(super) const LANES: usize = 16;
/// Groups of packets of a part: its answers, while they are looked for, fit into the processor's nearest cache.
pub(super) const GROUPS: usize = 8;
/// Rays of a part.
const PART: usize = GROUPS * LANES * LANES;

/// 16 numbers side by side.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Lanes(pub [f32; LANES]);

/// The directions of 16 rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packet {
    pub x: Lanes,
    pub y: Lanes,
    pub z: Lanes,
}

/// Bounding cones with their apex at the sensor: 16 packets' or groups'.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cones {
    pub x: Lanes,
    pub y: Lanes,
    pub z: Lanes,
    pub cos: Lanes,
    pub sin: Lanes,
}

/// Up to 2048 rays that follow one another.
#[derive(Debug, Clone)]
pub(super) struct PacketGroup {
    /// First ray.
    pub first: usize,
    /// Of each lane of each packet, its ray, counted from the first. Lanes that are left over repeat a ray.
    pub order: Vec<u16>,
    pub packets: Vec<Packet>,
    /// Around each packet, 16 packets a group.
    pub cones: Vec<Cones>,
    /// Around each group.
    pub groups: Cones,
    rays: usize,
}

/// The directions of a sensor's rays, made ready for [`BeamScene::cast_bundle`](super::BeamScene::cast_bundle).
///
/// Meant to be made once and shared by all sensors that are alike: about 45 bytes a ray.
#[derive(Debug, Clone)]
pub struct RayBundle {
    directions: Vec<Vector3<f64>>,
    parts: Vec<PacketGroup>,
}

impl RayBundle {
    /// Makes a bundle of directions in the sensor's frame. They need not be of length 1; one without a length, or with
    /// something that is no number, sees nothing.
    pub fn new(directions: &[[f64; 3]]) -> Self {
        let unit = |d: &[f64; 3]| {
            let d = Vector3::from(*d);
            d.try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite())).unwrap_or(Vector3::repeat(f64::NAN))
        };
        let directions: Vec<_> = directions.iter().map(unit).collect();
        let parts = directions.len().div_ceil(PART);
        let parts = (0..parts).map(|i| {
            let at = |i: usize| (directions.len() * i / parts).next_multiple_of(LANES).min(directions.len());
            PacketGroup::new(at(i), &directions[at(i)..at(i + 1)])
        });
        Self { parts: parts.collect(), directions }
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Whether there is no ray.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// The directions, of length 1, in the sensor's frame.
    pub fn directions(&self) -> &[Vector3<f64>] {
        &self.directions
    }

    pub(super) fn parts(&self) -> &[PacketGroup] {
        &self.parts
    }
}

impl PacketGroup {
    fn new(first: usize, directions: &[Vector3<f64>]) -> Self {
        let given: Vec<u16> = (0..directions.len() as u16).collect();
        let mut sorted = given.clone();
        sort(&mut sorted, directions);
        // The given order is kept where it is good: most scanners' rays come one beside the other.
        let width = |order: &[u16]| order.chunks(LANES).map(|p| 1.0 - Cone::around(p, directions).cos).sum::<f64>();
        let mut order = if width(&given) <= 1.1 * width(&sorted) { given } else { sorted };
        let rays = order.len();
        let last = order.last().copied().unwrap_or(0);
        order.resize(rays.next_multiple_of(LANES), last);

        let packets = order.chunks(LANES).map(|packet| {
            let axis = |axis: usize| {
                let mut lanes = Lanes([0.0; LANES]);
                lanes.0.iter_mut().zip(packet).for_each(|(lane, ray)| *lane = directions[*ray as usize][axis] as f32);
                lanes
            };
            Packet { x: axis(0), y: axis(1), z: axis(2) }
        });
        let cones = order.chunks(LANES * LANES).map(|group| {
            let around: Vec<Cone> = group.chunks(LANES).map(|p| Cone::around(p, directions)).collect();
            Cones::new(&around)
        });
        let groups: Vec<Cone> = order.chunks(LANES * LANES).map(|g| Cone::around(g, directions)).collect();
        Self { first, packets: packets.collect(), cones: cones.collect(), groups: Cones::new(&groups), order, rays }
    }

    pub fn rays(&self) -> usize {
        self.rays
    }
}

/// Puts rays that are close together one after the other: halves along the widest axis, down to packets.
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

/// A cone around directions.
#[derive(Debug, Clone, Copy)]
struct Cone {
    axis: Vector3<f64>,
    cos: f64,
}

impl Cone {
    fn around(rays: &[u16], directions: &[Vector3<f64>]) -> Self {
        let all = || rays.iter().map(|ray| &directions[*ray as usize]).filter(|d| d.x.is_finite());
        let axis = all().sum::<Vector3<f64>>().try_normalize(1e-9).unwrap_or_else(Vector3::z);
        // 1 - x loses digits near 1: half the chord's square does not.
        let widest = all().map(|d| (d - axis).norm_squared()).fold(0.0, f64::max);
        Self { axis, cos: 1.0 - 0.5 * widest }
    }
}

impl Cones {
    /// Lanes without a cone are never asked for.
    fn new(cones: &[Cone]) -> Self {
        let lane = |of: fn(&Cone) -> f64| {
            let mut lanes = Lanes([0.0; LANES]);
            lanes.0.iter_mut().zip(cones).for_each(|(lane, cone)| *lane = of(cone) as f32);
            lanes
        };
        // A cone wider than a half space sees everything: an axis without length does in the test.
        Self {
            x: lane(|c| if c.cos > 0.0 { c.axis.x } else { 0.0 }),
            y: lane(|c| if c.cos > 0.0 { c.axis.y } else { 0.0 }),
            z: lane(|c| if c.cos > 0.0 { c.axis.z } else { 0.0 }),
            cos: lane(|c| c.cos.max(0.0)),
            sin: lane(|c| if c.cos > 0.0 { (1.0 - c.cos * c.cos).max(0.0).sqrt() } else { 0.0 }),
        }
    }
}
