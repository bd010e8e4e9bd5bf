//! The state of a socket: its peers, and the routing of messages to and from them, which depends on the type of the
//! socket.

use std::{
    collections::{BTreeMap, VecDeque},
    time::Instant,
};

use crate::{
    errors::Errno,
    kinds::Kind,
    options::Options,
    queue::{Message, Queue, QueuedBytes},
};

/// Maximum number of parts of a message.
pub const MAX_PARTS: usize = 1024;
/// Maximum size of a message that is sent or received, bytes.
pub const MAX_MESSAGE_BYTES: usize = tatu_services_common::zmtp::MAX_MESSAGE_BYTES as usize;
/// Maximum number of subscriptions of a socket, and of each of its peers.
const MAX_TOPICS: usize = 10_000;

/// The other end of an accepted connection, or an endpoint to which the socket connects, whether or not the connection
/// is established.
pub struct Peer {
    /// Whether the handshake is complete.
    pub ready: bool,
    /// Whether the peer will be removed when its outgoing messages have been sent.
    pub leaving: bool,
    pub identity: Vec<u8>,
    pub incoming: Queue,
    pub outgoing: Queue,
    /// The topics to which the peer has subscribed.
    topics: Vec<Vec<u8>>,
}

/// The state of the alternation of requests and answers on a request or reply socket.
enum Turn {
    /// The next message is a request.
    Begin,
    /// A request was sent to the peer with this number, which must answer it.
    Asked(u64),
    /// A request was received from the peer with this number. The answer must be preceded by these parts, which contain
    /// the route to the requester.
    Answer(u64, Message),
}

/// The state of a socket: its options, its peers with their queues, and messages of which a script has sent or received
/// only some parts.
pub struct SocketState {
    pub kind: Kind,
    pub options: Options,
    pub peers: BTreeMap<u64, Peer>,
    /// If the socket has been closed, the time until which queued messages are still sent.
    pub closed: Option<Instant>,
    /// The endpoint to which the socket was bound last.
    pub last_endpoint: String,
    queued: QueuedBytes,
    last_peer: u64,
    turn: Turn,
    /// Number of the peer to which the last message was sent; `received_from` is that from which one was received.
    sent_to: u64,
    received_from: u64,
    /// The parts of an outgoing message that is not complete yet.
    sending: Message,
    /// The parts of the current incoming message that have not been returned to the script yet.
    receiving: VecDeque<Vec<u8>>,
    /// Whether the part that was returned last is followed by further parts of the same message.
    pub more: bool,
    topics: Vec<Vec<u8>>,
}

impl SocketState {
    /// Creates a socket without peers.
    pub fn new(kind: Kind, queued: &QueuedBytes) -> Self {
        SocketState {
            kind,
            options: Options::default(),
            peers: BTreeMap::new(),
            closed: None,
            last_endpoint: String::new(),
            queued: queued.clone(),
            last_peer: 0,
            turn: Turn::Begin,
            sent_to: 0,
            received_from: 0,
            sending: Vec::new(),
            receiving: VecDeque::new(),
            more: false,
            topics: Vec::new(),
        }
    }

    /// Adds a peer that is not ready yet, and returns its number.
    pub fn add_peer(&mut self) -> u64 {
        self.last_peer += 1;
        let peer = Peer {
            ready: false,
            leaving: false,
            identity: Vec::new(),
            incoming: Queue::new(&self.queued),
            outgoing: Queue::new(&self.queued),
            topics: Vec::new(),
        };
        self.peers.insert(self.last_peer, peer);
        self.last_peer
    }

    /// Marks a peer as ready, after a handshake. Returns false if the socket already has a peer with this identity.
    pub fn peer_is_ready(&mut self, number: u64, identity: Vec<u8>) -> bool {
        let taken = |p: (&u64, &Peer)| *p.0 != number && p.1.ready && p.1.identity == identity;
        if self.kind == Kind::Router && !identity.is_empty() && self.peers.iter().any(taken) {
            return false;
        }
        let topics = self.topics.iter().map(|topic| subscription(1, topic)).collect::<Vec<_>>();
        let Some(peer) = self.peers.get_mut(&number) else { return false };
        peer.ready = true;
        // Identities that a router assigns begin with a zero byte.
        peer.identity =
            if identity.is_empty() { [&[0][..], &(number as u32).to_be_bytes()].concat() } else { identity };
        if self.kind == Kind::Subscribe {
            peer.outgoing.clear();
            topics.into_iter().for_each(|topic| peer.outgoing.push(topic));
        }
        true
    }

    /// Marks a peer as not ready, because its connection has ended.
    pub fn peer_is_lost(&mut self, number: u64) {
        if let Some(peer) = self.peers.get_mut(&number) {
            peer.ready = false;
            peer.topics.clear();
        }
    }

    /// Returns whether a message from a peer can be queued.
    pub fn has_room(&self, number: u64) -> bool {
        let most = self.options.receive_limit();
        self.options.conflate != 0 || self.peers.get(&number).is_none_or(|p| p.incoming.has_room(most))
    }

    /// Queues a message from a peer, or changes the subscriptions of the peer.
    pub fn deposit(&mut self, number: u64, message: Message) {
        let wanted = self.kind != Kind::Subscribe || matches(&self.topics, &message);
        let conflate = self.options.conflate != 0;
        let Some(peer) = self.peers.get_mut(&number) else { return };
        if self.kind == Kind::Publish {
            match message.first().and_then(|part| part.split_first()) {
                Some((1, topic)) if peer.topics.len() < MAX_TOPICS => peer.topics.push(topic.to_vec()),
                Some((0, topic)) => remove(&mut peer.topics, topic),
                _ => {}
            }
        } else if self.kind.receives() && wanted {
            if conflate {
                peer.incoming.clear();
            }
            peer.incoming.push(message);
        }
    }

    /// Subscribes to messages that begin with `topic`.
    pub fn subscribe(&mut self, topic: &[u8]) -> Result<(), Errno> {
        if self.kind != Kind::Subscribe || self.topics.len() >= MAX_TOPICS {
            return Err(Errno::INVALID);
        }
        self.topics.push(topic.to_vec());
        self.announce(1, topic);
        Ok(())
    }

    /// Cancels a subscription.
    pub fn unsubscribe(&mut self, topic: &[u8]) -> Result<(), Errno> {
        if self.kind != Kind::Subscribe || !self.topics.iter().any(|t| t == topic) {
            return Err(Errno::INVALID);
        }
        remove(&mut self.topics, topic);
        self.announce(0, topic);
        Ok(())
    }

    fn announce(&mut self, flag: u8, topic: &[u8]) {
        for peer in self.peers.values_mut().filter(|p| p.ready) {
            peer.outgoing.push(subscription(flag, topic));
        }
    }

    /// Sends a part of a message; `more`: further parts follow. The message is queued when it is complete.
    pub fn send(&mut self, part: &[u8], more: bool) -> Result<(), Errno> {
        self.may_send()?;
        let size = part.len() + self.sending.iter().map(Vec::len).sum::<usize>();
        if size > MAX_MESSAGE_BYTES || self.sending.len() >= MAX_PARTS {
            self.sending.clear();
            return Err(Errno::TOO_LONG);
        }
        self.sending.push(part.to_vec());
        if more {
            return Ok(());
        }
        let message = std::mem::take(&mut self.sending);
        self.route(message).map_err(|(errno, mut message)| {
            // The part is discarded, so that the script can send it again.
            message.pop();
            self.sending = message;
            errno
        })
    }

    fn may_send(&self) -> Result<(), Errno> {
        match (self.kind, &self.turn) {
            (kind, _) if !kind.sends() => Err(Errno::UNSUPPORTED),
            (Kind::Request, Turn::Asked(_)) if self.options.relaxed == 0 => Err(Errno::STATE),
            (Kind::Reply, Turn::Begin) => Err(Errno::STATE),
            _ if !self.receiving.is_empty() && self.kind == Kind::Reply => Err(Errno::STATE),
            _ => Ok(()),
        }
    }

    /// Queues a message for the peers that must receive it. Returns the message together with the error if it cannot be
    /// queued.
    fn route(&mut self, mut message: Message) -> Result<(), (Errno, Message)> {
        let most = self.options.send_limit();
        match self.kind {
            Kind::Publish => {
                for peer in self.peers.values_mut().filter(|p| p.ready && matches(&p.topics, &message)) {
                    if self.options.conflate != 0 {
                        peer.outgoing.clear();
                    }
                    if peer.outgoing.has_room(most) {
                        peer.outgoing.push(message.clone());
                    }
                }
            }
            Kind::Reply => {
                let Turn::Answer(number, mut full) = std::mem::replace(&mut self.turn, Turn::Begin) else {
                    return Err((Errno::STATE, message));
                };
                full.append(&mut message);
                if let Some(peer) = self.peers.get_mut(&number).filter(|p| p.outgoing.has_room(most)) {
                    peer.outgoing.push(full);
                }
            }
            Kind::Router => {
                let Some(identity) = message.first() else { return Ok(()) };
                let mandatory = self.options.router_mandatory != 0;
                match self.peers.values_mut().find(|p| p.ready && p.identity == *identity) {
                    Some(peer) if peer.outgoing.has_room(most) => peer.outgoing.push(message.split_off(1)),
                    Some(_) if mandatory => return Err((Errno::WOULD_BLOCK, message)),
                    None if mandatory => return Err((Errno::UNREACHABLE, message)),
                    _ => {}
                }
            }
            _ => {
                let Some(number) = self.next_receiver() else { return Err((Errno::WOULD_BLOCK, message)) };
                self.sent_to = number;
                let request = self.kind == Kind::Request;
                if let Some(peer) = self.peers.get_mut(&number) {
                    if request {
                        message.insert(0, Vec::new());
                    }
                    if self.options.conflate != 0 {
                        peer.outgoing.clear();
                    }
                    peer.outgoing.push(message);
                }
                if request {
                    self.turn = Turn::Asked(number);
                    self.receiving.clear();
                }
            }
        }
        Ok(())
    }

    /// Returns the next peer in turn to which a message can be sent, or `None` if there is none.
    fn next_receiver(&self) -> Option<u64> {
        let (most, immediate, conflate) =
            (self.options.send_limit(), self.options.immediate != 0, self.options.conflate != 0);
        let open = |p: &Peer| !p.leaving && (p.ready || !immediate) && (conflate || p.outgoing.has_room(most));
        next(&self.peers, self.sent_to, open)
    }

    /// Returns whether a message can be sent.
    pub fn can_send(&self) -> bool {
        self.may_send().is_ok()
            && (matches!(self.kind, Kind::Publish | Kind::Reply | Kind::Router) || self.next_receiver().is_some())
    }

    /// Returns whether a part of a message can be received.
    pub fn can_receive(&mut self) -> bool {
        self.prepare().is_ok()
    }

    /// Returns the next part of an incoming message.
    pub fn receive(&mut self) -> Result<Vec<u8>, Errno> {
        self.prepare()?;
        let part = self.receiving.pop_front().ok_or(Errno::WOULD_BLOCK)?;
        self.more = !self.receiving.is_empty();
        if self.kind == Kind::Request && !self.more {
            self.turn = Turn::Begin;
        }
        Ok(part)
    }

    /// Moves the next message from the queues to `receiving`, unless that still contains parts of a message.
    fn prepare(&mut self) -> Result<(), Errno> {
        if !self.kind.receives() {
            return Err(Errno::UNSUPPORTED);
        }
        while self.receiving.is_empty() {
            let asked = match (self.kind, &self.turn) {
                (Kind::Request, Turn::Asked(number)) => Some(*number),
                (Kind::Request, _) | (Kind::Reply, Turn::Answer(..)) => return Err(Errno::STATE),
                _ => None,
            };
            let Some(number) = next(&self.peers, self.received_from, |p| !p.incoming.is_empty()) else {
                return Err(Errno::WOULD_BLOCK);
            };
            self.received_from = number;
            let Some(peer) = self.peers.get_mut(&number) else { return Err(Errno::WOULD_BLOCK) };
            let Some(mut message) = peer.incoming.pop() else { return Err(Errno::WOULD_BLOCK) };
            match self.kind {
                Kind::Request if asked == Some(number) && message.first().is_some_and(Vec::is_empty) => {
                    message.remove(0);
                }
                // An answer to an earlier request, or without the empty delimiter part, is dropped.
                Kind::Request => continue,
                Kind::Reply => {
                    let Some(end) = message.iter().position(Vec::is_empty) else { continue };
                    let body = message.split_off(end + 1);
                    if body.is_empty() {
                        continue;
                    }
                    self.turn = Turn::Answer(number, message);
                    message = body;
                }
                Kind::Router => message.insert(0, peer.identity.clone()),
                _ => {}
            }
            self.receiving = message.into();
        }
        Ok(())
    }
}

/// Returns the first peer that satisfies `fits`, starting after `last` and wrapping around.
fn next(peers: &BTreeMap<u64, Peer>, last: u64, fits: impl Fn(&Peer) -> bool) -> Option<u64> {
    let rest = peers.range(last + 1..).chain(peers.range(..=last));
    rest.into_iter().find(|(_, peer)| fits(peer)).map(|(number, _)| *number)
}

/// Returns whether a message begins with one of the topics.
fn matches(topics: &[Vec<u8>], message: &Message) -> bool {
    message.first().is_some_and(|part| topics.iter().any(|topic| part.starts_with(topic)))
}

fn subscription(flag: u8, topic: &[u8]) -> Message {
    vec![[&[flag][..], topic].concat()]
}

/// Removes one occurrence of a topic.
fn remove(topics: &mut Vec<Vec<u8>>, topic: &[u8]) {
    if let Some(at) = topics.iter().position(|t| t == topic) {
        topics.remove(at);
    }
}

#[cfg(test)]
mod tests;
