//! The page of results.

use super::batches::Row;
use super::single;
use super::{Options, entrants};
use crate::cpu::cpu;
use std::fmt::Write;

/// Name, title and description of each table.
const TABLES: [(&str, &str, &str); 5] = [
    ("growth", "Growth", "Uniform points in a cube, about 30 neighbours each."),
    (
        "radii",
        "Radii",
        "Uniform points, with increasing numbers of neighbours; near the cube's faces a point has fewer than \
         the row states.",
    ),
    (
        "scenes",
        "Scenes",
        "The sweeps are in $SIMDOP_DATA/points. About 5,100 points of each lidar sweep are exactly (0, 0, 0): \
         the tables have the sweeps with and without them.",
    ),
    (
        "particles",
        "Particles of different densities",
        "The radius of each particle gives about 30 neighbours of its own density, or all have the same \
         radius. Halos: eight centres; the distance of a particle from its centre is 10 to a power between -4 \
         and 0.",
    ),
    ("odd", "Odd clouds", "Few points, coincident ones, flat ones."),
];

/// For fewer points the allocator is too coarse to measure memory.
const FEW: usize = 1000;

type Measure = (&'static str, fn(&Row) -> f64);

const COUNT: Measure = ("count", |row| row.count_ms);
const FILL: Measure = ("fill", |row| row.fill_ms);
const BUILD: Measure = ("build", |row| row.build_ms);
const MEMORY: Measure = ("memory", |row| row.bytes_per_point);

pub(crate) fn page(batches: &[Row], singles: &[single::Row], options: &Options) -> String {
    let mut page =
        format!("# Neighbours of points, beside peers\n\n{}. {}, one thread.\n\n", options.stamp, cpu());
    page += &about(batches);
    for (table, title, text) in TABLES {
        let rows: Vec<&Row> = batches.iter().filter(|row| row.table == table).collect();
        if rows.is_empty() {
            continue;
        }
        let _ = write!(page, "## {title}\n\n{text}\n\n");
        for (what, unit) in [
            (COUNT, "Count, ms"),
            (FILL, "Fill, ms"),
            (BUILD, "Build, and simdop's refit, ms"),
            (MEMORY, "Memory, bytes per point"),
        ] {
            let _ = write!(page, "{unit}; in brackets relative to simdop:\n\n");
            page += &compared(&rows, what);
        }
    }
    page += &growth(batches);
    page += &asked(singles);
    page += &losses(batches, singles);
    page + &disagreements(batches, singles)
}

fn about(rows: &[Row]) -> String {
    let mut versions: Vec<String> =
        rows.iter().map(|row| format!("{} {}", row.library, row.version)).collect();
    versions.push(format!("capt {}", entrants::capt_version()));
    versions.sort();
    versions.dedup();
    let features = if cfg!(feature = "simd") {
        "with their SIMD, which needs unstable features of the compiler"
    } else {
        "without their SIMD, which needs unstable features of the compiler"
    };
    format!(
        "Versions: {}.\n\
        \n\
        Every point of a cloud is a query for all points within its radius, itself included. *Count*: the number\n\
        of neighbours of each. *Fill*: their indices, in memory passed by the caller (kiddo's join allocates its\n\
        own). Libraries take turns: one builds, searches and refits, then the next, in at least three and at\n\
        most eleven rounds. A figure is the median over the rounds, in processor time, which excludes other\n\
        programs. Memory is what is allocated from the C library after the build, by Rust and C++ alike.\n\
        \n\
        kiddo and capt are compiled for this processor, {features}. \"kiddo\" is its immutable tree, queried point\n\
        by point in the order of its leaves with its scratch memory, without items and distances where these are\n\
        not needed. \"kiddo mutable\" is its mutable tree, which cannot be built where many points coincide.\n\
        \"kiddo join\" joins two immutable trees of the same points, as it requires two; it has one radius and\n\
        answers in unordered pairs. nanoflann is compiled with -O3 -march=native, has {} points per leaf, counts\n\
        and fills through result sets of this package that allocate nothing, and is queried in the order of its\n\
        leaves. Its comparison is strict, so it gets the next float after the square, and its sums are not fused\n\
        (-ffp-contract=off), so that its answers are the same. The grids are this package's\n\
        (`src/points/grid.rs`): points sorted by cell, sixteen tested at a time. \"dense\" has an array of cells,\n\
        at most 256 cubed, \"hashed\" a table of nonempty cells; the cell side is the fastest of about 25, found\n\
        by trials that are not timed. Grids are built for the radii of one cloud, the other structures for any.\n\
        \n\
        Before timing, the counts and sets of up to 128 queries are compared with brute force, and all counts\n\
        with simdop's; differences are listed at the end.\n\n",
        versions.join(", "),
        entrants::LEAF,
    )
}

fn libraries(rows: &[&Row]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        if !names.contains(&row.library) {
            names.push(row.library.clone());
        }
    }
    names
}

/// Rows of the same cloud, simdop's first.
fn by_cloud<'a>(rows: &[&'a Row]) -> Vec<Vec<&'a Row>> {
    let mut clouds: Vec<Vec<&Row>> = Vec::new();
    for row in rows {
        match clouds.last_mut() {
            Some(cloud) if row.library != "simdop" => cloud.push(row),
            _ => clouds.push(vec![row]),
        }
    }
    clouds
}

fn number(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 10.0 => format!("{x:.1}"),
        x if x >= 0.1 => format!("{x:.2}"),
        x => format!("{x:.2e}"),
    }
}

fn compared(rows: &[&Row], (what, of): Measure) -> String {
    let libraries = libraries(rows);
    let refits = what == "build";
    let mut text = "| cloud | points | neighbours |".to_owned();
    for library in &libraries {
        let _ = write!(text, " {library} |");
        if refits && library == "simdop" {
            text += " refit, build / refit |";
        }
    }
    text += "\n| --- | --: | --: |";
    text += &" --: |".repeat(libraries.len() + usize::from(refits));
    text += "\n";
    for cloud in by_cloud(rows) {
        let ours = cloud[0];
        let _ = write!(text, "| {} | {} | {} |", ours.scene, ours.points, number(ours.neighbours));
        for library in &libraries {
            let cell = match cloud.iter().find(|row| row.library == *library) {
                None => "-".to_owned(),
                Some(_) if what == "memory" && ours.points < FEW => "-".to_owned(),
                Some(row) if row.library == "simdop" => number(of(row)),
                Some(row) => format!("{} ({})", number(of(row)), number(of(row) / of(ours))),
            };
            let _ = write!(text, " {cell} |");
            if refits && library == "simdop" {
                let refit = ours.refit_ms.unwrap_or(f64::NAN);
                let _ = write!(text, " {}, {} |", number(refit), number(ours.build_ms / refit));
            }
        }
        text += "\n";
    }
    text + "\n"
}

/// Times per point, and the exponent of their growth with the number of points.
fn growth(rows: &[Row]) -> String {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.table == "growth").collect();
    let clouds = by_cloud(&rows);
    let (Some(few), Some(many)) = (clouds.first(), clouds.last()) else { return String::new() };
    if few[0].points == many[0].points {
        return String::new();
    }
    let mut text = format!(
        "### Exponent of the growth of times with the number of points, from {} to {}\n\n\
         | library | build | count | fill |\n| --- | --: | --: | --: |\n",
        few[0].points, many[0].points
    );
    for (a, b) in few.iter().zip(many) {
        let power = |(_, of): Measure| (of(b) / of(a)).ln() / (b.points as f64 / a.points as f64).ln();
        let _ = writeln!(
            text,
            "| {} | {:.2} | {:.2} | {:.2} |",
            a.library,
            power(BUILD),
            power(COUNT),
            power(FILL)
        );
    }
    let refit = few[0].refit_ms.zip(many[0].refit_ms);
    if let Some((a, b)) = refit {
        let power = (b / a).ln() / (many[0].points as f64 / few[0].points as f64).ln();
        let _ = writeln!(text, "\nsimdop's refit: {power:.2}.");
    }
    text + "\n"
}

/// Rows of one query, simdop's first.
fn by_question(rows: &[single::Row]) -> Vec<Vec<&single::Row>> {
    let mut questions: Vec<Vec<&single::Row>> = Vec::new();
    for row in rows {
        match questions.last_mut() {
            Some(question)
                if question[0].scene == row.scene
                    && question[0].what == row.what
                    && question[0].points == row.points =>
            {
                question.push(row);
            }
            _ => questions.push(vec![row]),
        }
    }
    questions
}

fn asked(rows: &[single::Row]) -> String {
    let mut text = String::new();
    for (table, title, about) in [
        (
            "single",
            "Queries that are not points of the cloud, in random order",
            "Nanoseconds per query; in brackets relative to simdop one by one. \"Seated\": all at once, sorted by \
             `RangeSearch::seat`, whose time is included.",
        ),
        (
            "any",
            "Whether any point is within a sphere",
            "Nanoseconds per query; in brackets relative to simdop, and wrong answers. capt's tree is built for \
             radii of 0.02 to 0.2 m. Eight spheres are those of a link, side by side; simdop and capt stop at the \
             first that contains a point, capt's SIMD tests all eight at once.",
        ),
    ] {
        let of_table: Vec<single::Row> = rows.iter().filter(|row| row.table == table).cloned().collect();
        if of_table.is_empty() {
            continue;
        }
        let _ = write!(
            text,
            "## {title}\n\n{about}\n\n| cloud | points | query | yes or found, mean | simdop | peers |\n\
             | --- | --: | --- | --: | --: | --- |\n"
        );
        for question in by_question(&of_table) {
            let ours = question[0];
            let found = if ours.what.starts_with("the nearest") {
                "-".to_owned()
            } else {
                number(ours.sum as f64 / ours.asked as f64)
            };
            let _ = write!(
                text,
                "| {} | {} | {} | {found} | {} | ",
                ours.scene,
                ours.points,
                ours.what,
                number(ours.ns)
            );
            let peer = |row: &&single::Row| {
                let wrong = if row.wrong > 0 {
                    format!(", **{} of {} wrong**", row.wrong, row.asked)
                } else {
                    String::new()
                };
                format!("{} {} ({}){wrong}", row.library, number(row.ns), number(row.ns / ours.ns))
            };
            let peers: Vec<String> = question[1..].iter().map(peer).collect();
            let _ = writeln!(text, "{} |", peers.join("; "));
        }
        text += "\n";
        for library in ["simdop", "capt"] {
            let mut seen: Vec<&str> = Vec::new();
            for row in of_table.iter().filter(|row| row.library == library) {
                if let (Some(build), Some(bytes), false) =
                    (row.build_ms, row.bytes_per_point, seen.contains(&row.scene.as_str()))
                {
                    seen.push(&row.scene);
                    let _ = writeln!(
                        text,
                        "* {}, {library}: build {} ms, {} bytes per point.",
                        row.scene,
                        number(build),
                        number(bytes)
                    );
                }
            }
        }
        text += "\n";
    }
    text
}

fn losses(rows: &[Row], singles: &[single::Row]) -> String {
    let mut text = "## Where a peer is better\n\nRatios below 1, of the peer to simdop.\n\n".to_owned();
    text += "| cloud | points | what | peer | ratio |\n| --- | --: | --- | --- | --: |\n";
    let all: Vec<&Row> = rows.iter().collect();
    for cloud in by_cloud(&all) {
        let ours = cloud[0];
        for (what, of) in [COUNT, FILL] {
            for row in &cloud[1..] {
                let ratio = of(row) / of(ours);
                if ratio < 1.0 {
                    let _ = writeln!(
                        text,
                        "| {} | {} | {what} | {} | {ratio:.2} |",
                        ours.scene, ours.points, row.library
                    );
                }
            }
        }
    }
    for question in by_question(singles) {
        let ours = question[0];
        let faster = |row: &&&single::Row| !row.library.starts_with("simdop") && row.ns < ours.ns;
        for row in question[1..].iter().filter(faster) {
            let wrong =
                if row.wrong > 0 { format!(", {} of {} wrong", row.wrong, row.asked) } else { String::new() };
            let peer = format!("{}{wrong}", row.library);
            let _ = writeln!(
                text,
                "| {} | {} | {} | {peer} | {:.2} |",
                ours.scene,
                ours.points,
                ours.what,
                row.ns / ours.ns
            );
        }
    }
    text += "\nBuilds, refits and memory, over all clouds of at least 1000 points:\n\n";
    text += "| what | peer | minimum ratio | median | maximum |\n| --- | --- | --: | --: | --: |\n";
    let refit: Measure = ("the peer's build / simdop's refit", |row| row.refit_ms.unwrap_or(row.build_ms));
    for (what, of) in [BUILD, refit, MEMORY] {
        for library in libraries(&all).iter().skip(1) {
            let clouds = by_cloud(&all).into_iter().filter(|cloud| cloud[0].points >= FEW);
            let mut ratios: Vec<f64> = clouds
                .filter_map(|cloud| {
                    Some(of(cloud.iter().find(|row| row.library == *library)?) / of(cloud[0]))
                })
                .collect();
            ratios.sort_by(f64::total_cmp);
            if let [least, .., greatest] = ratios[..] {
                let median = ratios[ratios.len() / 2];
                let _ = writeln!(
                    text,
                    "| {what} | {library} | {} | {} | {} |",
                    number(least),
                    number(median),
                    number(greatest)
                );
            }
        }
    }
    text + "\n"
}

fn disagreements(rows: &[Row], singles: &[single::Row]) -> String {
    let mut text = "## Answers\n\n".to_owned();
    let queries: usize = rows.iter().map(|row| row.points).sum();
    let _ = writeln!(
        text,
        "Counts compared with simdop's: {queries}; different: {}.",
        rows.iter().map(|row| row.differs).sum::<usize>()
    );
    for row in rows.iter().filter(|row| row.wrong + row.differs > 0) {
        let _ = writeln!(
            text,
            "* {}, {} points, {}: {} of {} queries of the sample differ from brute force; {} counts of {} differ from \
             simdop's.",
            row.scene, row.points, row.library, row.wrong, row.sample, row.differs, row.points
        );
    }
    let wrong: usize = singles.iter().filter(|row| row.table == "single").map(|row| row.wrong).sum();
    let _ = writeln!(
        text,
        "\nSingle queries that differ from simdop's, and nearest points whose squared distance does by more than four \
         units in the last place: {wrong}."
    );
    text
}
