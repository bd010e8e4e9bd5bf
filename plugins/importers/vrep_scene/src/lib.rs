//! Scene and model files of V-REP and CoppeliaSim: `.ttt` and `.ttm`.
//!
//! `read` decodes a file and knows nothing of Tatu; `describe` tells what is in it; `build` makes a scene of it.

mod describe;
pub mod read;
