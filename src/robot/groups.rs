//! Groups of joints that an SRDF file defines, such as the left arm of a robot with two.

use super::description::Robot;
use super::error::RobotError;
use super::srdf::{attribute, line_of, parse};
use alloc::string::String;
use alloc::vec::Vec;
use roxmltree::Node;

/// Some of a robot's variables, for planning.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct JointGroup {
    /// Its name.
    pub name: String,
    /// Indices into [`Robot::variables`], ascending.
    pub variables: Vec<usize>,
}

impl Robot {
    /// The groups of an SRDF file: the variables of their chains, joints, links and subgroups. Fixed joints and joints
    /// that mimic another add no variables.
    ///
    /// # Errors
    /// [`RobotError`]: the text is not an SRDF file, or a group names a link, joint or group that does not exist.
    pub fn groups(&self, srdf: &str) -> Result<Vec<JointGroup>, RobotError> {
        let document = parse(srdf)?;
        let mut groups: Vec<JointGroup> = Vec::new();
        let is_group = |node: &Node<'_, '_>| node.has_tag_name("group");
        for node in document.root_element().children().filter(is_group) {
            let mut variables = Vec::new();
            for member in node.children().filter(Node::is_element) {
                self.add_member(member, &groups, &mut variables)?;
            }
            variables.sort_unstable();
            variables.dedup();
            groups.push(JointGroup { name: attribute(node, "name")?.into(), variables });
        }
        Ok(groups)
    }

    fn add_member(
        &self,
        member: Node<'_, '_>,
        groups: &[JointGroup],
        variables: &mut Vec<usize>,
    ) -> Result<(), RobotError> {
        let line = line_of(member);
        let unknown = |name: &str| RobotError::UnknownMember { line, name: name.into() };
        let variable = |joint: &str| self.variables.iter().position(|name| name == joint);
        match member.tag_name().name() {
            "chain" => {
                let base = self.link_named(attribute(member, "base_link")?, line)?;
                let tip = attribute(member, "tip_link")?;
                let mut link = self.link_named(tip, line)?;
                while link != base {
                    let parent = self.links[link].parent.as_ref().ok_or_else(|| unknown(tip))?;
                    variables.extend(variable(&parent.joint));
                    link = parent.link;
                }
            }
            "joint" => {
                let name = attribute(member, "name")?;
                let mut parents = self.links.iter().filter_map(|link| link.parent.as_ref());
                // A virtual joint attaches the robot to the world.
                let is_virtual = |node: Node<'_, '_>| {
                    node.has_tag_name("virtual_joint") && node.attribute("name") == Some(name)
                };
                if !parents.any(|parent| parent.joint == name)
                    && !member.document().descendants().any(is_virtual)
                {
                    return Err(unknown(name));
                }
                variables.extend(variable(name));
            }
            "link" => {
                let link = self.link_named(attribute(member, "name")?, line)?;
                variables.extend(self.links[link].parent.as_ref().and_then(|parent| variable(&parent.joint)));
            }
            "group" => {
                let name = attribute(member, "name")?;
                let group = groups.iter().find(|group| group.name == name).ok_or_else(|| unknown(name))?;
                variables.extend(&group.variables);
            }
            _ => {}
        }
        Ok(())
    }
}
