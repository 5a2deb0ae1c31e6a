//! All bounds of a robot in a scene.

use super::blocks::{LaneSphere, Radii16, radii};
use super::bodies::{LaneBody, ScreenedScene, lane_bodies};
use super::chain::LaneChain;
use super::doubts::Doubt;
use super::field::Field;
use super::grid::{ClearanceGrid, GridSize};
use super::lanes::LANES;
use super::levers::Levers;
use super::robot::RobotBounds;
use super::standing::{PROBE, Standing};
use super::table::{PairTable, ROUNDING};
use crate::node::Box3;
use crate::range::Point;
use crate::scene::{BodyId, SceneError};
use crate::vector::length;
use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Maximum number of grids.
const MOST_FIELDS: usize = 4;

/// Bodies that stand still, keyed by the moving bodies that are tested against them.
type StandingGroups = BTreeMap<Vec<usize>, Vec<BodyId>>;

/// A pair of bodies of the robot with a table.
#[derive(Clone, Debug)]
pub(super) struct TabledPair {
    pub(super) table: usize,
    pub(super) pair: BodyPair,
}

/// Two bodies of the robot: the spheres of each are looked up in a grid around the other.
#[derive(Clone, Debug)]
pub(super) struct BodyPair {
    pub(super) bodies: [usize; 2],
    /// For each body, the number of joints that move it but not the other.
    pub(super) joints: [usize; 2],
    pub(super) seen: Vec<SeenBody>,
}

/// A body whose spheres are looked up in the grid around another.
#[derive(Clone, Debug)]
pub(super) struct SeenBody {
    /// The other body and this one.
    pub(super) bodies: [usize; 2],
    pub(super) coarse: Radii16,
    pub(super) fine: Vec<Radii16>,
    /// How much the spheres may be enlarged.
    pub(super) room: f32,
}

/// The bounds of a robot among bodies that stand still.
#[derive(Clone, Debug)]
pub(crate) struct Screen {
    pub(super) chain: LaneChain,
    pub(super) levers: Levers,
    pub(super) bodies: Vec<LaneBody>,
    pub(super) fields: Vec<Field>,
    /// Pairs of bodies of the robot that have no table.
    pub(super) pairs: Vec<BodyPair>,
    pub(super) bounds: Arc<RobotBounds>,
    pub(super) tabled: Vec<TabledPair>,
    /// All pairs that are tested: those with tables, of fields, and without tables.
    pub(super) asked: Vec<Doubt>,
    /// Whether bodies that do not move meet.
    pub(super) is_blocked: bool,
    pub(super) cell: f64,
}

impl Screen {
    /// Makes the bounds with cells of this width. `None` if they do not cover such a robot or scene.
    pub(in crate::planning) fn new(
        around: &ScreenedScene<'_>,
        bounds: &Arc<RobotBounds>,
        cell: f64,
    ) -> Result<Option<Self>, SceneError> {
        let Some(chain) = LaneChain::new(&around.kinematics) else { return Ok(None) };
        let Some(bodies) = lane_bodies(around, &chain, bounds)? else { return Ok(None) };
        let levers = Levers::new(&around.kinematics, &chain, &bodies, ROUNDING * bounds.size);
        let mut screen = Self {
            chain,
            levers,
            bodies,
            fields: Vec::new(),
            pairs: Vec::new(),
            bounds: Arc::clone(bounds),
            tabled: Vec::new(),
            asked: Vec::new(),
            is_blocked: false,
            cell,
        };
        screen.set_pairs(around)?;
        let is_made = screen.set_fields(around)?;
        Ok(is_made.then_some(screen))
    }

    /// Bytes of its grids and tables.
    pub(in crate::planning) fn bytes(&self) -> usize {
        self.fields.iter().map(|field| field.grid.bytes()).sum::<usize>() + self.bounds.bytes()
    }

    /// The pairs of bodies of the robot that are tested.
    fn set_pairs(&mut self, around: &ScreenedScene<'_>) -> Result<(), SceneError> {
        for i in 0..self.bodies.len() {
            for j in i + 1..self.bodies.len() {
                let bodies = [i, j].map(|body| self.bodies[body].id);
                if !around.scene.is_asked(bodies[0], bodies[1])? {
                    continue;
                }
                match self.bounds.tables.find(i, j) {
                    None => self.pairs.push(self.pair([i, j])),
                    Some(table) => {
                        if !self.bounds.tables.get(table).is_some_and(PairTable::is_free) {
                            self.tabled.push(TabledPair { table, pair: self.pair([i, j]) });
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The spheres of the smaller body come first: its cover is tighter.
    fn pair(&self, bodies @ [i, j]: [usize; 2]) -> BodyPair {
        let first = if self.bodies[i].whole.outer < self.bodies[j].whole.outer { [j, i] } else { [i, j] };
        let seen = [first, [first[1], first[0]]].into_iter().filter_map(|bodies| self.seen(bodies));
        BodyPair { bodies, joints: self.levers.to_common(bodies), seen: seen.collect() }
    }

    /// The spheres of the second body in the grid around the first. `None` if there is no grid that supports spheres as
    /// large as these.
    fn seen(&self, bodies @ [a, b]: [usize; 2]) -> Option<SeenBody> {
        let ([p, q], (grid, _)) = ([&self.bodies[a], &self.bodies[b]], self.bounds.grids.get(a)?.as_ref()?);
        let seen = |sphere: &LaneSphere| {
            let more = self.chain.error_seen_from(p.link, q.link, &sphere.centre.map(f64::from));
            LaneSphere { outer: sphere.outer + more, inner: sphere.inner - more, ..*sphere }
        };
        let [coarse, fine] = [&q.coarse, &q.fine].map(|of| of.iter().map(seen).collect::<Vec<_>>());
        let largest = coarse.iter().chain(&fine).map(|sphere| sphere.outer).fold(0.0, f64::max);
        let of = |outer: f64, inner: f64| grid.radii(outer, inner);
        let fine = fine.chunks(LANES).map(|block| radii(block, of)).collect();
        let room = grid.room(largest);
        (largest <= grid.size().outer).then(|| SeenBody { bodies, coarse: radii(&coarse, of), fine, room })
    }

    /// The bodies that stand still, keyed by the moving bodies that are tested against them.
    fn groups(&self, around: &ScreenedScene<'_>) -> Result<StandingGroups, SceneError> {
        let mut groups = StandingGroups::new();
        let moving = || self.bodies.iter().enumerate().filter(|(_, body)| body.is_moving());
        let own = self.bodies.iter().filter(|body| !body.is_moving()).map(|body| body.id);
        for id in own {
            // Moving bodies are tested against it as pairs.
            groups.entry(Vec::new()).or_default().push(id);
        }
        for &id in around.objects {
            if around.scene.attached_to(id)?.is_some() {
                continue;
            }
            let mut asked = Vec::new();
            for (i, body) in moving() {
                if around.scene.is_asked(body.id, id)? {
                    asked.push(i);
                }
            }
            groups.entry(asked).or_default().push(id);
        }
        Ok(groups)
    }

    /// Makes all grids. False if there would be too many.
    fn set_fields(&mut self, around: &ScreenedScene<'_>) -> Result<bool, SceneError> {
        self.fields.clear();
        self.update_fields(around, None)
    }

    /// Whether the body is one of the robot's, or was attached to it when the bounds were made.
    pub(in crate::planning) fn moves(&self, id: BodyId) -> bool {
        self.bodies.iter().any(|body| body.id == id)
    }

    /// Updates the cells near the boxes around the body `id`, before and after it was inserted, moved or removed, and
    /// which does not move with the robot. False if the bounds no longer apply.
    pub(in crate::planning) fn update(
        &mut self,
        around: &ScreenedScene<'_>,
        id: BodyId,
        boxes: &[Box3],
    ) -> Result<bool, SceneError> {
        self.update_fields(around, Some((id, boxes)))
    }

    fn update_fields(
        &mut self,
        around: &ScreenedScene<'_>,
        changed: Option<(BodyId, &[Box3])>,
    ) -> Result<bool, SceneError> {
        let mut groups = self.groups(around)?;
        self.set_blocked(around, &groups)?;
        groups.retain(|asked, _| !asked.is_empty());
        if groups.len() > MOST_FIELDS {
            return Ok(false);
        }
        let mut before = core::mem::take(&mut self.fields);
        for (key, standing) in groups {
            let old = before.iter().position(|field| field.key == key).map(|i| before.swap_remove(i));
            let grid = match (old, changed) {
                (Some(old), Some((id, boxes))) => self.updated(around, old, &standing, (id, boxes))?,
                _ => None,
            };
            let grid = match grid {
                Some(grid) => grid,
                None => self.grid(around, &key, &standing)?,
            };
            let more = ROUNDING * self.bounds.size;
            let field = Field::new(around, &self.bodies, (key, standing), grid, more)?;
            self.fields.push(field);
        }
        let fields = self.fields.iter().enumerate();
        let of_fields = fields
            .flat_map(|(field, of)| (0..of.asked.len()).map(move |asked| Doubt::Field { field, asked }));
        let tables = (0..self.tabled.len()).map(|pair| Doubt::Table { pair });
        let pairs = (0..self.pairs.len()).map(|pair| Doubt::Pair { pair });
        self.asked = tables.chain(of_fields).chain(pairs).collect();
        Ok(true)
    }

    /// The grid of a field after one body changed. `None` if it is too small or of another kind.
    fn updated(
        &self,
        around: &ScreenedScene<'_>,
        old: Field,
        standing: &[BodyId],
        (id, boxes): (BodyId, &[Box3]),
    ) -> Result<Option<ClearanceGrid>, SceneError> {
        let mut grid = old.grid;
        let size = self.grid_size(around, &old.key, standing)?;
        let corners = self.reached(around, &old.key, standing, &size)?;
        if *grid.size() != size || !grid.holds(&corners) {
            return Ok(None);
        }
        if old.standing.contains(&id) || standing.contains(&id) {
            let mut still = Standing::new(around.scene, standing, PROBE * self.cell, &around.query)?;
            for bounds in boxes.iter().filter(|bounds| !bounds.is_empty()) {
                let corners = [bounds.lower, bounds.upper].map(|corner| corner.map(f64::from));
                grid.update(&mut still, &corners)?;
            }
        }
        Ok(Some(grid))
    }

    fn set_blocked(&mut self, around: &ScreenedScene<'_>, groups: &StandingGroups) -> Result<(), SceneError> {
        let standing: Vec<BodyId> = groups.values().flatten().copied().collect();
        self.is_blocked = false;
        for (i, &a) in standing.iter().enumerate() {
            for &b in &standing[i + 1..] {
                if !self.is_blocked && around.scene.is_asked(a, b)? {
                    self.is_blocked = around.scene.do_meet(&around.query, a, b)?;
                }
            }
        }
        Ok(())
    }

    fn grid_size(
        &self,
        around: &ScreenedScene<'_>,
        asked: &[usize],
        standing: &[BodyId],
    ) -> Result<GridSize, SceneError> {
        let spheres =
            || asked.iter().flat_map(|&i| self.bodies[i].fine.iter().chain([&self.bodies[i].whole]));
        let mut inner = spheres().map(|sphere| sphere.inner).fold(0.0, f64::max);
        for &id in standing {
            // A body may reach in through a hole and meet nothing.
            if around.scene.has_caps(id)? {
                inner = 0.0;
            }
        }
        let outer = spheres().map(|sphere| sphere.outer).fold(0.0, f64::max);
        // Two cells more than the largest sphere, so that a sphere enlarged by one cell can still be certainly free.
        Ok(GridSize { cell: self.cell, outer: outer.max(inner) + 2.0 * self.cell, inner })
    }

    fn grid(
        &self,
        around: &ScreenedScene<'_>,
        asked: &[usize],
        standing: &[BodyId],
    ) -> Result<ClearanceGrid, SceneError> {
        let size = self.grid_size(around, asked, standing)?;
        let corners = self.reached(around, asked, standing, &size)?;
        let mut still = Standing::new(around.scene, standing, PROBE * self.cell, &around.query)?;
        ClearanceGrid::new(&mut still, corners, size)
    }

    /// A box outside of which no sphere of the bodies meets what stands still.
    fn reached(
        &self,
        around: &ScreenedScene<'_>,
        asked: &[usize],
        standing: &[BodyId],
        size: &GridSize,
    ) -> Result<[Point; 2], SceneError> {
        let boxes = standing.iter().map(|&id| around.scene.bounds_of(id)).collect::<Result<Vec<_>, _>>()?;
        let reach = asked.iter().map(|&i| self.reach(&self.bodies[i])).fold(0.0, f64::max);
        let base = around.kinematics.base().translation();
        let room = size.outer + self.cell;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for bounds in boxes.iter().filter(|bounds| !bounds.is_empty()) {
            for i in 0..3 {
                low[i] = low[i].min(f64::from(bounds.lower[i]) - room);
                high[i] = high[i].max(f64::from(bounds.upper[i]) + room);
            }
        }
        for i in 0..3 {
            (low[i], high[i]) = (low[i].max(base[i] - reach), high[i].min(base[i] + reach));
            if low[i] > high[i] {
                (low[i], high[i]) = (base[i], base[i]);
            }
        }
        Ok([low, high])
    }

    /// Upper bound of the distance of any centre of a body from the base.
    fn reach(&self, body: &LaneBody) -> f64 {
        let away = |sphere: &LaneSphere| length(&sphere.centre.map(f64::from)) + sphere.outer;
        self.chain.reach_from_base(body.link) + body.spheres().map(away).fold(0.0, f64::max) + self.cell
    }
}
