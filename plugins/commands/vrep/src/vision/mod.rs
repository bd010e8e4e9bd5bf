//! Vision sensors: sensors that fill `depth_image/1` or `color_image/1`, under the names and in the units of this API.
//!
//! - `view`: what a sensor has seen, in its planes and units;
//! - `images`: images and depths as scripts get them; `packets`: the numbers that stand for an image;
//! - `saving`: images in files, and made of others;
//! - `handle`: taking an image, and what was found in it; `callbacks`: what scripts of the sensor make of it; `set`: images from elsewhere;
//! - `filters`: the chains that sensors had before 4.0, on a working image (`work`);
//! - `module`: the same filters one by one, as `simVision` has them;
//! - `parameters`: resolution, planes and angles by number.
//!
//! Rows run from the bottom to the top, depths from 0 at the near plane to 1 at the far one. A dummy or camera that stands
//! for a sensor in a run without its scene is blind: its image is black, and nothing is near.

mod callbacks;
mod filters;
mod handle;
mod images;
pub(crate) mod module;
mod packets;
pub(crate) mod parameters;
mod saving;
mod set;
mod view;
mod work;

use crate::{Vrep, kit::*};

pub(crate) use handle::AllSeen;
pub(crate) use module::AllWork;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    callbacks::offer(offer);
    filters::offer(offer);
    handle::offer(offer);
    images::offer(offer);
    saving::offer(offer);
    set::offer(offer);
}

/// Whether an object is a vision sensor.
pub(crate) fn is_one(c: &Shared<'_>, object: tatu_object) -> bool {
    let p = &c.plugin().p;
    c.world().reading(object, p.depth).is_ok() || c.world().reading(object, p.rgb).is_ok()
}

/// All vision sensors, each once.
fn all(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let mut all = c.world().sensors("depth_image/1")?;
    let more = c.world().sensors("color_image/1")?;
    all.extend(more.into_iter().filter(|s| !all.contains(s)).collect::<Vec<_>>());
    Ok(all)
}
