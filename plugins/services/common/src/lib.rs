//! Code shared by services. It is a library, not a plugin: services are linked with it.
//!
//! - [`json`]: converts values to JSON and back;
//! - [`listener`]: a local port that serves files and WebSockets, with tokens, limits, and checks of a page's origin;
//! - [`port`]: a local port with a thread for each connection, for other protocols;
//! - [`http`]: heads of requests, and answers; [`outbox`]: the queue of messages to a client;
//! - [`state`]: private files of the user that outlive a run; [`tokens`]: the tokens of a listener.

pub mod http;
pub mod json;
pub mod listener;
pub mod outbox;
pub mod port;
pub mod state;
pub mod tokens;
