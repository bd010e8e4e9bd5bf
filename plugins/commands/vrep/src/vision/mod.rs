//! Vision sensors: sensors that fill `depth_image/1` or `color_image/1`, under the names and in the units of this API.
//!
//! - `sensors`: which objects are vision sensors; `view`: what a sensor has seen, in its planes and units;
//! - `images`: images and depths as scripts get them; `packets`: the numbers that stand for an image;
//! - `saving`: images in files, and made of others;
//! - `handle`: taking an image, and what was found in it (`seen`); `callbacks`: what scripts of the sensor make of it; `set`: images from elsewhere;
//! - `filters`: the chains that sensors had before 4.0, on a working image (`work`);
//! - `module`: the same filters one by one, as `simVision` has them;
//! - `spherical`: images of six sensors as one of all around;
//! - `parameters`: resolution, planes and angles by number.
//!
//! Rows run from the bottom to the top, depths from 0 at the near plane to 1 at the far one. A dummy or camera that stands
//! for a sensor in a run without its scene is blind: its image is black, and nothing is near.

mod callbacks;
mod filters;
mod handle;
mod images;
mod module;
mod packets;
pub(crate) mod parameters;
mod saving;
pub(crate) mod seen;
pub(crate) mod sensors;
mod set;
mod spherical;
mod view;
pub(crate) mod work;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    callbacks::offer(offer);
    filters::offer(offer);
    handle::offer(offer);
    images::offer(offer);
    saving::offer(offer);
    set::offer(offer);
    module::offer(offer);
    spherical::offer(offer);
}
