//! Tests of the robots that come with the program, against closed forms and the original's behaviour.

mod course;
mod course_scenes;
mod flat;
pub mod manta;
mod manta_model;
mod pioneer_geometry;
mod pioneer_model;
mod pioneer_p3dx;
mod pioneer_sonars;
mod propeller;
mod thruster;
