//! Error numbers and messages, as ZeroMQ defines them on Linux.

use std::io::{self, ErrorKind};

/// An error number, as `simZMQ.errnum` returns it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Errno(pub i64);

/// Base of the numbers of errors that ZeroMQ defines itself.
const OWN: i64 = 156_384_712;

/// Name, number and message of each error.
pub const ERRORS: &[(&str, i64, &str)] = &[
    ("ENOENT", 2, "No such file or directory"),
    ("EAGAIN", 11, "Resource temporarily unavailable"),
    ("EACCES", 13, "Permission denied"),
    ("EFAULT", 14, "Bad address"),
    ("EINVAL", 22, "Invalid argument"),
    ("EMFILE", 24, "Too many open files"),
    ("ENOTSOCK", 88, "Socket operation on non-socket"),
    ("EMSGSIZE", 90, "Message too long"),
    ("EPROTONOSUPPORT", 93, "Protocol not supported"),
    ("ENOTSUP", 95, "Operation not supported"),
    ("EAFNOSUPPORT", 97, "Address family not supported by protocol"),
    ("EADDRINUSE", 98, "Address already in use"),
    ("EADDRNOTAVAIL", 99, "Cannot assign requested address"),
    ("ENETDOWN", 100, "Network is down"),
    ("ENETUNREACH", 101, "Network is unreachable"),
    ("ENETRESET", 102, "Network dropped connection on reset"),
    ("ECONNABORTED", 103, "Software caused connection abort"),
    ("ECONNRESET", 104, "Connection reset by peer"),
    ("ENOBUFS", 105, "No buffer space available"),
    ("ENOTCONN", 107, "Transport endpoint is not connected"),
    ("ETIMEDOUT", 110, "Connection timed out"),
    ("ECONNREFUSED", 111, "Connection refused"),
    ("EHOSTUNREACH", 113, "Host unreachable"),
    ("EINPROGRESS", 115, "Operation now in progress"),
    ("EFSM", OWN + 51, "Operation cannot be accomplished in current state"),
    ("ENOCOMPATPROTO", OWN + 52, "The protocol is not compatible with the socket type"),
    ("ETERM", OWN + 53, "Context was terminated"),
    ("EMTHREAD", OWN + 54, "No thread available"),
];

impl Errno {
    pub const ABSENT: Errno = Errno(2);
    pub const WOULD_BLOCK: Errno = Errno(11);
    pub const ACCESS: Errno = Errno(13);
    pub const FAULT: Errno = Errno(14);
    pub const INVALID: Errno = Errno(22);
    pub const TOO_MANY: Errno = Errno(24);
    pub const NOT_SOCKET: Errno = Errno(88);
    pub const TOO_LONG: Errno = Errno(90);
    pub const NO_PROTOCOL: Errno = Errno(93);
    pub const UNSUPPORTED: Errno = Errno(95);
    pub const IN_USE: Errno = Errno(98);
    pub const UNREACHABLE: Errno = Errno(113);
    pub const STATE: Errno = Errno(OWN + 51);
    pub const TERMINATED: Errno = Errno(OWN + 53);

    /// Returns the message for the error number.
    pub fn text(self) -> String {
        let known = ERRORS.iter().find(|(_, number, _)| *number == self.0);
        known.map_or_else(|| format!("Unknown error {}", self.0), |(_, _, text)| (*text).to_owned())
    }
}

impl From<io::Error> for Errno {
    fn from(e: io::Error) -> Self {
        match e.kind() {
            ErrorKind::AddrInUse => Errno::IN_USE,
            ErrorKind::AddrNotAvailable => Errno(99),
            ErrorKind::NotFound => Errno::ABSENT,
            ErrorKind::PermissionDenied => Errno::ACCESS,
            _ => Errno(e.raw_os_error().map_or(Errno::INVALID.0, i64::from)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected numbers: `zmq.EFSM` and `zmq.ETERM` as printed by pyzmq 27.3 with libzmq 4.3.5.
    #[test]
    fn numbers_equal_those_of_libzmq() {
        assert_eq!((Errno::STATE.0, Errno::TERMINATED.0), (156_384_763, 156_384_765));
        assert_eq!(Errno::WOULD_BLOCK.text(), "Resource temporarily unavailable");
        assert_eq!(Errno(7777).text(), "Unknown error 7777");
    }
}
