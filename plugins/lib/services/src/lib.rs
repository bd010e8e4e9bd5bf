//! Code shared by services. This is a library that services are linked with, not a plugin.
//!
//! - [`json`]: converts values to JSON and back;
//! - [`listener`]: a local port that serves files and WebSockets; checks tokens and origins, and limits clients;
//! - [`port`]: a local port with a thread for each connection, for other protocols;
//! - [`hold_limit`]: how long a client that controls the stepping may hold the simulation without sending a message;
//! - [`http`]: HTTP requests and responses; [`outbox`]: the queue of messages to a client;
//! - [`state`]: private files of the user that are stored for later runs; [`tokens`]: the access tokens of a listener;
//! - [`zmtp`]: the protocol of ZeroMQ.

pub mod hold_limit;
pub mod http;
pub mod json;
pub mod listener;
pub mod outbox;
pub mod port;
pub mod state;
pub mod tokens;
pub mod zmtp;
