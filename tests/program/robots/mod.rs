//! Tests of the robots that come with the program, against closed forms and the original's behaviour.

mod course;
mod course_scenes;
pub mod manta;
mod pioneer_p3dx;
mod thruster;
