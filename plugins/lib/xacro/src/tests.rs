//! Whole files. Expected trees in `tests/expected/` are those of xacro 2.1.1, recorded by `tests/against_xacro.py`.

use std::{collections::BTreeMap, fs, path::Path};

use proptest::prelude::*;

use crate::{Arguments, Expansion, Files, Limits, NoFiles, XacroError, expand, expand_within};

/// Files of a folder; the package `parts_pkg` is at `/parts`.
struct Folder(String);

impl Folder {
    fn of_tests(name: &str) -> Self {
        Folder(format!("{}/tests/{name}", env!("CARGO_MANIFEST_DIR")))
    }

    fn real(&self, path: &str) -> String {
        match path.strip_prefix("/parts") {
            Some(rest) => format!("{}/parts{rest}", self.0),
            None => format!("{}/{path}", self.0),
        }
    }
}

impl Files for Folder {
    fn read(&mut self, path: &str) -> Result<Vec<u8>, String> {
        fs::read(self.real(path)).map_err(|error| error.to_string())
    }
    fn list(&mut self, folder: &str) -> Result<Vec<String>, String> {
        let entries = fs::read_dir(self.real(folder)).map_err(|error| error.to_string())?;
        Ok(entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
    }
    fn package(&mut self, name: &str) -> Option<String> {
        (name == "parts_pkg").then(|| "/parts".to_owned())
    }
}

/// Files in memory.
struct Memory(BTreeMap<&'static str, String>);

impl Files for Memory {
    fn read(&mut self, path: &str) -> Result<Vec<u8>, String> {
        self.0.get(path).map(|text| text.clone().into_bytes()).ok_or_else(|| "there is no such file".to_owned())
    }
    fn list(&mut self, _: &str) -> Result<Vec<String>, String> {
        Ok(self.0.keys().map(|name| (*name).to_owned()).collect())
    }
}

fn names_in(folder: &str) -> Vec<String> {
    let folder = Folder::of_tests(folder).0;
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".xacro"))
        .collect();
    names.sort();
    names
}

fn expand_test(folder: &str, name: &str) -> Result<Expansion, XacroError> {
    let mut files = Folder::of_tests(folder);
    let bytes = files.read(name).unwrap();
    expand(name, &bytes, &Arguments::from_iter([("given", "1")]), &mut files)
}

fn expand_text(contents: &str) -> Result<Expansion, XacroError> {
    let text = format!("<robot xmlns:xacro=\"http://ros.org/xacro\">\n{contents}\n</robot>");
    expand("robot.xacro", text.as_bytes(), &Arguments::new(), &mut NoFiles)
}

/// An element as lines: names with namespaces, attributes sorted, texts without blanks around them.
fn outline(node: roxmltree::Node<'_, '_>, depth: usize, out: &mut Vec<String>) {
    let indent = " ".repeat(depth);
    if let Some(text) = node.text().filter(|_| node.is_text()) {
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        out.extend((!text.is_empty()).then(|| format!("{indent}{text}")));
    }
    if node.is_element() {
        let mut attributes: Vec<String> =
            node.attributes().map(|a| format!(" {:?}{}={:?}", a.namespace(), a.name(), a.value())).collect();
        attributes.sort();
        out.push(format!("{indent}{:?}{}", node.tag_name(), attributes.concat()));
        for child in node.children() {
            outline(child, depth + 1, out);
        }
    }
}

fn outline_of(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    outline(roxmltree::Document::parse(text).unwrap().root_element(), 0, &mut out);
    out
}

#[test]
fn files_expand_as_by_xacro() {
    let names = names_in("inputs");
    for name in &names {
        let found = expand_test("inputs", name).unwrap_or_else(|error| panic!("{error}")).text;
        let expected = Folder::of_tests("expected").0 + "/" + &name.replace(".xacro", ".xml");
        assert_eq!(outline_of(&found), outline_of(&fs::read_to_string(expected).unwrap()), "{name}");
    }
    assert!(names.len() >= 39, "{}", names.len());
}

#[test]
fn errors_name_the_line_and_the_flaw() {
    let names = names_in("refused");
    for name in &names {
        let text = fs::read_to_string(Path::new(&Folder::of_tests("refused").0).join(name)).unwrap();
        let wanted = text.lines().next().unwrap().strip_prefix("<!-- expected in line ").unwrap();
        let (line, words) = wanted.strip_suffix(" -->").unwrap().split_once(": ").unwrap();
        let error = expand_test("refused", name).map(|e| e.text).expect_err(name);
        assert!(error.message.contains(words), "{name}: {error}");
        assert_eq!(error.place.map(|place| place.line.to_string()).as_deref(), Some(line), "{name}");
    }
    assert!(names.len() >= 42, "{}", names.len());
}

#[test]
fn an_error_names_the_calls_that_led_to_it() {
    let error = expand_text(
        "<xacro:macro name=\"inner\" params=\"size\">\n<a v=\"${size / none}\"/>\n</xacro:macro>\n\
         <xacro:macro name=\"outer\"><xacro:inner size=\"1\"/></xacro:macro>\n<b><xacro:outer/></b>",
    );
    let expected = "robot.xacro:3:4: ${size / none}: `none` is not defined: expected a property, a parameter of the \
                    macro, or a function\n  robot.xacro:5:27: the macro `inner` is called here\n  robot.xacro:6:4: the \
                    macro `outer` is called here";
    assert_eq!(error.map(|e| e.text).unwrap_err().to_string(), expected);
}

#[test]
fn each_line_of_the_result_has_an_origin() {
    let expansion = expand_test("inputs", "include_relative.xacro").unwrap();
    let lines: Vec<(&str, Option<(&str, u32)>)> =
        (1..).zip(expansion.text.lines()).map(|(i, line)| (line.trim(), expansion.origin(i))).collect();
    let of = |words: &str| lines.iter().find(|(line, _)| line.contains(words)).unwrap().1;
    assert_eq!(of("<nested/>"), Some(("parts/nested.xacro", 3)));
    assert_eq!(of("<included "), Some(("parts/part.xacro", 6)));
    assert_eq!(of("<part "), Some(("parts/part.xacro", 5)));
    assert_eq!(of("<x "), Some(("include_relative.xacro", 5)));
    assert_eq!(of("</robot>"), Some(("include_relative.xacro", 2)));
    assert!(lines.iter().all(|(_, origin)| origin.is_some()));
    assert_eq!(expansion.origin(0), None);
    assert_eq!(expansion.origin(lines.len() as u32 + 1), None);
    let text = expand_text("<a>\n<b>one\ntwo</b>three\nfour</a>").unwrap();
    assert_eq!((1..=9).filter(|line| text.origin(*line).is_some()).count(), text.text.lines().count());
}

#[test]
fn packages_are_found_in_both_forms() {
    let text = "<r xmlns:xacro='x'><m a='file://$(find p)/a.stl' b='$(find p)/a.stl' c='package://p/a.stl'/>\
                <xacro:include filename='$(find p)/urdf/b.xacro'/></r>";
    let included = "<r><xacro:include filename='c.xacro'/></r>".to_owned();
    let mut files = Memory(BTreeMap::from([
        ("package://p/urdf/b.xacro", included),
        ("package://p/urdf/c.xacro", "<r><c/></r>".into()),
    ]));
    let expansion = expand("a.xacro", text.as_bytes(), &Arguments::new(), &mut files).unwrap();
    assert!(expansion.text.contains("a=\"package://p/a.stl\" b=\"package://p/a.stl\" c=\"package://p/a.stl\""));
    assert!(expansion.text.contains("<c/>"));
    assert_eq!(expansion.files, ["a.xacro", "package://p/urdf/b.xacro", "package://p/urdf/c.xacro"]);
}

#[test]
fn notes_mention_each_kind_once() {
    let text = "<r xmlns:xacro='x'>\n<a v='$(optenv A 1)' w='$(optenv B 2)'/>\n<xacro:property name='e' value='1' unit='m'/>\n\
                <b v=\"${xacro.warning('old')}\" gz:x='1'/><c><xacro:if value='1'><xacro:attribute name='d' value='1'/>\
                </xacro:if></c></r>";
    let text = text.replace("</r>", "<macro name='m'/></r>");
    let arguments = Arguments::from_iter([("speed", "3")]);
    let expansion = expand("r.xacro", text.as_bytes(), &arguments, &mut NoFiles).unwrap();
    let notes: Vec<(String, usize, Option<u32>)> =
        expansion.notes.iter().map(|n| (n.message.clone(), n.count, n.first.as_ref().map(|p| p.line))).collect();
    let expected = [
        ("the prefix `gz:` is not declared by xmlns:gz", 1, Some(1)),
        ("environment variables are not read: for A, its default \"1\" is used", 2, Some(2)),
        ("<xacro:property> has no attribute `unit`, which is ignored", 1, Some(3)),
        ("the name `e` hides what xacro has under this name", 1, Some(3)),
        ("the file reports, as warning: old", 1, Some(4)),
        (
            "<xacro:attribute> directly in a macro, a condition or a block has no effect, as in xacro: the condition \
             belongs into its value",
            1,
            Some(4),
        ),
        ("<macro> is not expanded: current versions of xacro expect <xacro:macro>", 1, Some(4)),
        ("the file has no argument `speed`", 1, None),
    ];
    let expected: Vec<_> = expected.into_iter().map(|(m, n, line)| (m.to_owned(), n, line)).collect();
    assert_eq!(notes, expected);
    roxmltree::Document::parse(&expansion.text).unwrap();
}

#[test]
fn the_prefix_may_be_unbound_or_bound_to_anything() {
    for root in ["<r>", "<r xmlns:xacro=\"http://any\">"] {
        let text = format!("{root}<xacro:property name='a' value='1'/><x v='${{a}}'/></r>");
        let expansion = expand("r.xacro", text.as_bytes(), &Arguments::new(), &mut NoFiles).unwrap();
        assert_eq!(expansion.text, "<?xml version=\"1.0\"?>\n<r>\n  <x v=\"1\"/>\n</r>\n");
        assert_eq!(expansion.notes, []);
    }
}

#[test]
fn arguments_are_listed_with_their_values() {
    let arguments = Arguments::from_iter([("given", "1"), ("other", "2")]);
    let mut files = Folder::of_tests("inputs");
    let bytes = files.read("arguments.xacro").unwrap();
    let expansion = expand("arguments.xacro", &bytes, &arguments, &mut files).unwrap();
    let names: Vec<&str> = expansion.arguments.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["given", "name", "path", "size"]);
    assert_eq!(expansion.arguments[3].1, "6");
}

#[test]
fn files_that_multiply_themselves_end_with_an_error() {
    let doubling: String =
        (1..40).map(|i| format!("<xacro:macro name='m{i}'><xacro:m{0}/><xacro:m{0}/></xacro:macro>", i - 1)).collect();
    let appending: String = (1..60)
        .map(|i| format!("<xacro:property name='p{i}' value='${{p{0} + p{0}}}' lazy_eval='false'/>", i - 1))
        .collect();
    let nesting: String = (1..100)
        .map(|i| format!("<xacro:property name='p{i}' value='${{[p{0}, p{0}]}}' lazy_eval='false'/>", i - 1))
        .collect();
    let chain: String =
        (1..500).map(|i| format!("<xacro:property name='p{i}' value='${{p{0} + 1}}'/>", i - 1)).collect();
    let looping =
        "<xacro:macro name='m' params='b:=^ *c'><xacro:m><xacro:insert_block name='c'/></xacro:m></xacro:macro>";
    let cases = [
        (format!("<xacro:macro name='m0'><a/></xacro:macro>{doubling}<xacro:m39/>"), "steps"),
        (format!("<xacro:property name='p0' value='abc'/>{appending}<a v='${{p59}}'/>"), "bytes"),
        (format!("<xacro:property name='p0' value='1'/>{nesting}<a v='${{p99}}'/>"), "deeper"),
        (format!("<xacro:property name='p0' value='1'/>{chain}<a v='${{p499}}'/>"), "in a chain"),
        (format!("<xacro:property name='b' value='1'/>{looping}<xacro:m><a/></xacro:m>"), "deeper"),
        (
            "<xacro:property name='b'><xacro:insert_block name='b'/></xacro:property><xacro:insert_block name='b'/>"
                .into(),
            "deeper",
        ),
        (format!("{}{}", "<a>".repeat(300), "</a>".repeat(300)), "deeper"),
        ("<xacro:element xacro:name='xacro:element'/>".into(), "own kind"),
        ("<a v='${list(python.range(10**9))}'/>".into(), "items"),
        (format!("<xacro:property name='n' value='{}'/><a v='${{n + 1}}'/>", "9".repeat(40)), "str and int"),
    ];
    let limits = Limits { work: 1_000_000, ..Limits::default() };
    for (contents, words) in cases {
        let text = format!("<r>{contents}</r>");
        let error = expand_within(limits.clone(), "r", text.as_bytes(), &Arguments::new(), &mut NoFiles);
        let error = error.map(|e| e.text).expect_err(words);
        assert!(error.message.contains(words) && error.place.is_some(), "{error}");
    }
}

#[test]
fn yaml_that_multiplies_itself_ends_with_an_error() {
    let laughs: String = (1..40).map(|i| format!("a{i}: &a{i} [*a{0}, *a{0}]\n", i - 1)).collect();
    let merges: String = (1..40).map(|i| format!("a{i}: &a{i}\n  <<: [*a{0}, *a{0}]\n  k{i}: 1\n", i - 1)).collect();
    let cases = [
        (format!("a0: &a0 [x]\n{laughs}"), "bytes"),
        (format!("a0: &a0 {{x: 1}}\n{merges}"), ""),
        ("[".repeat(10_000), "recursion limit"),
        (format!("{}a", "- ".repeat(10_000)), "deeper"),
        ("a: &a [*a]".to_owned(), "contain itself"),
        ("a: 2020-01-02".to_owned(), "date"),
        ("a: !!python/object:os.system x".to_owned(), "tag"),
        ("--- a\n--- b\n".to_owned(), "second document"),
    ];
    let limits = Limits { work: 1_000_000, ..Limits::default() };
    for (yaml, words) in cases {
        let mut files = Memory(BTreeMap::from([("y.yaml", yaml)]));
        let text = b"<r><a v=\"${xacro.load_yaml('y.yaml')}\"/></r>";
        let result = expand_within(limits.clone(), "r", text, &Arguments::new(), &mut files).map(|e| e.text);
        match words {
            "" => assert!(result.is_ok(), "{result:?}"),
            words => assert!(result.as_ref().is_err_and(|e| e.message.contains(words)), "{words}: {result:?}"),
        }
    }
}

/// The deepest nesting of everything at once must fit into the stack of a thread of usual size.
#[test]
fn the_stack_is_large_enough_for_the_deepest_file() {
    let deepest = || {
        let part = |inner: &str| format!("{}{inner}{}", "(".repeat(60), ")".repeat(60));
        let chain: String = (1..100)
            .map(|i| format!("<xacro:property name='p{i}' value='${{{}}}'/>", part(&format!("p{} + 1", i - 1))))
            .collect();
        let text = format!(
            "<r><xacro:property name='p0' value='1'/>{chain}<xacro:macro name='m' params='n *b'><a><b><c>\
             <xacro:if value='${{n == 0}}'><d v='${{p98}}'/></xacro:if>\
             <xacro:unless value='${{n == 0}}'><xacro:m n='${{n - 1}}'><e><xacro:insert_block name='b'/></e></xacro:m>\
             </xacro:unless></c></b></a></xacro:macro><xacro:m n='DEPTH'><f/></xacro:m></r>"
        );
        let run = |depth: usize| {
            let text = text.replace("DEPTH", &depth.to_string());
            expand("r", text.as_bytes(), &Arguments::new(), &mut NoFiles)
        };
        assert!(run(80).is_ok(), "{}", run(80).unwrap_err().message);
        assert!(run(1000).unwrap_err().message.contains("deeper"));
    };
    std::thread::Builder::new().stack_size(1 << 20).spawn(deepest).unwrap().join().unwrap();
}

/// Contents of xacro files: well-formed XML whose names often meet.
fn contents() -> impl Strategy<Value = String> {
    let value = prop::sample::select(vec![
        "1",
        "${a}",
        "${b * 2}",
        "${[a, b]}",
        "${a + b}",
        "$(arg a)",
        "$${a}",
        "a${b}c",
        "${n.a}",
        "$(eval 1 + a)",
        "${c[0]}",
        "${load_yaml('y.yaml').k}",
        "${str(a)[1:]}",
        "x",
        "'q'",
        "true",
        "${1 if a else 2}",
        "$(find p)/x",
        "$(optenv E 1)",
        "${a.split('1')}",
        "${len(a)}",
        "${dict(a=b)}",
        "${xacro.warning(a)}",
        "${a",
        "${b ** 2 // 3}",
        "&#10;&#9;&lt;é",
    ]);
    let leaf = (
        prop::sample::select(vec![
            "<xacro:property name='a' value='V'/>",
            "<xacro:property name='b' value='V'/>",
            "<y/>",
            "<x v='V' w='W'/>",
            "V text W",
            "<xacro:property name='a' value='V' scope='parent'/>",
            "<xacro:property name='b' value='V' scope='global'/>",
            "<xacro:property name='c' value='V' lazy_eval='false'/>",
            "<xacro:property name='a' remove='1'/>",
            "<xacro:property name='b' default='V'/>",
            "<xacro:m a='V'><p/><q>W</q></xacro:m>",
            "<xacro:m a='V' b='W'/>",
            "<xacro:k/>",
            "<xacro:insert_block name='c'/>",
            "<xacro:insert_block name='d'/>",
            "<xacro:insert_block name='e'/>",
            "<xacro:include filename='f.xacro' ns='n'/>",
            "<xacro:include filename='*.xacro'/>",
            "<xacro:include filename='V'/>",
            "<xacro:n.m a='1'/>",
            "<xacro:arg name='a' default='V'/>",
            "<xacro:element xacro:name='x:y' v='V'/>",
            "<xacro:attribute name='q' value='V'/>",
            "<xacro:call macro='k'/>",
            "<!-- V --><?pi V?>",
            "<![CDATA[V]]>",
            "<z:z z:z='V'/>",
        ]),
        value.clone(),
        value.clone(),
    )
        .prop_map(|(leaf, v, w)| {
            leaf.replace('V', &v.replace('\'', "&apos;")).replace('W', &w.replace('\'', "&apos;"))
        });
    let start = "<xacro:property name='a' value='1'/><xacro:property name='b' value='2'/><xacro:macro name='k'><g/></xacro:macro>";
    let nested = leaf.prop_recursive(4, 24, 6, move |inner| {
        let around = prop::sample::select(vec![
            ("<x v='1'>", "</x>"),
            ("<xacro:if value='${a}'>", "</xacro:if>"),
            ("<xacro:unless value='0'>", "</xacro:unless>"),
            ("<xacro:macro name='m' params='a b:=^|2'>", "</xacro:macro>"),
            ("<xacro:property name='e'>", "</xacro:property>"),
            ("<xacro:macro name='m' params='a b:=${a} *c **d'>", "</xacro:macro>"),
            ("<xacro:m a='1'>", "</xacro:m>"),
            ("<xacro:macro name='k' params=''>", "</xacro:macro>"),
            ("<w xmlns:z='u'>", "</w>"),
        ]);
        (around, prop::collection::vec(inner, 0..6))
            .prop_map(|((open, close), parts)| format!("{open}{}{close}", parts.concat()))
    });
    prop::collection::vec(nested, 0..6).prop_map(move |parts| format!("{start}{}", parts.concat()))
}

proptest! {
    // `PROPTEST_CASES` sets the number for long runs.
    #![proptest_config(ProptestConfig { cases: 8 * ProptestConfig::default().cases, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_cause_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        let _ = expand("r", &bytes, &Arguments::new(), &mut NoFiles);
    }

    #[test]
    fn no_contents_cause_a_panic(first in contents(), second in contents(), yaml in "[-a-c:{}\\[\\]&*,!?|>'\"# \n0-9.]{0,40}") {
        let files = [("f.xacro", format!("<r>{second}</r>")), ("y.yaml", format!("k: {yaml}"))];
        let limits = Limits { work: 20_000, include_depth: 4, depth: 60, ..Limits::default() };
        let text = format!("<r>{first}</r>");
        let expanded = expand_within(limits, "r", text.as_bytes(), &Arguments::new(), &mut Memory(files.into()));
        if let Ok(expansion) = expanded {
            prop_assert!(roxmltree::Document::parse(&expansion.text).is_ok(), "{}", expansion.text);
            let lines = expansion.text.lines().count() as u32;
            prop_assert!(expansion.origin(lines).is_some() && expansion.origin(lines + 1).is_none());
        }
    }

    #[test]
    fn no_damage_to_a_file_causes_a_panic(name in prop::sample::select(names_in("inputs")), at in any::<prop::sample::Index>(), byte in any::<u8>(), cut in 0..4_usize) {
        let mut files = Folder::of_tests("inputs");
        let mut bytes = files.read(&name).unwrap();
        let at = at.index(bytes.len());
        let end = (at + cut).min(bytes.len());
        bytes.splice(at..end, [byte]);
        let limits = Limits { work: 200_000, ..Limits::default() };
        let _ = expand_within(limits, &name, &bytes, &Arguments::new(), &mut files);
    }
}
