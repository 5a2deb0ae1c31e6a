//! Small bodies near corners of large ones.

use crate::corners::{inverse, near_corners};
use crate::data::MeshData;
use crate::distances::Page;
use crate::entrants::entrants;
use crate::measure::{Occasion, measure};
use crate::poses::judge;
use crate::record::{self, Row};
use crate::rng::Rng;
use crate::shapes::{append, room, scaled};
use crate::suites::Rows;
use crate::table::{self, Labels};
use crate::{Options, save};

/// Scale factors of the body.
const FACTORS: [f64; 7] = [1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6];

/// Triangles of the room.
const TRIANGLES: u32 = 100_000;

const POSES_OF_DISTANCES: &str =
    "row, as in SIZES.md, but shifted by up to two of the small body's diagonals along each axis";

const BODIES: [&str; 4] = ["cow", "armadillo", "room", "hand"];

/// Two bodies at poses where they are near each other.
struct Scene {
    mesh: String,
    what: String,
    meshes: [MeshData; 2],
    poses: Vec<Rows>,
}

pub(crate) fn run(options: &Options) -> Result<(), String> {
    let bodies = if options.meshes.is_empty() { &BODIES.map(str::to_owned)[..] } else { &options.meshes };
    std::fs::create_dir_all(&options.out).map_err(|e| format!("{}: {e}", options.out.display()))?;
    if options.distance {
        let mut page = Page::new(options, "Distances of bodies of different sizes", POSES_OF_DISTANCES);
        for body in bodies {
            for Scene { mesh, what, meshes, poses } in scenes(body, options)? {
                let judge = judge(&meshes[0], &meshes[1]);
                page.add(options, &mesh, &meshes, &[(what, poses.into_iter().map(judge).collect())]);
            }
        }
        return save(&options.out.join("SIZES_DISTANCES.md"), &page.text);
    }
    let mut rows: Vec<Row> = Vec::new();
    for body in bodies {
        for scene in scenes(body, options)? {
            let Scene { mesh, what, meshes, poses } = scene;
            eprintln!("{mesh}, {what}");
            let judge = judge(&meshes[0], &meshes[1]);
            let suites = [(what, poses.into_iter().map(judge).collect())];
            let entrants = entrants(&meshes, &options.drivers);
            for run in 1..=options.runs {
                rows.extend(measure(&Occasion { run, mesh: &mesh }, &meshes, &entrants, &suites));
            }
        }
    }
    record::write(&options.out.join("sizes.csv"), &rows)?;
    let about = format!(
        "{}. {}, one thread, {} run(s), the libraries in turns, with the versions in RESULTS.md.\n\
        \n\
        A body against itself at another scale (\"1e-3, small as A\" is the body at a thousandth of its size,\n\
        placed in the frame of the original), {} poses per row: rotated at random, a random corner of the small\n\
        body is at a random corner of the large one, shifted by up to half the small body's diagonal along each\n\
        axis. \"1e-3 in a detail\": the large body has a copy of itself at a thousandth of its size at one of its\n\
        corners, and the small body, another such copy, is near corners of the copy. The room has {TRIANGLES}\n\
        triangles (`tests/support/shapes.rs`), the hall is unc_env, the hand is the Panda's. The exchanged poses\n\
        are the rounded inverse poses.",
        options.stamp,
        crate::cpu::cpu(),
        options.runs,
        options.poses()
    );
    let labels = Labels { title: "Bodies of different sizes", mesh: "body", distance: "scale" };
    save(&options.out.join("SIZES.md"), &table::near_contact(&rows, &labels, &about))
}

fn scenes(body: &str, options: &Options) -> Result<Vec<Scene>, String> {
    let read = |file: &str| MeshData::obj(&options.data.join(file));
    match body {
        "cow" | "armadillo" => Ok(against_itself(body, &read(&format!("meshes/{body}.obj")), options)),
        "room" => Ok(against_itself(body, &room(TRIANGLES), options)),
        "hand" => {
            let hand = read("robots/panda/meshes/hand.obj");
            // The hall is in millimetres.
            let (large_hand, hall) = (scaled(&hand, 1e3, [0.0; 3]), read("planning/unc_env.obj"));
            let room = room(TRIANGLES);
            let in_hall = both_ways(body, "in the hall", &large_hand, &hall, &hall, options);
            let in_room = both_ways(body, "in the room", &hand, &room, &room, options);
            Ok(in_hall.into_iter().chain(in_room).collect())
        }
        _ => Err(format!("no body {body}: there are {}", BODIES.join(", "))),
    }
}

fn against_itself(name: &str, body: &MeshData, options: &Options) -> Vec<Scene> {
    let mut scenes = Vec::new();
    for factor in FACTORS {
        let small = scaled(body, factor, [0.0; 3]);
        let what = if factor < 0.01 { format!("{factor:e}") } else { factor.to_string() };
        scenes.extend(both_ways(name, &what, &small, body, body, options));
    }
    for factor in [1e-3, 1e-4] {
        let [small, detail] = [[0.0; 3], body.vertices[0]].map(|shift| scaled(body, factor, shift));
        let mut large = body.clone();
        append(&mut large, &detail);
        scenes.extend(both_ways(name, &format!("{factor:e} in a detail"), &small, &large, &detail, options));
    }
    scenes
}

/// Places the small body near corners of the third, which is a part of the large one.
fn both_ways(
    mesh: &str,
    what: &str,
    small: &MeshData,
    large: &MeshData,
    corners: &MeshData,
    options: &Options,
) -> [Scene; 2] {
    let reach = if options.distance { 2.0 } else { 0.5 };
    let poses = near_corners(small, corners, reach, options.poses(), &mut Rng::new(options.seed));
    let back = poses.iter().map(inverse).collect();
    let scene = |which: &str, [a, b]: [&MeshData; 2], poses| Scene {
        mesh: mesh.to_owned(),
        what: format!("{what}, {which}"),
        meshes: [a.clone(), b.clone()],
        poses,
    };
    [scene("small as A", [small, large], poses), scene("small as B", [large, small], back)]
}
