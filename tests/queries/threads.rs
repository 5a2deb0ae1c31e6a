//! Queries from any number of threads, on the same trees, give the answers and statistics of one thread.

use crate::support::rng::Rng;
use crate::support::shapes;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::{Bvh, BvhRef};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Answer, Distance, Query};

type View<'t> = BvhRef<'t, Node16<18>>;

fn ask(view: &View<'_>, pose: &Pose) -> (Answer, Distance) {
    let query = Query::new(Isa::detect());
    (query.collide(view, view, pose), query.distance(view, view, pose, 0.0).unwrap())
}

/// The poses in equal shares, one for each thread, with every answer at its pose's index.
fn with_threads(view: &View<'_>, poses: &[Pose], threads: usize) -> Vec<Option<(Answer, Distance)>> {
    let mut answers = vec![None; poses.len()];
    let share = poses.len().div_ceil(threads);
    std::thread::scope(|scope| {
        for (poses, answers) in poses.chunks(share).zip(answers.chunks_mut(share)) {
            scope.spawn(move || {
                for (pose, answer) in poses.iter().zip(answers) {
                    *answer = Some(ask(view, pose));
                }
            });
        }
    });
    answers
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let mesh = shapes::torus(40, 20);
    let tree: Bvh<Node16<18>> =
        Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let mut rng = Rng::new(11);
    let poses: Vec<Pose> = (0..200)
        .map(|_| {
            let (r, towards, distance) = (rng.rotation(), rng.rotation()[0], rng.range(1.0, 3.2));
            let rows = core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], distance * towards[i]]);
            Pose::from_rows(rows).unwrap()
        })
        .collect();
    let view = tree.view();
    let want: Vec<_> = poses.iter().map(|pose| Some(ask(&view, pose))).collect();
    let hits = want.iter().flatten().filter(|(answer, _)| answer.hit().is_some()).count();
    assert!((20..180).contains(&hits), "both answers are frequent: {hits} hits");
    for threads in [1, 2, 3, 8] {
        assert_eq!(with_threads(&view, &poses, threads), want, "{threads} threads");
    }
}
