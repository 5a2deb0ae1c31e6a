//! The results of the queries: tables and CSV.

use super::queries::{Cost, DIVISIONS, Row, Spread, Weights, Work};
use std::fmt::Write;

/// The table of one of the two queries. Numbers in brackets are relative to the first row of a group.
pub(crate) fn table(rows: &[Row], cost: fn(&Row) -> Cost) -> String {
    let mut text = String::from(
        "| scene | spheres | arity | partitioning | mean, us | median | p99 | visits | kernels | pairs tested | nodes \
         of both | depth |\n\
         |---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for group in rows.chunks(DIVISIONS.len()) {
        let first = cost(&group[0]);
        for row in group {
            let Row { scene, spheres, arity, division, nodes, depth, .. } = row;
            let Cost { mean, median, p99, work: Work { visits, kernels, pairs } } = cost(row);
            let [in_time, in_visits] = [mean / first.mean, visits / first.work.visits];
            // The number of nodes that a heuristic could not divide.
            let note = if row.balanced > 0 { format!(", {} balanced", row.balanced) } else { String::new() };
            writeln!(
                text,
                "| {scene} | {spheres} | {arity} | {division} | {mean:.2} ({in_time:.2}) | {median:.2} | {p99:.2} | \
                 {visits:.1} ({in_visits:.2}) | {kernels:.1} | {pairs:.1} | {nodes}{note} | {depth} |"
            )
            .unwrap();
        }
    }
    text
}

pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = String::from("scene,spheres,arity,partitioning,nodes,depth,balanced");
    for query in ["volume", "verdict"] {
        for column in ["mean", "median", "p99"] {
            write!(text, ",{query}_{column}_microseconds").unwrap();
        }
        write!(text, ",{query}_visits,{query}_kernels,{query}_pairs").unwrap();
    }
    for row in rows {
        let Row { scene, spheres, arity, division, nodes, depth, balanced, .. } = row;
        // One name has a comma.
        write!(text, "\n{scene},{spheres},{arity},\"{division}\",{nodes},{depth},{balanced}").unwrap();
        for Cost { mean, median, p99, work: Work { visits, kernels, pairs } } in [row.volume, row.verdict] {
            write!(text, ",{mean:.3},{median:.3},{p99:.3},{visits:.1},{kernels:.1},{pairs:.1}").unwrap();
        }
    }
    text.push('\n');
    text
}

pub(crate) fn table_of_weights(rows: &[Weights]) -> String {
    let mut text = String::from(
        "| scene | spheres | arity | volume: visits | kernels | pairs tested | yes or no: visits | kernels | pairs \
         tested |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for Weights { scene, spheres, arity, volume, verdict } in rows {
        write!(text, "| {scene} | {spheres} | {arity} |").unwrap();
        for Spread { mean, least, most } in volume.iter().chain(verdict) {
            write!(text, " {mean:.2} ({least:.2} to {most:.2}) |").unwrap();
        }
        text.push('\n');
    }
    text
}

/// Over all scenes and sizes: geometric means relative to the first row of each group.
pub(crate) fn summary(rows: &[Row]) -> String {
    let mut text = String::from(
        "| arity | partitioning | volume: time | visits | kernels | pairs tested | yes or no: time | visits | kernels \
         | pairs tested | nodes |\n\
         |--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for arity in [4, 16] {
        let of_arity = |group: &&[Row]| group[0].arity == arity;
        let groups: Vec<&[Row]> = rows.chunks(DIVISIONS.len()).filter(of_arity).collect();
        for index in 0..DIVISIONS.len() {
            let mean = |of: &dyn Fn(&Row) -> f64| {
                let logarithms = groups.iter().map(|group| (of(&group[index]) / of(&group[0])).ln());
                (logarithms.sum::<f64>() / groups.len() as f64).exp()
            };
            write!(text, "| {arity} | {} |", groups[0][index].division).unwrap();
            for query in [|row: &Row| row.volume, |row: &Row| row.verdict] {
                let [time, visits] = [mean(&|row| query(row).mean), mean(&|row| query(row).work.visits)];
                let [kernels, pairs] =
                    [mean(&|row| query(row).work.kernels), mean(&|row| query(row).work.pairs)];
                write!(text, " {time:.2} | {visits:.2} | {kernels:.2} | {pairs:.2} |").unwrap();
            }
            writeln!(text, " {:.2} |", mean(&|row| row.nodes as f64)).unwrap();
        }
    }
    text
}
