//! Tests of scenes: reading, importing, converting, refusing; and of how bodies in them move.

mod bounds;
mod cards;
mod convert;
mod crowd;
mod edits;
mod folder_changes;
mod folder_errors;
mod folder_limits;
mod folder_models;
mod importers;
mod large;
mod mjcf;
mod mjcf_files;
mod models_at_run;
mod opacity;
mod ranges;
mod reach;
mod removals;
mod robot_files;
mod scene_errors;
mod sdf;
mod textures;
mod urdf;
mod vrep_joints;
mod vrep_registered;
mod vrep_scene;
