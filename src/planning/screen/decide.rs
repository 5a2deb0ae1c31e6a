//! Evaluates all bounds for sixteen configurations.

use super::apart::are_apart;
use super::blocks::Radii16;
use super::bodies::LaneBody;
use super::chain::{LaneFrame, OneFrame};
use super::doubts::{Doubt, Doubts, LaneVerdicts, OpenPair};
use super::grid::ClearanceGrid;
use super::lanes::{LANES, Lane16, mask};
use super::table::PairTable;
use super::whole::{BodyPair, Screen, SeenBody, TabledPair};
use crate::isa::{Isa, on_isa};
use crate::kernel::Kernel;
use alloc::vec;
use alloc::vec::Vec;

impl Screen {
    pub(in crate::planning) fn doubts(&self, variables: usize) -> Doubts {
        Doubts {
            frames: vec![LaneFrame::NOWHERE; self.chain.links()],
            wholes: vec![[[0.0; LANES]; 3]; self.bodies.len()],
            doubts: Vec::with_capacity(self.asked.len()),
            values: vec![[0.0; LANES]; variables],
            motion: self.motion_spans(variables),
        }
    }

    /// Decides the configurations in the lanes of a mask, whose values are in `doubts`.
    pub(in crate::planning) fn decide(&self, isa: Isa, lanes: u16, doubts: &mut Doubts) -> LaneVerdicts {
        if self.is_blocked {
            return LaneVerdicts { free: 0, hit: lanes };
        }
        let open = self.decide_lanes(isa, lanes, false, doubts);
        let asked = doubts.doubts.iter().fold(0, |mask, (_, lanes)| mask | lanes);
        LaneVerdicts { free: open & !asked, hit: lanes & !open }
    }

    /// The pairs of bodies that the bounds leave open in a lane.
    pub(in crate::planning) fn open_pairs<'s>(
        &'s self,
        lane: usize,
        doubts: &'s Doubts,
    ) -> impl Iterator<Item = OpenPair<'s>> + 's {
        let of_lane = move |(_, lanes): &&(Doubt, u16)| lanes >> lane & 1 != 0;
        doubts.doubts.iter().filter(of_lane).map(|(doubt, _)| self.open_pair(doubt))
    }

    /// The bodies that a doubt is about.
    pub(super) fn open_pair(&self, doubt: &Doubt) -> OpenPair<'_> {
        let moved = |body: usize| (self.bodies[body].id, self.bodies[body].carrier);
        match (self.bodies_of(doubt), doubt) {
            ([body, _], Doubt::Field { field, .. }) => {
                OpenPair::Standing(moved(body), &self.fields[*field].standing)
            }
            (bodies, _) => OpenPair::Own(bodies.map(moved)),
        }
    }

    /// The moving bodies of a doubt; the same one twice if there is only one.
    pub(super) fn bodies_of(&self, doubt: &Doubt) -> [usize; 2] {
        match *doubt {
            Doubt::Field { field, asked } => [self.fields[field].asked[asked].body; 2],
            Doubt::Pair { pair } => self.pairs[pair].bodies,
            Doubt::Table { pair } => self.tabled[pair].pair.bodies,
        }
    }

    /// Tests all pairs. Returns the lanes without a certain hit. If `ends_at_hit`, the first lanes with a hit end it.
    pub(super) fn decide_lanes(&self, isa: Isa, lanes: u16, ends_at_hit: bool, doubts: &mut Doubts) -> u16 {
        on_isa!(isa, token => token.run(
            #[inline(always)]
            || {
                self.chain.go_to(&doubts.values, &mut doubts.frames);
                for body in 0..self.bodies.len() {
                    self.place_whole(body, doubts);
                }
                let mut open = lanes;
                doubts.doubts.clear();
                for doubt in &self.asked {
                    let unsure = self.decide_doubt::<false>(doubt, open, &mut open, doubts);
                    if unsure != 0 {
                        doubts.doubts.push((*doubt, unsure));
                    }
                    if ends_at_hit && open != lanes {
                        break;
                    }
                }
                for (_, lanes) in &mut doubts.doubts {
                    *lanes &= open;
                }
                open
            },
        ))
    }

    /// Places the sphere around a body.
    #[inline(always)]
    pub(super) fn place_whole(&self, body: usize, doubts: &mut Doubts) {
        let LaneBody { link, whole, .. } = &self.bodies[body];
        doubts.wholes[body] = doubts.frames[*link].apply(&whole.centre);
    }

    /// Removes lanes from `open` in which a pair meets. Returns those of `lanes` that stay uncertain. With spans, free
    /// means free within the whole span of the lane.
    #[inline(always)]
    pub(super) fn decide_doubt<const SPAN: bool>(
        &self,
        doubt: &Doubt,
        lanes: u16,
        open: &mut u16,
        doubts: &Doubts,
    ) -> u16 {
        let (pair, unsure) = match *doubt {
            Doubt::Field { field, asked } => {
                return self.decide_asked::<SPAN>((field, asked), lanes, open, doubts);
            }
            Doubt::Pair { pair } => (&self.pairs[pair], lanes & *open),
            Doubt::Table { pair: tabled } => {
                let TabledPair { table, pair } = &self.tabled[tabled];
                let Some(of) = self.bounds.tables.get(*table) else { return lanes };
                let along = if SPAN { doubts.motion.along[tabled] } else { 0.0 };
                let [free, meet] = look_up_table::<SPAN>(of, along, doubts);
                *open &= !(meet & lanes);
                (pair, lanes & *open & !free)
            }
        };
        if unsure == 0 { 0 } else { self.decide_pair::<SPAN>(pair, unsure, open, doubts) }
    }

    /// [`Screen::decide_doubt`] for a body against a field.
    #[inline(always)]
    fn decide_asked<const SPAN: bool>(
        &self,
        (f, a): (usize, usize),
        lanes: u16,
        open: &mut u16,
        doubts: &Doubts,
    ) -> u16 {
        let field = &self.fields[f];
        let asked = &field.asked[a];
        if let Some(table) = &asked.table {
            let along = if SPAN { table.cells_along(doubts.motion.ends()) } else { 0.0 };
            let [free, meet] = look_up_table::<SPAN>(table, along, doubts);
            *open &= !(meet & lanes);
            return lanes & *open & !free;
        }
        let body = &self.bodies[asked.body];
        let more = if SPAN { self.approach_standing(asked.body, doubts) } else { STILL };
        let [room_of_whole, room] = asked.room;
        let fits = within(&more, room_of_whole);
        let mut in_grid = more;
        for of in &mut in_grid {
            *of = in_cells::<SPAN>(&field.grid, *of);
        }
        let [far, _] = field.grid.look_up(&doubts.wholes[asked.body], &larger(&asked.whole, &in_grid));
        let (near, mut unsure) = (lanes & *open & !(mask(&far) & fits), 0);
        for lane in lanes_of(near) {
            let frame = doubts.frames[body.link].in_lane(lane);
            let more = Larger { cells: in_cells::<SPAN>(&field.grid, more[lane]), fits: more[lane] <= room };
            match look_up(&field.grid, &frame, body, (&asked.coarse, &asked.fine), more) {
                Some(false) => {}
                Some(true) => *open &= !(1 << lane),
                None => unsure |= 1 << lane,
            }
        }
        unsure
    }

    /// [`Screen::decide_doubt`] for two bodies of the robot, without their table.
    #[inline(always)]
    fn decide_pair<const SPAN: bool>(
        &self,
        pair: &BodyPair,
        lanes: u16,
        open: &mut u16,
        doubts: &Doubts,
    ) -> u16 {
        let [a, b] = pair.bodies;
        let more = if SPAN { self.approach_pair(pair, doubts) } else { STILL };
        let mut radius = more;
        for (radius, of_a) in radius.iter_mut().zip(&self.bodies[a].whole_radius) {
            *radius += of_a;
        }
        let far = are_apart((&doubts.wholes[a], &radius), (&doubts.wholes[b], &self.bodies[b].whole_radius));
        let mut unsure = lanes & !mask(&far);
        for SeenBody { bodies, coarse, fine, room } in &pair.seen {
            let [p, q] = bodies.map(|body| &self.bodies[body]);
            let Some((grid, _)) = &self.bounds.grids[bodies[0]] else { continue };
            for lane in lanes_of(unsure) {
                let [of_p, of_q] = [p, q].map(
                    #[inline(always)]
                    |body| doubts.frames[body.link].in_lane(lane),
                );
                let more = Larger { cells: in_cells::<SPAN>(grid, more[lane]), fits: more[lane] <= *room };
                match look_up(grid, &of_q.seen_from(&of_p), q, (coarse, fine), more) {
                    Some(false) => unsure &= !(1 << lane),
                    Some(true) => {
                        unsure &= !(1 << lane);
                        *open &= !(1 << lane);
                    }
                    None => {}
                }
            }
        }
        unsure
    }

    /// Upper bound of how much a body approaches what stands still, within the spans.
    #[inline(always)]
    pub(super) fn approach_standing(&self, body: usize, doubts: &Doubts) -> Lane16 {
        self.levers.approach([self.moved(body, self.levers.of(body).len(), doubts), None])
    }

    /// Upper bound of how much two bodies of the robot approach each other, within the spans.
    #[inline(always)]
    pub(super) fn approach_pair(&self, pair: &BodyPair, doubts: &Doubts) -> Lane16 {
        let of = [0, 1].map(
            #[inline(always)]
            |i| self.moved(pair.bodies[i], pair.joints[i], doubts),
        );
        self.levers.approach(of)
    }

    /// How far the first `joints` of the joints that move a body, from its link on, move it. `None` without a joint.
    #[inline(always)]
    fn moved<'d>(&self, body: usize, joints: usize, doubts: &'d Doubts) -> Option<&'d Lane16> {
        let of = self.levers.of(body);
        doubts.motion.moved[of].get(joints.wrapping_sub(1))
    }
}

/// The approach in configurations, which have no span.
const STILL: Lane16 = [0.0; LANES];

/// The lanes in which a length is at most `most`. False for NaN.
#[inline(always)]
fn within(lengths: &Lane16, most: f32) -> u16 {
    (0..LANES).fold(0, |within, lane| within | u16::from(lengths[lane] <= most) << lane)
}

/// The enlargement of outer spheres.
#[derive(Copy, Clone)]
struct Larger {
    cells: f32,
    /// Whether the grid supports spheres of this size.
    fits: bool,
}

#[inline(always)]
fn in_cells<const SPAN: bool>(grid: &ClearanceGrid, length: f32) -> f32 {
    if SPAN { grid.in_cells(length) } else { 0.0 }
}

/// Radii with the outer spheres enlarged.
#[inline(always)]
fn larger([outer, inner]: &Radii16, more: &Lane16) -> Radii16 {
    let mut of = *outer;
    for lane in 0..LANES {
        of[lane] += more[lane];
    }
    [of, *inner]
}

/// The lanes in which a pair is free, within the lane's span of a motion that is `along` cells long, and those in which
/// it meets.
#[inline(always)]
fn look_up_table<const SPAN: bool>(table: &PairTable, along: f32, doubts: &Doubts) -> [u16; 2] {
    if !SPAN {
        return table.look_up(&doubts.values);
    }
    let mut around = doubts.motion.spans;
    for of in &mut around {
        *of *= along;
    }
    table.look_up_around(&doubts.values, &around)
}

#[inline(always)]
fn lanes_of(mut lanes: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = lanes.trailing_zeros() as usize;
            (lanes != 0).then(|| {
                lanes &= lanes - 1;
                lane
            })
        },
    )
}

/// Whether a body certainly meets the bodies in a grid, or certainly does not. If a coarse sphere is free, the part of
/// the body in it needs no fine spheres. Free is certain if the enlarged outer spheres are free and the grid supports
/// their size.
#[inline(always)]
fn look_up(
    grid: &ClearanceGrid,
    frame: &OneFrame,
    body: &LaneBody,
    (coarse, fine): (&Radii16, &[Radii16]),
    more: Larger,
) -> Option<bool> {
    let cells = [more.cells; LANES];
    let [free, hit] = grid.look_up(&frame.apply(&body.coarse_centres), &larger(coarse, &cells));
    if mask(&hit) != 0 {
        return Some(true);
    }
    let mut needed = lanes_of(!mask(&free)).fold(0, |needed, sphere| needed | body.below[sphere]);
    let mut is_free = more.fits;
    for (centres, radii) in body.fine_centres.iter().zip(fine) {
        let now = needed as u16;
        needed >>= LANES;
        if now == 0 {
            continue;
        }
        let [free, hit] = grid.look_up(&frame.apply(centres), &larger(radii, &cells));
        if mask(&hit) != 0 {
            return Some(true);
        }
        is_free &= now & !mask(&free) == 0;
    }
    is_free.then_some(false)
}
