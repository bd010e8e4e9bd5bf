//! Empty: the manifest of this package names the features of crates that several packages share.
