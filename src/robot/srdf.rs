//! Pairs of links that an SRDF file disables.

use super::RobotError;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Two links that are not tested against each other.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DisabledPair {
    /// The links' names.
    pub links: [String; 2],
    /// The reason in the file: "Adjacent", "Never", "Default" and others. Most come from sampling.
    pub reason: String,
}

impl DisabledPair {
    /// All disabled pairs of an SRDF file.
    ///
    /// # Errors
    /// [`RobotError::Format`] if the text is not XML, or a pair lacks a name.
    pub fn from_srdf(text: &str) -> Result<Vec<Self>, RobotError> {
        let format = |problem: String| RobotError::Format { problem };
        let document = roxmltree::Document::parse(text).map_err(|error| format(error.to_string()))?;
        let pair = |node: roxmltree::Node<'_, '_>| {
            let name = |key: &str| {
                let line = document.text_pos_at(node.range().start).row;
                node.attribute(key)
                    .map(ToString::to_string)
                    .ok_or_else(|| format(alloc::format!("line {line}: a disabled pair without {key}")))
            };
            let reason = node.attribute("reason").unwrap_or_default().to_string();
            Ok(Self { links: [name("link1")?, name("link2")?], reason })
        };
        document.descendants().filter(|node| node.has_tag_name("disable_collisions")).map(pair).collect()
    }

    /// Whether these are its links, in either order.
    #[must_use]
    pub fn is_of(&self, a: &str, b: &str) -> bool {
        let [p, q] = &self.links;
        (p == a && q == b) || (p == b && q == a)
    }
}
