//! Values, errors, and declarations of parameters and fields, with utilities for files and for installed folders.

pub(crate) mod fail;
pub(crate) mod field;
pub(crate) mod install_paths;
pub(crate) mod list_cache;
pub(crate) mod owned;
pub(crate) mod param;
pub(crate) mod plain;
pub(crate) mod reading;
pub(crate) mod sample;
pub(crate) mod table_arena;
pub(crate) mod target;
