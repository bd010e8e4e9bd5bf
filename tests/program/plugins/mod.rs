//! Tests of plugins: loading and rejecting them, crashes, misbehaviour, old and new versions; and of the header and its
//! recorded layout.

mod book;
mod breaches;
mod broken;
mod check;
mod claims;
mod compat;
mod configure;
mod crashes;
mod declarations;
mod guards;
mod header;
mod install;
mod invalid_declarations;
mod layout;
pub mod mirror;
mod misbehaves;
mod misbehaves_safely;
mod missing_libraries;
mod museum;
mod names;
mod new;
pub mod outside;
mod parts;
mod refusals;
mod reload;
mod scopes;
mod targets;
mod templates;
mod testkit;
mod texts;
mod threads;
mod trust;
mod why;
