//! The results as CSV, JSON and a digest of the reproducible part.

use super::approach::{DISTANCES, PerDistance};
use super::covers::CoveredBodies;
use super::front::Budget;
use super::packings::{Packed, Packings};
use super::peers::Peer;
use super::setting::Setting;
use serde::{Serialize, Serializer};
use std::io::Write;
use std::path::Path;

/// Measurements of a setting's trees, for one body or two.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(super) struct Measured {
    #[serde(serialize_with = "as_text")]
    pub(super) setting: Setting,
    pub(super) bytes: usize,
    pub(super) bytes_per_triangle: f64,
    pub(super) build_milliseconds: f64,
    /// Mean overestimate, in the mesh's unit.
    pub(super) overestimate_mean: f64,
    pub(super) overestimate_greatest: f64,
    pub(super) at: PerDistance<MeasuredAt>,
    /// The geometric mean of the medians at the distances.
    pub(super) geometric_mean_microseconds: f64,
    pub(super) is_on_front: bool,
}

/// Results at one distance: means over the poses, and times.
#[derive(Copy, Clone, PartialEq, Default, Debug, Serialize)]
pub(super) struct MeasuredAt {
    /// Poses at which the bodies meet.
    pub(super) hits: usize,
    pub(super) false_positives: f64,
    /// Number of pairs of leaves whose k-DOPs meet.
    pub(super) leaf_pairs: f64,
    pub(super) visits: f64,
    pub(super) triangle_pairs: f64,
    pub(super) median_microseconds: f64,
    pub(super) p99_microseconds: f64,
}

fn as_text<S: Serializer>(setting: &Setting, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(setting)
}

/// A measured body.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) triangles: usize,
    /// Diagonal of its box, in its unit.
    pub(super) diagonal: f64,
}

/// All results.
pub(super) struct Results {
    /// One body, tested against itself, or two.
    pub(super) subjects: Vec<Subject>,
    pub(super) isa: &'static str,
    /// Number of poses at each distance.
    pub(super) poses: usize,
    pub(super) seed: u64,
    pub(super) budget: Budget,
    pub(super) settings: Vec<Measured>,
    /// Index of a setting.
    pub(super) recommended: Option<usize>,
    pub(super) covers: Vec<CoveredBodies>,
    pub(super) packings: Packings,
    pub(super) peers: Vec<Peer>,
}

/// A line of the CSV file: a setting, a cover, a packing or a peer at a distance. Fields that do not apply are empty.
#[derive(Serialize, Default)]
struct Line<'r> {
    kind: &'static str,
    k: Option<usize>,
    arity: Option<usize>,
    storage: Option<String>,
    leaf_size: Option<u32>,
    splitter: Option<String>,
    normal_slabs: Option<bool>,
    spheres: Option<usize>,
    library: Option<&'r str>,
    distance: &'static str,
    hits: Option<usize>,
    bytes: Option<usize>,
    bytes_per_triangle: Option<f64>,
    overestimate_mean: Option<f64>,
    overestimate_greatest: Option<f64>,
    cover_error: Option<f64>,
    volume_error: Option<f64>,
    false_positives: Option<f64>,
    leaf_pairs: Option<f64>,
    triangle_pairs: Option<f64>,
    sphere_pairs: Option<f64>,
    visits: Option<f64>,
    // The fields from here on vary between runs.
    build_ms: Option<f64>,
    median_us: Option<f64>,
    p99_us: Option<f64>,
    is_on_front: Option<bool>,
}

impl<'r> Line<'r> {
    fn of_setting(measured: &Measured, distance: usize) -> Self {
        let (setting, at) = (&measured.setting, &measured.at[distance]);
        Self {
            kind: "tree",
            k: Some(setting.node.k),
            arity: Some(setting.node.arity),
            storage: Some(setting.storage_name()),
            leaf_size: Some(setting.leaf_size),
            splitter: Some(setting.splitter_name()),
            normal_slabs: Some(setting.has_normal_slabs),
            distance: DISTANCES[distance],
            hits: Some(at.hits),
            bytes: Some(measured.bytes),
            bytes_per_triangle: Some(measured.bytes_per_triangle),
            overestimate_mean: Some(measured.overestimate_mean),
            overestimate_greatest: Some(measured.overestimate_greatest),
            false_positives: Some(at.false_positives),
            leaf_pairs: Some(at.leaf_pairs),
            triangle_pairs: Some(at.triangle_pairs),
            visits: Some(at.visits),
            build_ms: Some(measured.build_milliseconds),
            median_us: Some(at.median_microseconds),
            p99_us: Some(at.p99_microseconds),
            is_on_front: Some(measured.is_on_front),
            ..Self::default()
        }
    }

    fn of_cover(covered: &CoveredBodies, distance: usize) -> Self {
        let at = &covered.at[distance];
        Self {
            kind: "cover",
            spheres: Some(covered.spheres),
            distance: DISTANCES[distance],
            hits: Some(at.hits),
            bytes: Some(covered.bytes),
            cover_error: Some(covered.error),
            visits: Some(at.visits),
            build_ms: Some(covered.build_milliseconds),
            median_us: Some(at.median_microseconds),
            p99_us: Some(at.p99_microseconds),
            ..Self::default()
        }
    }

    fn of_packing(packed: &Packed, distance: usize) -> Self {
        let at = &packed.at[distance];
        Self {
            kind: "packing",
            spheres: Some(packed.spheres),
            distance: DISTANCES[distance],
            bytes: Some(packed.bytes),
            volume_error: Some(packed.volume_error),
            sphere_pairs: Some(at.pairs),
            visits: Some(at.visits),
            median_us: Some(at.median_microseconds),
            p99_us: Some(at.p99_microseconds),
            ..Self::default()
        }
    }

    fn of_peer(peer: &'r Peer, distance: usize) -> Self {
        Self {
            kind: "peer",
            library: Some(&peer.library),
            distance: DISTANCES[distance],
            bytes_per_triangle: peer.bytes_per_triangle,
            build_ms: Some(peer.build_milliseconds),
            median_us: peer.median_microseconds[distance],
            ..Self::default()
        }
    }

    /// The line without the fields that vary between runs.
    fn repeatable(self) -> Self {
        Self { build_ms: None, median_us: None, p99_us: None, is_on_front: None, ..self }
    }
}

impl Results {
    pub(super) fn packed(&self) -> &[Packed] {
        if let Packings::Of(packed) = &self.packings { packed } else { &[] }
    }

    fn lines(&self) -> impl Iterator<Item = Line<'_>> {
        let distances = || 0..DISTANCES.len();
        let settings =
            self.settings.iter().flat_map(move |one| distances().map(|i| Line::of_setting(one, i)));
        let covers = self.covers.iter().flat_map(move |one| distances().map(|i| Line::of_cover(one, i)));
        let packed = self.packed().iter().flat_map(move |one| distances().map(|i| Line::of_packing(one, i)));
        let peers = self.peers.iter().flat_map(move |one| distances().map(|i| Line::of_peer(one, i)));
        settings.chain(covers).chain(packed).chain(peers)
    }

    pub(super) fn csv(&self) -> Vec<u8> {
        written(self.lines())
    }

    /// Digest of everything that is the same on every machine and instruction set: numbers of triangles, bytes,
    /// overestimates, false positives, hits and query statistics. Excludes times and other libraries.
    pub(super) fn digest(&self) -> String {
        let repeatable = self.lines().filter(|line| line.kind != "peer").map(Line::repeatable);
        let mut bytes = written(repeatable);
        for subject in &self.subjects {
            bytes.extend(subject.triangles.to_le_bytes());
        }
        // FNV-1a.
        let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, step))
    }

    /// A sentence about the recommended setting, and another about covers if one meets a given limit on the error.
    pub(super) fn recommendation(&self) -> String {
        let exact = self.recommended_setting();
        let Some(most) = self.budget.error else { return exact };
        let fits = |cover: &&CoveredBodies| {
            cover.error <= most && self.budget.flash.is_none_or(|flash| cover.bytes as u64 <= flash)
        };
        let Some(cover) = self.covers.iter().filter(fits).min_by_key(|cover| cover.bytes) else {
            return exact;
        };
        format!(
            "{exact} Spheres that cover the mesh within {} take {} bytes and {} µs: where they are free, so is the \
             mesh; where they hit, it is nearer than {}.",
            short(cover.error),
            cover.bytes,
            short(cover.geometric_mean_microseconds()),
            short(2.0 * cover.error),
        )
    }

    fn recommended_setting(&self) -> String {
        let budget = match (self.budget.error, self.budget.flash) {
            (None, None) => "Without a limit on error or flash".to_owned(),
            (Some(error), None) => format!("For volumes that stick out by at most {error}"),
            (None, Some(flash)) => format!("For {flash} bytes of flash"),
            (Some(error), Some(flash)) => {
                format!("For volumes that stick out by at most {error} and {flash} bytes of flash")
            }
        };
        let Some(best) = self.recommended.map(|index| &self.settings[index]) else {
            let least = self.settings.iter().map(|one| one.bytes).min().unwrap_or_default();
            let tightest = self.settings.iter().map(|one| one.overestimate_greatest);
            return format!(
                "{budget} there is no setting: the smallest takes {least} bytes, and the tightest volumes stick out by \
                 up to {}.",
                short(tightest.fold(f64::INFINITY, f64::min))
            );
        };
        format!(
            "{budget}, take {}: {} µs a query (geometric mean of the medians at the four distances), {} bytes ({} a \
             triangle), \
             volumes that stick out by at most {}, and {} ms to build.",
            best.setting,
            short(best.geometric_mean_microseconds),
            best.bytes,
            short(best.bytes_per_triangle),
            short(best.overestimate_greatest),
            short(best.build_milliseconds),
        )
    }
}

impl Results {
    /// Prints the results for a person or a program: only the settings on the front, since the files have all.
    pub(super) fn print(
        &self,
        digest: &str,
        files: [&Path; 2],
        json: bool,
        out: &mut impl Write,
    ) -> std::io::Result<()> {
        if json {
            let report = Report {
                version: env!("CARGO_PKG_VERSION"),
                subjects: &self.subjects,
                isa: self.isa,
                poses: self.poses,
                seed: self.seed,
                digest,
                recommendation: self.recommendation(),
                recommended: self.recommended,
                settings: &self.settings,
                covers: &self.covers,
                packings: self.packed(),
                peers: &self.peers,
            };
            writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
            return out.flush();
        }
        for Subject { name, triangles, diagonal } in &self.subjects {
            writeln!(out, "{name}: {triangles} triangles, diagonal {}", short(*diagonal))?;
        }
        writeln!(
            out,
            "{} settings at {} poses of each distance, {}",
            self.settings.len(),
            self.poses,
            self.isa
        )?;
        writeln!(out, "\n     us  bytes/triangle  greatest overestimate  on the front")?;
        let mut front: Vec<&Measured> = self.settings.iter().filter(|one| one.is_on_front).collect();
        front.sort_by(|a, b| a.geometric_mean_microseconds.total_cmp(&b.geometric_mean_microseconds));
        for one in front {
            writeln!(
                out,
                "{:>7}  {:>14}  {:>21}  {}",
                short(one.geometric_mean_microseconds),
                short(one.bytes_per_triangle),
                short(one.overestimate_greatest),
                one.setting
            )?;
        }
        writeln!(
            out,
            "\n     us  bytes        cover within  1 % deep, 0 %, 1 %, 5 %: hits of {}",
            self.poses
        )?;
        for cover in &self.covers {
            let hits = cover.at.each_ref().map(|at| at.hits.to_string()).join(", ");
            let (time, error) = (short(cover.geometric_mean_microseconds()), short(cover.error));
            writeln!(out, "{time:>7}  {:<11}  {error:<12}  {hits}", cover.bytes)?;
        }
        writeln!(out, "\n{}", self.recommendation())?;
        writeln!(out, "digest {digest}")?;
        writeln!(out, "{}, {}", files[0].display(), files[1].display())?;
        out.flush()
    }
}

#[derive(Serialize)]
struct Report<'r> {
    version: &'static str,
    subjects: &'r [Subject],
    isa: &'static str,
    poses: usize,
    seed: u64,
    digest: &'r str,
    recommendation: String,
    /// Index of a setting.
    recommended: Option<usize>,
    settings: &'r [Measured],
    covers: &'r [CoveredBodies],
    packings: &'r [Packed],
    peers: &'r [Peer],
}

/// The lines as CSV. Writing to memory does not fail.
fn written<'r>(lines: impl Iterator<Item = Line<'r>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in lines {
        let _ = writer.serialize(line);
    }
    writer.into_inner().unwrap_or_default()
}

/// A number with three significant digits.
pub(super) fn short(x: f64) -> String {
    let magnitude = x.abs();
    if x == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&magnitude) {
        format!("{x:.2e}")
    } else {
        let decimals = (2 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{x:.decimals$}")
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_three_digits() {
        let texts = [0.0, 1.0, 0.012345, 123.4, 98765.0, 1.5e-5, 2.0e7].map(short);
        assert_eq!(texts, ["0", "1.00", "0.0123", "123", "98765", "1.50e-5", "2.00e7"]);
    }
}
