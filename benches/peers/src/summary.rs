//! Rows of several runs, grouped by mesh, distance and library.

use crate::entrants::OURS;
use crate::measure::quantile;
use crate::record::Row;

/// All measurements.
pub(crate) struct Summary<'r> {
    rows: &'r [Row],
    pub(crate) meshes: Vec<&'r str>,
    pub(crate) distances: Vec<&'r str>,
    pub(crate) libraries: Vec<&'r str>,
    pub(crate) runs: Vec<u32>,
}

/// The distinct items, in the order of first appearance.
fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    items.fold(Vec::new(), |mut all, item| {
        if !all.contains(&item) {
            all.push(item);
        }
        all
    })
}

impl<'r> Summary<'r> {
    pub(crate) fn new(rows: &'r [Row]) -> Self {
        Self {
            rows,
            meshes: distinct(rows.iter().map(|row| row.mesh.as_str())),
            distances: distinct(rows.iter().map(|row| row.distance.as_str())),
            libraries: distinct(rows.iter().map(|row| row.library.as_str())),
            runs: distinct(rows.iter().map(|row| row.run)),
        }
    }

    /// Rows of a library for a mesh and a distance, or all distances if empty.
    pub(crate) fn rows(&self, mesh: &str, distance: &str, library: &str) -> impl Iterator<Item = &'r Row> {
        let any = distance.is_empty();
        self.rows.iter().filter(move |row| {
            row.mesh == mesh && row.library == library && (any || row.distance == distance)
        })
    }

    /// The median over the runs.
    pub(crate) fn value(
        &self,
        mesh: &str,
        distance: &str,
        library: &str,
        of: fn(&Row) -> f64,
    ) -> Option<f64> {
        let mut values: Vec<f64> = self.rows(mesh, distance, library).map(of).collect();
        values.sort_by(f64::total_cmp);
        (!values.is_empty()).then(|| quantile(&values, 0.5))
    }

    /// Wrong answers on a mesh at all distances, and the number of answers. Runs repeat them: takes the worst run.
    pub(crate) fn wrong(&self, mesh: &str, library: &str) -> (usize, usize) {
        let in_run = |run: &u32| {
            let rows = self.rows(mesh, "", library).filter(|row| row.run == *run);
            rows.fold((0, 0), |(wrong, all), row| (wrong + row.wrong(), all + row.poses))
        };
        self.runs.iter().map(in_run).max().unwrap_or((0, 0))
    }

    pub(crate) fn is_ours(library: &str) -> bool {
        library.starts_with("simdop")
    }

    /// The peers without a wrong answer on the mesh.
    pub(crate) fn exact_peers(&self, mesh: &str) -> Vec<&'r str> {
        let peers = self.libraries.iter().copied().filter(|library| !Self::is_ours(library));
        peers.filter(|library| matches!(self.wrong(mesh, library), (0, 1..))).collect()
    }

    /// For each run, the ratio of the fastest of these peers to ours, by the medians.
    pub(crate) fn ratios(&self, mesh: &str, distance: &str, peers: &[&str]) -> Vec<f64> {
        let in_run = |run: &u32| {
            let median = |library: &str| {
                self.rows(mesh, distance, library).find(|row| row.run == *run).map(|row| row.median_us)
            };
            let fastest = peers.iter().filter_map(|library| median(library)).min_by(f64::total_cmp)?;
            Some(fastest / median(OURS)?)
        };
        self.runs.iter().filter_map(in_run).collect()
    }
}
