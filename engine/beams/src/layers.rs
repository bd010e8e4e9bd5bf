//! The surfaces along a ray that contribute to its colour: translucent ones, and the nearest opaque one behind them.

use super::{
    beam::{Beam, Hit},
    probe::Probe,
    scene::BeamScene,
};

/// Maximum number of translucent surfaces that contribute to a colour; farther ones are ignored.
pub const MAX_TRANSLUCENT_LAYERS: usize = 8;

/// A surface along a ray.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceLayer {
    /// Index of the target in [`BeamScene::targets`].
    pub target: usize,
    /// Opacity of the target.
    pub opacity: f32,
    /// The nearest admissible point of the target.
    pub hit: Hit,
}

impl BeamScene {
    /// Replaces `layers` by the surfaces along a ray, from near to far, up to the nearest opaque one.
    ///
    /// A target contributes once, with its nearest admissible point, so that the opacity of a closed form is that of
    /// the whole form. At most [`MAX_TRANSLUCENT_LAYERS`] translucent surfaces are listed, and none with an opacity of
    /// 0. Surfaces at the same distance are sorted by tag, primitive and index, as hits are.
    pub fn surfaces_along(&self, ray: &Beam, layers: &mut Vec<SurfaceLayer>) {
        layers.clear();
        let Some(probe) = Probe::new(ray, 0) else { return };
        let mut limit = probe.far();
        let mut visit = |index: u32, limit: f64| {
            let opacity = self.targets[index as usize].opacity;
            let sees = opacity > 0.0 && self.is_considered(ray, index);
            let Some(found) = sees.then(|| self.cast_at(index as usize, &probe, limit)).flatten() else { return limit };
            layers.push(SurfaceLayer { target: index as usize, opacity, hit: self.hit(ray, &found, index as usize) });
            if opacity < 1.0 { limit } else { limit.min(found.distance) }
        };
        for &index in &self.unbounded {
            limit = visit(index, limit);
        }
        self.top.walk(&probe, limit, |place, limit| visit(self.top.order[place], limit));
        let rank = |l: &SurfaceLayer| (l.hit.object, l.hit.primitive, l.target);
        layers.sort_unstable_by(|a, b| a.hit.distance.total_cmp(&b.hit.distance).then_with(|| rank(a).cmp(&rank(b))));
        if let Some(opaque) = layers.iter().position(|l| l.opacity >= 1.0) {
            layers.truncate(opaque + 1);
        }
        let mut translucent = 0;
        layers.retain(|l| {
            translucent += usize::from(l.opacity < 1.0);
            l.opacity >= 1.0 || translucent <= MAX_TRANSLUCENT_LAYERS
        });
    }
}

/// Composites colours from near to far. Each colour contributes its opacity as a fraction of the light that the nearer
/// ones transmit. The background has an opacity of 1.
pub fn composite(layers: impl IntoIterator<Item = ([f32; 3], f32)>, background: [f32; 3]) -> [f32; 3] {
    let (mut color, mut rest) = ([0.0; 3], 1.0);
    for (own, opacity) in layers.into_iter().chain([(background, 1.0)]) {
        for (sum, x) in color.iter_mut().zip(own) {
            *sum += x * (rest * opacity);
        }
        rest *= 1.0 - opacity;
    }
    color
}
