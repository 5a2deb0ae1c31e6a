//! Queries of configurations.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::query::{Completion, QueryStats};
use crate::scene::{SceneAnswer, SceneHit};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// Number of configurations in a job of [`PlanningScene::free`].
const JOB: usize = 64;

impl PlanningScene {
    /// Whether a configuration is certainly free: no two tested bodies meet. Touching counts as meeting.
    ///
    /// # Errors
    /// [`PlanningError::Scene`] if there is not one value for each variable, or a value is outside its limits.
    pub fn is_free(&self, workspace: &mut Workspace, values: &[f64]) -> Result<bool, PlanningError> {
        Ok(self.collide(workspace, values)?.is_free())
    }

    /// Two bodies that meet in a configuration, if any do.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`].
    pub fn collide(&self, workspace: &mut Workspace, values: &[f64]) -> Result<SceneAnswer, PlanningError> {
        self.within(workspace, values, 0.0)
    }

    /// Two bodies that come within `margin` of each other in a configuration, if any do.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`]; the margin is negative, NaN or too large.
    pub fn within(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        margin: f64,
    ) -> Result<SceneAnswer, PlanningError> {
        self.go_to(workspace, values)?;
        Ok(workspace.scene.within(&self.query, margin)?)
    }

    /// All pairs of bodies that come within `margin` of each other in a configuration. A hit names one pair of
    /// primitives for each pair of bodies.
    ///
    /// # Errors
    /// As [`PlanningScene::within`].
    pub fn hits(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        margin: f64,
    ) -> Result<Vec<SceneHit>, PlanningError> {
        let mut hits = Vec::new();
        let _ = self.for_each_hit(workspace, values, margin, |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        })?;
        Ok(hits)
    }

    /// Calls `visit` with each hit of [`PlanningScene::hits`], until it breaks. Returns what [`Scene::for_each_hit`]
    /// does. Does not allocate.
    ///
    /// [`Scene::for_each_hit`]: crate::Scene::for_each_hit
    ///
    /// # Errors
    /// As [`PlanningScene::within`].
    pub fn for_each_hit(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        margin: f64,
        visit: impl FnMut(SceneHit) -> ControlFlow<()>,
    ) -> Result<(Completion, u64, QueryStats), PlanningError> {
        self.go_to(workspace, values)?;
        Ok(workspace.scene.for_each_hit(&self.query, margin, visit)?)
    }

    /// Which configurations are certainly free? `configurations` holds their values, one configuration after the other.
    /// Runs on several threads with the feature `rayon`, with the same answers.
    ///
    /// # Errors
    /// [`PlanningError::Values`] if the number of values is not a multiple of the number of variables; as
    /// [`PlanningScene::is_free`].
    pub fn free(&self, configurations: &[f64]) -> Result<Vec<bool>, PlanningError> {
        self.on_threads(configurations, self.variables(), |workspace, values, free| {
            self.check_states(workspace, values, free)
        })
    }

    /// As [`PlanningScene::free`], on this thread: writes to `free`, which has a place for each configuration, whether
    /// it is certainly free. Does not allocate, except that the first call with a workspace after a change copies the
    /// scene.
    ///
    /// # Errors
    /// As [`PlanningScene::free`].
    pub fn check_states(
        &self,
        workspace: &mut Workspace,
        configurations: &[f64],
        free: &mut [bool],
    ) -> Result<(), PlanningError> {
        Self::check_count(configurations, self.variables(), free.len())?;
        self.free_of_job(workspace, configurations, free)
    }

    /// Checks that there are `length` values for each place.
    pub(super) fn check_count(values: &[f64], length: usize, places: usize) -> Result<(), PlanningError> {
        if length > 0 && length.checked_mul(places) == Some(values.len()) {
            Ok(())
        } else {
            Err(PlanningError::Values { given: values.len(), variables: length })
        }
    }

    /// Evaluates many queries of `length` values each, in runs of up to 64.
    pub(super) fn on_threads(
        &self,
        values: &[f64],
        length: usize,
        query: impl Fn(&mut Workspace, &[f64], &mut [bool]) -> Result<(), PlanningError> + Sync,
    ) -> Result<Vec<bool>, PlanningError> {
        let mut free = vec![false; values.len().checked_div(length).unwrap_or(0)];
        Self::check_count(values, length, free.len())?;
        let mut errors: Vec<Option<PlanningError>> = Vec::new();
        errors.resize_with(free.len().div_ceil(JOB), || None);
        let jobs = free.chunks_mut(JOB).zip(values.chunks(JOB * length)).zip(&mut errors).collect();
        crate::parallel::for_each(jobs, |workspace: &mut Option<Workspace>, ((free, values), error)| {
            let workspace = workspace.get_or_insert_with(|| self.workspace());
            *error = query(workspace, values, free).err();
        });
        match errors.into_iter().flatten().next() {
            Some(error) => Err(error),
            None => Ok(free),
        }
    }

    /// A configuration within the limits, from random numbers in 0 .. 1.
    #[must_use]
    pub fn random(&self, mut random: impl FnMut() -> f64) -> Vec<f64> {
        self.limits().iter().map(|[low, high]| (low + (high - low) * random()).clamp(*low, *high)).collect()
    }

    /// A free configuration, from random numbers in 0 .. 1. `None` after `tries` configurations that are not free.
    ///
    /// # Errors
    /// As [`PlanningScene::is_free`].
    pub fn random_free(
        &self,
        workspace: &mut Workspace,
        mut random: impl FnMut() -> f64,
        tries: usize,
    ) -> Result<Option<Vec<f64>>, PlanningError> {
        for _ in 0..tries {
            let values = self.random(&mut random);
            if self.is_free(workspace, &values)? {
                return Ok(Some(values));
            }
        }
        Ok(None)
    }
}
