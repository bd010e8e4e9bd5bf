//! Types of sockets, and which types can be connected to each other.

/// The type of a socket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sends each message to all subscribers of its topic.
    Publish,
    /// Receives from publishers the messages to whose topics it has subscribed.
    Subscribe,
    /// Alternately sends a request and receives its answer.
    Request,
    /// Alternately receives a request and sends its answer.
    Reply,
    /// Sends to its peers in turn, and receives from all of them.
    Dealer,
    /// Receives messages from all peers together with the sender's identity, and sends each message to the peer with a
    /// given identity.
    Router,
    /// Receives from all peers.
    Pull,
    /// Sends to its peers in turn.
    Push,
}

/// The types, with their names in the protocol and their numbers in scripts.
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
    /// Returns the type with this number, or `None` if there is none.
    pub fn of(number: i64) -> Option<Kind> {
        KINDS.iter().find(|(_, _, n)| *n == number).map(|(kind, ..)| *kind)
    }
    /// Returns the name in the protocol, and the number in scripts.
    pub fn names(self) -> (&'static str, i64) {
        KINDS.iter().find(|(kind, ..)| *kind == self).map_or(("", -1), |(_, name, number)| (name, *number))
    }
    /// Returns whether a socket of this type can be connected to one whose type has the name `peer`.
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
    /// Returns whether sockets of this type can send messages.
    pub fn sends(self) -> bool {
        !matches!(self, Kind::Subscribe | Kind::Pull)
    }
    /// Returns whether sockets of this type can receive messages.
    pub fn receives(self) -> bool {
        !matches!(self, Kind::Publish | Kind::Push)
    }
}
