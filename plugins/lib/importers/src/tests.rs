//! Tests with small files of all formats, and with the same files truncated or with modified bytes.

use base64::{Engine as _, engine::general_purpose::STANDARD};

use super::*;

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendloop\nendfacet\nendsolid a\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment a triangle\nelement vertex 3\nproperty double x\nproperty double y\n\
    property double z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 9\n1 0 0 9\n0 2 0 9\n3 0 1 2\n";
const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1 2 3\nusemtl wood\nf 1/1 3/3 2/2\n";
const MTL: &str = "newmtl red\nKd 1 0 0\nnewmtl wood\nKd 0.5 0.5 0.5\nmap_Kd -s 1 1 1 wood.png\n";

/// A triangle in mm, moved up by a node, rotated by another node, and instantiated twice.
const DAE: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="img"><init_from>wood.png</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON>
<newparam sid="surf"><surface type="2D"><init_from>img</init_from></surface></newparam>
<newparam sid="samp"><sampler2D><source>surf</source></sampler2D></newparam>
<technique sid="common"><lambert><diffuse><texture texture="samp" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect><effect id="fy"><profile_COMMON><technique><phong><diffuse><color>0 1 0 1</color></diffuse></phong>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#fx"/></material><material id="n"><instance_effect url="#fy"/></material>
</library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1000 0 0 1000 2000 0 0 2000 0</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"/></technique_common></source>
<source id="t"><float_array id="ta" count="8">0 0 1 0 1 1 0 1</float_array>
<technique_common><accessor source="#ta" count="4" stride="2"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist material="sym" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="1" set="0"/><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>
<triangles material="other" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">
<node><translate>0 0 1000</translate><node><rotate>0 0 1 90</rotate><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="sym" target="#m"/><instance_material symbol="other" target="#n"/>
</technique_common></bind_material></instance_geometry></node></node>
<node><matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="sym" target="#m"/><instance_material symbol="other" target="#n"/>
</technique_common></bind_material></instance_geometry></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

/// A triangle with a height of 2 m, whose node is moved by 5 m, and whose colour is linear.
fn gltf() -> String {
    let mut buffer = Vec::new();
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    let places: [f32; 6] = [0.0, 1.0, 1.0, 1.0, 0.0, 0.0];
    positions.iter().chain(&places).for_each(|x| buffer.extend(x.to_le_bytes()));
    [0u16, 1, 2].iter().for_each(|x| buffer.extend(x.to_le_bytes()));
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0, "translation": [5, 0, 0]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.2158605, 1, 0, 1],
            "baseColorTexture": {{"index": 0}}}}}}],
        "textures": [{{"source": 0}}], "images": [{{"uri": "wood.png"}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0]}},
            {{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}},
            {{"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 24}},
            {{"buffer": 0, "byteOffset": 60, "byteLength": 6}}],
        "buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream;base64,{}"}}]}}"#,
        buffer.len(),
        STANDARD.encode(&buffer)
    )
}

/// Returns the files next to the mesh: an image of one brown pixel, and the materials of the OBJ file.
fn neighbouring_file(name: &str) -> Option<Vec<u8>> {
    match name {
        "a.mtl" => Some(MTL.into()),
        "wood.png" => {
            let mut out = std::io::Cursor::new(Vec::new());
            image::RgbaImage::from_pixel(1, 1, image::Rgba([90, 60, 30, 255]))
                .write_to(&mut out, image::ImageOutputFormat::Png)
                .ok()?;
            Some(out.into_inner())
        }
        _ => None,
    }
}

fn read_without_notes(bytes: &[u8]) -> MeshModel {
    let read = read("", bytes, &neighbouring_file).unwrap();
    assert_eq!(read.notes, Vec::<String>::new());
    read.model
}

#[test]
fn all_formats_yield_the_same_triangle() {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let mut binary = vec![b'x'; 80];
    binary.extend(1u32.to_le_bytes());
    for x in [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0] {
        binary.extend(x.to_le_bytes());
    }
    binary.extend([0, 0]);
    let misleading = [b"solid of a program that calls all files so".as_slice(), &binary[42..]].concat();
    for bytes in [STL.as_bytes(), PLY.as_bytes(), OBJ.as_bytes(), &binary, &misleading] {
        assert_eq!(read_without_notes(bytes).pieces[0].points, points);
        assert_eq!(read_without_notes(bytes).pieces[0].triangles, [[0, 1, 2]]);
    }
    assert_eq!(read_without_notes(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").pieces[0].triangles.len(), 2);
    let fan = read_without_notes(PLY.replace("3 0 1 2", "4 0 1 2 1").as_bytes());
    assert_eq!(fan.pieces[0].triangles, [[0, 1, 2], [0, 2, 1]]);
}

/// Numbers with all digits are read exactly, and points retain their order.
#[test]
fn ply_numbers_are_read_exactly() {
    let text = PLY.replace("1 0 0 9", "0.1 1e-300 -123456.78901234567 9");
    assert_eq!(read_without_notes(text.as_bytes()).pieces[0].points[1], [0.1, 1e-300, -123456.78901234567]);
    let text = PLY.replace("uchar red", "float s\nproperty float t").replace(" 9\n", " 0.25 0.5\n");
    assert_eq!(read_without_notes(text.as_bytes()).pieces[0].coordinates, [[0.25, 0.5]; 3]);
}

#[test]
fn obj_is_divided_into_one_piece_per_material() {
    let [red, wood] = &read_without_notes(OBJ.as_bytes()).pieces[..] else { panic!("two materials") };
    assert_eq!((red.color, red.picture.is_some()), (Some([1.0, 0.0, 0.0]), false));
    assert_eq!(wood.coordinates, [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
    assert_eq!(wood.picture.as_ref().unwrap().rgba, [90, 60, 30, 255]);
    let alone = read("", OBJ.as_bytes(), &|_| None).unwrap();
    assert_eq!((alone.model.pieces.len(), alone.notes.len()), (1, 1), "{:?}", alone.notes);
    let without = read("", OBJ.as_bytes(), &|name| neighbouring_file(name).filter(|_| name == "a.mtl")).unwrap();
    assert_eq!(without.model.pieces.len(), 2);
    assert!(without.notes[0].contains("`wood.png`"), "{:?}", without.notes);
}

#[test]
fn opacity_of_obj_materials_is_d_or_one_minus_tr() {
    let opacity = |more: &str| {
        let files = |name: &str| match name {
            "a.mtl" => Some(format!("newmtl red\nKd 1 0 0\n{more}\n").into_bytes()),
            _ => None,
        };
        read("", OBJ.as_bytes(), &files).unwrap().model.pieces[0].opacity
    };
    for (line, wanted) in [("d 0.25", Some(0.25)), ("Tr 0.75", Some(0.25)), ("d 1", None), ("Tr 0", None), ("", None)] {
        assert_eq!(opacity(line), wanted, "`{line}`");
    }
}

#[test]
fn collada_geometries_are_transformed_by_their_nodes() {
    let [wood, green] = &read_without_notes(DAE.as_bytes()).pieces[..] else { panic!("two materials") };
    assert_eq!((wood.points.len(), wood.triangles.len(), green.triangles.len()), (8, 4, 2));
    // The triangle was moved up by 1 m and rotated, so that x became y.
    let near = |p: [f64; 3], q: [f64; 3]| p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(wood.points[1], [0.0, 1.0, 1.0]) && near(wood.points[2], [-2.0, 1.0, 1.0]), "{:?}", wood.points);
    // The second instance is mirrored, but its outside still faces up.
    assert!(near(wood.points[5], [-1.0, 0.0, 0.0]));
    let up = |t: [u32; 3]| {
        let [a, b, c] = t.map(|i| nalgebra::Vector3::from(wood.points[i as usize]));
        (b - a).cross(&(c - a)).z
    };
    assert!(wood.triangles.iter().all(|t| up(*t) > 0.0));
    assert_eq!(wood.coordinates[..4], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(wood.picture.as_ref().unwrap().columns, 1);
    assert_eq!(green.color, Some([0.0, 1.0, 0.0]));
    assert!(read_without_notes(DAE.replace("Z_UP", "Y_UP").as_bytes()).y_up);
}

#[test]
fn gltf_meshes_are_transformed_by_their_nodes() {
    let mut model = read_without_notes(gltf().as_bytes());
    let piece = &model.pieces[0];
    assert_eq!(piece.points[1], [6.0, 0.0, 0.0]);
    assert_eq!(piece.coordinates, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], "the origin is the lower left corner");
    let [r, g, b] = piece.color.unwrap();
    assert!((r - 0.502).abs() < 1e-3 && (g - 1.0).abs() < 1e-9 && b == 0.0, "{r} {g} {b}");
    assert!(piece.picture.is_some());
    model.turn_y_up_to_z_up();
    assert_eq!(model.pieces[0].points[2], [5.0, 0.0, 2.0], "the y axis of the file becomes the z axis");
}

/// The alpha of a material has an effect only if its mode is BLEND.
#[test]
fn opacity_of_gltf_materials_is_the_blended_alpha() {
    let clear = gltf().replace("[0.2158605, 1, 0, 1]", "[0.2158605, 1, 0, 0.25]");
    assert_eq!(read_without_notes(clear.as_bytes()).pieces[0].opacity, None);
    let blended = clear.replace("\"materials\": [{", "\"materials\": [{\"alphaMode\": \"BLEND\", ");
    assert_eq!(read_without_notes(blended.as_bytes()).pieces[0].opacity, Some(0.25));
}

/// A binary file with the same content is read identically.
#[test]
fn binary_gltf_equals_gltf_text() {
    let text = gltf();
    let (before, after) = text.split_once(", \"uri\": \"data:application/octet-stream;base64,").unwrap();
    let (data, after) = after.split_once('"').unwrap();
    let json = format!("{before}{after}");
    let body = STANDARD.decode(data).unwrap();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() + body.len()).to_le_bytes().iter().take(4));
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", &body)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    assert_eq!(read_without_notes(&bytes), read_without_notes(text.as_bytes()));
    for n in 0..bytes.len() {
        let _ = read("", &bytes[..n], &neighbouring_file);
        let mut wrong = bytes.clone();
        wrong[n] ^= 0x55;
        let _ = read("", &wrong, &neighbouring_file);
    }
}

/// A file of a few lines whose nodes would be visited 2^40 times is rejected immediately.
#[test]
fn nodes_that_refer_to_each_other_twice_are_refused() {
    let chain: String = (0..40)
        .map(|i| format!("<node id='n{i}'><instance_node url='#n{0}'/><instance_node url='#n{0}'/></node>", i + 1))
        .collect();
    let error =
        read("", DAE.replace("<node><translate>", &format!("{chain}<node><translate>")).as_bytes(), &neighbouring_file);
    assert!(error.unwrap_err().contains("nodes in total"));
    let nodes: String = (1..=40).map(|i| format!(", {{\"children\": [{0}, {0}]}}", i + 1)).collect();
    let text = gltf().replace("\"translation\": [5, 0, 0]}", &format!("\"children\": [1, 1]}}{nodes}, {{}}"));
    assert!(read("", text.as_bytes(), &neighbouring_file).unwrap_err().contains("nodes in total"));
}

/// Geometries without an id are distinguished.
#[test]
fn collada_without_a_scene_yields_all_geometries() {
    let text = DAE.replace("<scene><instance_visual_scene url=\"#s\"/></scene>", "");
    let (begin, end) = (text.find("<geometry ").unwrap(), text.find("</library_geometries>").unwrap());
    let second = text[begin..end].replace("id=\"g\"", "").replace("<p>0 1 2</p>", "<p>0 1 2 0 2 3</p>");
    let first = second.replace("<p>0 1 2 0 2 3</p>", "<p>0 1 2</p>");
    let two = format!("{}{first}{second}{}", &text[..begin], &text[end..]);
    let triangles = read_without_notes(two.as_bytes()).pieces.iter().map(|p| p.triangles.len()).sum::<usize>();
    assert_eq!(triangles, (2 + 1) + (2 + 2));
}

/// Truncated files, and files with one modified byte at each offset, result in an error or a model, but never a panic.
#[test]
fn truncated_and_modified_files_are_errors() {
    for text in [STL, PLY, OBJ, DAE, &gltf()] {
        for n in 0..text.len() {
            let _ = read("", &text.as_bytes()[..n], &neighbouring_file);
            for wrong in [21, b'9', b'-'] {
                let mut bytes = text.as_bytes().to_vec();
                bytes[n] = if wrong == 21 { bytes[n] ^ wrong } else { wrong };
                let _ = read("", &bytes, &neighbouring_file);
            }
        }
    }
    let wrong = |text: String| read("", text.as_bytes(), &neighbouring_file).unwrap_err();
    assert!(wrong(PLY.replace("element vertex 3", "element vertex 4000000000")).contains("4000000000"));
    assert!(wrong(PLY.replace("3 0 1 2", "3 0 1 7")).contains("does not exist"));
    assert!(wrong(DAE.replace("<p>0 1 2</p>", "<p>0 1 9</p>")).contains("position 9"));
    assert!(wrong(DAE.replace("<vcount>4", "<vcount>5")).contains("corners"));
    assert!(wrong(gltf().replace("\"byteLength\": 36", "\"byteLength\": 24")).contains("glTF"));
    assert!(wrong(DAE.replace("<vcount>4", "<vcount>18446744073709551615")).contains("corners"));
    // A primitive with this number of indices per corner has no corners.
    let far = read_without_notes(DAE.replace("offset=\"0\"/><p>", "offset=\"18446744073709551615\"/><p>").as_bytes());
    assert_eq!(far.pieces.len(), 1);
    let round = DAE.replace("<node><matrix>", "<node id='x'><instance_node url='#x'/><matrix>");
    assert!(wrong(round).contains("nested nodes"));
    assert!(read("", b"v 0 0 0\n", &neighbouring_file).is_err() && read("", b"", &neighbouring_file).is_err());
}

fn triangles_of(name: &str, bytes: &[u8]) -> usize {
    let read = read(name, bytes, &|_| None).unwrap();
    read.model.pieces.iter().map(|p| p.triangles.len()).sum()
}

#[test]
fn stl_files_in_capitals_or_with_trailing_bytes_are_read() {
    assert_eq!(triangles_of("a.stl", STL.to_uppercase().as_bytes()), 1);
    // Several solids, without names and behind a byte-order mark.
    let two = format!("\u{feff}{}{}", STL.replace("solid a", "solid"), STL.replace("vertex 1 0 0", "vertex 5 0 0"));
    assert_eq!(triangles_of("a", two.as_bytes()), 2);
    let mut binary = b"exported by a program".to_vec();
    binary.resize(80, 0);
    binary.extend(1_u32.to_le_bytes());
    let corners: [f32; 12] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    corners.iter().for_each(|x| binary.extend(x.to_le_bytes()));
    binary.extend([0, 0]);
    assert_eq!(triangles_of("a.stl", &binary), 1);
    binary.extend([7; 12]);
    assert_eq!(triangles_of("a", &binary), 1);
    binary.truncate(100);
    assert!(read("a.stl", &binary, &|_| None).is_err());
}

#[test]
fn obj_files_may_have_comments_and_continued_lines() {
    let text = "# a comment that ends in \\\nv 0 0 0 # the corner\nv 1 0 \\\n 0\nv 0 2 0\nusemtl #1\nf 1 \\\r\n2 3 # one face\n";
    assert_eq!(triangles_of("a.obj", text.as_bytes()), 1);
}

#[test]
fn ids_of_collada_are_those_of_the_own_mesh() {
    let mesh = |width: u32| {
        format!(
            r##"<geometry id="g{width}"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 {width} 0 0 0 1 0
            </float_array><technique_common><accessor source="#pa" count="3" stride="3"/></technique_common></source>
            <vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
            <input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>"##
        )
    };
    let text = format!(
        r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><library_geometries>{}{}
        </library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g1"/></node>
        <node><instance_geometry url="#g5"/></node></visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
        mesh(1),
        mesh(5)
    );
    let read = read("a.dae", text.as_bytes(), &|_| None).unwrap();
    let widest = read.model.pieces.iter().flat_map(|p| &p.points).map(|p| p[0]).fold(0.0, f64::max);
    assert_eq!(widest, 5.0);
}

#[test]
fn gltf_files_may_require_extensions_that_no_mesh_needs() {
    let with = |extension: &str| {
        gltf().replacen("\"scene\": 0", &format!("\"extensionsRequired\": [\"{extension}\"], \"scene\": 0"), 1)
    };
    assert_eq!(triangles_of("a.gltf", with("KHR_lights_punctual").as_bytes()), 1);
    assert_eq!(triangles_of("a.gltf", with("KHR_materials_clearcoat").as_bytes()), 1);
    let compressed = read("a.gltf", with("KHR_draco_mesh_compression").as_bytes(), &|_| None);
    assert!(compressed.unwrap_err().contains("KHR_draco_mesh_compression"));
}
