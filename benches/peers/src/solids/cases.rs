//! Poses of pairs of solids with the true answers: generated once, written to files, and read back with a checksum.

use super::bodies::pairs;
use super::gjk::bounds;
use super::truth::{self, Judgement};
use crate::Options;
use crate::digest::digest;
use crate::driver::{Kind, Solid};
use crate::rng::Rng;
use crate::suites::{DISTANCES, Distance, Rows};
use core::fmt::Write as _;
use simdop::pose::Pose;
use std::path::Path;

/// Pairs of sizes in a suite. They take turns.
const SIZES: usize = 10;

/// Thickness of the thin solids, and size of the small ones.
const SMALL: f64 = 1e-6;

/// Distance of the far bodies, whose size is about 1.
const FAR: f64 = 1e6;

const UNLIKE: f64 = 1e-3;

/// Gap of the bodies that are barely apart. It needs no rounding of coordinates.
const APART: f64 = 1.0 / (1_u64 << 36) as f64;

/// How the bodies are placed.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) enum Placement {
    /// At one of [`DISTANCES`].
    At(usize),
    /// One within the other.
    Nested,
    Thin,
    Tiny,
    Unlike,
    Far,
    /// At exactly this distance along an axis, rotated by right angles.
    Exact(f64),
}

/// The placements, with their names.
pub(super) fn placements() -> Vec<(String, Placement)> {
    let distances = DISTANCES.iter().enumerate().map(|(i, (name, _))| ((*name).to_owned(), Placement::At(i)));
    let others = [
        ("nested", Placement::Nested),
        ("thin", Placement::Thin),
        ("tiny", Placement::Tiny),
        ("1:1000", Placement::Unlike),
        ("far", Placement::Far),
        ("touching", Placement::Exact(0.0)),
        ("2^-36 apart", Placement::Exact(APART)),
    ];
    distances.chain(others.map(|(name, placement)| (name.to_owned(), placement))).collect()
}

/// A pose, and the true answers there.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Case {
    /// Index of the pair of sizes.
    pub(super) pair: usize,
    pub(super) rows: Rows,
    /// Whether the solids meet, if known.
    pub(super) meets: Option<bool>,
    /// Bounds of the distance.
    pub(super) distance: [f64; 2],
}

/// A row of the tables.
pub(super) struct Suite {
    pub(super) kinds: [Kind; 2],
    pub(super) placement: String,
    pub(super) pairs: Vec<[Solid; 2]>,
    pub(super) cases: Vec<Case>,
}

/// All suites, or those of the named kinds.
pub(super) fn suites(options: &Options) -> Result<Vec<Suite>, String> {
    let named = |kind: &Kind| options.meshes.iter().any(|name| name == kind.name());
    let wanted = |kinds: &[Kind; 2]| options.meshes.is_empty() || kinds.iter().all(named);
    let mut suites = Vec::new();
    for (name, placement) in placements() {
        for kinds in pairs().into_iter().filter(wanted) {
            if placement.is_of(kinds) {
                suites.push(suite(kinds, &name, placement, options)?);
            }
        }
    }
    if suites.is_empty() {
        return Err(format!("no pairs of {}", options.meshes.join(", ")));
    }
    Ok(suites)
}

fn suite(kinds: [Kind; 2], name: &str, placement: Placement, options: &Options) -> Result<Suite, String> {
    let title = format!("{}, {}, {name}", kinds[0].name(), kinds[1].name());
    let count = options.poses();
    let mut rng = Rng::new(options.seed ^ digest(title.as_bytes()));
    let pairs: Vec<_> = (0..SIZES).map(|i| placement.sizes(kinds, i, &mut rng)).collect();
    let file: String = title
        .chars()
        .filter_map(|c| if c == ',' { None } else { Some(if c == ' ' { '-' } else { c }) })
        .collect();
    let path =
        options.out.join("poses").join(format!("{file}_{}_{count}_{}.poses", truth::NAME, options.seed));
    let cases = if path.exists() {
        read(&path).ok_or_else(|| format!("{}: damaged; remove it to have it made again", path.display()))?
    } else {
        eprintln!("{title}: poses");
        let cases: Vec<Case> = (0..count).map(|i| placement.case(&pairs, i, &mut rng)).collect();
        let text = written(&format!("{title}, {count} poses, seed {}", options.seed), &cases);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        cases
    };
    Ok(Suite { kinds, placement: name.to_owned(), pairs, cases })
}

impl Placement {
    /// A sphere is never thin, and a half-space never small.
    fn is_of(self, [a, b]: [Kind; 2]) -> bool {
        match self {
            Self::Thin => a != Kind::Sphere || !matches!(b, Kind::Sphere | Kind::HalfSpace),
            Self::Unlike => b != Kind::HalfSpace,
            _ => true,
        }
    }

    fn sizes(self, kinds: [Kind; 2], index: usize, rng: &mut Rng) -> [Solid; 2] {
        let [a, b] = kinds.map(|kind| Solid::random(kind, matches!(self, Self::Exact(_)), rng));
        match self {
            Self::Nested => [a.scaled(0.1), b],
            Self::Thin => [a.thinned(SMALL, rng), b.thinned(SMALL, rng)],
            Self::Tiny => [a.scaled(SMALL), b.scaled(SMALL)],
            Self::Unlike if index.is_multiple_of(2) => [a.scaled(UNLIKE), b],
            Self::Unlike => [a, b.scaled(UNLIKE)],
            _ => [a, b],
        }
    }

    fn case(self, pairs: &[[Solid; 2]], index: usize, rng: &mut Rng) -> Case {
        let pair = index % pairs.len();
        let solids = &pairs[pair];
        let unit = solids[0].diagonal().min(solids[1].diagonal());
        let turn = index / pairs.len() % DISTANCES.len();
        let mut known = None;
        let rows = match self {
            Self::At(i) => approach(solids, relative(i, unit), rng),
            Self::Tiny | Self::Unlike => approach(solids, relative(turn, unit), rng),
            Self::Thin if turn == 0 => approach(solids, Distance::Deep(0.5 * SMALL), rng),
            Self::Thin => approach(solids, relative(turn, unit), rng),
            Self::Far => approach(solids, Distance::Gap(FAR), rng),
            Self::Nested => {
                let [p, mut q] = [&solids[0], &solids[1]].map(|solid| solid.inside(rng));
                if solids[1].kind == Kind::HalfSpace {
                    q[2] = -unit * rng.range(1.0, 10.0);
                }
                at(&rng.rotation(), &p, &q.map(|x| 0.5 * x))
            }
            Self::Exact(gap) => {
                known = Some(gap == 0.0);
                exactly(solids, gap, rng)
            }
        };
        let pose = Pose::from_rows(rows).expect("rotations are rigid");
        let (a, b) = (solids[0].shape().moved(&pose), solids[1].shape());
        let judged = match truth::meets(&a, &b, 0.0) {
            Judgement::Meets => Some(true),
            Judgement::Apart => Some(false),
            Judgement::TooCloseToCall => None,
        };
        assert!(known.is_none() || judged.is_none() || known == judged, "{solids:?} {rows:?}: {judged:?}");
        Case { pair, rows, meets: judged.or(known), distance: truth::distance_interval(&a, &b) }
    }
}

/// One of [`DISTANCES`], as a length.
fn relative(index: usize, unit: f64) -> Distance {
    match DISTANCES[index].1 {
        Distance::Gap(gap) => Distance::Gap(gap * unit),
        Distance::Deep(depth) => Distance::Deep(depth * unit),
    }
}

/// The rotation, with the point p of A at q.
fn at(rotation: &[[f64; 3]; 3], p: &[f64; 3], q: &[f64; 3]) -> Rows {
    core::array::from_fn(|i| {
        let r = &rotation[i];
        [r[0], r[1], r[2], q[i] - super::gjk::dot(r, p)]
    })
}

/// A, rotated at random, approaches from a random direction, such that a random point of it moves towards one of B. For
/// a gap, returns the last position that is farther; for a depth, the position that much beyond the first contact.
fn approach(solids: &[Solid; 2], distance: Distance, rng: &mut Rng) -> Rows {
    let [a, b] = solids.map(|solid| solid.shape());
    let is_plane = solids[1].kind == Kind::HalfSpace;
    let unit = solids[0].diagonal().min(solids[1].diagonal());
    let (gap, depth) = match distance {
        Distance::Gap(gap) => (gap, 0.0),
        Distance::Deep(depth) => (0.0, depth),
    };
    let rotation = rng.rotation();
    let mut from = rng.rotation()[0];
    // Not so far from the side that a cube in place of the half-space would end too early.
    while is_plane && from[2] < 1.0 / 16.0 {
        from = rng.rotation()[0];
    }
    let [p, q] = [&solids[0], &solids[1]].map(|solid| solid.inside(rng));
    let rows = |along: f64| at(&rotation, &p, &core::array::from_fn(|i| q[i] + along * from[i]));
    let goal = gap.max(1e-9 * unit);
    let is_near = |along: f64| {
        let pose = Pose::from_rows(rows(along)).expect("rotations are rigid");
        bounds(&a.moved(&pose), &b).upper <= goal
    };
    // The distance is a convex function of the travel, and 0 at its end.
    let (mut near, mut far) = (0.0, gap + unit);
    while is_near(far) {
        (near, far) = (far, 2.0 * far);
    }
    while far - near > goal / 128.0 {
        let middle = 0.5 * (near + far);
        if middle <= near || middle >= far {
            break;
        }
        if is_near(middle) { near = middle } else { far = middle }
    }
    rows(far - depth)
}

/// B's farthest point along an axis is below A's lowest by exactly the gap. All numbers have few bits, so nothing is
/// rounded.
fn exactly(solids: &[Solid; 2], gap: f64, rng: &mut Rng) -> Rows {
    let rotation = right_angles(rng);
    let (axis, sign) = match solids[1].kind {
        Kind::HalfSpace => (2, 1.0),
        _ => (rng.below(3) as usize, *rng.pick(&[1.0, -1.0])),
    };
    // The axis of A that the rotation takes to that of B, and its direction.
    let own = (0..3).find(|j| rotation[axis][*j] != 0.0).expect("rows are unit vectors");
    let p = solids[0].support(own, -sign * rotation[axis][own]);
    let mut q = solids[1].support(axis, sign);
    q[axis] += sign * gap;
    at(&rotation, &p, &q)
}

/// One of the 24 rotations that map axes to axes.
fn right_angles(rng: &mut Rng) -> [[f64; 3]; 3] {
    let first = rng.below(3) as usize;
    let second = (first + 1 + rng.below(2) as usize) % 3;
    let third = 3 - first - second;
    let signs: [f64; 2] = core::array::from_fn(|_| *rng.pick(&[1.0, -1.0]));
    let even = if (first + 1) % 3 == second { 1.0 } else { -1.0 };
    let mut rotation = [[0.0; 3]; 3];
    rotation[0][first] = signs[0];
    rotation[1][second] = signs[1];
    rotation[2][third] = even * signs[0] * signs[1];
    rotation
}

fn written(title: &str, cases: &[Case]) -> String {
    let mut text = format!(
        "# {title}: the pair of sizes, the rows of [R|t] of A in B's frame, bounds of the distance\n\
         # checksum {:016x}\n",
        checksum(cases)
    );
    for case in cases {
        let _ = write!(text, "{} ", case.pair);
        for number in case.rows.iter().flatten().chain(&case.distance) {
            let _ = write!(text, "{number:e} ");
        }
        let _ = writeln!(text, "{}", WORDS[code(case.meets)]);
    }
    text
}

/// Names of verdicts.
const WORDS: [&str; 3] = ["free", "hit", "open"];

fn code(meets: Option<bool>) -> usize {
    meets.map_or(2, usize::from)
}

/// `None` if the file is not as it was written.
fn read(path: &Path) -> Option<Vec<Case>> {
    let text = std::fs::read_to_string(path).ok()?;
    let sum = text.lines().find_map(|line| line.strip_prefix("# checksum "))?;
    let cases: Option<Vec<Case>> = text.lines().filter(|line| !line.starts_with('#')).map(parsed).collect();
    cases.filter(|cases| format!("{:016x}", checksum(cases)) == sum)
}

fn parsed(line: &str) -> Option<Case> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [pair, numbers @ .., verdict] = words.as_slice() else { return None };
    let numbers: Vec<f64> = numbers.iter().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let numbers: [f64; 14] = numbers.try_into().ok()?;
    Some(Case {
        pair: pair.parse().ok()?,
        rows: core::array::from_fn(|i| core::array::from_fn(|j| numbers[4 * i + j])),
        meets: [Some(false), Some(true), None][WORDS.iter().position(|word| word == verdict)?],
        distance: [numbers[12], numbers[13]],
    })
}

/// The checksum of the bits of the numbers, and the verdicts.
fn checksum(cases: &[Case]) -> u64 {
    let bytes = cases.iter().flat_map(|case| {
        let numbers =
            case.rows.iter().flatten().chain(&case.distance).flat_map(|x| x.to_bits().to_le_bytes());
        numbers.chain([case.pair as u8, code(case.meets) as u8]).collect::<Vec<_>>()
    });
    digest(&bytes.collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_read_back_to_the_bit() {
        let rows =
            [[0.1, -0.2, 1e-300, 3.0], [f64::MIN_POSITIVE, 0.3, 1.0 / 3.0, -7.5], [1.0, 2.0, 3.0, 4e17]];
        for meets in [None, Some(true), Some(false)] {
            let case = Case { pair: 3, rows, meets, distance: [0.1, 0.3] };
            let line = written("test", core::slice::from_ref(&case));
            assert_eq!(parsed(line.lines().last().unwrap()), Some(case));
        }
    }

    #[test]
    fn right_angles_are_rotations() {
        let mut rng = Rng::new(1);
        for _ in 0..100 {
            let [x, y, z] = right_angles(&mut rng);
            let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
            assert_eq!(cross, z);
        }
    }
}
