//! Commands on vision sensors, which are sensors with readings of `depth_image/1` or `color_image/1`.
//!
//! - `sensors`: determines which objects are vision sensors; `view`: a sensor's reading, converted to its clipping
//!   planes and units;
//! - `images`: commands that return images and depths; `packets`: statistics of an image;
//! - `saving`: image files, and image conversions;
//! - `handle`: takes images and collects their results (`results`); `callbacks`: callbacks of the sensor's scripts;
//!   `set`: images set by scripts;
//! - `filters`: the chains that sensors had before 4.0, on a working image (`work`);
//! - `module`: the same filters as separate functions, as in `simVision`;
//! - `spherical`: combines images of six sensors into a panorama; `anaglyph`: those of two into a stereo picture;
//! - `parameters`: resolution, clipping planes and angles by number.
//!
//! Rows are ordered from bottom to top; depths range from 0 at the near plane to 1 at the far plane. The image of a
//! dummy or camera that replaces a sensor in a run without its scene is black, with all depths at the far plane.

mod anaglyph;
mod callbacks;
mod filters;
mod handle;
mod images;
mod module;
mod packets;
pub(crate) mod parameters;
pub(crate) mod results;
mod saving;
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
    anaglyph::offer(offer);
}
