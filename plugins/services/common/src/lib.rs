//! What services share. No plugin of its own: services are linked with it.
//!
//! - [`json`]: values as JSON;
//! - [`listener`]: a port of this machine that serves files and WebSockets, with token, limits, and a look at where a page
//!   comes from;
//! - [`port`]: one with a thread for each connection, for other protocols;
//! - [`http`]: heads of requests and answers; [`outbox`]: what waits to be sent to a client.

pub mod http;
pub mod json;
pub mod listener;
pub mod outbox;
pub mod port;
