//! Tests with small files that are built byte by byte.

use proptest::prelude::*;
use tatu_importers_vrep_scene::read::{
    common,
    file::{File, Kind},
    made::{Bytes, file},
};

/// Returns the common part of an object: handle, parent, name.
fn object(id: i32, parent: i32, name: &str) -> Bytes {
    Bytes::new()
        .element("Ids", Bytes::new().i32(id).i32(parent))
        .element("Nme", Bytes::new().text(name))
        .element("Cfq", Bytes::new().f32(&[1.0, 0.0, 0.0, 0.0, 0.5, -0.25, 2.0]))
        .mark("NXT")
}

fn read(sections: Bytes) -> File {
    File::read(&file(25, &sections.mark("EOF").0)).unwrap()
}

fn refused(sections: Bytes) -> String {
    File::read(&file(25, &sections.0)).err().expect("it is refused").to_string()
}

#[test]
fn an_object_has_its_place_in_the_tree() {
    let f = read(
        Bytes::new()
            .element("DMY", object(7, -1, "base#3").mark("EOO"))
            .element("DMY", object(9, 7, "tip").element("Lli", Bytes::new().i32(7)).mark("EOO")),
    );
    let [base, tip] = f.objects.as_slice() else { panic!("two objects") };
    assert_eq!((base.common.id, base.common.parent, base.common.alias()), (7, -1, "base".into()));
    // A pose is a quaternion w x y z, then a position.
    assert_eq!(tip.common.pose, [1.0, 0.0, 0.0, 0.0, 0.5, -0.25, 2.0]);
    assert!(matches!(&tip.kind, Kind::Dummy(d) if d.link == 7));
}

#[test]
fn of_two_forms_of_a_number_both_are_read() {
    let joint = |of: Bytes| {
        let f = read(Bytes::new().element("JNT", object(1, -1, "j").bytes(&of.0).mark("EOO")));
        match &f.objects[0].kind {
            Kind::Joint(j) => (j.kind, j.position, j.target_velocity, j.max_force),
            _ => panic!("a joint"),
        }
    };
    let kind = Bytes::new().element("Jtt", Bytes::new().i32(11));
    let single = kind.clone().element("Prt", Bytes::new().f32(&[0.5]));
    let double = kind.element("_rt", Bytes::new().bytes(&0.5_f64.to_le_bytes()));
    assert_eq!(joint(single), joint(double.clone()));
    // A force may be stored as a negative number.
    let driven = double.element("Dmp", Bytes::new().f32(&[2.0, -3.0]));
    assert_eq!(joint(driven), (11, 0.5, 2.0, 3.0));
}

#[test]
fn a_path_keeps_its_points() {
    let point = Bytes::new()
        .element("At2", Bytes::new().f32(&[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.9, 0.8]).i32(15).f32(&[1.0]))
        .mark("EOO");
    let ways = Bytes::new().element("Pat", point.clone()).element("Pat", point).element("At2", Bytes::new().i32(4));
    let f = read(Bytes::new().element("PAT", object(1, -1, "way").element("Ntp", ways.mark("EOO")).mark("EOO")));
    let Kind::Path(path) = &f.objects[0].kind else { panic!("a path") };
    assert_eq!((path.points.len(), path.attributes), (2, 4));
    assert_eq!(path.points[0].pose, [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
    assert_eq!(path.points[0].bezier.1, 15);
}

#[test]
fn cameras_and_lights_tell_how_they_see_and_shine() {
    let f = read(
        Bytes::new()
            .element("CMA", object(1, -1, "c").element("Cp3", Bytes::new().f32(&[2.0, 1.5])).mark("EOO"))
            .element("LGT", object(2, -1, "l").element("Cas", Bytes::new().bytes(&[1])).mark("EOO")),
    );
    assert!(matches!(&f.objects[0].kind, Kind::Camera(k) if k.sees == [2.0, 1.5]));
    assert!(matches!(&f.objects[1].kind, Kind::Light(l) if l.bits == 1));
}

#[test]
fn collections_windows_and_pairs_stand_beside_the_objects() {
    let item = Bytes::new()
        .element("Obj", Bytes::new().i32(5).i32(0))
        .element("Gty", Bytes::new().bytes(&[1]))
        .element("Var", Bytes::new().bytes(&[0]))
        .mark("EOO");
    let group = Bytes::new().element("Grn", Bytes::new().text("g")).element("Gix", Bytes::new().i32(2_000_000));
    let button = Bytes::new().i32(2).i32(3).i32(1).i32(1).i32(0).i32(0).text("up").text("down").f32(&[250.0]);
    let window = Bytes::new()
        .element("Bkh", Bytes::new().i32(2_060_000))
        .element("Bkn", Bytes::new().text("w"))
        .element("Btn", Bytes::new().element("Bva", button).mark("EOO"));
    let distance = Bytes::new()
        .element("Nme", Bytes::new().text("d"))
        .element("Inx", Bytes::new().i32(5).i32(-1).i32(2_020_000))
        .element("Trh", Bytes::new().f32(&[0.5]))
        .element("Var", Bytes::new().bytes(&[0b101]));
    let f = read(
        Bytes::new()
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
fn what_nobody_understands_is_kept_where_it_stands() {
    let f = read(
        Bytes::new()
            .element("ZZZ", Bytes::new().bytes(b"whatever"))
            .element("DMY", object(1, -1, "d").element("Qqq", Bytes::new().i32(5)).mark("EOO")),
    );
    let known: Vec<(&str, usize)> = f.unknown.all.iter().map(|(p, u)| (p.as_str(), u.count)).collect();
    assert_eq!(known, [("DMY/Qqq", 1), ("ZZZ", 1)]);
    assert_eq!(f.unknown.all["ZZZ"].spans[0].of(&f.data), b"whatever");
}

#[test]
fn an_object_of_a_kind_to_come_has_its_place_in_the_tree() {
    let (tag, bytes) = common::SIGNATURE;
    let of = Bytes::new().element(tag, Bytes::new().bytes(bytes)).bytes(&object(4, -1, "new").0).mark("EOO");
    let f = read(Bytes::new().element("NEW", of));
    assert_eq!((f.objects.len(), f.objects[0].word(), f.objects[0].common.id), (1, "unknown", 4));
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let dummy = |id, parent| object(id, parent, "d").mark("EOO");
    let twice = Bytes::new().element("DMY", dummy(1, -1)).element("DMY", dummy(1, -1)).mark("EOF");
    assert!(refused(twice).contains("two objects have the handle 1"));
    let circle = Bytes::new().element("DMY", dummy(1, 2)).element("DMY", dummy(2, 1)).mark("EOF");
    assert!(refused(circle).contains("is its own ancestor"));
    let lies = Bytes::new().bytes(b"DMY").i32(1_000_000).bytes(&[0; 8]);
    assert_eq!(
        refused(lies),
        "byte 0 of the unpacked data, in section DMY: the section declares 1000000 bytes, but only 8 remain"
    );
    assert!(refused(Bytes::new().element("DMY", dummy(1, -1))).contains("ends without `EOF`"));
    let short = object(1, -1, "d").element("Lli", Bytes::new().bytes(&[0; 3])).mark("EOO");
    assert!(
        refused(Bytes::new().element("DMY", short).mark("EOF")).contains("in section DMY/Lli: expected 4 more bytes")
    );
    let mut deep = Bytes::new();
    for _ in 0..100 {
        deep = Bytes::new().element("Gv3", deep);
    }
    // The nesting depth is limited, and unknown sections are not parsed.
    let _ = File::read(&file(25, &Bytes::new().element("SHP", object(1, -1, "s").bytes(&deep.0)).mark("EOF").0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// For any content of a section, reading terminates with a file or an error.
    #[test]
    fn any_bytes_end_well(tag in "[A-Z][A-Za-z][A-Za-z0-9]", of in proptest::collection::vec(any::<u8>(), 0..300)) {
        let sections = object(1, -1, "o").element(&tag, Bytes::new().bytes(&of)).mark("EOO");
        for kind in ["SHP", "JNT", "SNR", "RSN", "GRH", "PAT", "CMA", "LGT", "SCT"] {
            let _ = File::read(&file(25, &Bytes::new().element(kind, sections.clone()).mark("EOF").0));
        }
    }
}
