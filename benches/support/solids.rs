//! Kernels of one sphere, capsule or cuboid against sixteen, and the same pairs one after the other.

use crate::page::show;
use crate::rng::Rng;
use crate::{Bench, medians};
use simdop::isa::{Isa, Scalar, on_isa};
use simdop::low_level::kernel::Kernel;
use simdop::pose::Pose;
use simdop::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use simdop::primitive::shape::{Shape, is_within, separation};
use std::hint::black_box;
use std::rc::Rc;
use std::time::Instant;

/// Shapes that are compared with sixteen others each: few enough for the first-level cache.
const QUERIES: usize = 16;
const TIMES: usize = 16;

/// Gaps in diagonals of the smaller shape; the last overlap.
const GAPS: [(&str, f64); 4] =
    [("50 % apart", 0.5), ("5 % apart", 0.05), ("1 % apart", 0.01), ("1 % deep", -0.01)];

/// Two kinds at one gap.
pub(crate) struct Solids {
    pub(crate) name: String,
    pub(crate) benches: Vec<Bench>,
    /// Share of pairs that the kernel decides.
    decided: f64,
}

/// Sphere, capsule or cuboid by the number of half edges, with lengths in 1/4 .. 1.
fn shape(edges: usize, rng: &mut Rng) -> Shape {
    let mut length = || rng.range(0.25, 1.0);
    let made = match edges {
        0 => Shape::sphere(0.5 * length()),
        1 => Shape::capsule(0.5 * length(), length()),
        _ => Shape::cuboid([length(), length(), length()]),
    };
    made.expect("sizes in range")
}

fn moved(shape: &Shape, rows: &[[f64; 3]; 3], by: [f64; 3]) -> Shape {
    let row = |k: usize| [rows[k][0], rows[k][1], rows[k][2], by[k]];
    shape.moved(&Pose::from_rows([row(0), row(1), row(2)]).expect("a rotation"))
}

/// A random pose of `b` at this gap from `a`: from far away in a random direction, along the closest points.
fn placed(a: &Shape, b: &Shape, gap: f64, rng: &mut Rng) -> Shape {
    let (rows, far) = (rng.rotation(), rng.rotation()[0].map(|x| 10.0 * x));
    let found = separation(a, &moved(b, &rows, far), f64::INFINITY, 0.0).expect("there is no limit");
    let closer = 1.0 - gap / found.upper;
    moved(b, &rows, core::array::from_fn(|k| far[k] + closer * (found.a[k] - found.b[k])))
}

fn solids<const M: usize, const N: usize>(kinds: &str) -> impl Iterator<Item = Solids> {
    GAPS.map(|(at, gap)| {
        let mut rng = Rng::new(42);
        let queries: Vec<Shape> = (0..QUERIES)
            .map(|_| moved(&shape(M, &mut rng), &rng.rotation(), [(); 3].map(|()| rng.range(-2.0, 2.0))))
            .collect();
        let others: Vec<Vec<Shape>> = queries
            .iter()
            .map(|query| (0..16).map(|_| placed(query, &shape(N, &mut rng), gap, &mut rng)).collect())
            .collect();
        let calls: Rc<[(Solid<M>, SolidLanes<N>)]> = queries
            .iter()
            .zip(&others)
            .map(|(query, others)| {
                let query = Solid::new(query, 0.0).expect("this many half edges");
                (query, SolidLanes::new(others).expect("this many half edges"))
            })
            .collect();
        let scalar = Scalar::new();
        let answers: Vec<Decided> = calls.iter().map(|(query, lanes)| scalar.solids(query, lanes)).collect();
        for (answer, (query, others)) in answers.iter().zip(queries.iter().zip(&others)) {
            for (lane, other) in others.iter().enumerate() {
                let (apart, within) = (answer.apart >> lane & 1 == 1, answer.within >> lane & 1 == 1);
                let is_right = if is_within(query, other, 0.0) { !apart } else { !within };
                assert!(is_right, "{kinds}, {at}: a wrong decision");
            }
        }
        let decided: u32 = answers.iter().map(|answer| (answer.apart | answer.within).count_ones()).sum();
        let pairs = 16 * QUERIES;
        let mut benches = Vec::new();
        for isa in Isa::available() {
            on_isa!(isa, token => {
                let calls = calls.clone();
                let mut both = calls.iter().zip(&answers);
                let is_same = both.all(|((query, lanes), answer)| token.solids(query, lanes) == *answer);
                assert!(is_same, "{kinds}, {at}: {isa} differs from the scalar kernel");
                let time = move || {
                    let pass = || token.run(
                        #[inline(always)]
                        || for (query, lanes) in calls.iter() {
                            black_box(token.solids(black_box(query), lanes));
                        },
                    );
                    pass();
                    let start = Instant::now();
                    (0..TIMES).for_each(|_| pass());
                    start.elapsed()
                };
                benches.push(Bench { name: isa.name().into(), calls: TIMES * pairs, time: Box::new(time) });
            });
        }
        let time = move || {
            let pass = || {
                for (query, others) in queries.iter().zip(&others) {
                    for other in others {
                        black_box(is_within(black_box(query), other, 0.0));
                    }
                }
            };
            pass();
            let start = Instant::now();
            (0..TIMES).for_each(|_| pass());
            start.elapsed()
        };
        benches.push(Bench { name: "one by one".into(), calls: TIMES * pairs, time: Box::new(time) });
        Solids { name: format!("{kinds} {at}"), benches, decided: f64::from(decided) / pairs as f64 }
    })
    .into_iter()
}

pub(crate) fn all() -> Vec<Solids> {
    let round = solids::<0, 0>("sphere, sphere").chain(solids::<0, 1>("sphere, capsule"));
    let round = round.chain(solids::<1, 1>("capsule, capsule"));
    let flat = solids::<0, 3>("sphere, cuboid").chain(solids::<1, 3>("capsule, cuboid"));
    round.chain(flat).chain(solids::<3, 3>("cuboid, cuboid")).collect()
}

pub(crate) fn print_summary() {
    let rows = all();
    let names: Vec<&str> = rows[0].benches.iter().map(|bench| bench.name.as_str()).collect();
    show!(
        "\nOne shape against sixteen, lengths 1/4 to 1: nanoseconds a pair. *One by one*: `is_within`, in `f64` and \
         always decided.\n\n| pair | {} | decided |\n|---|{}---|",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    for row in &rows {
        let times: Vec<String> = medians(&row.benches, 15).iter().map(|ns| format!("{ns:.1}")).collect();
        show!("| {} | {} | {:.1} % |", row.name, times.join(" | "), 100.0 * row.decided);
    }
}
