//! The figures of the BNG paper (Weller, Mainzer, Srinivas, Teschner & Zachmann, *Massively Parallel Batch Neural Gas
//! for Bounding Volume Hierarchy Construction*, VRIPHYS 2014), for the library's trees of real packings:
//!
//! ```sh
//! cargo bench --bench spheres                        # one thread, no GPU
//! cargo bench --features gpu,rayon --bench spheres   # all threads and the GPU as well
//! cargo bench --bench spheres -- 10000               # up to this many spheres
//! ```
//!
//! * **Figures 7 and 8**: time of construction against the number of spheres. All ways to build give the same bytes.
//! * **Figure 10**: time of a query along a path through another body, by the division of a node's spheres: Batch
//!   Neural Gas with and without the spheres' volumes as weights, the paper's two rivals (`spheres/heuristics.rs`), and
//!   the library's default. The queries are for the shared volume, and for yes or no. Before timing, all trees must
//!   give the same volumes, bit for bit, and these must be the sum over all pairs of spheres.
//! * **Weights**: the work of the same queries with the spheres' volumes as weights relative to that without, for Batch
//!   Neural Gas from several starts.
//! * **Bounds**: how fast they converge with the budget.
//!
//! Prints tables and writes CSV to `target/spheres/`. Counted work is the same on every machine. The paper's pig and
//! statue are not available; a hand and the armadillo replace them.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "../tests/support/lens.rs"]
mod lens;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/warm.rs"]
mod warm;
mod spheres {
    pub(crate) mod all_pairs;
    pub(crate) mod bounds;
    pub(crate) mod construction;
    pub(crate) mod heuristics;
    pub(crate) mod makers;
    pub(crate) mod models;
    pub(crate) mod queries;
    pub(crate) mod report;
}

use data::directory;
use page::show;
use short::{count, is_short};
use spheres::bounds;
use spheres::construction;
use spheres::makers::Makers;
use spheres::models::Model;
use spheres::queries::Scene;
use spheres::report;
use std::path::Path;

/// A short run uses the first two.
const MODELS: [&str; 4] = ["cow", "hand", "armadillo", "brain_pia_lh"];
/// The paper's cow and pig, and pig and statue.
const SCENES: [[usize; 2]; 2] = [[0, 1], [1, 2]];
const SIZES: [usize; 4] = [2_000, 10_000, 50_000, 100_000];

fn main() {
    let Some(data) = directory() else { return };
    let most = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(SIZES[3]);
    let sizes: Vec<usize> =
        if is_short() { vec![200] } else { SIZES.into_iter().filter(|size| *size <= most).collect() };
    let models: Vec<Model> = MODELS[..count(MODELS.len(), 2)]
        .iter()
        .map(|name| {
            eprintln!("{name}: packing");
            Model::load(&data, name, *sizes.last().expect("there is a size"))
        })
        .collect();

    let makers = Makers::new();
    page::begin(
        "Sphere trees",
        "Milliseconds a build, microseconds a query: figures 7, 8 and 10 of Weller et al., *Massively Parallel \
         Batch Neural Gas for Bounding Volume Hierarchy Construction* (VRIPHYS 2014), for packings of spheres.",
    );
    show!("Construction, figures 7 and 8 ({}):\n", makers.describe());
    let built = construction::measure(&models, &sizes, &makers);
    show!("{}", construction::table(&built));

    let (mut asked, mut weights, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    for [a, b] in SCENES.into_iter().take(count(SCENES.len(), 1)) {
        for &size in &sizes {
            let scene = Scene::new(&models[a], &models[b], size);
            show!("* {}.", scene.describe());
            scene.measure(&mut asked);
            scene.weights(&mut weights);
            bounds.push(bounds::measure(&scene));
        }
    }
    show!("\nQueries, figure 10, penetration volume (in brackets: over the first):\n");
    show!("{}", report::table(&asked, |row| row.volume));
    show!("Queries, yes or no:\n\n{}", report::table(&asked, |row| row.verdict));
    show!("All scenes and sizes, geometric means of the ratios to the first:\n\n{}", report::summary(&asked));
    show!("Volumes as weights: work with weights over work without (range over the starts):\n");
    show!("{}", report::table_of_weights(&weights));
    show!(
        "Bounds after a part of the visits, estimates and their errors, relative to the volume; medians over the \
         poses with a shared volume:\n"
    );
    show!("{}", bounds::table(&bounds));

    let name = if is_short() { "spheres-short" } else { "spheres" };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("construction.csv"), construction::csv(&built)).unwrap();
    std::fs::write(folder.join("queries.csv"), report::csv(&asked)).unwrap();
    println!("{}", folder.display());
    page::write();
}
