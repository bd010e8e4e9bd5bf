//! Robots that come with the program, against closed forms and what the original did.

mod course;
mod course_scenes;
pub mod manta;
mod pioneer_p3dx;
mod thruster;
