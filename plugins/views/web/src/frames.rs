//! Encodes the motion of objects and joints since the last frame that a client received. Positions are rounded to 0.1
//! mm, quaternions to 1/32767, and joint positions to f32.
//!
//! A frame consists of a byte 1 (frame), a byte 1 (version), two unused bytes, the step as u32, the simulation time in
//! s as f64, the number of entries as u32, and the entries, all in little-endian order. An entry starts with its key, a
//! u32: the handle of the object in the low 24 bits, and the type of the data that follow in the high 8 bits.
//!
//! - Type 0: pose in the parent's frame (position as three i32 in units of 0.1 mm, quaternion as four i16);
//! - type 1: position of a joint (f32, rad or m);
//! - type 2: rotation of a spherical joint (quaternion as four i16).

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_services_common::outbox::OutgoingMessage;

use crate::{plugin::Props, scene::PageScene};

/// First byte of a frame.
const FRAME_TAG: u8 = 1;
/// Number of position units per metre; a unit is 0.1 mm.
const UNITS_PER_METRE: f64 = 1e4;

/// An encoded entry: its key, its data, and the number of data bytes that are used.
pub type FrameEntry = (u32, [u8; 20], u8);

/// The last frame that a client received.
#[derive(Default)]
pub struct SentFrame {
    /// The last entry that was sent, by key.
    entries: BTreeMap<u32, [u8; 20]>,
    /// The step and the simulation time, s; `None` before the first frame.
    at: Option<(u64, f64)>,
}

/// The encoded poses and joint positions of all objects.
#[derive(Default)]
pub struct EncodedMotion {
    entries: Vec<FrameEntry>,
}

/// Writes a quaternion as four i16 in units of 1/32767.
fn write_quaternion(q: &[f64], out: &mut [u8]) {
    for (x, place) in q.iter().zip(out.chunks_exact_mut(2)) {
        place.copy_from_slice(&((x * 32767.0).round() as i16).to_le_bytes());
    }
}

impl EncodedMotion {
    /// Reads and encodes the current poses and joint positions.
    pub fn read(turn: &Turn<'_>, p: &Props, whole: &PageScene) -> Result<EncodedMotion> {
        let mut entries = Vec::with_capacity(whole.ids.len() + whole.joints.len());
        for &id in &whole.ids {
            // Objects removed in the meantime disappear with the next scene message.
            let Ok(pose) = turn.f64s::<7>(id, p.pose) else { continue };
            let mut bytes = [0; 20];
            for (x, place) in pose[..3].iter().zip(bytes.chunks_exact_mut(4)) {
                place.copy_from_slice(&((x * UNITS_PER_METRE).round() as i32).to_le_bytes());
            }
            write_quaternion(&pose[3..], &mut bytes[12..]);
            entries.push((tatu_slot(id), bytes, 20));
        }
        for &(id, spherical) in &whole.joints {
            let mut bytes = [0; 20];
            if spherical {
                let Ok(q) = turn.f64s::<4>(id, p.joint_rotation) else { continue };
                write_quaternion(&q, &mut bytes);
                entries.push((tatu_slot(id) | 2 << 24, bytes, 8));
            } else {
                let Ok(x) = turn.f64(id, p.joint_position) else { continue };
                bytes[..4].copy_from_slice(&(x as f32).to_le_bytes());
                entries.push((tatu_slot(id) | 1 << 24, bytes, 4));
            }
        }
        Ok(EncodedMotion { entries })
    }

    /// Returns a frame with the entries that differ from those of the last frame, and updates `last`. Returns `None` if
    /// nothing has moved and no time has passed.
    pub fn frame_since(&self, last: &mut SentFrame, step: u64, time: f64) -> Option<OutgoingMessage> {
        let mut out = head(step, time);
        let mut count = 0_u32;
        for (key, bytes, len) in &self.entries {
            if last.entries.get(key) != Some(bytes) {
                last.entries.insert(*key, *bytes);
                out.extend_from_slice(&key.to_le_bytes());
                out.extend_from_slice(&bytes[..usize::from(*len)]);
                count += 1;
            }
        }
        if count == 0 && last.at == Some((step, time)) {
            return None;
        }
        last.at = Some((step, time));
        out[16..20].copy_from_slice(&count.to_le_bytes());
        Some(OutgoingMessage::Binary(out.into()))
    }
}

/// Returns a frame in full precision with the entries that differ from `known`, and updates `known`. Entries of types
/// 3, 4 and 5 contain the data of types 0, 1 and 2 as f64, in m and rad.
pub fn exact_frame(
    turn: &Turn<'_>,
    p: &Props,
    whole: &PageScene,
    known: &mut BTreeMap<u32, Vec<f64>>,
    (step, time): (u64, f64),
) -> OutgoingMessage {
    let mut out = head(step, time);
    let mut count = 0_u32;
    let mut put = |key: u32, numbers: &[f64]| {
        if known.get(&key).is_none_or(|k| k != numbers) {
            known.insert(key, numbers.to_vec());
            out.extend_from_slice(&key.to_le_bytes());
            numbers.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
            count += 1;
        }
    };
    let key = |id: tatu_object, kind: u32| tatu_slot(id) | kind << 24;
    for &id in &whole.ids {
        // Objects removed in the meantime disappear with the next scene message.
        if let Ok(pose) = turn.f64s::<7>(id, p.pose) {
            put(key(id, 3), &pose);
        }
    }
    for &(id, spherical) in &whole.joints {
        if spherical {
            if let Ok(q) = turn.f64s::<4>(id, p.joint_rotation) {
                put(key(id, 5), &q);
            }
        } else if let Ok(x) = turn.f64(id, p.joint_position) {
            put(key(id, 4), &[x]);
        }
    }
    out[16..20].copy_from_slice(&count.to_le_bytes());
    OutgoingMessage::Binary(out.into())
}

/// Returns the header of a frame. The number of entries in its last four bytes is 0 and must be set later.
fn head(step: u64, time: f64) -> Vec<u8> {
    let mut out = vec![FRAME_TAG, 1, 0, 0];
    out.extend_from_slice(&(step as u32).to_le_bytes());
    out.extend_from_slice(&time.to_le_bytes());
    out.extend_from_slice(&0_u32.to_le_bytes());
    out
}

/// Converts a handle from a client to an object id, which refers to whatever object now has that handle.
pub fn object_id(n: u32) -> tatu_object {
    tatu_object::from(n) & TATU_SLOT_BITS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changes_are_sent() {
        let mut bytes = [0; 20];
        bytes[0] = 7;
        let now = EncodedMotion { entries: vec![(5, bytes, 20), (6 | 1 << 24, [0; 20], 4)] };
        let mut last = SentFrame::default();
        let len = |m| if let Some(OutgoingMessage::Binary(b)) = m { (b.len(), b[16]) } else { (0, 0) };
        assert_eq!(len(now.frame_since(&mut last, 1, 0.05)), (20 + 24 + 8, 2));
        assert_eq!(len(now.frame_since(&mut last, 2, 0.1)), (20, 0));
        assert!(now.frame_since(&mut last, 2, 0.1).is_none());
    }
}
