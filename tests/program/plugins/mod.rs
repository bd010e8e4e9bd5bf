//! Tests of plugins: loading, refusal, crashes, misbehaviour, old and new versions; the header and its recorded layout.

mod away;
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
mod texts;
mod trust;
mod why;
