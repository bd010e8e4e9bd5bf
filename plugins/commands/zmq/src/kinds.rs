//! Types of sockets, and which of them can be connected.

/// The type of a socket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sends to all subscribers.
    Publish,
    /// Receives from publishers what it has subscribed to.
    Subscribe,
    /// Sends a request, then receives the answer.
    Request,
    /// Receives a request, then answers it.
    Reply,
    /// Sends to its peers in turn, and receives from all.
    Dealer,
    /// Receives from all peers, with their identities, and sends to the one with a given identity.
    Router,
    /// Receives from all peers.
    Pull,
    /// Sends to its peers in turn.
    Push,
}

/// The types with their names and numbers.
pub const KINDS: &[(Kind, &str, i64)] = &[
    (Kind::Publish, "PUB", 1),
    (Kind::Subscribe, "SUB", 2),
    (Kind::Request, "REQ", 3),
    (Kind::Reply, "REP", 4),
    (Kind::Dealer, "DEALER", 5),
    (Kind::Router, "ROUTER", 6),
    (Kind::Pull, "PULL", 7),
    (Kind::Push, "PUSH", 8),
];

impl Kind {
    /// Returns the type with a number.
    pub fn of(number: i64) -> Option<Kind> {
        KINDS.iter().find(|(_, _, n)| *n == number).map(|(kind, ..)| *kind)
    }
    /// Returns the name in the protocol, and the number.
    pub fn names(self) -> (&'static str, i64) {
        KINDS.iter().find(|(kind, ..)| *kind == self).map_or(("", -1), |(_, name, number)| (name, *number))
    }
    /// Returns whether a peer may have a socket with this name.
    pub fn accepts(self, peer: &str) -> bool {
        let peers: &[&str] = match self {
            Kind::Publish => &["SUB", "XSUB"],
            Kind::Subscribe => &["PUB", "XPUB"],
            Kind::Request => &["REP", "ROUTER"],
            Kind::Reply => &["REQ", "DEALER"],
            Kind::Dealer => &["REP", "DEALER", "ROUTER"],
            Kind::Router => &["REQ", "DEALER", "ROUTER"],
            Kind::Pull => &["PUSH"],
            Kind::Push => &["PULL"],
        };
        peers.contains(&peer)
    }
    /// Returns whether the socket sends messages.
    pub fn sends(self) -> bool {
        !matches!(self, Kind::Subscribe | Kind::Pull)
    }
    /// Returns whether the socket receives messages.
    pub fn receives(self) -> bool {
        !matches!(self, Kind::Publish | Kind::Push)
    }
}
