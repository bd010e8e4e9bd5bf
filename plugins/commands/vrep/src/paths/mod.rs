//! Commands on paths, which are tables of configurations or, in old scenes, objects.

mod interpolation;
pub(crate) mod objects;
mod tables;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    tables::offer(offer);
    objects::offer(offer);
}
