//! Tests of the page, in a real browser if there is one.

mod gallery;
mod reconnect;
mod web;
