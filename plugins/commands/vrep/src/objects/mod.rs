//! Commands on objects: handles and types, and the tree that they form.

mod handles;
mod tree;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    handles::offer(offer);
    tree::offer(offer);
}
