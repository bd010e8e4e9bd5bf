//! The page, in a real browser where there is one.

mod web;
