//! Classifies which bodies of a robot can meet at all, for all values of its joints, and compares with its SRDF.

use super::model::moving_pairs;
use crate::progress;
use serde::Serialize;
use simdop::planning::{PlanningError, PlanningScene, RobotModel};
use simdop::query::Query;
use simdop::scene::{PairClass, PairReport};
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

/// Values of the joints, by name.
type Configuration = BTreeMap<String, f64>;

#[derive(Serialize)]
pub(super) struct FatesReport {
    /// Maximum number of boxes of values for a pair.
    boxes_allowed: usize,
    boxes: usize,
    seconds: f64,
    fates: Vec<FateReport>,
    /// Entries of the SRDF that are wrong.
    refuted: Vec<Refuted>,
    /// Every pair, tested or excluded by the SRDF.
    matrix: Vec<CertifiedPair>,
}

#[derive(Serialize)]
struct CertifiedPair {
    bodies: [String; 2],
    is_asked: bool,
    fate: &'static str,
    boxes: usize,
}

#[derive(Serialize)]
struct FateReport {
    fate: &'static str,
    asked: usize,
    ruled_out: usize,
}

#[derive(Serialize)]
struct Refuted {
    bodies: [String; 2],
    reason: String,
    /// Whether they meet there, or are apart.
    meets: bool,
    at: Configuration,
}

const FATES: [(PairClass, &str); 4] = [
    (PairClass::Never, "never"),
    (PairClass::Always, "always"),
    (PairClass::Sometimes, "sometimes"),
    (PairClass::Undecided, "undecided"),
];

pub(super) fn ask(
    model: &Arc<RobotModel>,
    query: Query,
    boxes: usize,
    quiet: bool,
) -> Result<FatesReport, PlanningError> {
    let scene = PlanningScene::new(Arc::clone(model))?.with_query(query);
    let mut workspace = scene.workspace();
    let pairs = moving_pairs(model);
    let mut report = FatesReport {
        boxes_allowed: boxes,
        boxes: 0,
        seconds: 0.0,
        fates: FATES.map(|(_, fate)| FateReport { fate, asked: 0, ruled_out: 0 }).into(),
        refuted: Vec::new(),
        matrix: Vec::new(),
    };
    let bar = progress::bar(pairs.len(), "pairs", quiet);
    let start = Instant::now();
    for (i, j) in pairs {
        let pair = (scene.links()[i], scene.links()[j]);
        let found = scene.classify_pair(&mut workspace, pair, boxes)?;
        report.add(model, (i, j), &found);
        bar.inc(1);
    }
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

impl FatesReport {
    fn add(&mut self, model: &RobotModel, (i, j): (usize, usize), found: &PairReport) {
        self.boxes += found.boxes;
        let bodies = || [i, j].map(|body| model.names()[body].clone());
        let is_asked = model.pairs().contains(&(i, j));
        for ((fate, name), report) in FATES.iter().zip(&mut self.fates) {
            if *fate == found.fate {
                *(if is_asked { &mut report.asked } else { &mut report.ruled_out }) += 1;
                let (bodies, boxes) = (bodies(), found.boxes);
                self.matrix.push(CertifiedPair { bodies, is_asked, fate: name, boxes });
            }
        }
        if is_asked {
            return;
        }
        let links = [i, j].map(|body| model.robot().names[body].as_str());
        let Some(entry) = model.disabled().iter().find(|entry| entry.is_of(links[0], links[1])) else {
            return;
        };
        if let Some((meets, values)) = counterexample(&entry.reason, found) {
            let at = model.robot().variables.iter().cloned().zip(values.iter().copied()).collect();
            self.refuted.push(Refuted { bodies: bodies(), reason: entry.reason.clone(), meets, at });
        }
    }

    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        writeln!(out, "\npairs meet        asked  ruled out")?;
        for FateReport { fate, asked, ruled_out } in &self.fates {
            writeln!(out, "{fate:15} {asked:7} {ruled_out:10}")?;
        }
        writeln!(
            out,
            "{} boxes of values in {:.2} s, at most {} a pair",
            self.boxes, self.seconds, self.boxes_allowed
        )?;
        for Refuted { bodies: [a, b], reason, meets, at } in &self.refuted {
            let how = if *meets { "meet" } else { "are apart" };
            writeln!(out, "refuted: \"{reason}\" of {a}, {b}: they {how} at")?;
            let values: Vec<String> = at.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
            writeln!(out, "    {}", values.join(", "))?;
        }
        for CertifiedPair { bodies: [a, b], is_asked, fate, .. } in &self.matrix {
            // Tested pairs that meet for no configuration, or for every one.
            if *is_asked && ["never", "always"].contains(fate) {
                writeln!(out, "asked, and they {fate} meet: {a}, {b}")?;
            }
        }
        Ok(())
    }
}

/// Values that refute the reason for excluding a pair: whether the bodies meet there, and the values. The reason
/// `Adjacent` allows everything. Excluding any other pair that meets for some values only hides collisions.
fn counterexample<'a>(reason: &str, found: &'a PairReport) -> Option<(bool, &'a [f64])> {
    let meeting = found.meeting.as_deref().map(|values| (true, values));
    match reason {
        "Adjacent" => None,
        "Never" => meeting,
        "Always" => found.free.as_deref().map(|values| (false, values)),
        _ => meeting.filter(|_| found.fate == PairClass::Sometimes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_is_refuted_by_what_it_denies() {
        let report = |fate, meeting: Option<f64>, free: Option<f64>| PairReport {
            fate,
            meeting: meeting.map(|x| vec![x]),
            free: free.map(|x| vec![x]),
            boxes: 1,
        };
        let sometimes = report(PairClass::Sometimes, Some(1.0), Some(2.0));
        let always = report(PairClass::Always, Some(1.0), None);
        let never = report(PairClass::Never, None, Some(2.0));
        let undecided = report(PairClass::Undecided, Some(1.0), None);
        let (meets, free) = (Some((true, 1.0)), Some((false, 2.0)));
        for (reason, want) in [
            ("Adjacent", [None; 4]),
            ("Never", [meets, meets, None, meets]),
            ("Always", [free, None, free, None]),
            ("Default", [meets, None, None, None]),
        ] {
            for (found, want) in [&sometimes, &always, &never, &undecided].into_iter().zip(want) {
                let got = counterexample(reason, found).map(|(meets, values)| (meets, values[0]));
                assert_eq!(got, want, "{reason}, {:?}", found.fate);
            }
        }
    }
}
