//! Serialized state of the engine: a header that identifies the layout, a checksum, and the state.

use xxhash_rust::xxh3::xxh3_64;

use super::engine_state::EngineState;

/// Identifies the layout. It must change with rapier's version and with [`EngineState`].
const HEADER: &[u8; 16] = b"tatu rapier0361k";
const PREFIX_LEN: usize = HEADER.len() + 8;

pub(crate) fn write(state: &EngineState) -> Vec<u8> {
    let mut bytes = HEADER.to_vec();
    bytes.extend_from_slice(&[0; 8]);
    let mut bytes = postcard::to_extend(state, bytes).expect("writing to a vector cannot fail");
    let sum = xxh3_64(&bytes[PREFIX_LEN..]);
    bytes[HEADER.len()..PREFIX_LEN].copy_from_slice(&sum.to_le_bytes());
    bytes
}

pub(crate) fn read(bytes: &[u8]) -> Result<EngineState, String> {
    let (head, rest) = bytes.split_at_checked(HEADER.len()).ok_or("the physics snapshot has no header")?;
    if head != HEADER {
        return Err("the physics snapshot was written by a different engine or version".to_string());
    }
    let (sum, state) = rest.split_first_chunk::<8>().ok_or("the physics snapshot has no checksum")?;
    // Rapier relies on the indices in its state, so damage must be detected before it is read.
    if xxh3_64(state) != u64::from_le_bytes(*sum) {
        return Err("the physics snapshot is damaged: its checksum does not match".to_string());
    }
    postcard::from_bytes(state).map_err(|e| format!("the physics snapshot cannot be decoded: {e}"))
}
