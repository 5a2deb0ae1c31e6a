//! The tree settings compared.

use crate::{SplitterName, TreeOptions};
use clap::ValueEnum;
use core::fmt;

/// The options for building a mesh.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Setting {
    pub(super) k: usize,
    pub(super) arity: usize,
    pub(super) leaf_size: u32,
    pub(super) splitter: SplitterName,
    pub(super) has_normal_slabs: bool,
}

/// Which settings are compared.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Sweep {
    /// All combinations of k, arity and leaf size; the other options one at a time.
    Cross,
    /// All combinations.
    Full,
}

/// k and arity.
const NODES: [(usize, usize); 5] = [(6, 16), (14, 16), (18, 16), (26, 16), (18, 4)];
const LEAF_SIZES: [u32; 4] = [1, 2, 4, 8];

/// The library's defaults.
const DEFAULT: Setting =
    Setting { k: 18, arity: 16, leaf_size: 1, splitter: SplitterName::MeanWidth, has_normal_slabs: true };

impl Sweep {
    /// The settings, without duplicates.
    pub(super) fn settings(self) -> Vec<Setting> {
        let mut all = Vec::new();
        for &splitter in SplitterName::value_variants() {
            for (has_normal_slabs, (k, arity)) in
                [true, false].into_iter().flat_map(|has_slabs| NODES.map(|node| (has_slabs, node)))
            {
                for leaf_size in LEAF_SIZES {
                    all.push(Setting { k, arity, leaf_size, splitter, has_normal_slabs });
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
        let Self { arity, leaf_size, splitter, has_normal_slabs, .. } = *self;
        let is_usual = (splitter, has_normal_slabs) == (DEFAULT.splitter, DEFAULT.has_normal_slabs);
        let is_thick = splitter == DEFAULT.splitter && arity == DEFAULT.arity && matches!(leaf_size, 1 | 4);
        let is_split_otherwise = Self { splitter: DEFAULT.splitter, ..*self } == DEFAULT;
        is_usual || is_thick || is_split_otherwise
    }

    pub(super) fn options(&self) -> TreeOptions {
        TreeOptions {
            k: Some(self.k),
            arity: Some(self.arity),
            leaf_size: Some(self.leaf_size),
            splitter: Some(self.splitter),
            without_normal_slabs: !self.has_normal_slabs,
            ..TreeOptions::default()
        }
    }

    /// In the form of `simdop build`'s options.
    pub(super) fn arguments(&self) -> String {
        let Self { k, arity, leaf_size, has_normal_slabs, .. } = self;
        let thin = if *has_normal_slabs { "" } else { " --without-normal-slabs" };
        format!("-k {k} -a {arity} -l {leaf_size} -s {}{thin}", self.splitter_name())
    }

    /// The splitter in the form of the options.
    pub(super) fn splitter_name(&self) -> String {
        self.splitter.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { k, arity, leaf_size, has_normal_slabs, .. } = self;
        let thin = if *has_normal_slabs { "with" } else { "without" };
        let s = if *leaf_size == 1 { "" } else { "s" };
        write!(
            f,
            "k {k}, arity {arity}, {leaf_size} triangle{s} a leaf, splitter {}, {thin} normal slabs",
            self.splitter_name()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_has_the_default_and_nothing_twice() {
        for (sweep, count) in [(Sweep::Cross, 55), (Sweep::Full, 480)] {
            let settings = sweep.settings();
            assert_eq!(settings.len(), count);
            assert!(settings.contains(&DEFAULT));
            for (i, setting) in settings.iter().enumerate() {
                assert!(!settings[..i].contains(setting), "{setting}");
            }
        }
        assert_eq!(
            DEFAULT.to_string(),
            "k 18, arity 16, 1 triangle a leaf, splitter mean-width, with normal slabs"
        );
    }
}
