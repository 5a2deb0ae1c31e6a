//! Pairs of a robot's bodies whose relative pose depends on one to three variables: a table over their values.
//!
//! Each cell of the table says that the bodies meet nowhere in it, everywhere in it, or neither is certain, as
//! [`Scene::classify_pair`] certifies boxes. The construction starts with boxes of many cells, and halves those that
//! are not certain. The bodies also certainly meet in a box if a sphere inside one reaches into the other, according to
//! the other's grid, deeper than any point moves in the box.
//!
//! The other variables move both bodies together, and change only the rounding of their poses, which the allowance
//! [`ROUNDING`] covers. Boxes are larger than their cells by 2^-30 of the limits, more than the error of a value in a
//! look-up.

use super::blocks::{LaneSphere, block, radii};
use super::grid::{ClearanceGrid, LinkGrids};
use super::lanes::{LANES, Lane16, mask};
use super::links::LinkSpheres;
use crate::exact::power_of_two;
use crate::isa::Isa;
use crate::motion::Kinematics;
use crate::parallel;
use crate::planning::{LinkGeometry, PlanningNode};
use crate::pose::Pose;
use crate::primitive::Sphere;
use crate::query::Query;
use crate::scene::{BodyId, BoxClass, Scene, SceneError};
use crate::vector::length;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::vec;
use alloc::vec::Vec;

/// Number of cells along each variable, for one, two and three variables.
const ALONG: [usize; 3] = [1024, 256, 40];
/// Allowance for the rounding of poses, relative to the size of the robot. The base is at most 2^8 sizes away, and
/// poses are off by less than 2^-40 of the coordinates.
pub(super) const ROUNDING: f64 = power_of_two(-30);
/// The enlargement of a box beyond its cells, relative to the limits.
const WIDER: f64 = power_of_two(-30);
/// The enlargement of a span, for roundings.
const WIDER_SPAN: f64 = power_of_two(-18);
/// Adding it rounds a number below 2^31 to an integer, in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// The verdict of a cell, in the lowest bits.
const ASK: u8 = 0;
const FREE: u8 = 1;
const MEET: u8 = 2;
const SAYS: u8 = 3;
/// The upper bits hold the distance in cells, along all axes, within which all cells are free, up to a maximum.
const AROUND: u8 = 4;
const MOST_AROUND: usize = 63;

/// A variable of a table.
#[derive(Copy, Clone, PartialEq, Debug)]
struct TableAxis {
    variable: usize,
    /// The middle of the first cell.
    first: f64,
    per_unit: f64,
    cells: usize,
    limits: [f64; 2],
}

/// Whether two bodies meet, over the values of a few variables.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct PairTable {
    axes: Vec<TableAxis>,
    /// Empty if all cells are free.
    cells: Vec<u8>,
}

/// The tables of a robot.
#[derive(Clone, Default, Debug)]
pub(super) struct PairTables {
    all: Vec<PairTable>,
    /// Keyed by the indices of the bodies, the lower one first.
    of: BTreeMap<(usize, usize), usize>,
}

impl PairTables {
    /// The number of a pair's table.
    pub(super) fn find(&self, i: usize, j: usize) -> Option<usize> {
        self.of.get(&(i.min(j), i.max(j))).copied()
    }

    #[inline(always)]
    pub(super) fn get(&self, number: usize) -> Option<&PairTable> {
        self.all.get(number)
    }

    pub(super) fn bytes(&self) -> usize {
        self.all.iter().map(|table| table.cells.len()).sum()
    }
}

/// The variables that move one link relative to another.
fn between(kinematics: &Kinematics<'_>, links: [u32; 2]) -> BTreeSet<usize> {
    let path = |mut link: u32| {
        let mut joints = BTreeSet::new();
        while link > 0 {
            joints.insert(link as usize - 1);
            link = kinematics.joints()[link as usize - 1].parent();
        }
        joints
    };
    let [a, b] = links.map(path);
    a.symmetric_difference(&b).map(|&joint| kinematics.joints()[joint].variable() as usize).collect()
}

/// Tables of the pairs that depend on few variables.
pub(super) fn tables(
    kinematics: &Kinematics<'_>,
    (bodies, spheres, grids): (&[LinkGeometry], &[LinkSpheres], &LinkGrids),
    pairs: &[(usize, usize)],
    size: f64,
) -> Result<PairTables, SceneError> {
    let mut scene: Scene<'static, PlanningNode> = Scene::new();
    let ids = bodies
        .iter()
        .map(|body| scene.insert(body.body(), &Pose::IDENTITY))
        .collect::<Result<Vec<_>, _>>()?;
    let mut tables = PairTables::default();
    let mut jobs = Vec::new();
    for &(i, j) in pairs {
        let variables = between(kinematics, [i, j].map(|body| kinematics.bodies()[body].link));
        if (1..=ALONG.len()).contains(&variables.len()) {
            let _ = tables.of.insert((i.min(j), i.max(j)), jobs.len());
            jobs.push(([i, j], variables));
        }
    }
    let mut made: Vec<Option<Result<PairTable, SceneError>>> = vec![None; jobs.len()];
    let more = ROUNDING * size;
    // Each thread has its own scene, with shared trees.
    parallel::for_each(
        made.iter_mut().zip(&jobs).collect(),
        |own: &mut Option<_>, (made, (pair, variables))| {
            let scene = own.get_or_insert_with(|| scene.clone());
            let inside = pair.map(|body| (&spheres[body].inside[..], grids[body].as_ref()));
            let [a, b] = pair.map(|body| ids[body]);
            let table = PairTable::new(kinematics, scene, &ids, (a, b), variables, more, inside);
            *made = Some(table.map(PairTable::with_surroundings));
        },
    );
    tables.all = made.into_iter().flatten().collect::<Result<_, _>>()?;
    Ok(tables)
}

/// Whether the bodies meet everywhere in a box of values, or nowhere. `None` if neither is certain.
type AskBox<'q> = dyn FnMut(&[Vec<f64>; 2]) -> Result<Option<bool>, SceneError> + 'q;

/// Spheres inside a body, and a grid around it, with the body's pose in the grid's frame.
type InnerSpheres<'s> = (&'s [Sphere], Option<&'s (ClearanceGrid, Pose)>);

/// Whether a sphere inside either body reaches into the other at the middle of a box, deeper than any point moves in
/// the box.
fn do_overlap([a, b]: [InnerSpheres<'_>; 2], class: &BoxClass) -> bool {
    let [at_a, at_b] = &class.poses;
    let is_in = |of: InnerSpheres<'_>, at: &Pose, other: InnerSpheres<'_>, at_other: &Pose| {
        other.1.is_some_and(|around| reaches_in(of.0, at, around, at_other, class.path))
    };
    is_in(b, at_b, a, at_a) || is_in(a, at_a, b, at_b)
}

/// Whether a sphere of a body reaches deeper than `path` into the body in a grid.
fn reaches_in(
    spheres: &[Sphere],
    at: &Pose,
    (grid, on_link): &(ClearanceGrid, Pose),
    at_other: &Pose,
    path: f64,
) -> bool {
    let Ok(relative) = Pose::relative(at, at_other) else { return false };
    let (to_grid, shrunk) = (on_link.after(relative.pose()), 1.0 - at.skew().max(at_other.skew()));
    let seen = |sphere: &Sphere| {
        let centre = to_grid.unflushed(&sphere.centre);
        let rounding = power_of_two(-22) * length(&centre);
        let inner = sphere.radius * shrunk - path - rounding;
        LaneSphere { centre: centre.map(|x| x as f32), outer: 0.0, inner }
    };
    let deep: Vec<LaneSphere> = spheres.iter().map(seen).filter(|sphere| sphere.inner > 0.0).collect();
    deep.chunks(LANES).any(|spheres| {
        let radii = radii(spheres, |outer, inner| grid.radii(outer, inner));
        let [_, hit] = grid.look_up(&block(spheres), &radii);
        mask(&hit) != 0
    })
}

impl PairTable {
    /// The table of a body that one variable moves, against bodies that stand still. `None` for other bodies.
    pub(super) fn of_body(
        kinematics: &Kinematics<'_>,
        scene: &Scene<'static, PlanningNode>,
        body: usize,
        (links, standing): (&[BodyId], &[BodyId]),
        more: f64,
    ) -> Result<Option<Self>, SceneError> {
        let variables = between(kinematics, [0, kinematics.bodies()[body].link]);
        if variables.len() != 1 {
            return Ok(None);
        }
        let (mut scene, mut all) = (scene.clone(), None);
        for &id in standing {
            let pair = (links[body], id);
            let table = Self::new(kinematics, &mut scene, links, pair, &variables, more, [(&[], None); 2])?;
            all = Some(match all {
                None => table,
                Some(before) => table.and(before),
            });
        }
        Ok(all.map(Self::with_surroundings))
    }

    /// Before their surroundings are known: the cells that are free in both tables are free; those that meet in either
    /// meet.
    fn and(self, other: Self) -> Self {
        if self.is_free() {
            return other;
        }
        let says = |(a, b): (&u8, &u8)| match (*a, *b) {
            (MEET, _) | (_, MEET) => MEET,
            (FREE, FREE) => FREE,
            _ => ASK,
        };
        let cells = match other.is_free() {
            true => self.cells,
            false => self.cells.iter().zip(&other.cells).map(says).collect(),
        };
        Self { cells, ..other }
    }

    /// Writes to each free cell the distance in cells within which all cells are free.
    fn with_surroundings(mut self) -> Self {
        let count = [0, 1, 2].map(|i| self.axes.get(i).map_or(1, |axis| axis.cells));
        // Distance to the nearest cell that is not free: the largest difference along the axes so far.
        let far = |says: &u8| if *says & SAYS == FREE { 1 + MOST_AROUND } else { 0 };
        let mut away: Vec<usize> = self.cells.iter().map(far).collect();
        let mut line = Vec::new();
        for axis in 0..self.axes.len() {
            let stride: usize = count[axis + 1..].iter().product();
            for first in (0..away.len()).filter(|place| (place / stride).is_multiple_of(count[axis])) {
                line.clear();
                line.extend((0..count[axis]).map(|i| away[first + i * stride]));
                for i in 0..line.len() {
                    let mut least = line[i];
                    for by in 1..=MOST_AROUND {
                        if by >= least {
                            break;
                        }
                        for of in [i.checked_sub(by), Some(i + by)].into_iter().flatten() {
                            least = least.min(line.get(of).map_or(least, |away| by.max(*away)));
                        }
                    }
                    away[first + i * stride] = least;
                }
            }
        }
        for (cell, away) in self.cells.iter_mut().zip(&away) {
            *cell = (*cell & SAYS) + AROUND * away.saturating_sub(1) as u8;
        }
        self
    }

    fn new(
        kinematics: &Kinematics<'_>,
        scene: &mut Scene<'static, PlanningNode>,
        ids: &[BodyId],
        pair: (BodyId, BodyId),
        variables: &BTreeSet<usize>,
        more: f64,
        inside: [InnerSpheres<'_>; 2],
    ) -> Result<Self, SceneError> {
        let axis = |&variable: &usize| {
            let limits @ [low, high] = kinematics.limits()[variable];
            let cells = if high > low { ALONG[variables.len() - 1] } else { 1 };
            let width = (high - low) / cells as f64;
            let per_unit = if high > low { 1.0 / width } else { 0.0 };
            TableAxis { variable, first: low + 0.5 * width, per_unit, cells, limits }
        };
        let axes: Vec<TableAxis> = variables.iter().map(axis).collect();
        let mut table = Self { cells: vec![ASK; axes.iter().map(|axis| axis.cells).product()], axes };
        let query = Query::new(Isa::detect());
        scene.ask_boxes(&query, ids, *kinematics, pair, |ask| {
            let mut ask = |values: &[Vec<f64>; 2]| {
                let class = ask(values, more)?;
                let is_certain = class.is_everywhere || class.is_meeting && do_overlap(inside, &class);
                Ok(is_certain.then_some(class.is_meeting))
            };
            // The values of the other variables are irrelevant.
            let any: Vec<f64> =
                kinematics.limits().iter().map(|[low, high]| 0.0_f64.clamp(*low, *high)).collect();
            let (from, to) = ([0; 3], [0, 1, 2].map(|i| table.axes.get(i).map_or(1, |axis| axis.cells)));
            table.refine(&mut ask, &any, from, to)
        })?;
        if table.cells.iter().all(|says| *says == FREE) {
            table.cells = Vec::new();
        }
        Ok(table)
    }

    /// Whether the bodies never meet.
    pub(super) const fn is_free(&self) -> bool {
        self.cells.is_empty()
    }

    fn refine(
        &mut self,
        ask: &mut AskBox<'_>,
        any: &[f64],
        from: [usize; 3],
        to: [usize; 3],
    ) -> Result<(), SceneError> {
        let mut values = [any.to_vec(), any.to_vec()];
        for (i, axis) in self.axes.iter().enumerate() {
            let [low, high] = axis.limits;
            let at = |cell: usize| low + (high - low) * (cell as f64 / axis.cells as f64);
            let more = WIDER * (high - low);
            values[0][axis.variable] = (at(from[i]) - more).clamp(low, high);
            values[1][axis.variable] = (at(to[i]) + more).clamp(low, high);
        }
        let width = [0, 1, 2].map(|i| to[i] - from[i]);
        let widest = (1..3).fold(0, |most, i| if width[i] > width[most] { i } else { most });
        match ask(&values)? {
            Some(is_meeting) => self.fill(from, to, if is_meeting { MEET } else { FREE }),
            None if width[widest] == 1 => {}
            None => {
                let (mut middle, mut next) = (to, from);
                middle[widest] = from[widest] + width[widest] / 2;
                next[widest] = middle[widest];
                self.refine(ask, any, from, middle)?;
                self.refine(ask, any, next, to)?;
            }
        }
        Ok(())
    }

    fn fill(&mut self, from: [usize; 3], to: [usize; 3], says: u8) {
        let count = [1, 2].map(|i| self.axes.get(i).map_or(1, |axis| axis.cells));
        for x in from[0]..to[0] {
            for y in from[1]..to[1] {
                let row = (x * count[0] + y) * count[1];
                self.cells[row + from[2]..row + to[2]].fill(says);
            }
        }
    }

    /// Masks of the lanes in which the bodies certainly do not meet, and of those in which they certainly do.
    #[inline(always)]
    pub(super) fn look_up(&self, values: &[[f64; LANES]]) -> [u16; 2] {
        self.look_up_around(values, &[0.0; LANES])
    }

    /// The length of a motion of the variables in cells, along the axis where it is the longest.
    pub(super) fn cells_along(&self, [from, to]: [&[f64]; 2]) -> f32 {
        let along = |axis: &TableAxis| (to[axis.variable] - from[axis.variable]).abs() * axis.per_unit;
        (self.axes.iter().map(along).fold(0.0, f64::max) * (1.0 + WIDER_SPAN)) as f32
    }

    /// As [`PairTable::look_up`], where free means free within `around` cells of the values, along each axis.
    #[inline(always)]
    pub(super) fn look_up_around(&self, values: &[[f64; LANES]], around: &Lane16) -> [u16; 2] {
        let mut index = [0_u32; LANES];
        for axis in &self.axes {
            let (of, last, stride) = (&values[axis.variable], (axis.cells - 1) as f64, axis.cells as u32);
            for lane in 0..LANES {
                let h = (of[lane] - axis.first) * axis.per_unit;
                let h = if h > 0.0 { h } else { 0.0 };
                let h = if h < last { h } else { last };
                index[lane] = index[lane] * stride + ((h + ROUND).to_bits() as u32 & 0xffff);
            }
        }
        let [mut free, mut meet] = [0_u16; 2];
        for (lane, index) in index.iter().enumerate() {
            let says = self.cells.get(*index as usize).copied().unwrap_or(ASK);
            let is_free = says & SAYS == FREE && f32::from(says / AROUND) >= around[lane];
            free |= u16::from(is_free) << lane;
            meet |= u16::from(says & SAYS == MEET) << lane;
        }
        [free, meet]
    }
}
