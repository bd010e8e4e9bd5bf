//! Registers the preludes that script languages run for scripts of this API.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.prelude("lua", "", include_str!("prelude.lua"));
    offer.prelude("lua", "", include_str!("base.lua"));
    offer.prelude("lua", "", include_str!("matrix.lua"));
    offer.prelude("python", "", include_str!("prelude.py"));
}
