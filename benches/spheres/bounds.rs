//! Convergence of the bounds of a penetration volume: the lower and the upper bound and the estimate after a part of
//! the visits that the exact volume takes. Counted work: the same on every machine.

use super::queries::Scene;
use simdop::construct::{Magnification, Splitter};
use simdop::isa::Isa;
use simdop::query::Query;
use std::fmt::Write;

/// Shares of the visits.
const SHARES: [f64; 4] = [0.1, 0.25, 0.5, 0.75];

/// One scene: for each share of the visits, the medians of both bounds and of the estimate relative to the volume, and
/// of the estimate's error.
pub(crate) struct Row {
    scene: String,
    visits: u64,
    bounds: [[f64; 4]; SHARES.len()],
}

pub(crate) fn measure(scene: &Scene<'_>) -> Row {
    let [a, b] = scene.trees_of(Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 0 });
    let query = Query::new(Isa::detect());
    let mut found = SHARES.map(|_| [(); 4].map(|()| Vec::new()));
    let mut visits = Vec::new();
    for pose in scene.poses() {
        let whole = query.with_budget(u64::MAX - 1).penetration(&a, &b, pose);
        if whole.volume > 0.0 {
            visits.push(whole.stats.visits);
            for (share, [lower, upper, estimate, error]) in SHARES.iter().zip(&mut found) {
                let budget = (whole.stats.visits as f64 * share) as u64;
                let part = query.with_budget(budget).penetration(&a, &b, pose);
                assert!(part.volume <= whole.volume && whole.volume <= part.upper, "{part:?} {whole:?}");
                lower.push(part.volume / whole.volume);
                upper.push(part.upper / whole.volume);
                estimate.push(part.estimate / whole.volume);
                error.push((part.estimate / whole.volume - 1.0).abs());
            }
        }
    }
    visits.sort_unstable();
    let median = |mut numbers: Vec<f64>| {
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    };
    Row {
        scene: scene.describe(),
        visits: visits[visits.len() / 2],
        bounds: found.map(|numbers| numbers.map(median)),
    }
}

pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = String::from("| scene | visits, median |");
    for share in SHARES {
        write!(text, " bounds after {:.0} % |", 100.0 * share).unwrap();
    }
    writeln!(text, "\n|---|--:|{}", "--:|".repeat(SHARES.len())).unwrap();
    for Row { scene, visits, bounds } in rows {
        write!(text, "| {scene} | {visits} |").unwrap();
        for [lower, upper, estimate, error] in bounds {
            write!(text, " {lower:.2} to {upper:.2}, {estimate:.2} ± {error:.2} |").unwrap();
        }
        text.push('\n');
    }
    text
}
