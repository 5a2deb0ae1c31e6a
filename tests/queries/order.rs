//! The query chooses which body to rotate: the order of the bodies changes no answer, and hardly the cost.

use crate::build;
use crate::pairs_that_meet;
use crate::support::data::{MeshData, suite_step};
use crate::support::exact::meeting_pairs;
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::support::turns;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::query::{Lanes, Query};

/// A room, whose flat walls grow when rotated, and a body that is as round as possible.
fn room_and_torus() -> [MeshData; 2] {
    [shapes::room(600), shapes::scaled(&shapes::torus(16, 12), 0.2, [0.0; 3])]
}

/// Whether the k-DOPs of A grow more than those of B when rotated, according to the headers.
fn gets_looser<N: Lanes>(a: &Bvh<N>, b: &Bvh<N>) -> bool {
    let loose = |tree: &Bvh<N>| {
        f64::from(tree.view().header().rotation_growth) / f64::from(tree.view().header().exponent).exp2()
    };
    loose(a) > 1.1 * loose(b)
}

/// The room is A, at poses that are as far from rotations as allowed: the query rotates the torus into the
/// frame of the room.
fn the_way_back_loses_no_pair<N: Lanes>(poses: usize) {
    let mut rng = Rng::new(5);
    let [room, torus] = room_and_torus();
    let (a, b) = (build::<N>(&room), build::<N>(&torus));
    assert!(gets_looser(&a, &b));
    let (mut met, mut free) = (0, 0);
    for _ in 0..poses {
        let shift = *rng.pick(&[0.0, 1.0, 1e3, 1e6]);
        let turn = turns::rotation(&mut rng);
        // Some triangle of the room comes to a triangle of the torus, and perhaps others do, too.
        let corner =
            |rng: &mut Rng, mesh: &MeshData| mesh.vertices[rng.below(mesh.vertices.len() as u64) as usize];
        let (p, q) = (corner(&mut rng, &room), corner(&mut rng, &torus));
        let (room, torus) =
            (shapes::scaled(&room, 1.0, [shift; 3]), shapes::scaled(&torus, 1.0, [-shift; 3]));
        let (a, b) = (build::<N>(&room), build::<N>(&torus));
        let (p, q) = (p.map(|x| x + shift), q.map(|x| x - shift));
        let near = *rng.pick(&[1e-9, 1e-3, 0.5]);
        let off = rng.range(-near, near);
        let t = core::array::from_fn(|i| q[i] + off - (0..3).map(|j| turn[i][j] * p[j]).sum::<f64>());
        let pose = turns::pose(&turn, t);
        let rows = core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]]);
        let want: Vec<_> = meeting_pairs(&room.placed(&rows), &torus.corners());
        let want = want.into_iter().map(|(i, j)| (i as u32, j as u32)).collect();
        let mut first = None;
        for isa in Isa::available() {
            let (found, stats) = pairs_that_meet(Query::new(isa), &a, &b, &pose);
            assert_eq!(found, want, "{isa} {pose:?}");
            assert_eq!(stats, *first.get_or_insert(stats), "{isa} {pose:?}");
            let answer = Query::new(isa).collide(&a, &b, &pose);
            assert_eq!(answer.is_free(), want.is_empty(), "{isa} {pose:?}");
        }
        *if want.is_empty() { &mut free } else { &mut met } += 1;
    }
    assert!(met * 4 > poses && free * 20 > poses, "{met} of {poses} meet, {free} are free");
}

#[test]
fn the_way_back_loses_nothing() {
    let fewer = suite_step();
    the_way_back_loses_no_pair::<Node16<18>>(300 / fewer);
    the_way_back_loses_no_pair::<Node4<14>>(100 / fewer);
    #[cfg(simdop_all_nodes)]
    {
        the_way_back_loses_no_pair::<Node16<6>>(100 / fewer);
        the_way_back_loses_no_pair::<Node4<32>>(100 / fewer);
    }
}

#[test]
fn either_order_costs_the_same() {
    let mut rng = Rng::new(6);
    let [room, torus] = room_and_torus();
    let (a, b) = (build::<Node16<18>>(&room), build::<Node16<18>>(&torus));
    assert!(gets_looser(&a, &b));
    let query = Query::new(Isa::SCALAR);
    let mut visits = [0, 0];
    for _ in 0..400 {
        let r = rng.rotation();
        let t = [(); 3].map(|()| rng.range(-1.0, 1.0));
        let pose = turns::pose(&r, t);
        let back: [[f64; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|j| r[j][i]));
        let back = turns::pose(&back, back.map(|row| -(0..3).map(|j| row[j] * t[j]).sum::<f64>()));
        let [one, other] = [query.collide(&b, &a, &pose), query.collide(&a, &b, &back)];
        assert_eq!(one.is_free(), other.is_free(), "{pose:?}");
        visits = [visits[0] + one.stats.visits, visits[1] + other.stats.visits];
    }
    let [one, other] = visits.map(|x| x as f64);
    assert!(one > 800.0 && (0.95..1.05).contains(&(one / other)), "{visits:?}");
}
