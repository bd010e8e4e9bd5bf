//! Dummies, cameras, lights, paths and graphs: the specific parts of these objects.

use super::{
    color::{self, Color},
    cursor::{Cursor, ReadResult},
    pose::{IDENTITY, StoredPose, position_first},
    section::{ElementTag, object, tags},
    unknown::UnknownElements,
};

/// The specific part of a dummy.
#[derive(Debug, Clone)]
pub struct Dummy {
    /// Handle of the dummy to which this dummy is linked; -1: not linked.
    pub link: i32,
    /// 0 closes a dynamic loop, 1 applies a pulling force, 5 tip and target, 8 none; others are obsolete.
    pub link_type: i32,
}

impl Default for Dummy {
    fn default() -> Self {
        Dummy { link: -1, link_type: 8 }
    }
}

/// Tags of the elements of dummies.
pub const DUMMY: &[ElementTag<Dummy>] = tags!(Dummy {
    "Lli" => |d, c, _| Ok(d.link = c.i32()?),
    "Dl2" => |d, c, _| Ok(d.link_type = c.i32()?),
});

/// Known elements that are not used, for the user interface and other engines.
pub const DUMMY_IGNORED: &[&str] =
    &["Dy2", "_y2", "Atg", "Var", "Po4", "Po5", "_o5", "Cl0", "Mj1", "_j1", "Dla", "Cv2", "Dlt", "Pob"];

/// The specific part of a camera.
#[derive(Debug, Clone, Default)]
pub struct Camera {
    /// Orthographic size, m, and perspective angle, rad.
    pub size_and_angle: [f64; 2],
    /// Near and far clipping planes, m.
    pub clip: [f64; 2],
    /// Flags. 0x2: perspective projection; before 3.3.
    pub bits: u8,
    /// Projection: -1 as in the view that shows the camera's image, 0 orthographic, 1 perspective.
    pub perspective: Option<i32>,
}

/// Tags of the elements of cameras.
pub const CAMERA: &[ElementTag<Camera>] = tags!(Camera {
    "Cp3" | "_p3" => |k, c, _| Ok(k.size_and_angle = c.reals()?),
    "Ccp" | "_cp" => |k, c, _| Ok(k.clip = c.reals()?),
    "Ca3" => |k, c, _| Ok(k.bits = c.u8()?),
    "Cpm" => |k, c, _| Ok(k.perspective = Some(c.i32()?)),
});

/// Known elements that are not used, for the user interface and other renderers.
pub const CAMERA_IGNORED: &[&str] =
    &["Cp4", "_p4", "Ca2", "Rmd", "Rm2", "Cmp", "Cl1", "Cl2", "Rcm", "Pv1", "Var", "Cv2"];

/// The specific part of a light.
#[derive(Debug, Clone, Default)]
pub struct Light {
    /// 1 omnidirectional, 2 spot, 3 directional.
    pub kind: i32,
    /// Half the cone angle of a spot light, rad.
    pub angle: f64,
    /// Flags. 0x1: the light is on.
    pub bits: u8,
    /// Color of the emitted light.
    pub color: Option<Color>,
}

/// Tags of the elements of lights.
pub const LIGHT: &[ElementTag<Light>] = tags!(Light {
    "Cp2" | "_p2" => |l, c, _| Ok(l.kind = c.i32()?),
    "Cp3" | "_p3" => |l, c, _| Ok(l.angle = c.real()?),
    "Cas" => |l, c, _| Ok(l.bits = c.u8()?),
    "Cl2" => |l, c, u| Ok(l.color = Some(color::read(c, u)?)),
});

/// Known elements that are not used, for other renderers.
pub const LIGHT_IGNORED: &[&str] = &["Caf", "_af", "Cl1", "Pfd", "Var", "Cv2"];

/// A control point of a path.
#[derive(Debug, Clone)]
pub struct PathPoint {
    /// Pose in the frame of the path.
    pub pose: StoredPose,
    /// Rounded fractions of the segments before and after the point, and the number of points of the arc.
    pub bezier: ([f64; 2], i32),
    /// Velocity, as a fraction of the velocity of the path.
    pub velocity: f64,
}

/// A path, in files from before 4.2.
#[derive(Debug, Clone, Default)]
pub struct Path {
    /// Flags. 0x4: the path is closed.
    pub attributes: i32,
    /// Control points, in the order of the path.
    pub points: Vec<PathPoint>,
}

/// Tags of the elements of paths.
pub const PATH: &[ElementTag<Path>] = tags!(Path {
    "Ntp" => |p, c, u| {
        let tags = tags!(Path {
            "Pat" => |p, c, u| {
                let point = point(c, u)?;
                Ok(p.points.push(point))
            },
            "At2" => |p, c, _| Ok(p.attributes = c.i32()?),
        });
        object(c, tags, &["Jm2", "_m2", "Si2", "_i2", "Av2", "Av3", "Av9", "_v9", "Cl0", "Cv2"], p, u).map(drop)
    },
});

/// Known elements that are not used, for the user interface.
pub const PATH_IGNORED: &[&str] = &["Sec", "_ec", "Sha", "Pss", "Scl", "Var", "Cv2", "_ha", "_ss"];

fn point(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<PathPoint> {
    let mut point = PathPoint { pose: IDENTITY, bezier: ([0.0; 2], 1), velocity: 1.0 };
    let tags = tags!(PathPoint {
        "At2" | "_t2" => |p, c, _| {
            p.pose = position_first(c)?;
            p.bezier = (c.reals()?, c.i32()?);
            Ok(p.velocity = c.real()?)
        },
    });
    object(c, tags, &["At3", "_t3", "At4", "_t4", "Cv2"], &mut point, unknown)?;
    Ok(point)
}

/// A recorded stream of a graph.
#[derive(Debug, Clone, Default)]
pub struct GraphStream {
    /// Name of the stream, by which scripts can refer to it.
    pub name: String,
    /// Id of the stream, unique within its graph.
    pub id: i32,
    /// Kind of the recorded data, as a constant of V-REP's API; before 4.0.
    pub data: i32,
    /// Handle of the object whose data is recorded; before 4.0.
    pub object: i32,
    /// Color of the curve: red, green and blue, 0 to 1.
    pub color: [f64; 3],
    /// Unit of the values; since 4.0.
    pub unit: String,
    /// Whether the stream is from before 4.0, when streams were filled by the program instead of by scripts.
    pub old: bool,
}

/// The specific part of a graph.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Maximum number of samples that the graph stores.
    pub buffer: i32,
    /// Whether the graph records only on request.
    pub explicit: bool,
    /// Streams, in the order of the file.
    pub streams: Vec<GraphStream>,
}

impl Default for Graph {
    fn default() -> Self {
        Graph { buffer: 1000, explicit: false, streams: Vec::new() }
    }
}

/// Tags of the elements of graphs.
pub const GRAPH: &[ElementTag<Graph>] = tags!(Graph {
    "Gbv" => |g, c, _| Ok(g.buffer = c.i32()?),
    "Gps" => |g, c, _| Ok(g.explicit = c.u8()? & 16 != 0),
    "Ghd" => |g, c, u| {
        let mut stream = GraphStream { old: true, ..Default::default() };
        let tags = tags!(GraphStream {
            "Nme" => |s, c, _| Ok(s.name = c.text()?),
            "Oid" => |s, c, _| Ok(s.id = c.i32()?),
            "Dt2" => |s, c, _| Ok((s.data, s.object) = (c.i32()?, c.i32()?)),
            "Col" => |s, c, _| Ok(s.color = c.reals()?),
        });
        const IGNORED: &[&str] =
            &["Var", "_ar", "Mac", "Dci", "Pa2", "Par", "Dt9", "_t9", "Bla", "Bli", "Ifd", "_fd", "Cv2", "Dtt", "Zer"];
        object(c, tags, IGNORED, &mut stream, u)?;
        Ok(g.streams.push(stream))
    },
    "Dst" => |g, c, u| {
        let mut stream = GraphStream::default();
        let tags = tags!(GraphStream {
            "Nme" => |s, c, _| Ok((s.name, s.unit) = (c.text()?, c.text()?)),
            "Oid" => |s, c, _| Ok(s.id = c.i32()?),
            "Col" => |s, c, _| Ok(s.color = c.reals()?),
        });
        object(c, tags, &["Sch", "Var", "_ar", "Pa0", "Pts", "_ts", "Cv2"], &mut stream, u)?;
        Ok(g.streams.push(stream))
    },
});

/// Known elements that are not used: curves, recorded values, and those for the user interface.
pub const GRAPH_IGNORED: &[&str] =
    &["Ghg", "_hg", "Cl0", "Cl1", "Gtd", "_td", "Gh2", "Gh3", "Sta", "Cuv", "Cv2", "Col", "Ghr"];

/// Known elements of a script object that are not used.
pub const SCRIPT_IGNORED: &[&str] = &["Sos", "Var", "Soc", "Cv2"];
