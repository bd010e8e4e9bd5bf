//! Vision sensors: sensors with readings of `depth_image/1` or `color_image/1`, under the names and in the units of
//! this API.
//!
//! - `sensors`: which objects are vision sensors; `view`: what a sensor has measured, in its clipping planes and units;
//! - `images`: commands that return images and depths; `packets`: statistics of an image;
//! - `saving`: image files, and image conversions;
//! - `handle`: takes an image and collects what is found in it (`seen`); `callbacks`: callbacks of the sensor's
//!   scripts; `set`: images from elsewhere;
//! - `filters`: the chains that sensors had before 4.0, on a working image (`work`);
//! - `module`: the same filters as single functions, as in `simVision`;
//! - `spherical`: combines images of six sensors into a panorama;
//! - `parameters`: resolution, planes and angles by number.
//!
//! Rows run from bottom to top, depths from 0 at the near plane to 1 at the far one. A dummy or camera that replaces a
//! sensor in a run without its scene sees nothing: its image is black, with all depths at the far plane.

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
