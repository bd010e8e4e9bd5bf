//! Masks by which chosen pairs of bodies of one mechanism collide.
//!
//! The low byte of a shape's mask decides within a mechanism: two shapes collide if they have a bit in common. For each of
//! the eight bits, a set of bodies is chosen of which all pairs may collide, so that together the sets contain as many
//! pairs as possible. Eight suffice for arms and quadrupeds, whose bodies must not collide with their neighbours, and
//! leave out 3 % of the pairs of a humanoid.

/// Number of bits of a mask that decide within a mechanism.
const BITS: usize = 8;
/// Maximum number of bodies for which sets are sought, since the time grows with the third power of their number.
const MAX_BODIES: usize = 256;

/// The masks of the bodies of a mechanism.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SelfCollisionMasks {
    /// The low byte of each body's mask.
    pub low: Vec<u8>,
    /// Number of pairs that may collide, but whose masks do not let them.
    pub missing: usize,
}

impl SelfCollisionMasks {
    /// Chooses masks for `count` bodies. `may_collide` states whether two bodies may collide, the first of which has the
    /// lower index; others never collide with these masks. In mechanisms of more than 256 bodies, none collide.
    pub fn choose(count: usize, may_collide: impl Fn(usize, usize) -> bool) -> Self {
        let mut low = vec![0; count];
        let pairs = || (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        if count > MAX_BODIES {
            return SelfCollisionMasks { low, missing: pairs().filter(|(a, b)| may_collide(*a, *b)).count() };
        }
        let (mut allowed, mut open) = (vec![vec![false; count]; count], vec![vec![false; count]; count]);
        for (a, b) in pairs() {
            let may = may_collide(a, b);
            for (i, j) in [(a, b), (b, a)] {
                (allowed[i][j], open[i][j]) = (may, may);
            }
        }
        for bit in 0..BITS {
            let set = largest_gain(&allowed, &open);
            for (i, a) in set.iter().enumerate() {
                low[*a] |= 1 << bit;
                for b in &set[i + 1..] {
                    (open[*a][*b], open[*b][*a]) = (false, false);
                }
            }
        }
        SelfCollisionMasks { low, missing: pairs().filter(|(a, b)| open[*a][*b]).count() }
    }
}

/// Returns a set of bodies of which all pairs are allowed, grown from the body with the most open pairs by the one that
/// adds most of them. Of equal ones, the first is taken.
fn largest_gain(allowed: &[Vec<bool>], open: &[Vec<bool>]) -> Vec<usize> {
    let count = allowed.len();
    let first = |gains: &mut dyn Iterator<Item = (usize, usize)>| {
        gains.fold((0, 0), |best, (body, gain)| if gain > best.1 { (body, gain) } else { best })
    };
    let all = |body: usize| open[body].iter().filter(|open| **open).count();
    let (start, gain) = first(&mut (0..count).map(|body| (body, all(body))));
    if gain == 0 {
        return Vec::new();
    }
    let mut set = vec![start];
    loop {
        let fits = |body: &usize| set.iter().all(|other| allowed[*body][*other]);
        let adds = |body: usize| set.iter().filter(|other| open[body][**other]).count();
        let (body, gain) = first(&mut (0..count).filter(fits).map(|body| (body, adds(body))));
        if gain == 0 {
            return set;
        }
        set.push(body);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parents of the links of a robot with `legs` legs of `length` links on a trunk.
    fn legged(legs: usize, length: usize) -> Vec<Option<usize>> {
        let above = |i: usize| if i.is_multiple_of(length) { Some(0) } else { Some(i) };
        std::iter::once(None).chain((0..legs * length).map(above)).collect()
    }

    /// Checks the masks of a robot whose neighbours do not collide; returns the number of missing pairs.
    fn missing(parents: &[Option<usize>]) -> usize {
        let may = |a: usize, b: usize| parents[b] != Some(a);
        let masks = SelfCollisionMasks::choose(parents.len(), may);
        let mut missing = 0;
        for b in 0..parents.len() {
            for a in 0..b {
                let collide = masks.low[a] & masks.low[b] != 0;
                assert!(may(a, b) || !collide, "{a} and {b}");
                missing += usize::from(may(a, b) && !collide);
            }
        }
        assert_eq!(missing, masks.missing);
        missing
    }

    #[test]
    fn all_but_neighbours_of_quadrupeds_and_arms_collide() {
        assert_eq!(missing(&legged(4, 3)), 0);
        assert_eq!(missing(&legged(1, 7)), 0);
    }

    #[test]
    fn nearly_all_pairs_of_humanoids_collide() {
        assert_eq!(missing(&legged(2, 6)), 1);
        let missing = missing(&legged(4, 7));
        assert!(missing <= 11, "{missing} of 378");
    }

    #[test]
    fn bodies_without_allowed_pairs_have_no_bits() {
        assert_eq!(SelfCollisionMasks::choose(3, |_, _| false), SelfCollisionMasks { low: vec![0; 3], missing: 0 });
        assert_eq!(SelfCollisionMasks::choose(300, |a, b| (a, b) == (0, 1)).missing, 1);
        assert!(SelfCollisionMasks::choose(0, |_, _| true).low.is_empty());
    }
}
