//! `simdop selftest`: hard cases on the user's machine, each answer compared with an oracle that shares no code with
//! the library.
//!
//! A *trial* is two bodies, built in one of the formats, and up to 64 poses. Each pose is a *pair*: the [`oracle`]
//! decides it, and queries run on every available instruction set. The input of a trial depends only on the seed, the
//! case and the number of the trial, so that a run of one case reproduces its part of a run of all cases.

mod cases;
mod check;
mod draw;
mod figures;
mod oracle;
mod points;
mod tally;
mod trees;
mod trial;

use super::error::Error;
use super::progress;
use cases::{CASES, HardCase, Maker};
use check::Wrong;
use clap::Args;
use draw::Draw;
use oracle::{Matrix, Oracle, Truth};
use serde::Serialize;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Answer, AnyError, QueryStats, Verdict};
use std::io::{BufWriter, Write};
use std::time::Instant;
use tally::{Asked, CaseReport, Tally};
use trees::{Bodies, BodyTrees, TreeFormat};
use trial::Trial;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// Number of pairs to generate: two bodies at a pose, in one of the formats, or a point of a cloud. Each is tested
    /// on every instruction set of this machine.
    #[arg(long, value_name = "COUNT", default_value_t = 250_000, value_parser = clap::value_parser!(u64).range(1..))]
    pairs: u64,
    /// Seed of the random input.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Run only this case.
    #[arg(long, value_name = "NAME", value_parser = hard_case)]
    case: Option<HardCase>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

fn hard_case(text: &str) -> Result<HardCase, String> {
    CASES.into_iter().find(|case| case.name == text).ok_or_else(|| {
        let names: Vec<&str> = CASES.iter().map(|case| case.name).collect();
        format!("must be one of {}", names.join(", "))
    })
}

#[derive(Serialize)]
struct SelfTestReport {
    version: &'static str,
    isas: Vec<&'static str>,
    seed: u64,
    is_right: bool,
    pairs: u64,
    hits: u64,
    knife_edge: u64,
    exact_pairs: u64,
    seconds: f64,
    /// Digest of all answers and query statistics of all cases: the same on every machine.
    digest: String,
    cases: Vec<CaseReport>,
}

pub(super) fn run(options: &Options) -> Result<u8, Error> {
    let selected: Vec<HardCase> = options.case.map_or_else(|| CASES.into(), |case| vec![case]);
    let shares: u64 = selected.iter().map(|case| case.share).sum();
    // At least one pair per case.
    let counts = selected.iter().map(|case| (options.pairs * case.share).div_ceil(shares));
    let counts: Vec<u64> = counts.collect();
    let bar = progress::bar(counts.iter().sum::<u64>() as usize, "pairs", options.json);
    let tick = || bar.inc(1);
    let start = Instant::now();
    let mut reports = Vec::new();
    for (case, count) in selected.iter().zip(counts) {
        let mut tally = Tally::new([case.name, case.benign], options.seed, &tick);
        run_case(case, count, options.seed, &mut tally)?;
        let mut report = tally.finished();
        report.compare(&reports);
        reports.push(report);
    }
    drop(bar);
    let sums = reports.iter().map(CaseReport::sums);
    let [pairs, hits, knife_edge, exact_pairs] =
        sums.fold([0; 4], |sums, row| core::array::from_fn(|i| sums[i] + row[i]));
    let report = SelfTestReport {
        version: env!("CARGO_PKG_VERSION"),
        isas: Isa::available().map(Isa::name).collect(),
        seed: options.seed,
        is_right: reports.iter().all(CaseReport::is_right),
        pairs,
        hits,
        knife_edge,
        exact_pairs,
        seconds: start.elapsed().as_secs_f64(),
        digest: CaseReport::joint_digest(&reports),
        cases: reports,
    };
    let code = u8::from(!report.is_right);
    match report.print(options.json, &mut BufWriter::new(std::io::stdout().lock())) {
        // The reader closed the pipe. The verdict is valid all the same.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(code),
        printed => printed.map(|()| code).map_err(Error::Output),
    }
}

/// Runs trials until there are enough pairs.
fn run_case(case: &HardCase, count: u64, seed: u64, tally: &mut Tally<'_>) -> Result<(), Error> {
    for trial in 0.. {
        let left = usize::try_from(count - tally.pairs()).unwrap_or(usize::MAX);
        if left == 0 {
            break;
        }
        let format = TreeFormat::of(trial);
        let mut draw = Draw::new(seed, case.name, trial, format.is_single);
        match case.maker {
            Maker::Points(make) => make(&mut draw).ask(left, trial, tally)?,
            Maker::Bodies(make) => {
                let mut drawn = make(&mut draw);
                drawn.poses.truncate(left);
                let failed = |problem: String| {
                    let name = format!("{}, seed {seed}, trial {trial}, {format}", case.name);
                    Error::SelfTest { name, problem }
                };
                tally.add_format(&format);
                let trees = BodyTrees::build(&drawn, &format).map_err(|error| failed(error.to_string()))?;
                ask(&trees, &drawn, (trial, &format), tally).map_err(failed)?;
            }
        }
    }
    Ok(())
}

/// For one in this many poses, the test also enumerates all pairs of triangles.
const POSES_FOR_ALL_PAIRS: usize = 8;

/// Runs the queries of a trial and compares them with the oracle.
fn ask(
    bodies: &dyn Bodies,
    drawn: &Trial,
    (trial, format): (u64, &TreeFormat),
    tally: &mut Tally<'_>,
) -> Result<(), String> {
    let oracle = Oracle::new(&drawn.a, &drawn.b);
    for (place, rows) in drawn.poses.iter().enumerate() {
        let pose = Pose::from_rows(*rows).map_err(|error| error.to_string())?;
        let truth = oracle.truth(rows);
        let (answers, nanoseconds) = answers(bodies, &pose).map_err(|error| error.to_string())?;
        let mut wrong = check::verdicts(truth, &answers, |a, b| oracle.is_witness(rows, a, b));
        let mut wrong_pairs = Vec::new();
        if place % POSES_FOR_ALL_PAIRS == 0 && drawn.a.copies == 1 {
            wrong_pairs = all_pairs(bodies, &oracle, rows, &pose).map_err(|error| error.to_string())?;
            wrong.extend(&wrong_pairs);
        }
        if let Some((_, answer)) = answers.last() {
            tally.add_answer(numbers(answer));
        }
        tally.add(Asked {
            trial,
            place,
            is_hit: truth.meets,
            is_knife_edge: truth.is_knife_edge,
            exact_pairs: answers.last().map_or(0, |(_, answer)| answer.stats.exact_pairs),
            nanoseconds,
            wrong,
            describe: &|| described(format, rows, truth, &answers) + &of_all_pairs(&wrong_pairs),
        });
    }
    Ok(())
}

/// The answers of all instruction sets, weakest first, and the time of the last one, which runs with warm caches.
fn answers(bodies: &dyn Bodies, pose: &Pose) -> Result<(Vec<(Isa, Answer)>, u64), AnyError> {
    let (mut answers, mut nanoseconds) = (Vec::with_capacity(4), 0);
    for isa in Isa::available() {
        let start = Instant::now();
        let answer = bodies.collide(isa, pose)?;
        nanoseconds = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        answers.push((isa, answer));
    }
    Ok((answers, nanoseconds))
}

fn all_pairs(
    bodies: &dyn Bodies,
    oracle: &Oracle<'_>,
    rows: &Matrix,
    pose: &Pose,
) -> Result<Vec<(Wrong, Isa)>, AnyError> {
    let mut found = Vec::new();
    for isa in Isa::available() {
        match bodies.pairs(isa, pose) {
            Some(pairs) => found.push((isa, pairs?)),
            None => return Ok(Vec::new()),
        }
    }
    Ok(check::all_pairs(&oracle.pairs(rows).into_iter().collect(), &found))
}

/// The answer as input of the digest.
fn numbers(answer: &Answer) -> [u64; 7] {
    let QueryStats { visits, kernels, realignments, primitive_pairs, exact_pairs } = answer.stats;
    let [verdict, pair] = match answer.verdict {
        Verdict::Free => [0, 0],
        Verdict::Hit(pair) => [1, u64::from(pair.a) << 32 | u64::from(pair.b)],
        Verdict::Unknown { .. } => [2, 0],
    };
    [verdict, pair, visits, kernels, realignments, primitive_pairs, exact_pairs]
}

fn described(format: &TreeFormat, rows: &Matrix, truth: Truth, answers: &[(Isa, Answer)]) -> String {
    let numbers: Vec<String> = rows.iter().flatten().map(|x| format!("{x:?}")).collect();
    let answers: Vec<String> =
        answers.iter().map(|(isa, answer)| format!("{isa} {:?}", answer.verdict)).collect();
    let truth = if truth.meets { "they meet" } else { "they do not meet" };
    format!("{format}\n  pose {}\n  {truth}; {}", numbers.join(" "), answers.join(", "))
}

/// Describes errors in the enumeration of all pairs, which can occur even if the first hit is right.
fn of_all_pairs(wrong: &[(Wrong, Isa)]) -> String {
    let each = wrong.iter().map(|(wrong, isa)| format!("\n  of all pairs of triangles: {wrong:?} by {isa}"));
    each.collect()
}

impl SelfTestReport {
    fn print(&self, json: bool, out: &mut impl Write) -> std::io::Result<()> {
        if json {
            writeln!(out, "{}", serde_json::to_string_pretty(self)?)?;
            return out.flush();
        }
        CaseReport::print_head(out)?;
        for case in &self.cases {
            case.print(out)?;
        }
        for case in &self.cases {
            case.print_wrong(out)?;
        }
        let Self { pairs, hits, knife_edge, exact_pairs, seconds, digest, seed, .. } = self;
        writeln!(out, "\nA format is {}.", TreeFormat::CHOICES)?;
        writeln!(
            out,
            "{pairs} pairs, each on {}: {hits} hits, {knife_edge} on a knife's edge, {exact_pairs} pairs of primitives \
             in exact arithmetic",
            self.isas.join(", ")
        )?;
        let verdict = if self.is_right { "every answer is right" } else { "THERE ARE WRONG ANSWERS" };
        writeln!(out, "{verdict}; seed {seed}, digest {digest}, {seconds:.1} s")?;
        out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use figures::resized;
    use oracle::Figure;
    use simdop::query::{Hint, Pair};
    use trees::AllPairs;

    /// Bodies that answer correctly, but for other sizes than the oracle's: stand for a library that misses collisions
    /// or invents them.
    struct Resized {
        a: Figure,
        b: Figure,
        /// Whether the scalar code reports other statistics.
        is_unequal: bool,
    }

    impl Bodies for Resized {
        fn collide(&self, isa: Isa, pose: &Pose) -> Result<Answer, AnyError> {
            let (pairs, mut stats) = self.pairs(isa, pose).unwrap()?;
            let verdict = pairs.first().map_or(Verdict::Free, |&(a, b)| Verdict::Hit(Pair { a, b }));
            stats.visits = u64::from(self.is_unequal && isa == Isa::SCALAR);
            Ok(Answer { verdict, stats, hint: Hint::NONE })
        }

        fn pairs(&self, _: Isa, pose: &Pose) -> Option<Result<AllPairs, AnyError>> {
            let (rows, t) = (pose.rows(), pose.translation());
            let rows: Matrix =
                core::array::from_fn(|i| core::array::from_fn(|j| if j < 3 { rows[i][j] } else { t[i] }));
            let pairs = Oracle::new(&self.a, &self.b).pairs(&rows);
            Some(Ok((pairs.into_iter().collect(), QueryStats::default())))
        }
    }

    #[test]
    fn wrong_answers_are_noticed() {
        let format = TreeFormat::of(0);
        let mut draw = Draw::new(1, "benign", 0, format.is_single);
        let Maker::Bodies(make) = CASES[0].maker else { panic!("the first case is of bodies") };
        let drawn = make(&mut draw);
        let judged = |by: f64, is_unequal: bool| {
            let figure =
                |figure: &Figure| Figure::surface(resized(figure.triangles().copied().collect(), by));
            let bodies = Resized { a: figure(&drawn.a), b: figure(&drawn.b), is_unequal };
            let mut tally = Tally::new([CASES[0].name, CASES[0].benign], 1, &|| ());
            ask(&bodies, &drawn, (0, &format), &mut tally).unwrap();
            tally.finished()
        };
        let right = judged(1.0, false);
        assert!(right.is_right());
        assert_eq!(right.sums()[0], 64);
        let (smaller, larger, unequal) = (judged(0.9, false), judged(1.1, false), judged(1.0, true));
        assert!(smaller.wrong_answers()[0] > 0 && larger.wrong_answers()[1] > 0);
        for wrong in [&smaller, &larger] {
            assert_eq!(wrong.wrong_answers()[2], 0, "all instruction sets are as wrong");
        }
        // With scalar code alone nothing can differ.
        let differ = Isa::available().count() > 1;
        assert_eq!(unequal.wrong_answers(), [0, 0, if differ { 64 } else { 0 }]);
        assert!(!smaller.is_right() && !larger.is_right());
    }
}
