//! The report of `simdop collide`: a table for people, an object for programs.

use super::StorageName;
use super::body::CapsReport;
use super::output;
use super::pair::Bodies;
use super::patches::PatchReport;
use alloc::rc::Rc;
use core::cell::Cell;
use core::ops::ControlFlow;
use serde::ser::{Serialize, SerializeSeq, Serializer};
use simdop::low_level::key::StorageKind;
use simdop::pose::Pose;
use simdop::query::{Completion, Pair, Query};
use std::io::{BufWriter, Write};

#[derive(serde::Serialize)]
pub(super) struct Report<'a> {
    pub(super) version: &'static str,
    pub(super) a: BodyReport,
    pub(super) b: BodyReport,
    /// k of the trees. Null if both bodies are shapes.
    pub(super) k: Option<usize>,
    pub(super) arity: Option<usize>,
    pub(super) storage: Option<StorageName>,
    pub(super) isa: &'static str,
    /// Budget in visits.
    pub(super) budget: Option<u64>,
    pub(super) repeat: u32,
    pub(super) summary: Summary,
    /// Poses, in the order of the file.
    pub(super) poses: Vec<PoseReport<'a>>,
}

#[derive(serde::Serialize)]
pub(super) struct BodyReport {
    pub(super) name: String,
    /// The kind of a body that is one shape: it has no triangles, and is neither read nor built.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) shape: Option<&'static str>,
    pub(super) triangles: Option<u32>,
    pub(super) degenerate_triangles: Option<u32>,
    pub(super) leaf_size: Option<u16>,
    pub(super) caps: Option<CapsReport>,
    /// The time to read and check the file. Null for a generated body.
    pub(super) read_nanoseconds: Option<u128>,
    /// The time to build the tree. Null for a tree from a file.
    pub(super) build_nanoseconds: Option<u128>,
}

#[derive(serde::Serialize)]
pub(super) struct PoseReport<'a> {
    pub(super) verdict: &'static str,
    /// The first pair of triangles found to meet, by their indices in the meshes. A shape has the index 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pair: Option<[u32; 2]>,
    /// All pairs that meet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pairs: Option<Pairs<'a>>,
    /// Whether the budget sufficed for all pairs. Follows the pairs, since it is known once they are written.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "known")]
    pub(super) pairs_complete: Option<Rc<Cell<bool>>>,
    /// The patches in which triangles touch; incomplete if the budget was exhausted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) patches: Option<Vec<PatchReport>>,
    /// Bounds on the distance, if the budget was exhausted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) distance_bounds: Option<[f64; 2]>,
    /// Time of the query, including set-up.
    pub(super) nanoseconds: u64,
    /// The time before the first visit.
    pub(super) set_up_nanoseconds: u64,
    pub(super) visits: u64,
    pub(super) kernels: u64,
    pub(super) realignments: u64,
    pub(super) primitive_pairs: u64,
    pub(super) exact_pairs: u64,
}

fn known<S: Serializer>(value: &Option<Rc<Cell<bool>>>, serializer: S) -> Result<S::Ok, S::Error> {
    value.as_deref().map(Cell::get).serialize(serializer)
}

/// Every pair of triangles that meet, found while writing them: there may be as many as the product of the numbers of
/// triangles.
pub(super) struct Pairs<'a> {
    bodies: &'a Bodies,
    query: Query,
    pose: &'a Pose,
    is_complete: Rc<Cell<bool>>,
}

impl<'a> Pairs<'a> {
    /// The pairs, and a flag that will hold whether the list is complete.
    pub(super) fn new(bodies: &'a Bodies, query: Query, pose: &'a Pose) -> (Self, Rc<Cell<bool>>) {
        let is_complete = Rc::new(Cell::new(false));
        (Self { bodies, query, pose, is_complete: is_complete.clone() }, is_complete)
    }

    /// Calls `write` for each pair until it fails.
    fn try_for_each<E>(&self, mut write: impl FnMut(Pair) -> Result<(), E>) -> Result<(), E> {
        let mut written = Ok(());
        let mut visit = |pair| {
            written = write(pair);
            if written.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let completion = self.bodies.for_each_pair(&self.query, self.pose, &mut visit);
        self.is_complete.set(completion == Completion::Complete);
        written
    }
}

impl Serialize for Pairs<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(None)?;
        self.try_for_each(|Pair { a, b }| list.serialize_element(&[a, b]))?;
        list.end()
    }
}

#[derive(serde::Serialize)]
pub(super) struct Summary {
    hits: usize,
    free: usize,
    unknown: usize,
    median_nanoseconds: u64,
    p99_nanoseconds: u64,
    max_nanoseconds: u64,
}

impl Summary {
    /// Summarizes the verdict and time of each pose. At least one pose.
    pub(super) fn of(poses: impl Iterator<Item = (&'static str, u64)>) -> Self {
        let (verdicts, mut times): (Vec<_>, Vec<_>) = poses.unzip();
        let count = |of| verdicts.iter().filter(|verdict| **verdict == of).count();
        times.sort_unstable();
        // Nearest rank: the smallest time that is not below the given percentage of all times.
        let rank = |percent: usize| (times.len() * percent).div_ceil(100).saturating_sub(1);
        let at = |percent| times.get(rank(percent)).copied().unwrap_or(0);
        Self {
            hits: count("hit"),
            free: count("free"),
            unknown: count("unknown"),
            median_nanoseconds: at(50),
            p99_nanoseconds: at(99),
            max_nanoseconds: at(100),
        }
    }
}

impl Summary {
    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        let Self { hits, free, unknown, .. } = self;
        writeln!(out, "{} poses: {hits} hits, {free} free, {unknown} unknown", hits + free + unknown)?;
        writeln!(
            out,
            "us per query: median {:.2}, p99 {:.2}, max {:.2}",
            microseconds(self.median_nanoseconds),
            microseconds(self.p99_nanoseconds),
            microseconds(self.max_nanoseconds)
        )
    }
}

fn microseconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e3
}

impl Report<'_> {
    pub(super) fn print_json(&self) -> std::io::Result<()> {
        let mut out = BufWriter::new(std::io::stdout().lock());
        serde_json::to_writer_pretty(&mut out, self)?;
        writeln!(out)?;
        out.flush()
    }

    /// Prints at most `rows` poses, then the summary.
    pub(super) fn print_table(&self, rows: usize) -> std::io::Result<()> {
        let mut out = BufWriter::new(std::io::stdout().lock());
        self.print_bodies(&mut out)?;
        writeln!(out, "\n  pose  verdict          us  visits  kernels  re-aligned  triangle pairs  exact")?;
        for (index, pose) in self.poses.iter().enumerate().take(rows) {
            pose.print(&mut out, index, [&self.a, &self.b])?;
        }
        output::rest(&mut out, self.poses.len(), rows)?;
        if self.poses.len() > 1 {
            self.print_summary(&mut out)?;
        }
        out.flush()
    }

    fn print_bodies(&self, out: &mut impl Write) -> std::io::Result<()> {
        for (letter, body) in [("A", &self.a), ("B", &self.b)] {
            write!(out, "{letter}  {}: ", body.name)?;
            match (body.shape, body.triangles) {
                (Some(_), _) => write!(out, "a shape")?,
                (None, triangles) => write!(out, "{} triangles", triangles.unwrap_or(0))?,
            }
            if let Some(caps) = body.caps {
                write!(out, ", {caps}")?;
            }
            let times = [("read", body.read_nanoseconds), ("built", body.build_nanoseconds)];
            for (what, time) in times {
                if let Some(nanoseconds) = time {
                    write!(out, ", {what} in {:.1} ms", nanoseconds as f64 / 1e6)?;
                }
            }
            writeln!(out)?;
        }
        if let (Some(k), Some(arity), Some(storage)) = (self.k, self.arity, self.storage) {
            write!(out, "k {k}, arity {arity}, {}, ", StorageKind::from(storage))?;
        }
        writeln!(out, "{}", self.isa)
    }

    fn print_summary(&self, out: &mut impl Write) -> std::io::Result<()> {
        let count = self.poses.len();
        let sum = |value: fn(&PoseReport<'_>) -> u64| self.poses.iter().map(value).sum::<u64>();
        let mean = |value| sum(value) as f64 / count as f64;
        writeln!(out)?;
        self.summary.print(out)?;
        writeln!(
            out,
            "per query: {:.1} visits, {:.1} kernels, {:.1} re-alignments, {:.1} triangle pairs; {} pairs in all were \
             exact",
            mean(|p| p.visits),
            mean(|p| p.kernels),
            mean(|p| p.realignments),
            mean(|p| p.primitive_pairs),
            sum(|p| p.exact_pairs)
        )
    }
}

impl PoseReport<'_> {
    fn print(&self, out: &mut impl Write, index: usize, bodies: [&BodyReport; 2]) -> std::io::Result<()> {
        let Self { verdict, visits, kernels, realignments, primitive_pairs, exact_pairs, .. } = self;
        write!(out, "{index:6}  {verdict:7} {:11.2} ", microseconds(self.nanoseconds))?;
        write!(out, "{visits:7} {kernels:8} {realignments:11} {primitive_pairs:15} {exact_pairs:6}")?;
        match (self.pair, self.distance_bounds) {
            (Some([a, b]), _) => match bodies.map(|body| body.shape.is_some()) {
                [false, false] => writeln!(out, "  triangle {a} of A meets {b} of B")?,
                [false, true] => writeln!(out, "  triangle {a} of A meets B")?,
                [true, false] => writeln!(out, "  A meets triangle {b} of B")?,
                [true, true] => writeln!(out, "  A meets B")?,
            },
            (_, Some([low, high])) => writeln!(out, "  the distance is in {low} ..= {high}")?,
            _ => writeln!(out)?,
        }
        for patch in self.patches.iter().flatten() {
            patch.print(out)?;
        }
        let Some(pairs) = &self.pairs else { return Ok(()) };
        pairs.try_for_each(|Pair { a, b }| writeln!(out, "        {a} {b}"))?;
        if !pairs.is_complete.get() {
            writeln!(out, "        the budget was spent: there may be more pairs")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_times_that_were_measured() {
        let of = |count: u64| {
            let s = Summary::of((1..=count).rev().map(|nanoseconds| ("free", nanoseconds)));
            (s.free as u64, s.median_nanoseconds, s.p99_nanoseconds, s.max_nanoseconds)
        };
        assert_eq!(of(1), (1, 1, 1, 1));
        assert_eq!(of(3), (3, 2, 3, 3));
        assert_eq!(of(200), (200, 100, 198, 200));
    }
}
