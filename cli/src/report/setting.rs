//! The tree settings compared.

use crate::{SplitterName, StorageName, TreeOptions};
use clap::ValueEnum;
use core::fmt;
use simdop::hierarchy::NodeType;
use simdop::low_level::key::StorageKind::{self, Fixed, Half};

/// The options for building a mesh.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Setting {
    pub(super) node: NodeType,
    pub(super) leaf_size: u32,
    pub(super) splitter: SplitterName,
    pub(super) has_normal_slabs: bool,
}

/// Which settings are compared.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Sweep {
    /// All combinations of node type and leaf size; the other options one at a time, with fixed point.
    Cross,
    /// All combinations.
    Full,
}

/// Every node type that can be chosen at run time.
const NODES: [(usize, usize, StorageKind); 8] = [
    (6, 16, Fixed),
    (14, 16, Fixed),
    (18, 16, Fixed),
    (26, 16, Fixed),
    (18, 4, Fixed),
    (14, 16, Half),
    (18, 16, Half),
    (26, 16, Half),
];
const LEAF_SIZES: [u32; 4] = [1, 2, 4, 8];

/// The library's defaults.
const DEFAULT: Setting = Setting {
    node: NodeType { k: 18, arity: 16, storage: Fixed },
    leaf_size: 1,
    splitter: SplitterName::MeanWidth,
    has_normal_slabs: true,
};

impl Sweep {
    /// The settings, without duplicates.
    pub(super) fn settings(self) -> Vec<Setting> {
        let mut all = Vec::new();
        for &splitter in SplitterName::value_variants() {
            for (has_normal_slabs, (k, arity, storage)) in
                [true, false].into_iter().flat_map(|has_slabs| NODES.map(|node| (has_slabs, node)))
            {
                let node = NodeType { k, arity, storage };
                for leaf_size in LEAF_SIZES {
                    all.push(Setting { node, leaf_size, splitter, has_normal_slabs });
                }
            }
        }
        if self == Self::Cross {
            all.retain(Setting::is_in_cross);
        }
        all
    }
}

impl Setting {
    fn is_in_cross(&self) -> bool {
        let Self { node, leaf_size, splitter, has_normal_slabs } = *self;
        let is_usual = (splitter, has_normal_slabs) == (DEFAULT.splitter, DEFAULT.has_normal_slabs);
        let is_thick = splitter == DEFAULT.splitter
            && (node.arity, node.storage) == (DEFAULT.node.arity, DEFAULT.node.storage)
            && matches!(leaf_size, 1 | 4);
        let is_split_otherwise = Self { splitter: DEFAULT.splitter, ..*self } == DEFAULT;
        is_usual || is_thick || is_split_otherwise
    }

    pub(super) fn options(&self) -> TreeOptions {
        TreeOptions {
            k: Some(self.node.k),
            arity: Some(self.node.arity),
            storage: Some(self.node.storage.into()),
            leaf_size: Some(self.leaf_size),
            splitter: Some(self.splitter),
            without_normal_slabs: !self.has_normal_slabs,
            ..TreeOptions::default()
        }
    }

    /// The setting in the form of `simdop build`'s options.
    pub(super) fn arguments(&self) -> String {
        let Self { node: NodeType { k, arity, .. }, leaf_size, has_normal_slabs, .. } = self;
        let (storage, splitter) = (self.storage_name(), self.splitter_name());
        let thin = if *has_normal_slabs { "" } else { " --without-normal-slabs" };
        format!("-k {k} -a {arity} --storage {storage} -l {leaf_size} -s {splitter}{thin}")
    }

    /// The storage in the form of the options.
    pub(super) fn storage_name(&self) -> String {
        name_of(&StorageName::from(self.node.storage))
    }

    /// The splitter in the form of the options.
    pub(super) fn splitter_name(&self) -> String {
        name_of(&self.splitter)
    }
}

/// The name of a value of an option.
fn name_of(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { node: NodeType { k, arity, storage }, leaf_size, has_normal_slabs, .. } = self;
        let thin = if *has_normal_slabs { "with" } else { "without" };
        let s = if *leaf_size == 1 { "" } else { "s" };
        write!(
            f,
            "k {k}, arity {arity}, {storage}, {leaf_size} triangle{s} a leaf, splitter {}, {thin} normal slabs",
            self.splitter_name()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_has_the_default_and_nothing_twice() {
        for (sweep, count) in [(Sweep::Cross, 45), (Sweep::Full, 384)] {
            let settings = sweep.settings();
            assert_eq!(settings.len(), count);
            assert!(settings.contains(&DEFAULT));
            for (i, setting) in settings.iter().enumerate() {
                assert!(!settings[..i].contains(setting), "{setting}");
            }
        }
        assert_eq!(
            DEFAULT.to_string(),
            "k 18, arity 16, fixed point, 1 triangle a leaf, splitter mean-width, with normal slabs"
        );
    }
}
