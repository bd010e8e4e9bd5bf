//! Communication tubes, which transfer packets between two scripts in order.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

/// All tubes of a world.
#[derive(Default, Clone, PartialEq, Debug, Serialize, Deserialize)]
pub(crate) struct Tubes {
    tubes: Vec<Tube>,
    next: i64,
}

#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
struct Tube {
    header: i64,
    name: Vec<u8>,
    ends: [TubeEnd; 2],
}

#[derive(Default, Clone, PartialEq, Debug, Serialize, Deserialize)]
struct TubeEnd {
    /// The handle of this end (0, 2, 4, ...), or `None` while no script has opened it.
    handle: Option<i64>,
    room: usize,
    packets: VecDeque<Vec<u8>>,
}

impl Tubes {
    pub(crate) fn open(&mut self, header: i64, name: Vec<u8>, room: i64) -> Option<i64> {
        let known = self.tubes.iter().position(|t| t.header == header && t.name == name);
        let tube = match known {
            Some(i) => &mut self.tubes[i],
            None => {
                self.tubes.push(Tube { header, name, ends: Default::default() });
                self.tubes.last_mut()?
            }
        };
        let end = tube.ends.iter_mut().find(|e| e.handle.is_none())?;
        end.handle = Some(self.next);
        end.room = room.clamp(1, 10_000) as usize;
        end.packets.clear();
        self.next += 2;
        end.handle
    }
    /// Returns the tube to which a handle belongs, and the index of its end.
    fn find(&mut self, handle: i64) -> Option<(&mut Tube, usize)> {
        self.tubes.iter_mut().find_map(|t| {
            let end = t.ends.iter().position(|e| e.handle == Some(handle))?;
            Some((t, end))
        })
    }
    pub(crate) fn write(&mut self, handle: i64, data: Vec<u8>) -> bool {
        let Some((tube, end)) = self.find(handle) else {
            return false;
        };
        let other = &mut tube.ends[1 - end];
        if other.handle.is_none() || data.is_empty() {
            return false;
        }
        if other.packets.len() == other.room {
            other.packets.pop_front();
        }
        other.packets.push_back(data);
        true
    }
    pub(crate) fn read(&mut self, handle: i64) -> Option<Vec<u8>> {
        let (tube, end) = self.find(handle)?;
        tube.ends[end].packets.pop_front()
    }
    pub(crate) fn status(&mut self, handle: i64) -> Option<(bool, usize, usize)> {
        let (tube, end) = self.find(handle)?;
        let (here, there) = (&tube.ends[end], &tube.ends[1 - end]);
        Some((there.handle.is_some(), here.packets.len(), there.packets.len()))
    }
    /// Closes an end. Packets that were sent before it was closed can still be read at the other end.
    pub(crate) fn close(&mut self, handle: i64) -> bool {
        let Some((tube, end)) = self.find(handle) else {
            return false;
        };
        tube.ends[end] = TubeEnd::default();
        self.tubes.retain(|t| t.ends.iter().any(|e| e.handle.is_some()));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tube_connects_exactly_two_scripts() {
        let mut t = Tubes::default();
        let a = t.open(0, b"x".to_vec(), 1).unwrap();
        assert!(!t.write(a, b"lost".to_vec()));
        let b = t.open(0, b"x".to_vec(), 2).unwrap();
        assert_ne!(a, b);
        assert_eq!(t.open(0, b"x".to_vec(), 1), None);
        assert!(t.open(1, b"x".to_vec(), 1).is_some());
        for packet in [b"1", b"2", b"3"] {
            assert!(t.write(a, packet.to_vec()));
        }
        assert_eq!(t.status(a), Some((true, 0, 2)));
        assert_eq!(t.read(b), Some(b"2".to_vec()), "the oldest was dropped");
        assert!(t.close(a));
        assert_eq!(t.read(b), Some(b"3".to_vec()));
        assert!(!t.write(a, b"gone".to_vec()));
        assert_eq!(t.status(b), Some((false, 0, 0)));
    }
}
