//! Single queries: whether any point is near, and which points are nearest.

use super::search::RangeDescent;
use super::store::is_finite;
use super::{CloudRef, RangeSearch, RangeStats, SearchError};
use crate::hierarchy::MAX_DEPTH;
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::{Aabb16, Box3, Bucket, Link};
use core::ops::ControlFlow;

/// A point of a cloud, and its distance from the query.
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(C)]
pub struct Neighbour {
    /// Index of the point.
    pub index: u32,
    /// The squared distance, rounded as in the comparison with a radius.
    pub square: f32,
}

impl Neighbour {
    /// Fills the output before anything is found.
    pub const NONE: Self = Self { index: Bucket::UNUSED, square: f32::INFINITY };

    /// Orders by distance, then by index.
    #[inline(always)]
    fn is_before(&self, other: &Self) -> bool {
        self.square < other.square || self.square == other.square && self.index < other.index
    }
}

impl RangeSearch {
    /// Whether any point is within `radius` of `centre`. Touching counts.
    ///
    /// # Errors
    /// [`SearchError::Radius`], [`SearchError::Query`], of query 0.
    #[inline]
    pub fn any_within(
        &self,
        cloud: &CloudRef<'_>,
        centre: [f32; 3],
        radius: f32,
    ) -> Result<bool, SearchError> {
        check(centre, radius)?;
        Ok(on_isa!(self.isa, kernel => kernel.run(
            #[inline(always)]
            || {
                let square = radius * radius;
                let mut descent = RangeDescent { kernel, cloud: *cloud, work: RangeStats::default() };
                let found = descent.go_down(&Box3::of_point(centre), square, |this, _, _, bucket| {
                    match kernel.points_near(centre, square, &this.cloud.buckets[bucket as usize]) {
                        0 => ControlFlow::Continue(()),
                        _ => ControlFlow::Break(()),
                    }
                });
                found.is_break()
            },
        )))
    }

    /// Calls `visit` with the index of each point within `radius` of `centre`, in the order of [`RangeSearch::fill`],
    /// until it breaks. Many queries are faster in packets.
    ///
    /// # Errors
    /// [`SearchError::Radius`], [`SearchError::Query`], of query 0.
    pub fn each_within(
        &self,
        cloud: &CloudRef<'_>,
        centre: [f32; 3],
        radius: f32,
        mut visit: impl FnMut(u32) -> ControlFlow<()>,
    ) -> Result<RangeStats, SearchError> {
        check(centre, radius)?;
        Ok(on_isa!(self.isa, kernel => kernel.run(
            #[inline(always)]
            || {
                let square = radius * radius;
                let mut descent = RangeDescent { kernel, cloud: *cloud, work: RangeStats::default() };
                // A break of the visitor ends the search.
                let _ = descent.go_down(&Box3::of_point(centre), square, |this, _, _, bucket| {
                    let bucket = &this.cloud.buckets[bucket as usize];
                    this.work.buckets += 1;
                    let mut left = kernel.points_near(centre, square, bucket);
                    while left != 0 {
                        this.work.neighbours += 1;
                        visit(bucket.indices[left.trailing_zeros() as usize & 15])?;
                        left &= left - 1;
                    }
                    ControlFlow::Continue(())
                });
                descent.work
            },
        )))
    }

    /// The point nearest to `point`; of equally near ones, the one with the lowest index. `None` if the cloud is
    /// empty.
    ///
    /// # Errors
    /// [`SearchError::Query`], of query 0.
    pub fn nearest(&self, cloud: &CloudRef<'_>, point: [f32; 3]) -> Result<Option<Neighbour>, SearchError> {
        let mut found = [Neighbour::NONE];
        Ok(if self.k_nearest(cloud, point, &mut found)? == 1 { Some(found[0]) } else { None })
    }

    /// Finds the `found.len()` points nearest to `point`, nearest first; of equally near ones, those with the lowest
    /// indices. Returns their number, which is less than `found.len()` only if the cloud has fewer points.
    ///
    /// # Errors
    /// [`SearchError::Query`], of query 0.
    pub fn k_nearest(
        &self,
        cloud: &CloudRef<'_>,
        point: [f32; 3],
        found: &mut [Neighbour],
    ) -> Result<usize, SearchError> {
        check(point, 0.0)?;
        found.fill(Neighbour::NONE);
        if !found.is_empty() {
            on_isa!(self.isa, kernel => kernel.run(
                #[inline(always)]
                || descend(kernel, cloud, point, found),
            ));
        }
        Ok(found.len().min(cloud.len()))
    }
}

fn check(point: [f32; 3], radius: f32) -> Result<(), SearchError> {
    if !is_finite(point) {
        return Err(SearchError::Query { query: 0 });
    }
    if radius >= 0.0 && radius.is_finite() { Ok(()) } else { Err(SearchError::Radius { query: 0 }) }
}

/// A node of the path: the squared distances of its lanes, and the lanes left to visit.
#[derive(Copy, Clone)]
struct Open<'a> {
    node: &'a Aabb16,
    squares: [f32; 16],
    left: u16,
}

impl<'a> Open<'a> {
    #[inline(always)]
    fn new<E: Kernel>(kernel: E, query: &Box3, node: &'a Aabb16, farthest: f32) -> Self {
        let mut squares = [0.0; 16];
        kernel.box_squares(query, node, &mut squares);
        Self { node, left: near(&squares, farthest), squares }
    }

    /// The nearest lane left, up to the low bits of its squared distance. This only decides the order of the visits.
    #[inline(always)]
    fn nearest(&self) -> usize {
        // Non-negative floats are ordered as their bits are. The low four bits are replaced by the lane.
        let key = |lane: usize| {
            let key = self.squares[lane].to_bits() & !15 | lane as u32;
            if self.left >> lane & 1 != 0 { key } else { u32::MAX }
        };
        let keys: [u32; 16] = core::array::from_fn(key);
        (keys.into_iter().fold(u32::MAX, u32::min) & 15) as usize
    }
}

/// The mask of squares that are at most `farthest`. Empty lanes and slots are NaN, and never set.
#[inline(always)]
fn near(squares: &[f32; 16], farthest: f32) -> u16 {
    (0..16).fold(0, |mask, i| mask | u16::from(squares[i] <= farthest) << i)
}

/// Visits the nearest lanes first, and only those not farther than the last neighbour found.
#[inline(always)]
fn descend<E: Kernel>(kernel: E, cloud: &CloudRef<'_>, point: [f32; 3], found: &mut [Neighbour]) {
    let Some(root) = cloud.nodes.first() else { return };
    let (query, last) = (Box3::of_point(point), found.len() - 1);
    let mut path = [Open { node: root, squares: [0.0; 16], left: 0 }; MAX_DEPTH];
    path[0] = Open::new(kernel, &query, root, f32::INFINITY);
    let mut level = 0;
    loop {
        let open = &mut path[level];
        // Lanes at the same distance as the last neighbour stay: they may hold a lower index.
        open.left &= near(&open.squares, found[last].square);
        if open.left == 0 {
            if level == 0 {
                return;
            }
            level -= 1;
            continue;
        }
        let lane = open.nearest();
        open.left &= !(1 << lane);
        match open.node.child[lane].link() {
            Link::Inner(below) => {
                level += 1;
                path[level] = Open::new(kernel, &query, &cloud.nodes[below as usize], found[last].square);
            }
            Link::Leaf { first, .. } => {
                let bucket = &cloud.buckets[first as usize];
                let mut squares = [0.0; 16];
                kernel.point_squares(point, bucket, &mut squares);
                let mut left = near(&squares, found[last].square);
                while left != 0 {
                    let slot = left.trailing_zeros() as usize & 15;
                    left &= left - 1;
                    insert(found, Neighbour { index: bucket.indices[slot], square: squares[slot] });
                }
            }
            Link::Empty => {}
        }
    }
}

/// Inserts a neighbour in order, and drops the last one.
#[inline(always)]
fn insert(found: &mut [Neighbour], new: Neighbour) {
    let mut place = found.len();
    while place > 0 && new.is_before(&found[place - 1]) {
        if place < found.len() {
            found[place] = found[place - 1];
        }
        place -= 1;
    }
    if let Some(place) = found.get_mut(place) {
        *place = new;
    }
}
