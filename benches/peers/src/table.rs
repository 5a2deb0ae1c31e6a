//! The results as a page of Markdown.

use crate::entrants::{FCL_NATIVE, OPCODE, OURS};
use crate::measure::quantile;
use crate::record::Row;
use crate::summary::Summary;
use core::fmt::Write as _;

/// The project's targets: how many times as long the fastest exact peer and the fastest tree of FCL take, and the
/// maximum ratio of our p99 to the median.
const EXACT_BAR: f64 = 5.0;
const FCL_BAR: f64 = 10.0;
const TAIL_BAR: f64 = 3.0;

/// The page.
pub(crate) fn page(rows: &[Row], stamp: &str) -> String {
    let all = Summary::new(rows);
    let mut page = String::new();
    head(&mut page, rows, &all, stamp);
    medians(&mut page, &all);
    wins(&mut page, &all);
    spreads(&mut page, &all);
    builds(&mut page, &all);
    work(&mut page, &all);
    page
}

fn head(page: &mut String, rows: &[Row], all: &Summary<'_>, stamp: &str) {
    let _ = write!(
        page,
        "# simdop beside its peers\n\n\
        {stamp}. {}, one thread.\n\
        \n\
        {} run(s); {} poses for each mesh and distance, half by the sphere method, half by the grid method of\n\
        the suite by Trenkel, Weller and Zachmann. Distances are relative to the diagonal of A's box; \"0 %\" is a\n\
        gap of 2e-5. A time is the minimum of up to five passes over a block of ten poses; the libraries take\n\
        turns. Times include the conversion of the pose, and exclude the minimum time of reading the clock\n\
        twice. With several runs, a figure is their median.\n\n\
        ![Median time against distance](results.svg)\n\n\
        Versions: ",
        crate::cpu::cpu(),
        all.runs.len(),
        rows.first().map_or(0, |row| row.poses),
    );
    let version = |library: &&str| {
        let row = rows.iter().find(|row| row.library == *library);
        row.map(|row| {
            format!(
                "{library} {}",
                if Summary::is_ours(library) { format!("({})", row.version) } else { row.version.clone() }
            )
        })
    };
    let versions: Vec<String> = all.libraries.iter().filter_map(version).collect();
    let _ = write!(page, "{}.\n\n", versions.join(", "));
    page.push_str(
        "simdop, Coal, FCL and parry f64 store coordinates in f64; OPCODE, ODE, PhysX and parry f32 in f32. Coal,\n\
        FCL, ODE and Embree are compiled as in their packages. \"FCL native\" is FCL OBB with its templates\n\
        compiled here, OPCODE is ODE's copy and PhysX is its crate's; these three are compiled here with -O3\n\
        -march=native. ODE collects all pairs of triangles, the others stop at the first. Coal's break_distance\n\
        is 0: with its default, 1e-3 in any unit, it visits nodes that are separated. PhysX has tolerances in\n\
        its unit, so its bodies are scaled by a power of two to edges of about 1: in the units of the data it\n\
        reports false hits near contact. Embree finds pairs of boxes, which simdop's exact test decides. Its\n\
        trees have no pose, so its time includes the refit of A's tree.\n\n",
    );
}

/// The title of a page of [`near_contact`], and the meaning of its rows.
pub(crate) struct Labels {
    pub(crate) title: &'static str,
    pub(crate) mesh: &'static str,
    pub(crate) distance: &'static str,
}

/// A page with a row for each pair of bodies at each distance: times, our visits, and all wrong answers.
pub(crate) fn near_contact(rows: &[Row], labels: &Labels, about: &str) -> String {
    let all = Summary::new(rows);
    let mut page = format!("# {}\n\n{about}\n\n", labels.title);
    let peers = || all.libraries.iter().copied().filter(|library| *library != OURS);
    let mut cells = strings(&[labels.mesh, labels.distance, "hits", "visits, mean", "triangle pairs, mean"]);
    cells.push(format!("{OURS}, median / p99"));
    cells.extend(peers().map(str::to_owned));
    cells.extend([FCL_NATIVE, OPCODE].map(|peer| format!("{peer} / ours")));
    cells.push("wrong".to_owned());
    header(&mut page, "Median time of a query, µs", 2, &cells);
    for (mesh, distance) in all.meshes.iter().flat_map(|mesh| all.distances.iter().map(move |d| (mesh, d))) {
        let Some(ours) = all.rows(mesh, distance, OURS).next() else { continue };
        let median = |library: &str| all.value(mesh, distance, library, |row| row.median_us);
        let value = |of| all.value(mesh, distance, OURS, of).map_or_else(|| "-".to_owned(), short);
        let mut cells = strings(&[mesh, distance, &format!("{} of {}", ours.hits, ours.poses)]);
        cells.push(value(|row| row.visits.unwrap_or_default()));
        cells.push(value(|row| row.primitive_pairs.unwrap_or_default()));
        cells.push(format!("{} / {}", value(|row| row.median_us), value(|row| row.p99_us)));
        cells.extend(peers().map(|peer| median(peer).map_or_else(|| "-".to_owned(), short)));
        for peer in [FCL_NATIVE, OPCODE] {
            cells.push(match median(peer).zip(median(OURS)) {
                Some((theirs, ours)) => short(theirs / ours),
                None => "-".to_owned(),
            });
        }
        let wrong = |library: &&str| {
            let row = all.rows(mesh, distance, library).find(|row| row.wrong() > 0)?;
            Some(format!("{library} {} + {}", row.missed, row.invented))
        };
        let wrong: Vec<String> = all.libraries.iter().filter_map(wrong).collect();
        cells.push(if wrong.is_empty() { "none".to_owned() } else { wrong.join(", ") });
        row(&mut page, &cells);
    }
    page.push_str("\nWrong: answers \"free\" where the bodies meet + \"hit\" where they do not.\n");
    page
}

fn row(page: &mut String, cells: &[String]) {
    let _ = writeln!(page, "| {} |", cells.join(" | "));
}

fn header(page: &mut String, title: &str, words: usize, cells: &[String]) {
    let _ = write!(page, "## {title}\n\n");
    row(page, cells);
    let rules: Vec<String> =
        (0..cells.len()).map(|i| if i < words { "---" } else { "--:" }.to_owned()).collect();
    row(page, &rules);
}

fn strings(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Three significant digits.
pub(crate) fn short(x: f64) -> String {
    if x >= 100.0 {
        format!("{x:.0}")
    } else if x >= 10.0 {
        format!("{x:.1}")
    } else {
        format!("{x:.2}")
    }
}

fn median_of(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile(&sorted, 0.5)
}

/// A ratio, and in how many runs it meets the target.
fn judged(values: &[f64], keeps: impl Fn(f64) -> bool) -> String {
    if values.is_empty() {
        return "-".to_owned();
    }
    let kept = values.iter().filter(|value| keeps(**value)).count();
    format!("{} ({kept}/{})", short(median_of(values)), values.len())
}

fn medians(page: &mut String, all: &Summary<'_>) {
    let mut cells = strings(&["mesh", "distance"]);
    cells.extend(strings(&all.libraries));
    cells.push(format!("fastest exact peer / ours, target {EXACT_BAR}"));
    cells.push(format!("FCL / ours, target {FCL_BAR}"));
    cells.push(format!("our p99 / median, target {TAIL_BAR}"));
    header(page, "Median time of a query, µs", 2, &cells);
    let fcl: Vec<&str> = all.libraries.iter().copied().filter(|library| library.starts_with("FCL")).collect();
    for mesh in &all.meshes {
        let exact = all.exact_peers(mesh);
        for distance in &all.distances {
            let of = |library: &&str| all.value(mesh, distance, library, |row| row.median_us);
            let least = all.libraries.iter().filter_map(of).min_by(f64::total_cmp);
            let mut cells = strings(&[mesh, distance]);
            cells.extend(all.libraries.iter().map(|library| match of(library) {
                Some(time) if Some(time) == least => format!("**{}**", short(time)),
                Some(time) => short(time),
                None => "-".to_owned(),
            }));
            let tails: Vec<f64> =
                all.rows(mesh, distance, OURS).map(|row| row.p99_us / row.median_us).collect();
            cells.push(judged(&all.ratios(mesh, distance, &exact), |x| x >= EXACT_BAR));
            cells.push(judged(&all.ratios(mesh, distance, &fcl), |x| x >= FCL_BAR));
            cells.push(judged(&tails, |x| x <= TAIL_BAR));
            row(page, &cells);
        }
    }
    page.push_str(
        "\nIn brackets: the runs that meet the target. An exact peer of a mesh has no wrong answer on it. The fastest \
         is bold.\n\n",
    );
}

fn wins(page: &mut String, all: &Summary<'_>) {
    page.push_str("## Where a peer is faster\n\n");
    let mut any = false;
    for mesh in &all.meshes {
        for distance in &all.distances {
            let Some(ours) = all.value(mesh, distance, OURS, |row| row.median_us) else { continue };
            for library in all.libraries.iter().filter(|library| !Summary::is_ours(library)) {
                if let Some(time) =
                    all.value(mesh, distance, library, |row| row.median_us).filter(|time| *time < ours)
                {
                    any = true;
                    let (wrong, of) = all.wrong(mesh, library);
                    let _ = writeln!(
                        page,
                        "* {mesh}, {distance}: {library} takes {} µs, ours {} µs ({wrong} of {of} answers on the mesh \
                         wrong)",
                        short(time),
                        short(ours)
                    );
                }
            }
        }
    }
    page.push_str(if any { "\n" } else { "Nowhere, by the medians.\n\n" });
}

fn spreads(page: &mut String, all: &Summary<'_>) {
    let mut cells = strings(&["mesh", "distance", "hits"]);
    cells.extend(strings(&all.libraries));
    header(page, "Median / mean / 99th percentile / maximum time, µs", 2, &cells);
    for mesh in &all.meshes {
        for distance in &all.distances {
            let hits = all
                .rows(mesh, distance, OURS)
                .next()
                .map_or_else(String::new, |row| format!("{} of {}", row.hits, row.poses));
            let mut cells = strings(&[mesh, distance, &hits]);
            cells.extend(all.libraries.iter().map(|library| {
                let value = |of| all.value(mesh, distance, library, of).map_or_else(|| "-".to_owned(), short);
                let [median, mean, p99, most] = [
                    value(|row| row.median_us),
                    value(|row| row.mean_us),
                    value(|row| row.p99_us),
                    value(|row| row.max_us),
                ];
                format!("{median} / {mean} / {p99} / {most}")
            }));
            row(page, &cells);
        }
    }
    page.push('\n');
}

fn builds(page: &mut String, all: &Summary<'_>) {
    let mut cells = strings(&["mesh", "triangles"]);
    cells.extend(strings(&all.libraries));
    header(page, "Build, ms; bytes per triangle; wrong answers (missed + invented) of all", 1, &cells);
    for mesh in &all.meshes {
        let triangles = all
            .rows(mesh, "", OURS)
            .next()
            .map_or_else(String::new, |row| format!("{} and {}", row.triangles_a, row.triangles_b));
        let mut cells = strings(&[mesh, &triangles]);
        cells.extend(all.libraries.iter().map(|library| {
            let Some(build) = all.value(mesh, "", library, |row| row.build_ms) else { return "-".to_owned() };
            let bytes = all.rows(mesh, "", library).next().and_then(|row| row.bytes_per_triangle);
            let bytes = bytes.map_or_else(|| "?".to_owned(), |bytes| format!("{bytes:.0}"));
            let first = all.rows(mesh, "", library).filter(|row| Some(&row.run) == all.runs.first());
            let (missed, invented) = first.fold((0, 0), |(m, i), row| (m + row.missed, i + row.invented));
            format!("{}; {bytes}; {missed} + {invented} of {}", short(build), all.wrong(mesh, library).1)
        }));
        row(page, &cells);
    }
    page.push_str(
        "\nMissed: reported free where the bodies meet. Invented: reported hit where they do not. The truth is \
         brute force in exact arithmetic, at every pose.\n\n",
    );
}

fn work(page: &mut String, all: &Summary<'_>) {
    header(
        page,
        &format!("Work of a query, {OURS}, means"),
        2,
        &strings(&[
            "mesh",
            "distance",
            "visits",
            "kernels",
            "realignments",
            "triangle pairs",
            "of them exact",
        ]),
    );
    for mesh in &all.meshes {
        for distance in &all.distances {
            let value = |of| all.value(mesh, distance, OURS, of).map_or_else(|| "-".to_owned(), short);
            let mut cells = strings(&[mesh, distance]);
            cells.extend([
                value(|row| row.visits.unwrap_or_default()),
                value(|row| row.kernels.unwrap_or_default()),
                value(|row| row.realignments.unwrap_or_default()),
                value(|row| row.primitive_pairs.unwrap_or_default()),
                value(|row| row.exact_pairs.unwrap_or_default()),
            ]);
            row(page, &cells);
        }
    }
}
