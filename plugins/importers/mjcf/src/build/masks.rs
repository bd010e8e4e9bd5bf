//! Which bodies of a mechanism collide with each other: those that do in MuJoCo.

use std::collections::BTreeSet;

use tatu_importers_common::SelfCollisionMasks;

use super::ModelBuilder;

impl ModelBuilder<'_, '_> {
    /// Chooses the low bytes of masks, which decide within a mechanism: groups collide if contact types of their geoms
    /// match, unless they are parent and child or the file excludes the pair.
    pub(super) fn choose_masks(&mut self) {
        let (model, groups) = (self.model, self.groups);
        let number = |name: &String| model.bodies.iter().position(|body| body.name == *name);
        let group_of = |name: &String| Some(groups.of_body[number(name)?].0);
        let excluded: BTreeSet<(usize, usize)> = model
            .exclusions
            .iter()
            .filter_map(|[a, b]| Some((group_of(a)?, group_of(b)?)))
            .flat_map(|(a, b)| [(a, b), (b, a)])
            .collect();
        // The contact types of each group, without repetitions.
        let types = |group: usize| -> BTreeSet<(u32, u32)> {
            let geoms = groups.all[group].bodies.iter().flat_map(|(body, _)| &model.bodies[*body].geoms);
            geoms.map(|geom| (geom.contype, geom.conaffinity)).filter(|types| *types != (0, 0)).collect()
        };
        let types: Vec<BTreeSet<(u32, u32)>> = (0..groups.all.len()).map(types).collect();
        let match_types =
            |a: usize, b: usize| types[a].iter().any(|x| types[b].iter().any(|y| x.0 & y.1 != 0 || y.0 & x.1 != 0));
        let tops: BTreeSet<usize> = groups.all.iter().skip(1).map(|group| self.mechanism_of(group.top)).collect();
        let mut missing = 0;
        for top in tops {
            let members: Vec<usize> =
                (1..groups.all.len()).filter(|group| self.mechanism_of(groups.all[*group].top) == top).collect();
            let may_collide = |a: usize, b: usize| {
                let (a, b) = (members[a], members[b]);
                groups.all[b].parent != a && match_types(a, b) && !excluded.contains(&(a, b))
            };
            let masks = SelfCollisionMasks::choose(members.len(), may_collide);
            members.iter().zip(&masks.low).for_each(|(group, low)| self.low_masks[*group] = *low);
            missing += masks.missing;
        }
        if missing > 0 {
            self.report.warn_file(format!(
                "{missing} pairs of bodies that collide in MuJoCo do not collide, since masks cannot express all pairs"
            ));
        }
    }

    /// Returns the number that stands for the mechanism of a group at the top level.
    fn mechanism_of(&self, top: usize) -> usize {
        self.geared.get(&top).copied().unwrap_or(top)
    }
}
