//! Elements of XML files in the style of SDF, detached from the text, so that included files can be merged into one tree.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use roxmltree::Node;
use tatu_plugin_api::safe::{Fail, Result};

use crate::tree::check_finite;

/// Maximum nesting depth of elements in one file; real files have a depth of 12.
const MAX_DEPTH: usize = 64;

/// An element with its attributes in the order of the file.
#[derive(Debug, Clone, Default)]
pub struct Element {
    /// Its name, without a namespace.
    pub name: String,
    /// Names and values of the attributes.
    pub attributes: Vec<(String, String)>,
    /// The elements in it.
    pub children: Vec<Element>,
    /// The text before the first child.
    pub text: String,
    /// Line of the start tag, counted through all files.
    pub line: u64,
}

impl Element {
    /// Copies an element of an XML document; `line_of` returns the line of a byte of the text. Fails if elements are
    /// nested more than 64 deep.
    pub fn copy(node: Node<'_, '_>, line_of: &dyn Fn(usize) -> u64) -> Result<Self> {
        Self::copy_at(node, line_of, 1)
    }
    fn copy_at(node: Node<'_, '_>, line_of: &dyn Fn(usize) -> u64, depth: usize) -> Result<Self> {
        let line = line_of(node.range().start);
        if depth > MAX_DEPTH {
            let text = format!("the file nests elements more than {MAX_DEPTH} levels deep");
            return Err(Fail::argument(text).at("", line));
        }
        let attributes = node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect();
        let children = node.children().filter(Node::is_element).map(|c| Self::copy_at(c, line_of, depth + 1));
        Ok(Element {
            name: node.tag_name().name().to_owned(),
            attributes,
            children: children.collect::<Result<_>>()?,
            text: node.text().unwrap_or_default().to_owned(),
            line,
        })
    }

    /// Returns the text of an attribute, or `None` if it is missing.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.trim())
    }
    /// Returns the first child with this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|c| c.name == name)
    }
    /// Returns the children with this name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.name == name)
    }
    /// Returns the element at a path of names, each of which is a child of the one before.
    pub fn at(&self, path: &[&str]) -> Option<&Element> {
        path.iter().try_fold(self, |element, name| element.child(name))
    }
    /// Returns the name that an attribute states.
    pub fn label(&self) -> &str {
        self.attribute("name").unwrap_or_default()
    }
    /// Returns the text of the first child with this name, unless it is empty.
    pub fn text_of(&self, name: &str) -> Option<&str> {
        self.child(name).map(|c| c.text.trim()).filter(|text| !text.is_empty())
    }
    /// Builds an error at this element.
    pub fn fail(&self, text: impl Into<String>) -> Fail {
        Fail::argument(text).at("", self.line)
    }

    /// Returns the number in the text of the first child with this name, or `None` if there is none.
    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        match child.text.trim() {
            "" => Ok(None),
            text => match text.parse() {
                Ok(number) => Ok(Some(number)),
                Err(_) => Err(child.fail(format!("<{name}> is \"{}\"; expected a number", shortened(text)))),
            },
        }
    }
    /// Returns the finite number in the text of the first child with this name.
    pub fn finite(&self, name: &str) -> Result<Option<f64>> {
        let number = self.number(name)?;
        number.map(|number| self.checked(name, [number]).map(|[number]| number)).transpose()
    }
    /// Returns the `N` finite numbers in the text of the first child with this name.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>> {
        self.child(name).map(|child| child.own_numbers()).transpose()
    }
    /// Returns the `N` finite numbers in the text.
    pub fn own_numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let numbers: Result<Vec<f64>, _> = self.text.split_whitespace().map(str::parse).collect();
        let numbers: Option<[f64; N]> = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        let text = self.text.trim();
        let fail = || self.fail(format!("<{}> is \"{}\"; expected {N} numbers", self.name, shortened(text)));
        self.checked(&self.name, numbers.ok_or_else(fail)?)
    }
    fn checked<const N: usize>(&self, name: &str, numbers: [f64; N]) -> Result<[f64; N]> {
        check_finite(&numbers, &format!("<{name}>"), self.child(name).unwrap_or(self).line)?;
        Ok(numbers)
    }
    /// Reads the text of an element `<pose>`: x y z roll pitch yaw, or what its attributes say.
    pub fn own_pose(&self) -> Result<Isometry3<f64>> {
        if self.text.trim().is_empty() {
            return Ok(Isometry3::identity());
        }
        if self.attribute("rotation_format") == Some("quat_xyzw") {
            let [x, y, z, i, j, k, w] = self.own_numbers()?;
            let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-12);
            let turn = turn.ok_or_else(|| self.fail("<pose> has a quaternion of 0 0 0 0"))?;
            return Ok(Isometry3::from_parts(Translation3::new(x, y, z), turn));
        }
        let [x, y, z, roll, pitch, yaw]: [f64; 6] = self.own_numbers()?;
        let unit = if self.attribute("degrees").is_some_and(is_true) { std::f64::consts::PI / 180.0 } else { 1.0 };
        let turn = UnitQuaternion::from_euler_angles(roll * unit, pitch * unit, yaw * unit);
        Ok(Isometry3::from_parts(Translation3::new(x, y, z), turn))
    }
    /// Returns whether the text of the first child with this name is `true` or `1`.
    pub fn flag(&self, name: &str) -> Option<bool> {
        self.text_of(name).map(is_true)
    }
}

/// Returns whether a text means "true".
pub fn is_true(text: &str) -> bool {
    text.trim().eq_ignore_ascii_case("true") || text.trim() == "1"
}

/// Returns the beginning of a text, for messages.
pub fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}
