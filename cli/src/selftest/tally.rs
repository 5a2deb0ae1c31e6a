//! The results of a case: its row of the table.

use super::check::Wrong;
use super::trees::TreeFormat;
use serde::Serialize;
use simdop::isa::Isa;
use std::collections::BTreeSet;
use std::io::Write;

/// Maximum number of times in a median.
const TIMES: usize = 1 << 16;
/// Maximum number of wrong answers that are described for a case.
const DESCRIBED: usize = 4;

#[derive(Serialize)]
pub(super) struct CaseReport {
    case: &'static str,
    /// Bodies at a pose, or points, each tested on every instruction set.
    pairs: u64,
    /// Tree formats that occurred. Clouds have one format, which is not counted.
    formats: usize,
    hits: u64,
    /// Missed hits, summed over all instruction sets.
    missed: u64,
    invented: u64,
    /// Pairs for which instruction sets differ.
    unequal: u64,
    /// Pairs whose exact answer changes one unit in the last place away.
    knife_edge: u64,
    /// Number for the strongest instruction set; all agree.
    exact_pairs: u64,
    median_nanoseconds: u64,
    /// The median time relative to the benign case's, if that was run.
    times_benign: Option<f64>,
    /// Digest of all answers and query statistics: the same on every machine.
    digest: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wrong: Vec<WrongAnswer>,
    #[serde(skip)]
    benign: &'static str,
}

/// A wrong answer, with everything needed to reproduce it.
#[derive(Serialize)]
struct WrongAnswer {
    wrong: Wrong,
    isa: &'static str,
    trial: u64,
    /// Index among the trial's poses or points.
    place: usize,
    what: String,
    repeat: String,
}

/// One query, and the comparison of its answers with the truth.
pub(super) struct Asked<'t> {
    pub(super) trial: u64,
    pub(super) place: usize,
    pub(super) is_hit: bool,
    pub(super) is_knife_edge: bool,
    pub(super) exact_pairs: u64,
    pub(super) nanoseconds: u64,
    pub(super) wrong: Vec<(Wrong, Isa)>,
    pub(super) describe: &'t dyn Fn() -> String,
}

/// A row while it is computed.
pub(super) struct Tally<'t> {
    seed: u64,
    report: CaseReport,
    times: Vec<u64>,
    /// The formats, by name.
    formats: BTreeSet<String>,
    digest: u64,
    /// Called for each pair.
    progress: &'t dyn Fn(),
}

impl<'t> Tally<'t> {
    /// Starts a case, given its name and the name of its benign case.
    pub(super) fn new([case, benign]: [&'static str; 2], seed: u64, progress: &'t dyn Fn()) -> Self {
        let report = CaseReport {
            case,
            pairs: 0,
            formats: 0,
            hits: 0,
            missed: 0,
            invented: 0,
            unequal: 0,
            knife_edge: 0,
            exact_pairs: 0,
            median_nanoseconds: 0,
            times_benign: None,
            digest: String::new(),
            wrong: Vec::new(),
            benign,
        };
        Self {
            seed,
            report,
            times: Vec::new(),
            formats: BTreeSet::new(),
            digest: 0xcbf2_9ce4_8422_2325,
            progress,
        }
    }

    /// The number of pairs so far.
    pub(super) const fn pairs(&self) -> u64 {
        self.report.pairs
    }

    pub(super) fn add_format(&mut self, format: &TreeFormat) {
        self.formats.insert(format.to_string());
    }

    pub(super) fn add(&mut self, asked: Asked<'_>) {
        let report = &mut self.report;
        report.pairs += 1;
        report.hits += u64::from(asked.is_hit);
        report.knife_edge += u64::from(asked.is_knife_edge);
        report.exact_pairs += asked.exact_pairs;
        if self.times.len() < TIMES {
            self.times.push(asked.nanoseconds);
        }
        for (wrong, isa) in asked.wrong {
            *match wrong {
                Wrong::Missed => &mut report.missed,
                Wrong::Invented => &mut report.invented,
                Wrong::Unequal => &mut report.unequal,
            } += 1;
            if report.wrong.len() < DESCRIBED {
                let (case, seed, pairs) = (report.case, self.seed, report.pairs);
                report.wrong.push(WrongAnswer {
                    wrong,
                    isa: isa.name(),
                    trial: asked.trial,
                    place: asked.place,
                    what: (asked.describe)(),
                    repeat: format!("simdop selftest --case {case} --seed {seed} --pairs {pairs}"),
                });
            }
        }
        (self.progress)();
    }

    /// Adds the numbers of an answer. The digest is FNV-1a, by words, and depends on their order.
    pub(super) fn add_answer(&mut self, numbers: impl IntoIterator<Item = u64>) {
        for number in numbers {
            self.digest = (self.digest ^ number).wrapping_mul(0x100_0000_01b3).rotate_left(23);
        }
    }

    pub(super) fn finished(mut self) -> CaseReport {
        self.times.sort_unstable();
        CaseReport {
            median_nanoseconds: self.times.get(self.times.len() / 2).copied().unwrap_or(0),
            formats: self.formats.len(),
            digest: format!("{:016x}", self.digest),
            ..self.report
        }
    }
}

impl CaseReport {
    pub(super) fn is_right(&self) -> bool {
        self.wrong_answers() == [0; 3]
    }

    /// Numbers of missed, invented and unequal answers.
    pub(super) const fn wrong_answers(&self) -> [u64; 3] {
        [self.missed, self.invented, self.unequal]
    }

    /// Computes the time relative to that of the benign case, if it is among the others.
    pub(super) fn compare(&mut self, others: &[Self]) {
        let name = self.benign;
        let benign = others.iter().find(|other| other.case == name).map(|other| other.median_nanoseconds);
        let benign = if name == self.case { Some(self.median_nanoseconds) } else { benign };
        self.times_benign =
            benign.filter(|time| *time > 0).map(|time| self.median_nanoseconds as f64 / time as f64);
    }

    pub(super) fn print_head(out: &mut impl Write) -> std::io::Result<()> {
        writeln!(
            out,
            "{:28} {:>9} {:>8} {:>9} {:>7} {:>9} {:>8} {:>11} {:>11} {:>9} {:>9}",
            "case",
            "pairs",
            "formats",
            "hits",
            "missed",
            "invented",
            "unequal",
            "knife edges",
            "exact pairs",
            "median us",
            "x benign"
        )
    }

    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        let Self { case, pairs, formats, hits, missed, invented, unequal, knife_edge, exact_pairs, .. } =
            self;
        let microseconds = self.median_nanoseconds as f64 / 1e3;
        write!(out, "{case:28} {pairs:9} {formats:8} {hits:9} {missed:7} {invented:9} {unequal:8} ")?;
        write!(out, "{knife_edge:11} {exact_pairs:11} {microseconds:9.2} ")?;
        match self.times_benign {
            Some(times) => writeln!(out, "{times:9.2}"),
            None => writeln!(out, "{:>9}", "-"),
        }
    }

    pub(super) fn print_wrong(&self, out: &mut impl Write) -> std::io::Result<()> {
        for WrongAnswer { wrong, isa, trial, place, what, repeat } in &self.wrong {
            writeln!(out, "\n{wrong:?} by {isa}: {}, trial {trial}, place {place}", self.case)?;
            writeln!(out, "  {what}\n  again: {repeat}")?;
        }
        Ok(())
    }

    /// Numbers of pairs, hits, knife-edge pairs, and pairs of triangles or spheres that needed exact arithmetic.
    pub(super) const fn sums(&self) -> [u64; 4] {
        [self.pairs, self.hits, self.knife_edge, self.exact_pairs]
    }

    /// The digest of several cases.
    pub(super) fn joint_digest(reports: &[Self]) -> String {
        let digest = reports
            .iter()
            .flat_map(|report| report.digest.bytes())
            .fold(0xcbf2_9ce4_8422_2325_u64, |digest, byte| {
                (digest ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
            });
        format!("{digest:016x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(wrong: Vec<(Wrong, Isa)>) -> Asked<'static> {
        Asked {
            trial: 3,
            place: 5,
            is_hit: true,
            is_knife_edge: false,
            exact_pairs: 2,
            nanoseconds: 7,
            wrong,
            describe: &|| "there".into(),
        }
    }

    #[test]
    fn what_is_wrong_is_counted_and_described() {
        let mut tally = Tally::new(["near-parallel", "benign"], 9, &|| ());
        tally.add(asked(Vec::new()));
        tally.add(asked(vec![(Wrong::Missed, Isa::SCALAR), (Wrong::Unequal, Isa::SCALAR)]));
        let report = tally.finished();
        assert_eq!((report.missed, report.invented, report.unequal), (1, 0, 1));
        assert!(!report.is_right());
        assert_eq!(report.sums(), [2, 2, 0, 4]);
        let mut text = Vec::new();
        report.print_wrong(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("Missed by scalar: near-parallel, trial 3, place 5\n  there\n"), "{text}");
        assert!(text.contains("again: simdop selftest --case near-parallel --seed 9 --pairs 2"), "{text}");

        for wrong in [Wrong::Missed, Wrong::Invented, Wrong::Unequal] {
            let mut tally = Tally::new(["near-parallel", "benign"], 9, &|| ());
            assert!(Tally::new(["near-parallel", "benign"], 9, &|| ()).finished().is_right());
            tally.add(asked(vec![(wrong, Isa::SCALAR)]));
            assert!(!tally.finished().is_right(), "{wrong:?}");
        }
    }

    #[test]
    fn other_answers_have_another_digest() {
        let digest = |numbers: &[u64]| {
            let mut tally = Tally::new(["benign"; 2], 1, &|| ());
            tally.add_answer(numbers.iter().copied());
            tally.finished().digest
        };
        assert_eq!(digest(&[1, 2]), digest(&[1, 2]));
        assert_ne!(digest(&[1, 2]), digest(&[2, 1]));
        assert_ne!(digest(&[1, 2]), digest(&[1, 2, 0]));
    }
}
