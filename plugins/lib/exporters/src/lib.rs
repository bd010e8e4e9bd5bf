//! What exporters share.
//!
//! - `numbers`: numbers and rotations as text; `names`: names that are valid and unique in the file; `xml`: XML as text;
//! - `report`: what a format cannot hold;
//! - `objects`: the objects of a scene with their properties; `forms`: the forms of shapes; `joints`: joints;
//! - `mechanism`: the bodies and joints that the objects form; `losses`: what no format holds;
//! - `mesh_files`: meshes as OBJ files;
//! - `command`: the command that an exporter offers.

mod command;
mod forms;
mod joints;
mod losses;
mod mechanism;
mod mesh_files;
mod names;
mod numbers;
mod objects;
mod report;
mod xml;

pub use command::{Export, export_command};
pub use forms::{Form, Look, Surface, ellipsoid_mesh};
pub use joints::{Control, Follow, JointKind, JointProperties};
pub use losses::report_losses;
pub use mechanism::{Attached, Body, Frame, Loop, MassProperties, Mechanisms, Part, Tie};
pub use mesh_files::MeshFiles;
pub use names::NameSpace;
pub use numbers::{number, numbers, roll_pitch_yaw};
pub use objects::{Item, SceneReader, pose_of};
pub use report::{ExportReport, Severity};
pub use xml::XmlWriter;
