//! Default classes: attributes that elements have unless they set them themselves.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::Result;

use crate::{
    attributes::{Attributes, Record, completed},
    xml::Element,
};

/// Elements whose defaults are one record, because all of them are actuators.
pub const ACTUATORS: [&str; 12] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
    "orientation",
];

/// The name of the outermost class.
pub const MAIN: &str = "main";

/// What one class sets.
#[derive(Default, Clone)]
pub struct DefaultClass {
    records: BTreeMap<String, Record>,
    /// Actuator elements in the order of the file, those of the classes around first: they all change one record.
    pub actuators: Vec<Element>,
}

/// Maximum number of attributes and actuators of all classes, including those that they inherit.
const MAX_ENTRIES: usize = 500_000;

/// All classes by name.
#[derive(Default)]
pub struct Defaults {
    classes: BTreeMap<String, DefaultClass>,
    entries: usize,
}

impl Defaults {
    /// Reads the default sections of a file. Nested classes begin as copies of the class around them.
    pub fn read(root: &Element) -> Result<Self> {
        let mut defaults = Defaults::default();
        let mut main = DefaultClass::default();
        // Sections are merged; what one class contains is read before the classes nested in it.
        let tops: Vec<&Element> = root.named("default").collect();
        tops.iter().for_each(|top| main.add(top));
        for top in tops {
            defaults.classes.insert(top.attribute("class").unwrap_or(MAIN).to_owned(), main.clone());
            defaults.nested(top, &main)?;
        }
        defaults.classes.insert(MAIN.to_owned(), main);
        Ok(defaults)
    }

    fn nested(&mut self, around: &Element, outer: &DefaultClass) -> Result {
        for element in around.named("default") {
            let name = element.attribute("class").ok_or_else(|| element.fail("a nested <default> has no `class`"))?;
            let mut class = self.classes.get(name).unwrap_or(outer).clone();
            class.add(element);
            self.entries += class.records.values().map(Record::len).sum::<usize>() + class.actuators.len() + 1;
            if self.entries > MAX_ENTRIES {
                return Err(
                    element.fail(format!("the default classes have more than {MAX_ENTRIES} attributes in total"))
                );
            }
            self.nested(element, &class)?;
            self.classes.insert(name.to_owned(), class);
        }
        Ok(())
    }

    /// Returns a class by name. Fails with the line of the element that refers to it.
    pub fn class(&self, name: &str, of: &Element) -> Result<&DefaultClass> {
        self.classes.get(name).ok_or_else(|| of.fail(format!("there is no default class `{name}`")))
    }

    /// Returns the attributes of an element. Its class is its own, or else that of the bodies around it.
    pub fn attributes<'a>(&'a self, element: &'a Element, kind: &str, around: &str) -> Result<Attributes<'a>> {
        let class = self.class(element.attribute("class").unwrap_or(around), element)?;
        Ok(Attributes::new(element, class.records.get(kind)))
    }
}

impl DefaultClass {
    fn add(&mut self, section: &Element) {
        for element in section.children.iter().filter(|c| c.name != "default") {
            if ACTUATORS.contains(&element.name.as_str()) {
                self.actuators.push(element.clone());
                continue;
            }
            let record = self.records.entry(element.name.clone()).or_default();
            for (name, value) in &element.attributes {
                let value = completed(name, value, record.get(name).map(|(text, _)| text.as_str()));
                record.insert(name.clone(), (value, element.place.clone()));
            }
        }
    }
}
