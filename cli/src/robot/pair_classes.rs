//! Classifies which bodies of a robot can meet, over all values of its joints, and compares the result with its SRDF.

use super::logged::Logged;
use super::model::moving_pairs;
use crate::markup::escaped;
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
pub(super) struct ClassesReport {
    /// Maximum number of boxes of values for a pair.
    boxes_allowed: usize,
    boxes: usize,
    /// Number of random configurations, in addition to the boxes.
    samples: usize,
    seconds: f64,
    classes: Vec<ClassReport>,
    /// Entries of the SRDF that are wrong.
    refuted: Vec<Refuted>,
    /// Every pair, tested or excluded by the SRDF.
    matrix: Vec<CertifiedPair>,
}

#[derive(Serialize)]
struct CertifiedPair {
    bodies: [String; 2],
    is_asked: bool,
    class: &'static str,
    boxes: usize,
}

#[derive(Serialize)]
struct ClassReport {
    class: &'static str,
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

const CLASSES: [(PairClass, &str); 4] = [
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
) -> Result<ClassesReport, PlanningError> {
    let scene = PlanningScene::new(Arc::clone(model))?.with_query(query);
    let mut workspace = scene.workspace();
    let pairs = moving_pairs(model);
    let mut report = ClassesReport {
        boxes_allowed: boxes,
        boxes: 0,
        samples: 0,
        seconds: 0.0,
        classes: CLASSES.map(|(_, class)| ClassReport { class, asked: 0, ruled_out: 0 }).into(),
        refuted: Vec::new(),
        matrix: Vec::new(),
    };
    let mut bar = Logged::new(pairs.len(), "pairs", quiet);
    let start = Instant::now();
    for (i, j) in pairs {
        let pair = (scene.links()[i], scene.links()[j]);
        let found = scene.classify_pair(&mut workspace, pair, boxes)?;
        report.add(model, (i, j), &found);
        bar.inc();
    }
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

impl ClassesReport {
    fn add(&mut self, model: &RobotModel, (i, j): (usize, usize), found: &PairReport) {
        (self.boxes, self.samples) = (self.boxes + found.boxes, self.samples + found.samples);
        let bodies = || [i, j].map(|body| model.names()[body].clone());
        let is_asked = model.pairs().contains(&(i, j));
        for ((class, name), report) in CLASSES.iter().zip(&mut self.classes) {
            if *class == found.class {
                *(if is_asked { &mut report.asked } else { &mut report.ruled_out }) += 1;
                let (bodies, boxes) = (bodies(), found.boxes);
                self.matrix.push(CertifiedPair { bodies, is_asked, class: name, boxes });
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

    /// An SRDF file that disables the pairs of links each of whose pairs of bodies meets never or always, and those
    /// that a joint connects.
    pub(super) fn srdf(&self, model: &RobotModel) -> String {
        let mut classes: BTreeMap<[&str; 2], Vec<&str>> = BTreeMap::new();
        for (pair, (i, j)) in self.matrix.iter().zip(moving_pairs(model)) {
            let [a, b] = [i, j].map(|body| model.robot().names[body].as_str());
            classes.entry([a.min(b), a.max(b)]).or_default().push(pair.class);
        }
        let links = &model.robot().links;
        for link in links {
            if let Some(parent) = &link.parent {
                let [a, b] = [link.name.as_str(), links[parent.link].name.as_str()];
                let _ = classes.insert([a.min(b), a.max(b)], vec!["adjacent"]);
            }
        }
        let mut text =
            format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(&model.robot().name));
        for ([a, b], classes) in classes {
            let all = |known: &[&str]| classes.iter().all(|class| known.contains(class));
            let reason = match () {
                () if all(&["adjacent"]) => "Adjacent",
                () if all(&["never"]) => "Never",
                () if all(&["never", "always"]) => "Always",
                () => continue,
            };
            let (a, b) = (escaped(a), escaped(b));
            text += &format!("  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>\n");
        }
        text + "</robot>\n"
    }

    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        writeln!(out, "\npairs meet        asked  ruled out")?;
        for ClassReport { class, asked, ruled_out } in &self.classes {
            writeln!(out, "{class:15} {asked:7} {ruled_out:10}")?;
        }
        writeln!(
            out,
            "{} boxes of values, at most {} a pair, and {} random configurations in {:.2} s",
            self.boxes, self.boxes_allowed, self.samples, self.seconds
        )?;
        for Refuted { bodies: [a, b], reason, meets, at } in &self.refuted {
            let how = if *meets { "meet" } else { "are apart" };
            writeln!(out, "refuted: \"{reason}\" of {a}, {b}: they {how} at")?;
            let values: Vec<String> = at.iter().map(|(name, value)| format!("{name} {value:.4}")).collect();
            writeln!(out, "    {}", values.join(", "))?;
        }
        for CertifiedPair { bodies: [a, b], is_asked, class, .. } in &self.matrix {
            // Tested pairs that meet for no configuration, or for every one.
            if *is_asked && ["never", "always"].contains(class) {
                writeln!(out, "asked, and they {class} meet: {a}, {b}")?;
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
        _ => meeting.filter(|_| found.class == PairClass::Sometimes),
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::URDF;
    use super::*;
    use simdop::planning::LinkGeometry;
    use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};

    /// Pairs that the file disables never meet at random configurations, unless a joint connects them.
    #[test]
    fn an_srdf_disables_what_never_meets() {
        let robot = Robot::from_urdf(URDF, LinkShapes::Collision).unwrap();
        let bodies = robot.shapes.iter().filter_map(LinkShape::shape).map(LinkGeometry::Shape).collect();
        let model = Arc::new(RobotModel::new(robot, bodies, Vec::new(), Vec::new()).unwrap());
        let query = Query::new(simdop::Isa::detect());
        let text = ask(&model, query, 4000, true).unwrap().srdf(&model);
        let disabled = DisabledPair::from_srdf(&text).unwrap();
        let scene = PlanningScene::new(Arc::clone(&model)).unwrap();
        let (mut workspace, mut random) = (scene.workspace(), crate::random::Random::new(3));
        let mut met = std::collections::BTreeSet::new();
        for _ in 0..5000 {
            let values = scene.random(|| random.unit());
            for hit in scene.hits(&mut workspace, &values, 0.0).unwrap() {
                let (a, b) = (scene.name(hit.a).to_owned(), scene.name(hit.b).to_owned());
                met.insert(if a < b { (a, b) } else { (b, a) });
            }
        }
        let reason =
            |a: &str, b: &str| disabled.iter().find(|pair| pair.is_of(a, b)).map(|pair| &*pair.reason);
        let names = ["base", "column", "upper_arm", "forearm", "hand"];
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate().skip(i + 1) {
                let key = if a < b { (*a, *b) } else { (*b, *a) };
                let does_meet = met.contains(&(key.0.to_owned(), key.1.to_owned()));
                match reason(a, b) {
                    Some("Adjacent") => assert_eq!(j, i + 1, "{a} {b}"),
                    Some("Never") => assert!(!does_meet && j > i + 1, "{a} {b}"),
                    other => assert!(other.is_none() && j > i + 1, "{a} {b}"),
                }
            }
        }
        let count = |reason: &str| disabled.iter().filter(|pair| pair.reason == reason).count();
        assert!(count("Adjacent") == 4 && count("Never") > 0 && disabled.len() < 10, "{text}");
    }

    #[test]
    fn a_reason_is_refuted_by_what_it_denies() {
        let report = |class, meeting: Option<f64>, free: Option<f64>| PairReport {
            class,
            meeting: meeting.map(|x| vec![x]),
            free: free.map(|x| vec![x]),
            boxes: 1,
            samples: 0,
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
                assert_eq!(got, want, "{reason}, {:?}", found.class);
            }
        }
    }
}
