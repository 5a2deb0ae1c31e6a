/*
 * simdop for OMPL: a validity checker with clearance, and a motion validator that proves motions free at all times
 * instead of sampling them. Needs simdop.hpp with exceptions and SIMDOP_PLANNING, which CMake's targets define.
 *
 * Threads. Both may be used by several threads at once: each thread gets a workspace of its own at its first query.
 */
#ifndef SIMDOP_OMPL_HPP
#define SIMDOP_OMPL_HPP

#include "simdop.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO2StateSpace.h>

#include <limits>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

namespace simdop {
namespace planning_with_ompl {

namespace base = ::ompl::base;

/* The robot of a planner, whose states are the values of the variables that it plans for. */
class arm {
  public:
    /* The memory of one thread's queries. */
    struct context {
        simdop::planner::workspace workspace;
        /* Values of both ends of a motion, or of one state in the first half. */
        std::vector<double> ends;

        double *second() {
            return ends.data() + ends.size() / 2;
        }
    };

    /* Keeps the planner, which no longer changes. Its queries are faster after `planner.use_bounds(0.02)`, whose
       costs are documented there. */
    explicit arm(simdop::planner planner) : planner_(std::move(planner)), space_(space_of(planner_)) {
        /* Makes the first query of this thread as fast as the later ones. */
        (void)here();
    }

    const simdop::planner &planner() const {
        return planner_;
    }

    /* The variables in their order: real numbers within their limits, and angles for continuous joints. */
    const base::StateSpacePtr &space() const {
        return space_;
    }

    /* The context of the calling thread. */
    context &here() const {
        const std::thread::id id = std::this_thread::get_id();
        {
            const std::shared_lock<std::shared_mutex> lock(mutex_);
            const auto found = contexts_.find(id);
            if (found != contexts_.end()) {
                return *found->second;
            }
        }
        auto made = std::make_unique<context>(
            context{planner_.make_workspace(), std::vector<double>(2 * planner_.variables())});
        const std::unique_lock<std::shared_mutex> lock(mutex_);
        return *contexts_.emplace(id, std::move(made)).first->second;
    }

    /* Writes the values of a state to `values`, and returns `values`. */
    const double *write(const base::State *state, double *values) const {
        double *next = values;
        for (const auto &location : space_->getValueLocations()) {
            *next++ = *space_->getValueAddressAtLocation(state, location);
        }
        return values;
    }

    /* Whether a query has an answer. Values out of limits have none, but throw no exception. */
    static bool has_answer(simdop_error code) {
        if (code != SIMDOP_ERROR_NONE && code != SIMDOP_ERROR_MOTION_OUT_OF_LIMITS) {
            throw error::last(code);
        }
        return code == SIMDOP_ERROR_NONE;
    }

  private:
    static base::StateSpacePtr space_of(const simdop::planner &planner) {
        std::vector<simdop_variable> variables;
        for (std::size_t i = 0; i < planner.variables(); i++) {
            variables.push_back(planner.variable(i));
        }
        std::vector<base::StateSpacePtr> parts;
        for (auto next = variables.begin(); next != variables.end();) {
            if (next->is_continuous != 0) {
                parts.push_back(std::make_shared<base::SO2StateSpace>());
                ++next;
                continue;
            }
            auto part = std::make_shared<base::RealVectorStateSpace>();
            for (; next != variables.end() && next->is_continuous == 0; ++next) {
                part->addDimension(next->name, next->lower, next->upper);
            }
            parts.push_back(part);
        }
        const auto space = parts.size() == 1 ? parts.front() : sum_of(parts);
        space->computeLocations();
        return space;
    }

    static base::StateSpacePtr sum_of(const std::vector<base::StateSpacePtr> &parts) {
        return std::make_shared<base::CompoundStateSpace>(parts, std::vector<double>(parts.size(), 1));
    }

    simdop::planner planner_;
    base::StateSpacePtr space_;
    mutable std::shared_mutex mutex_;
    mutable std::unordered_map<std::thread::id, std::unique_ptr<context>> contexts_;
};

/* A state is valid if it is certainly free. States out of limits are invalid. */
class validity_checker : public base::StateValidityChecker {
  public:
    validity_checker(const base::SpaceInformationPtr &information, std::shared_ptr<const arm> arm)
        : base::StateValidityChecker(information), arm_(std::move(arm)) {
        specs_.clearanceComputationType = base::StateValidityCheckerSpecs::EXACT;
    }

    bool isValid(const base::State *state) const override {
        arm::context &here = arm_->here();
        simdop_scene_answer answer{};
        const double *values = arm_->write(state, here.ends.data());
        const simdop_error code =
            simdop_planner_within(arm_->planner().get(), here.workspace.get(), values, 0, &answer);
        return arm::has_answer(code) && answer.verdict == SIMDOP_VERDICT_FREE;
    }

    /* A lower bound on the distance of all tested pairs of bodies, equal to it up to rounding. */
    double clearance(const base::State *state) const override {
        arm::context &here = arm_->here();
        simdop_scene_clearance_answer answer{};
        const double *values = arm_->write(state, here.ends.data());
        const simdop_error code = simdop_planner_clearance(arm_->planner().get(), here.workspace.get(), values, 0,
                                                           std::numeric_limits<double>::infinity(), &answer);
        return arm::has_answer(code) ? answer.lower : 0;
    }

  private:
    std::shared_ptr<const arm> arm_;
};

/* A motion is valid if it is certainly free at all times. Motions out of limits are invalid. */
class motion_validator : public base::MotionValidator {
  public:
    motion_validator(const base::SpaceInformationPtr &information, std::shared_ptr<const arm> arm)
        : base::MotionValidator(information), arm_(std::move(arm)) {}

    bool checkMotion(const base::State *from, const base::State *to) const override {
        arm::context &here = ends(from, to);
        std::uint8_t is_free = 0;
        std::size_t count = 0;
        const simdop_error code = simdop_planner_check_motions(arm_->planner().get(), here.workspace.get(),
                                                               here.ends.data(), 1, &is_free, &count);
        return counted(arm::has_answer(code) && is_free != 0);
    }

    /* The last valid state is the end of the longest motion from `from` that was proved free, up to 1/1024. */
    bool checkMotion(const base::State *from, const base::State *to,
                     std::pair<base::State *, double> &last_valid) const override {
        arm::context &here = ends(from, to);
        double share = 0;
        const simdop_error code = simdop_planner_free_share(arm_->planner().get(), here.workspace.get(),
                                                            here.ends.data(), here.second(), &share);
        if (counted(arm::has_answer(code) && share == 1)) {
            return true;
        }
        last_valid.second = share;
        if (last_valid.first != nullptr) {
            si_->getStateSpace()->interpolate(from, to, share, last_valid.first);
        }
        return false;
    }

  private:
    /* The context of the calling thread, with the values of both states. */
    arm::context &ends(const base::State *from, const base::State *to) const {
        arm::context &here = arm_->here();
        (void)arm_->write(from, here.ends.data());
        (void)arm_->write(to, here.second());
        return here;
    }

    /* The counters belong to the base class, and are only statistics. */
    bool counted(bool is_valid) const {
        const std::lock_guard<std::mutex> lock(counters_);
        (is_valid ? valid_ : invalid_)++;
        return is_valid;
    }

    std::shared_ptr<const arm> arm_;
    mutable std::mutex counters_;
};

/* The space information of an arm, set up with the checker and the validator. */
inline base::SpaceInformationPtr information_of(const std::shared_ptr<const arm> &arm) {
    auto information = std::make_shared<base::SpaceInformation>(arm->space());
    information->setStateValidityChecker(std::make_shared<validity_checker>(information, arm));
    information->setMotionValidator(std::make_shared<motion_validator>(information, arm));
    information->setup();
    return information;
}

} // namespace planning_with_ompl
} // namespace simdop

#endif /* SIMDOP_OMPL_HPP */
