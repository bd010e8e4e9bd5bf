//! Commands on objects: their handles and types, and the scene tree.

mod handles;
mod tree;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    handles::offer(offer);
    tree::offer(offer);
}
