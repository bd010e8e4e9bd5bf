//! The elements of a document, which refer to each other by ids.

use std::collections::HashMap;

use roxmltree::Node;

/// The elements of a document, by their ids.
pub struct ElementIndex<'a> {
    pub root: Node<'a, 'a>,
    ids: HashMap<&'a str, Node<'a, 'a>>,
}

impl<'a> ElementIndex<'a> {
    /// Collects all elements that have an id.
    pub fn new(root: Node<'a, 'a>) -> Self {
        let mut ids = HashMap::new();
        for node in root.descendants() {
            if let Some(id) = node.attribute("id") {
                ids.entry(id).or_insert(node);
            }
        }
        ElementIndex { root, ids }
    }

    /// Returns the element to which a reference such as `#box` refers.
    pub fn get(&self, reference: &str) -> Option<Node<'a, 'a>> {
        self.ids.get(reference.strip_prefix('#').unwrap_or(reference)).copied()
    }

    /// Returns the element to which an attribute of a node refers. Files whose meshes repeat each other's ids exist, so
    /// an element of the node's own mesh comes first.
    pub fn follow(&self, node: Node<'a, 'a>, attribute: &str) -> Option<Node<'a, 'a>> {
        let reference = node.attribute(attribute)?;
        let id = reference.strip_prefix('#').unwrap_or(reference);
        let mesh = node.ancestors().find(|n| n.tag_name().name() == "mesh");
        let own = mesh.and_then(|mesh| mesh.descendants().find(|n| n.attribute("id") == Some(id)));
        own.or_else(|| self.get(reference))
    }
}

/// Returns the children of an element with the given tag name.
pub fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |n| n.tag_name().name() == name)
}

/// Returns the first child of an element with the given tag name.
pub fn child<'a>(node: Node<'a, 'a>, name: &'static str) -> Option<Node<'a, 'a>> {
    children(node, name).next()
}

/// Returns the numbers in an element's text, up to the first word that is not a number.
pub fn numbers<T: std::str::FromStr>(node: Node<'_, '_>) -> Vec<T> {
    node.text().unwrap_or_default().split_ascii_whitespace().map_while(|word| word.parse().ok()).collect()
}
