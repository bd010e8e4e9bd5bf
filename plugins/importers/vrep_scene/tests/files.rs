//! Tests with small files that are built byte by byte.

use proptest::prelude::*;
use tatu_importers_vrep_scene::read::{
    common,
    file::{ObjectKind, VrepFile},
    test_files::{ElementBytes, file},
};

/// Returns the common part of an object: handle, parent, name.
fn object(id: i32, parent: i32, name: &str) -> ElementBytes {
    ElementBytes::new()
        .element("Ids", ElementBytes::new().i32(id).i32(parent))
        .element("Nme", ElementBytes::new().text(name))
        .element("Cfq", ElementBytes::new().f32(&[1.0, 0.0, 0.0, 0.0, 0.5, -0.25, 2.0]))
        .mark("NXT")
}

fn read(sections: ElementBytes) -> VrepFile {
    VrepFile::read(&file(25, &sections.mark("EOF").0)).unwrap()
}

fn refused(sections: ElementBytes) -> String {
    VrepFile::read(&file(25, &sections.0)).err().expect("it is refused").to_string()
}

#[test]
fn objects_have_parents_and_poses() {
    let f = read(
        ElementBytes::new()
            .element("DMY", object(7, -1, "base#3").mark("EOO"))
            .element("DMY", object(9, 7, "tip").element("Lli", ElementBytes::new().i32(7)).mark("EOO")),
    );
    let [base, tip] = f.objects.as_slice() else { panic!("two objects") };
    assert_eq!((base.common.id, base.common.parent, base.common.alias()), (7, -1, "base".into()));
    // A pose is a quaternion w x y z, then a position.
    assert_eq!(tip.common.pose, [1.0, 0.0, 0.0, 0.0, 0.5, -0.25, 2.0]);
    assert!(matches!(&tip.kind, ObjectKind::Dummy(d) if d.link == 7));
}

#[test]
fn single_and_double_precision_numbers_are_read() {
    let joint = |of: ElementBytes| {
        let f = read(ElementBytes::new().element("JNT", object(1, -1, "j").bytes(&of.0).mark("EOO")));
        match &f.objects[0].kind {
            ObjectKind::Joint(j) => (j.kind, j.position, j.drive.target_velocity, j.drive.max_force),
            _ => panic!("a joint"),
        }
    };
    let kind = ElementBytes::new().element("Jtt", ElementBytes::new().i32(11));
    let single = kind.clone().element("Prt", ElementBytes::new().f32(&[0.5]));
    let double = kind.element("_rt", ElementBytes::new().bytes(&0.5_f64.to_le_bytes()));
    assert_eq!(joint(single), joint(double.clone()));
    // A force may be stored as a negative number.
    let driven = double.element("Dmp", ElementBytes::new().f32(&[2.0, -3.0]));
    assert_eq!(joint(driven), (11, 0.5, 2.0, 3.0));
}

#[test]
fn points_of_a_path_are_read() {
    let point = ElementBytes::new()
        .element("At2", ElementBytes::new().f32(&[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.9, 0.8]).i32(15).f32(&[1.0]))
        .mark("EOO");
    let ways = ElementBytes::new()
        .element("Pat", point.clone())
        .element("Pat", point)
        .element("At2", ElementBytes::new().i32(4));
    let f = read(ElementBytes::new().element("PAT", object(1, -1, "way").element("Ntp", ways.mark("EOO")).mark("EOO")));
    let ObjectKind::Path(path) = &f.objects[0].kind else { panic!("a path") };
    assert_eq!((path.points.len(), path.attributes), (2, 4));
    assert_eq!(path.points[0].pose, [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
    assert_eq!(path.points[0].bezier.1, 15);
}

#[test]
fn camera_angles_and_light_states_are_read() {
    let f = read(
        ElementBytes::new()
            .element("CMA", object(1, -1, "c").element("Cp3", ElementBytes::new().f32(&[2.0, 1.5])).mark("EOO"))
            .element("LGT", object(2, -1, "l").element("Cas", ElementBytes::new().bytes(&[1])).mark("EOO")),
    );
    assert!(matches!(&f.objects[0].kind, ObjectKind::Camera(k) if k.size_and_angle == [2.0, 1.5]));
    assert!(matches!(&f.objects[1].kind, ObjectKind::Light(l) if l.bits == 1));
}

#[test]
fn collections_windows_and_pairs_are_read_separately() {
    let item = ElementBytes::new()
        .element("Obj", ElementBytes::new().i32(5).i32(0))
        .element("Gty", ElementBytes::new().bytes(&[1]))
        .element("Var", ElementBytes::new().bytes(&[0]))
        .mark("EOO");
    let group = ElementBytes::new()
        .element("Grn", ElementBytes::new().text("g"))
        .element("Gix", ElementBytes::new().i32(2_000_000));
    let button = ElementBytes::new().i32(2).i32(3).i32(1).i32(1).i32(0).i32(0).text("up").text("down").f32(&[250.0]);
    let window = ElementBytes::new()
        .element("Bkh", ElementBytes::new().i32(2_060_000))
        .element("Bkn", ElementBytes::new().text("w"))
        .element("Btn", ElementBytes::new().element("Bva", button).mark("EOO"));
    let distance = ElementBytes::new()
        .element("Nme", ElementBytes::new().text("d"))
        .element("Inx", ElementBytes::new().i32(5).i32(-1).i32(2_020_000))
        .element("Trh", ElementBytes::new().f32(&[0.5]))
        .element("Var", ElementBytes::new().bytes(&[0b101]));
    let f = read(
        ElementBytes::new()
            .element("GRP", group.element("Asg", item).mark("EOO"))
            .element("BBK", window.mark("EOO"))
            .element("DST", distance.mark("EOO")),
    );
    let item = &f.collections[0].items[0];
    assert_eq!((item.object, item.kind, item.remove), (5, 1, true));
    let button = &f.windows[0].buttons[0];
    assert_eq!((button.handle, button.labels[1].as_str(), button.slider), (3, "down", 250.0));
    let pair = &f.distances[0];
    assert_eq!((pair.of, pair.threshold, pair.explicit), ([5, -1], 0.5, true));
}

#[test]
fn unknown_elements_are_recorded_with_their_path() {
    let f = read(
        ElementBytes::new()
            .element("ZZZ", ElementBytes::new().bytes(b"whatever"))
            .element("DMY", object(1, -1, "d").element("Qqq", ElementBytes::new().i32(5)).mark("EOO")),
    );
    let known: Vec<(&str, usize)> = f.unknown.all.iter().map(|(p, u)| (p.as_str(), u.count)).collect();
    assert_eq!(known, [("DMY/Qqq", 1), ("ZZZ", 1)]);
    assert_eq!(f.unknown.all["ZZZ"].spans[0].of(&f.data), b"whatever");
}

#[test]
fn object_of_an_unknown_kind_is_read() {
    let (tag, bytes) = common::SIGNATURE;
    let of =
        ElementBytes::new().element(tag, ElementBytes::new().bytes(bytes)).bytes(&object(4, -1, "new").0).mark("EOO");
    let f = read(ElementBytes::new().element("NEW", of));
    assert_eq!((f.objects.len(), f.objects[0].kind_name(), f.objects[0].common.id), (1, "unknown", 4));
}

#[test]
fn contradictory_file_is_refused_with_its_section() {
    let dummy = |id, parent| object(id, parent, "d").mark("EOO");
    let twice = ElementBytes::new().element("DMY", dummy(1, -1)).element("DMY", dummy(1, -1)).mark("EOF");
    assert!(refused(twice).contains("two objects have the handle 1"));
    let circle = ElementBytes::new().element("DMY", dummy(1, 2)).element("DMY", dummy(2, 1)).mark("EOF");
    assert!(refused(circle).contains("is its own ancestor"));
    let lies = ElementBytes::new().bytes(b"DMY").i32(1_000_000).bytes(&[0; 8]);
    assert_eq!(
        refused(lies),
        "byte 0 of the unpacked data, in section DMY: the section declares 1000000 bytes, but only 8 remain"
    );
    assert!(refused(ElementBytes::new().element("DMY", dummy(1, -1))).contains("ends without `EOF`"));
    let short = object(1, -1, "d").element("Lli", ElementBytes::new().bytes(&[0; 3])).mark("EOO");
    assert!(
        refused(ElementBytes::new().element("DMY", short).mark("EOF"))
            .contains("in section DMY/Lli: expected 4 more bytes")
    );
    let mut deep = ElementBytes::new();
    for _ in 0..100 {
        deep = ElementBytes::new().element("Gv3", deep);
    }
    // The nesting depth is limited, and unknown sections are not parsed.
    let _ =
        VrepFile::read(&file(25, &ElementBytes::new().element("SHP", object(1, -1, "s").bytes(&deep.0)).mark("EOF").0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// For any content of a section, reading terminates with a file or an error.
    #[test]
    fn any_bytes_end_well(tag in "[A-Z][A-Za-z][A-Za-z0-9]", of in proptest::collection::vec(any::<u8>(), 0..300)) {
        let sections = object(1, -1, "o").element(&tag, ElementBytes::new().bytes(&of)).mark("EOO");
        for kind in ["SHP", "JNT", "SNR", "RSN", "GRH", "PAT", "CMA", "LGT", "SCT"] {
            let _ = VrepFile::read(&file(25, &ElementBytes::new().element(kind, sections.clone()).mark("EOF").0));
        }
    }
}
