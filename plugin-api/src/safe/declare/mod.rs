//! Declarations of what a plugin offers, with a trait or type for each kind of extension.

pub(crate) mod actuator;
pub(crate) mod command;
pub(crate) mod event;
pub(crate) mod importer;
pub(crate) mod language;
pub(crate) mod model;
pub(crate) mod model_reader;
pub(crate) mod offer;
pub(crate) mod part;
pub(crate) mod plugin;
pub(crate) mod sensor;
pub(crate) mod service;
