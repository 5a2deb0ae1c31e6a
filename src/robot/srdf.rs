//! Pairs of links that an SRDF file disables.

use super::RobotError;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use roxmltree::{Document, Node};

/// Two links that are not tested against each other.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DisabledPair {
    /// The links' names.
    pub links: [String; 2],
    /// The reason in the file: "Adjacent", "Never", "Default" and others. Most reasons come from sampling.
    pub reason: String,
    /// The line of the file, counted from 1.
    pub line: u32,
}

impl DisabledPair {
    /// All disabled pairs of an SRDF file.
    ///
    /// # Errors
    /// [`RobotError::Format`] if the text is not XML, is a URDF file, or a pair lacks a name.
    pub fn from_srdf(text: &str) -> Result<Vec<Self>, RobotError> {
        let document = parse(text)?;
        let pair = |node: Node<'_, '_>| {
            Ok(Self {
                links: [attribute(node, "link1")?.into(), attribute(node, "link2")?.into()],
                reason: node.attribute("reason").unwrap_or_default().to_string(),
                line: line_of(node),
            })
        };
        document.descendants().filter(|node| node.has_tag_name("disable_collisions")).map(pair).collect()
    }

    /// Whether these are the two links, in either order.
    #[must_use]
    pub fn is_of(&self, a: &str, b: &str) -> bool {
        let [p, q] = &self.links;
        (p == a && q == b) || (p == b && q == a)
    }
}

pub(super) fn parse(text: &str) -> Result<Document<'_>, RobotError> {
    let format = |problem: String| RobotError::Format { problem };
    let document = Document::parse(text).map_err(|error| format(error.to_string()))?;
    let of_urdf = |node: &Node<'_, '_>| node.has_tag_name("joint") || node.has_tag_name("link");
    // In an SRDF file, links and joints are members of groups only.
    match document.root_element().children().find(of_urdf) {
        Some(node) => {
            let (line, name) = (line_of(node), node.tag_name().name());
            Err(format(format!("line {line}: a {name} outside of a group: a URDF file, not an SRDF file")))
        }
        None => Ok(document),
    }
}

pub(super) fn line_of(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

pub(super) fn attribute<'a>(node: Node<'a, '_>, key: &str) -> Result<&'a str, RobotError> {
    node.attribute(key).ok_or_else(|| {
        let (line, name) = (line_of(node), node.tag_name().name());
        RobotError::Format { problem: format!("line {line}: {name} without {key}") }
    })
}
