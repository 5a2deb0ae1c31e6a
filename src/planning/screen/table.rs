//! Pairs of a robot's bodies whose relative pose depends on one to three variables: a table over their values.
//!
//! Each cell of the table says that the bodies meet nowhere in it, or everywhere, as [`Scene::classify_pair`] certifies
//! boxes, or neither. Boxes of many cells are asked first, and halved where they are not certain. A box is also certain
//! where a sphere inside of one body reaches into the other, by a grid around that, deeper than any point moves in the box.
//!
//! The other variables move both bodies as one, and change only the rounding of their poses, which is in the allowance
//! [`ROUNDING`]. Boxes are larger than their cells by 2^-30 of the limits, more than a value can be off when its cell is
//! looked up.

use super::blocks::{LaneSphere, block, radii};
use super::grid::{ClearanceGrid, LinkGrids};
use super::lanes::{LANES, mask};
use super::links::LinkSpheres;
use crate::exact::power_of_two;
use crate::isa::Isa;
use crate::motion::Kinematics;
use crate::planning::{LinkGeometry, PlanningNode};
use crate::pose::Pose;
use crate::primitive::Sphere;
use crate::query::Query;
use crate::scene::{BodyId, BoxClass, Scene, SceneError};
use crate::vector::length;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::vec;
use alloc::vec::Vec;

/// Cells along each variable, for one, two and three of them.
const ALONG: [usize; 3] = [1024, 256, 40];
/// Allowance for the rounding of poses, relative to the size of the robot. The base is at most 2^8 sizes away, and poses
/// are off by less than 2^-40 of the coordinates.
pub(super) const ROUNDING: f64 = power_of_two(-30);
/// By how much a box is larger than its cells, relative to the limits.
const WIDER: f64 = power_of_two(-30);
/// Adding it rounds a number below 2^31 to an integer, in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// What a cell says.
const ASK: u8 = 0;
const FREE: u8 = 1;
const MEET: u8 = 2;

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
    /// None if all are free.
    cells: Vec<u8>,
}

/// The tables of a robot.
#[derive(Clone, Default, Debug)]
pub(super) struct PairTables {
    all: Vec<PairTable>,
    /// By the indices of the bodies, the lower one first.
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

/// Tables of those pairs that depend on few variables.
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
    for &(i, j) in pairs {
        let links = [i, j].map(|body| kinematics.bodies()[body].link);
        let variables = between(kinematics, links);
        if (1..=ALONG.len()).contains(&variables.len()) {
            let _ = tables.of.insert((i.min(j), i.max(j)), tables.all.len());
            let pair = (ids[i], ids[j]);
            let inside = [i, j].map(|body| (&spheres[body].inside[..], grids[body].as_ref()));
            let more = ROUNDING * size;
            tables.all.push(PairTable::new(kinematics, &mut scene, &ids, pair, &variables, more, inside)?);
        }
    }
    Ok(tables)
}

/// Whether the bodies meet in a box of values, everywhere or nowhere.
type AskBox<'q> = dyn FnMut(&[Vec<f64>; 2]) -> Result<Option<bool>, SceneError> + 'q;

/// Spheres inside of a body, and a grid around it, with the body's pose there.
type InnerSpheres<'s> = (&'s [Sphere], Option<&'s (ClearanceGrid, Pose)>);

/// Whether a sphere inside of a body reaches into the other at the middle of a box, deeper than any point moves in it.
fn do_overlap([a, b]: [InnerSpheres<'_>; 2], class: &BoxClass) -> bool {
    let [at_a, at_b] = &class.poses;
    let is_in = |of: InnerSpheres<'_>, at: &Pose, other: InnerSpheres<'_>, at_other: &Pose| {
        other.1.is_some_and(|around| reaches_in(of.0, at, around, at_other, class.path))
    };
    is_in(b, at_b, a, at_a) || is_in(a, at_a, b, at_b)
}

/// Whether a sphere of a body reaches deeper than `path` into what a grid is around.
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
    /// Of a body that one variable moves, against bodies that stand still. `None` for other bodies.
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
        Ok(all)
    }

    /// Free where both are, and met where one is.
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
            // The values of all other variables do not matter.
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

    /// In which lanes the bodies certainly do not meet, and in which they do, as masks.
    #[inline(always)]
    pub(super) fn look_up(&self, values: &[[f64; LANES]]) -> [u16; 2] {
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
            free |= u16::from(says & FREE) << lane;
            meet |= u16::from(says >> 1) << lane;
        }
        [free, meet]
    }
}
