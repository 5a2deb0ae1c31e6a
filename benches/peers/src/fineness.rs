//! A smooth surface against itself, nearly touching, with ever finer meshes.

use crate::entrants::beside_fcl;
use crate::measure::{Occasion, measure};
use crate::poses::{Judged, Named, approaching, judge};
use crate::record::{self, Row};
use crate::shapes::wavy_torus;
use crate::suites::{Distance, Method, Rows};
use crate::table::{self, Labels};
use crate::{Options, save};

pub(crate) const TRIANGLES: [u32; 5] = [5_000, 20_000, 80_000, 320_000, 1_280_000];

const GAPS: [(&str, Distance); 2] = [("2e-5", Distance::Gap(2e-5)), ("1e-3", Distance::Gap(1e-3))];

/// Up to this many triangles brute force decides whether the bodies meet. Its time grows quadratically.
const JUDGED: usize = 100_000;

pub(crate) fn run(options: &Options) -> Result<(), String> {
    let mut rows: Vec<Row> = Vec::new();
    for &triangles in &options.triangles {
        let meshes = [wavy_torus(triangles)];
        let mesh = format!("{} triangles", meshes[0].triangles.len());
        eprintln!("{mesh}");
        let poses = approaching(&meshes, &GAPS, [(Method::Sphere, options.poses())], options.seed);
        let by_force = judge(&meshes[0], &meshes[0]);
        let judge = |(rows, _)| {
            let few = meshes[0].triangles.len() <= JUDGED;
            if few { by_force(rows) } else { Judged { rows, meets: false } }
        };
        let named = |((gap, _), poses): (&(&str, Distance), Vec<(Rows, Method)>)| -> Named {
            ((*gap).to_owned(), poses.into_iter().map(judge).collect())
        };
        let suites: Vec<Named> = GAPS.iter().zip(poses).map(named).collect();
        let entrants = beside_fcl(&meshes, &options.drivers);
        for run in 1..=options.runs {
            rows.extend(measure(&Occasion { run, mesh: &mesh }, &meshes, &entrants, &suites));
        }
    }
    std::fs::create_dir_all(&options.out).map_err(|e| format!("{}: {e}", options.out.display()))?;
    record::write(&options.out.join("fineness.csv"), &rows)?;
    let about = format!(
        "{}. {}, one thread, {} run(s), the libraries in turns as in RESULTS.md.\n\
        \n\
        A torus with waves (`tests/support/shapes.rs`) against itself, {} poses per row: rotated at random, it\n\
        approaches from a random direction until the gap is this share of its diagonal. Up to {JUDGED} triangles\n\
        the truth is brute force in exact arithmetic; above, it is that there is a gap, which simdop's margin\n\
        query found.",
        options.stamp,
        crate::cpu::cpu(),
        options.runs,
        options.poses()
    );
    let labels = Labels { title: "Meshes of any fineness", mesh: "torus", distance: "gap" };
    save(&options.out.join("FINENESS.md"), &table::near_contact(&rows, &labels, &about))
}
