//! Colours and opacities of shapes and of the parts of compounds. Scripts address parts by the names of their colours.

use crate::kit::*;

/// Tag under which the importer stores the names of the colours of a compound's parts, one per line.
const NAMES_TAG: &str = "color names";

/// Name by which scripts address all parts of a compound.
const ALL_PARTS: &str = "@compound";

/// A property of a shape, and the corresponding property of its parts.
pub(super) struct PartProperty<const N: usize> {
    whole: Prop,
    parts: Prop,
}

pub(super) fn diffuse(c: &SharedCtx<'_>) -> PartProperty<3> {
    let p = &c.plugin().p;
    PartProperty { whole: p.color, parts: p.part_colors }
}

pub(super) fn opacity(c: &SharedCtx<'_>) -> PartProperty<1> {
    let p = &c.plugin().p;
    PartProperty { whole: p.opacity, parts: p.part_opacities }
}

impl<const N: usize> PartProperty<N> {
    /// Returns the value of the first part with the given name, or of the first part if no name is given.
    pub(super) fn get(&self, c: &SharedCtx<'_>, shape: tatu_object, name: Option<&str>) -> Result<[f64; N]> {
        let first = parts_named(c, shape, name)?.and_then(|(chosen, _)| chosen.first().copied()).unwrap_or(0);
        let own = self.of_parts(c, shape)?;
        match own.get(N * first..N * (first + 1)).and_then(|v| v.try_into().ok()) {
            Some(own) => Ok(own),
            None => c.world().f64s::<N>(shape, self.whole),
        }
    }

    /// Sets the value of the parts with the given name, or of the whole shape if no name is given.
    pub(super) fn set(&self, c: &Ctx<'_>, shape: tatu_object, name: Option<&str>, value: [f64; N]) -> Result {
        let (w, mut own) = (c.world(), self.of_parts(c, shape)?);
        match parts_named(c, shape, name)? {
            Some((chosen, count)) if chosen.len() < count => {
                if own.len() != N * count {
                    own = w.f64s::<N>(shape, self.whole)?.repeat(count);
                }
                chosen.iter().for_each(|i| own[N * i..N * (i + 1)].copy_from_slice(&value));
                w.set(shape, self.parts, &Value::Floats(own))
            }
            _ => {
                w.set_f64s(shape, self.whole, &value)?;
                if own.is_empty() { Ok(()) } else { w.set(shape, self.parts, &Value::Floats(Vec::new())) }
            }
        }
    }

    /// Returns the value of the shape, followed by those of its parts if they differ from it.
    pub(super) fn all(&self, c: &SharedCtx<'_>, shape: tatu_object) -> Result<Vec<f64>> {
        let mut all = c.world().f64s::<N>(shape, self.whole)?.to_vec();
        all.extend(self.of_parts(c, shape)?);
        Ok(all)
    }

    /// Restores values that [`all`](Self::all) returned.
    pub(super) fn restore(&self, c: &Ctx<'_>, shape: tatu_object, all: &[f64]) -> Result {
        let Some((whole, parts)) = all.split_at_checked(N) else { return Ok(()) };
        c.world().set_f64s(shape, self.whole, whole)?;
        c.world().set(shape, self.parts, &Value::Floats(parts.to_vec()))
    }

    fn of_parts(&self, c: &SharedCtx<'_>, shape: tatu_object) -> Result<Vec<f64>> {
        Ok(c.world().get(shape, self.parts)?.numbers().unwrap_or_default())
    }
}

/// Returns the indices of the parts with the given name, and the number of all parts. Returns `None`, which denotes the
/// whole shape, if no name is given or the parts of the shape have no names.
fn parts_named(c: &SharedCtx<'_>, shape: tatu_object, name: Option<&str>) -> Result<Option<(Vec<usize>, usize)>> {
    let Some(name) = name.filter(|n| !n.is_empty() && *n != ALL_PARTS) else { return Ok(None) };
    let Some(names) = tags::private(c, shape, NAMES_TAG)? else { return Ok(None) };
    let names: Vec<&[u8]> = names.split(|b| *b == b'\n').collect();
    let chosen = names.iter().enumerate().filter(|(_, n)| **n == name.as_bytes()).map(|(i, _)| i).collect();
    Ok(Some((chosen, names.len())))
}
