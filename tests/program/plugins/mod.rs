//! Plugins: loaded, refused, crashing, misbehaving, old and new; the header and its record.

mod away;
mod breaches;
mod claims;
mod compat;
mod configure;
mod crashes;
mod declarations;
mod guards;
mod header;
mod layout;
mod made_wrong;
pub mod mirror;
mod misbehaves;
mod misbehaves_safely;
mod museum;
mod names;
mod new;
mod outside;
mod refusals;
mod reload;
mod scopes;
mod templates;
mod testkit;
mod texts;
mod trust;
