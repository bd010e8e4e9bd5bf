//! Tests of the robots that come with the program, against closed forms and the behaviour of V-REP's models.

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
