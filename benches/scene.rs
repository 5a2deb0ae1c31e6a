//! A planner's validity check: does the robot collide? `cargo bench --bench scene` prints a table. A minute.
//!
//! Robots on every seventh problem of MotionBenchMaker: the start, a goal and ten random configurations. Poses are
//! given: forward kinematics is not timed.
//!
//! * *Scene*: the links are placed and the scene is queried.
//! * *Pairs*: every pair is queried at its relative pose, without boxes, until one hits. The verdicts of both are
//!   compared first.
//! * *At once*: 256 random configurations of each problem, one by one, and all by one call, on one thread and on all.
//! * *Shapes*: the obstacles as shapes instead of prisms, and the links alone.
//! * *Sphere models*: the same configurations with the published spheres of the robot instead of its meshes; their
//!   wrong verdicts are counted.
//! * *Covers*: spheres that cover the links are tested first, and the meshes where these hit: the same verdicts, also
//!   with margins.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/robots.rs"]
mod robots;
#[path = "support/short.rs"]
mod short;

use data::{MeshData, directory};
use glam::{DAffine3, DVec3};
use page::show;
use rng::Rng;
use robots::{Problem, Robot, SETTINGS, Setting};
use short::count;
use simdop::construct::{Builder, Mesh, OwnedMesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Aabb16, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::Query;
use simdop::scene::{Body, BodyId, BodyTree, Scene};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

type Tree = Bvh<Node16<18>>;

fn link_tree(mesh: &MeshData) -> Tree {
    Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

/// A solid.
fn obstacle_tree(mesh: &OwnedMesh) -> Tree {
    Builder::new().solid().build_as(&mesh.as_mesh()).unwrap()
}

fn pose(at: &DAffine3) -> Pose {
    Pose::try_from(*at).unwrap()
}

/// A scene, and the bodies placed in it.
struct World<'t> {
    scene: Scene<'t, Node16<18>>,
    links: Vec<BodyId>,
    /// Trees and their poses, for queries of pairs: links first.
    obstacles: Vec<(&'t Tree, DAffine3)>,
    configurations: &'t [Vec<DAffine3>],
    poses: Vec<Vec<Pose>>,
}

fn main() {
    page::begin(
        "Scenes",
        "Microseconds a configuration of a robot among obstacles, means of the least of 15 passes. Times \
         exclude forward kinematics.",
    );
    let Some(data) = directory() else { return };
    for setting in &SETTINGS {
        run(&data, setting);
    }
    page::write();
}

fn run(data: &Path, setting: &Setting) {
    let robot = setting.robot(data);
    let links: Vec<Tree> = robot.links.iter().map(|link| link_tree(&link.mesh)).collect();
    let problems = setting.problems(data, &robot, count(7, 70));
    let obstacles: Vec<Vec<Tree>> = problems
        .iter()
        .map(|p| p.obstacles.iter().map(|o| obstacle_tree(&o.shape.mesh())).collect())
        .collect();
    let mut worlds: Vec<World<'_>> = Vec::new();
    for (problem, trees) in problems.iter().zip(&obstacles) {
        let (scene, ids) =
            scene_of(links.iter().map(|link| link.view().into()), &robot, views(trees), problem);
        let placed =
            trees.iter().zip(&problem.obstacles).map(|(tree, obstacle)| (tree, obstacle.at)).collect();
        let poses = problem.poses.iter().map(|at| at.iter().map(pose).collect()).collect();
        worlds.push(World { scene, links: ids, obstacles: placed, configurations: &problem.poses, poses });
    }
    let query = Query::new(Isa::detect());
    let by_pairs = |world: &World<'_>, at: &[DAffine3]| {
        pairs_of(&robot, &links, world, at).all(|(a, b, pose)| query.collide(a, b, &pose).is_free())
    };
    let (mut asked, mut free, mut pairs, mut visits, mut differ) = (0_u64, 0, 0, 0, 0);
    let mut tests = 0;
    for world in &mut worlds {
        for i in 0..world.configurations.len() {
            place(world, i);
            let answer = world.scene.collide(&query).unwrap();
            asked += 1;
            free += u64::from(answer.is_free());
            pairs += answer.pairs;
            visits += answer.stats.visits;
            tests += answer.stats.primitive_pairs;
            differ += u64::from(answer.is_free() != by_pairs(world, &world.configurations[i]));
        }
    }
    assert_eq!(differ, 0, "verdicts of the scene and of its pairs differ");
    show!("## {}\n", setting.name);
    show!(
        "* {asked} configurations, {free} free; a configuration: pairs asked {:.2}, visits {:.2}, pairs of \
         triangles {:.2}",
        pairs as f64 / asked as f64,
        visits as f64 / asked as f64,
        tests as f64 / asked as f64
    );
    // The minimum over the passes of each configuration, to exclude the time of other programs.
    let mut best = vec![[f64::INFINITY; 6]; asked as usize];
    for _ in 0..count(15, 1) {
        let mut time = |slot: usize, f: &mut dyn FnMut(&mut World<'_>, usize) -> bool| {
            let mut best = best.iter_mut();
            for world in &mut worlds {
                for (i, best) in (0..world.configurations.len()).zip(&mut best) {
                    let start = Instant::now();
                    black_box(f(world, i));
                    best[slot] = best[slot].min(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        };
        time(0, &mut |world, i| {
            place(world, i);
            world.scene.collide(&query).unwrap().is_free()
        });
        time(1, &mut |world, i| by_pairs(world, &world.configurations[i]));
        time(2, &mut |world, i| {
            place(world, i);
            true
        });
        for (slot, margin) in [(3, 0.005), (4, 0.02), (5, 0.05)] {
            time(slot, &mut |world, i| {
                place(world, i);
                world.scene.within(&query, margin).unwrap().is_free()
            });
        }
    }
    let mean = |slot: usize| best.iter().map(|times| times[slot]).sum::<f64>() / asked as f64;
    let [scene, pairs, placing, five, twenty, fifty] = core::array::from_fn(mean);
    show!(
        "* scene {scene:.2} (of which placing {placing:.2}), pairs {pairs:.2}; margins of 5, 20, 50 mm {five:.2} \
         {twenty:.2} {fifty:.2}"
    );
    drop(best);
    show!("* {}", same_pairs(&robot, &links, &worlds, &query));
    covers_of_all_errors(&robot, &mut worlds, &problems, &obstacles, &query);
    at_once(&robot, &mut worlds, &query);
    among_shapes(&robot, &links, &problems, &obstacles, &query);
    if !setting.is_drawn {
        let models = sphere_models(data, setting, &robot);
        let scenes = problems.iter().zip(&obstacles).map(|(problem, trees)| {
            scene_of(models.iter().map(|model| model.view().into()), &robot, views(trees), problem)
        });
        by_spheres(&robot, &mut worlds, scenes, &query);
    }
    show!("");
}

/// The pairs of a configuration: links that may meet, and each link with each obstacle, with the pose of the first
/// relative to the second.
fn pairs_of<'w>(
    robot: &'w Robot,
    links: &'w [Tree],
    world: &'w World<'_>,
    at: &'w [DAffine3],
) -> impl Iterator<Item = (&'w Tree, &'w Tree, Pose)> {
    let of_links = robot.pairs.iter().map(|&(i, j)| (&links[i], &links[j], pose(&(at[j].inverse() * at[i]))));
    let with_obstacles = world.obstacles.iter().flat_map(move |(tree, place)| {
        let back = place.inverse();
        links.iter().zip(at).map(move |(link, at)| (link, *tree, pose(&(back * *at))))
    });
    of_links.chain(with_obstacles)
}

/// The cost of all pairs of a configuration, each queried alone and to the end, for contact and for margins.
fn same_pairs(robot: &Robot, links: &[Tree], worlds: &[World<'_>], query: &Query) -> String {
    const MARGINS: [f64; 3] = [0.005, 0.02, 0.05];
    let (mut sums, mut asked, mut pairs) = ([0.0; 4], 0, 0);
    for world in worlds {
        for at in world.configurations {
            let posed: Vec<_> = pairs_of(robot, links, world, at).collect();
            let mut best = [f64::INFINITY; 4];
            for _ in 0..count(15, 1) {
                for (slot, best) in best.iter_mut().enumerate() {
                    let start = Instant::now();
                    for (a, b, pose) in &posed {
                        let answer = match slot {
                            0 => query.collide(*a, *b, pose),
                            _ => query.within(*a, *b, pose, MARGINS[slot - 1]).unwrap(),
                        };
                        let _ = black_box(answer);
                    }
                    *best = best.min(start.elapsed().as_secs_f64() * 1e6);
                }
            }
            sums.iter_mut().zip(best).for_each(|(sum, best)| *sum += best);
            asked += 1;
            pairs += posed.len();
        }
    }
    let [touching, five, twenty, fifty] = sums.map(|sum| sum / f64::from(asked));
    format!(
        "all pairs alone, {:.1} a configuration: {touching:.2}; margins of 5, 20, 50 mm {five:.2} {twenty:.2} \
         {fifty:.2}, {:.2} {:.2} {:.2} times that",
        pairs as f64 / f64::from(asked),
        five / touching,
        twenty / touching,
        fifty / touching
    )
}

/// A scene of a robot's links, among the obstacles of a problem.
fn scene_of<'t>(
    links: impl Iterator<Item = BodyTree<'t, Node16<18>>>,
    robot: &Robot,
    obstacles: impl Iterator<Item = BodyTree<'t, Node16<18>>>,
    problem: &Problem,
) -> (Scene<'t, Node16<18>>, Vec<BodyId>) {
    let mut scene = Scene::new();
    let ids: Vec<BodyId> =
        links.map(|link| scene.insert(Body::new(link), &Pose::IDENTITY).unwrap()).collect();
    for i in 0..ids.len() {
        for j in i + 1..ids.len() {
            if robot.pairs.contains(&(i, j)) {
                scene.forbid_collision(ids[i], ids[j]).unwrap();
            } else {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            };
        }
    }
    for (tree, obstacle) in obstacles.zip(&problem.obstacles) {
        let _ = scene.insert(Body::new(tree).fixed(), &pose(&obstacle.at)).unwrap();
    }
    (scene, ids)
}

fn views(trees: &[Tree]) -> impl Iterator<Item = BodyTree<'_, Node16<18>>> {
    trees.iter().map(|tree| tree.view().into())
}

/// The cost of a configuration among the obstacles as prisms, as shapes, and without obstacles, for contact and for
/// 20 mm; the least of all passes, in which the three take turns.
fn among_shapes(robot: &Robot, links: &[Tree], problems: &[Problem], obstacles: &[Vec<Tree>], query: &Query) {
    const MARGINS: [f64; 2] = [0.0, 0.02];
    let (mut sums, mut asked, mut differ) = ([[0.0; 2]; 3], 0, 0);
    for (problem, trees) in problems.iter().zip(obstacles) {
        let shapes = problem.obstacles.iter().map(|obstacle| obstacle.shape.shape().into());
        let mut scenes = [
            scene_of(views(links), robot, views(trees), problem),
            scene_of(views(links), robot, shapes, problem),
            scene_of(views(links), robot, core::iter::empty(), problem),
        ];
        for at in &problem.poses {
            let poses: Vec<Pose> = at.iter().map(pose).collect();
            let (mut best, mut free) = ([[f64::INFINITY; 2]; 3], [false; 3]);
            for _ in 0..count(15, 1) {
                for (((scene, ids), best), free) in scenes.iter_mut().zip(&mut best).zip(&mut free) {
                    for (margin, best) in MARGINS.into_iter().zip(best) {
                        let start = Instant::now();
                        for (&id, pose) in ids.iter().zip(&poses) {
                            scene.place(id, pose).unwrap();
                        }
                        let is_free = black_box(scene.within(query, margin).unwrap().is_free());
                        *best = best.min(start.elapsed().as_secs_f64() * 1e6);
                        *free |= is_free && margin == 0.0;
                    }
                }
            }
            asked += 1;
            differ += u32::from(free[0] != free[1]);
            for (sums, best) in sums.as_flattened_mut().iter_mut().zip(best.as_flattened()) {
                *sums += best;
            }
        }
    }
    let [[p, p_20], [s, s_20], [n, n_20]] = sums.map(|sums| sums.map(|sum| sum / f64::from(asked)));
    show!(
        "* obstacles as prisms {p:.2}, as shapes {s:.2}, none {n:.2}; at 20 mm {p_20:.2} {s_20:.2} {n_20:.2}; {differ} \
         verdicts of prisms and shapes differ"
    );
}

/// The published spheres of each link, in the frame of its mesh. They do not cover it.
fn sphere_models(data: &Path, setting: &Setting, robot: &Robot) -> Vec<Bvh<Node16<18>, Spheres>> {
    let text = std::fs::read_to_string(data.join("robots").join(setting.robot).join("spheres.tsv")).unwrap();
    let models = robot.links.iter().map(|link| {
        let rows =
            text.lines().map(|line| line.split('\t').collect::<Vec<_>>()).filter(|row| row[0] == link.name);
        let spheres: Vec<Sphere> = rows
            .map(|row| {
                let [x, y, z, radius] = [1, 2, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
                let centre = link.origin.inverse().transform_point3(DVec3::new(x, y, z));
                Sphere { centre: centre.to_array(), radius }
            })
            .collect();
        Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
            .unwrap()
    });
    models.collect()
}

/// The cost of a configuration with spheres, and how often their verdict is wrong.
fn by_spheres<'t>(
    robot: &Robot,
    worlds: &mut [World<'_>],
    scenes: impl Iterator<Item = (Scene<'t, Node16<18>>, Vec<BodyId>)>,
    query: &Query,
) {
    let mut rng = Rng::new(8);
    let (mut best, mut missed, mut invented, mut hits) = ([0.0; 2], 0, 0, 0);
    for (world, (mut scene, moving)) in worlds.iter_mut().zip(scenes) {
        let poses: Vec<Pose> =
            (0..AT_ONCE).flat_map(|_| robot.poses(&robot.random(&mut rng))).map(|at| pose(&at)).collect();
        let exact = one_by_one(&mut world.scene, query, &world.links, &poses);
        let mut boxes = vec![Aabb16::EMPTY; scene.room()];
        let mut least = [f64::INFINITY; 2];
        let mut free = [0; AT_ONCE / 16];
        for _ in 0..count(15, 1) {
            let start = Instant::now();
            let one = one_by_one(&mut scene, query, &moving, &poses);
            least[0] = least[0].min(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let _ = scene.check_states(query, &moving, &poses, &mut boxes, &mut free).unwrap();
            least[1] = least[1].min(start.elapsed().as_secs_f64());
            assert_eq!(one, free, "free at once, and free one by one");
        }
        for (sum, least) in best.iter_mut().zip(least) {
            *sum += least * 1e6 / AT_ONCE as f64;
        }
        for (exact, free) in exact.iter().zip(free) {
            hits += (!exact).count_ones();
            missed += (!exact & free).count_ones();
            invented += (exact & !free).count_ones();
        }
    }
    let [one, at_once] = best.map(|sum| sum / worlds.len() as f64);
    let all = worlds.len() * AT_ONCE;
    show!(
        "* by sphere models: one by one {one:.2}, at once {at_once:.2}; of {all} configurations {hits} hit, \
         {missed} of these are missed and {invented} others called hits"
    );
}

/// Errors of the links' covers, in metres.
const ERRORS: [f64; 3] = [0.01, 0.02, 0.05];

fn cover(mesh: &MeshData, error: f64) -> Bvh<Node16<18>, Spheres> {
    let spheres = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }.cover(error).unwrap();
    Builder::balanced()
        .without_balls()
        .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
        .unwrap()
}

/// One line for each error of the links' covers.
fn covers_of_all_errors(
    robot: &Robot,
    worlds: &mut [World<'_>],
    problems: &[Problem],
    obstacles: &[Vec<Tree>],
    query: &Query,
) {
    for error in ERRORS {
        let covers: Vec<_> = robot.links.iter().map(|link| cover(&link.mesh, error)).collect();
        let scenes = problems.iter().zip(obstacles).map(|(problem, trees)| {
            scene_of(covers.iter().map(|cover| cover.view().into()), robot, views(trees), problem)
        });
        let spheres: usize = covers.iter().map(|cover| cover.view().len()).sum();
        show!("* covers of {} mm, {spheres} spheres: {}", 1e3 * error, covers_first(worlds, scenes, query));
    }
}

/// Margins of 0, 5, 20 and 50 mm: the cost of a configuration with the meshes alone, and with covers first and the
/// meshes where these hit.
fn covers_first<'t>(
    worlds: &mut [World<'_>],
    scenes: impl Iterator<Item = (Scene<'t, Node16<18>>, Vec<BodyId>)>,
    query: &Query,
) -> String {
    let mut scenes: Vec<_> = scenes.collect();
    let asked: usize = worlds.iter().map(|world| world.configurations.len()).sum();
    let mut cells = Vec::new();
    for margin in [0.0, 0.005, 0.02, 0.05] {
        let mut best = vec![[f64::INFINITY; 2]; asked];
        for _ in 0..count(15, 1) {
            let mut best = best.iter_mut();
            for (world, (covers, links)) in worlds.iter_mut().zip(&mut scenes) {
                for (i, best) in (0..world.configurations.len()).zip(&mut best) {
                    let mut time = |slot: usize, f: &mut dyn FnMut() -> bool| {
                        let start = Instant::now();
                        let is_free = black_box(f());
                        best[slot] = best[slot].min(start.elapsed().as_secs_f64() * 1e6);
                        is_free
                    };
                    let exact = time(0, &mut || {
                        place(world, i);
                        world.scene.within(query, margin).unwrap().is_free()
                    });
                    let covered = time(1, &mut || {
                        for (&id, pose) in links.iter().zip(&world.poses[i]) {
                            covers.place(id, pose).unwrap();
                        }
                        covers.within(query, margin).unwrap().is_free() || {
                            place(world, i);
                            world.scene.within(query, margin).unwrap().is_free()
                        }
                    });
                    assert_eq!(covered, exact, "the verdict by covers first");
                }
            }
        }
        let mean = |slot: usize| best.iter().map(|times| times[slot]).sum::<f64>() / asked as f64;
        cells.push(format!("{:.2} / {:.2}", mean(0), mean(1)));
    }
    cells.join(", ")
}

/// Configurations of each problem that one call checks.
const AT_ONCE: usize = 256;

/// One bit for each configuration: whether it is free.
fn one_by_one(
    scene: &mut Scene<'_, Node16<18>>,
    query: &Query,
    moving: &[BodyId],
    poses: &[Pose],
) -> [u16; AT_ONCE / 16] {
    let mut free = [0; AT_ONCE / 16];
    for (i, poses) in poses.chunks(moving.len()).enumerate() {
        for (&id, pose) in moving.iter().zip(poses) {
            scene.place(id, pose).unwrap();
        }
        free[i / 16] |= u16::from(scene.collide(query).unwrap().is_free()) << (i % 16);
    }
    free
}

fn at_once(robot: &Robot, worlds: &mut [World<'_>], query: &Query) {
    let mut rng = Rng::new(8);
    let mut best = vec![[f64::INFINITY; 3]; worlds.len()];
    for (world, best) in worlds.iter_mut().zip(&mut best) {
        let configurations: Vec<_> = (0..AT_ONCE).map(|_| robot.random(&mut rng)).collect();
        let poses: Vec<Pose> =
            configurations.iter().flat_map(|q| robot.poses(q)).map(|at| pose(&at)).collect();
        let mut boxes = vec![Aabb16::EMPTY; world.scene.room()];
        let (scene, moving) = (&mut world.scene, &world.links);
        let expected = one_by_one(scene, query, moving, &poses);
        for _ in 0..count(15, 1) {
            let mut time = |slot: usize, f: &mut dyn FnMut() -> [u16; AT_ONCE / 16]| {
                let start = Instant::now();
                let free = f();
                best[slot] = best[slot].min(start.elapsed().as_secs_f64() * 1e6 / AT_ONCE as f64);
                assert_eq!(free, expected, "free at once, and free one by one");
            };
            time(0, &mut || one_by_one(scene, query, moving, &poses));
            time(1, &mut || {
                let mut free = [0; AT_ONCE / 16];
                let _ = scene.check_states(query, moving, &poses, &mut boxes, &mut free).unwrap();
                free
            });
            time(2, &mut || {
                let mut free = [0; AT_ONCE / 16];
                let _ = scene.free_configurations_on_threads(query, moving, &poses, &mut free).unwrap();
                free
            });
        }
    }
    let mean = |slot: usize| best.iter().map(|times| times[slot]).sum::<f64>() / worlds.len() as f64;
    show!("* random ones: one by one {:.2}, at once {:.2}, on threads {:.2}", mean(0), mean(1), mean(2));
}

fn place(world: &mut World<'_>, configuration: usize) {
    for (&id, pose) in world.links.iter().zip(&world.poses[configuration]) {
        world.scene.place(id, pose).unwrap();
    }
}
