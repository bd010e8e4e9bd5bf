//! Tests of plugins: loading and rejecting them, crashes, misbehaviour, old and new versions; and of the header and its
//! recorded layout.

mod away;
mod book;
mod breaches;
mod broken;
mod claims;
mod compat;
mod configure;
mod crashes;
mod declarations;
mod guards;
mod header;
mod install;
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
mod threads;
mod trust;
mod why;
