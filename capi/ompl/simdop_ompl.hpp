/*
 * simdop for OMPL: a validity checker with clearance, and a motion validator that proves edges free at all times
 * instead of sampling them. Needs simdop.hpp with exceptions and SIMDOP_URDF, which CMake's targets define.
 *
 * Threads. Both may be used by several threads at once: each thread gets a scene of its own, of shared bodies, at its
 * first query.
 */
#ifndef SIMDOP_OMPL_HPP
#define SIMDOP_OMPL_HPP

#include "simdop.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <functional>
#include <mutex>
#include <shared_mutex>
#include <thread>

namespace simdop {
namespace planning_with_ompl {

namespace base = ::ompl::base;

/* A robot among obstacles, whose states are the values of its variables. */
class arm {
  public:
    /* What a thread asks. */
    struct context {
        simdop::scene scene;
        std::vector<body_id> ids;
        simdop::robot robot;
        std::vector<pose> poses;
    };

    /* `links` are the robot's bodies in its order; `add_obstacles` inserts the others into a scene of each thread.
       `srdf` is the text of an SRDF file, or empty. */
    arm(simdop::description description, std::vector<body> links, std::function<void(simdop::scene &)> add_obstacles,
        std::string srdf = {}, const pose &base = identity())
        : description_(std::move(description)), links_(std::move(links)), add_obstacles_(std::move(add_obstacles)),
          srdf_(std::move(srdf)), base_(base) {}

    /* The robot's bodies, if all of them are shapes. */
    static std::vector<body> shapes_of(const simdop::description &description) {
        std::vector<body> bodies;
        for (std::size_t i = 0; i < description.bodies(); i++) {
            bodies.push_back(description.build_body(i));
        }
        return bodies;
    }

    /* The values of its variables within their limits. */
    std::shared_ptr<base::RealVectorStateSpace> space() const {
        const auto count = static_cast<unsigned>(description_.variables());
        auto space = std::make_shared<base::RealVectorStateSpace>(count);
        base::RealVectorBounds bounds(count);
        for (unsigned i = 0; i < count; i++) {
            const simdop_variable variable = description_.variable(i);
            bounds.setLow(i, variable.lower);
            bounds.setHigh(i, variable.upper);
        }
        space->setBounds(bounds);
        return space;
    }

    /* Of the calling thread. */
    context &here() const {
        const std::thread::id id = std::this_thread::get_id();
        {
            const std::shared_lock<std::shared_mutex> lock(mutex_);
            const auto found = contexts_.find(id);
            if (found != contexts_.end()) {
                return *found->second;
            }
        }
        auto made = std::make_unique<context>(build());
        const std::unique_lock<std::shared_mutex> lock(mutex_);
        return *contexts_.emplace(id, std::move(made)).first->second;
    }

    static const double *values(const base::State *state) {
        return state->as<base::RealVectorStateSpace::StateType>()->values;
    }

  private:
    context build() const {
        context made{scene::create(), {}, description_.build_robot(base_), std::vector<pose>(links_.size())};
        for (const body &link : links_) {
            made.ids.push_back(made.scene.insert(link));
        }
        description_.select_pairs(srdf_, made.scene, made.ids);
        add_obstacles_(made.scene);
        return made;
    }

    simdop::description description_;
    std::vector<body> links_;
    std::function<void(simdop::scene &)> add_obstacles_;
    std::string srdf_;
    pose base_;
    mutable std::shared_mutex mutex_;
    mutable std::unordered_map<std::thread::id, std::unique_ptr<context>> contexts_;
};

/* A state is valid if it is certainly free. States out of the limits are not. */
class validity_checker : public base::StateValidityChecker {
  public:
    validity_checker(const base::SpaceInformationPtr &information, std::shared_ptr<const arm> arm)
        : base::StateValidityChecker(information), arm_(std::move(arm)) {
        specs_.clearanceComputationType = base::StateValidityCheckerSpecs::EXACT;
    }

    bool isValid(const base::State *state) const override {
        arm::context &here = arm_->here();
        std::uint8_t is_free = 0;
        simdop_states_answer answer{};
        /* By C, since a state out of the limits is no exception. */
        const simdop_error code = simdop_scene_check_joint_states(here.scene.get(), here.ids.data(), here.ids.size(),
                                                                  here.robot.get(), arm::values(state), 1, no_budget,
                                                                  &is_free, &answer);
        if (code != SIMDOP_ERROR_NONE && code != SIMDOP_ERROR_MOTION_OUT_OF_LIMITS) {
            throw error::last(code);
        }
        return code == SIMDOP_ERROR_NONE && is_free != 0;
    }

    /* A lower bound on the distance of any two bodies that are tested, up to rounding their distance. */
    double clearance(const base::State *state) const override {
        arm::context &here = arm_->here();
        const simdop_error code = simdop_robot_poses(here.robot.get(), arm::values(state), here.poses.data());
        if (code == SIMDOP_ERROR_MOTION_OUT_OF_LIMITS) {
            return 0;
        }
        if (code != SIMDOP_ERROR_NONE) {
            throw error::last(code);
        }
        here.scene.place(here.ids, here.poses);
        return here.scene.clearance().lower;
    }

  private:
    std::shared_ptr<const arm> arm_;
};

/* A motion is valid if it is certainly free at all times. */
class motion_validator : public base::MotionValidator {
  public:
    /* Intervals of time not longer than `resolution`, of 0 to 1, are not split. */
    motion_validator(const base::SpaceInformationPtr &information, std::shared_ptr<const arm> arm,
                     double resolution = 1e-6)
        : base::MotionValidator(information), arm_(std::move(arm)), resolution_(resolution) {}

    bool checkMotion(const base::State *from, const base::State *to) const override {
        return counted(ask(from, to).verdict == SIMDOP_MOTION_VERDICT_FREE);
    }

    /* The last valid state is the end of the longest motion from `from` that was proved free, up to 1/1024. */
    bool checkMotion(const base::State *from, const base::State *to,
                     std::pair<base::State *, double> &last_valid) const override {
        const simdop_motion_answer answer = ask(from, to);
        if (counted(answer.verdict == SIMDOP_MOTION_VERDICT_FREE)) {
            return true;
        }
        const bool is_hit = answer.verdict == SIMDOP_MOTION_VERDICT_HIT;
        double low = is_hit ? 0 : answer.from, high = is_hit ? answer.time : answer.from;
        base::State *middle = si_->allocState();
        while (high - low > 1.0 / 1024) {
            const double time = low + (high - low) / 2;
            si_->getStateSpace()->interpolate(from, to, time, middle);
            (ask(from, middle).verdict == SIMDOP_MOTION_VERDICT_FREE ? low : high) = time;
        }
        si_->freeState(middle);
        last_valid.second = low;
        if (last_valid.first != nullptr) {
            si_->getStateSpace()->interpolate(from, to, low, last_valid.first);
        }
        return false;
    }

  private:
    /* A motion that leaves the limits is unresolved from its start. */
    simdop_motion_answer ask(const base::State *from, const base::State *to) const {
        arm::context &here = arm_->here();
        simdop_motion_answer answer{};
        const simdop_error code = simdop_scene_check_joint_motion(
            here.scene.get(), here.ids.data(), here.ids.size(), here.robot.get(), arm::values(from), arm::values(to),
            resolution_, no_budget, &answer);
        if (code == SIMDOP_ERROR_MOTION_OUT_OF_LIMITS) {
            answer.verdict = SIMDOP_MOTION_VERDICT_UNRESOLVED;
            answer.from = 0;
        } else if (code != SIMDOP_ERROR_NONE) {
            throw error::last(code);
        }
        return answer;
    }

    /* The counters are the base class's, and only statistics. */
    bool counted(bool is_valid) const {
        const std::lock_guard<std::mutex> lock(counters_);
        (is_valid ? valid_ : invalid_)++;
        return is_valid;
    }

    std::shared_ptr<const arm> arm_;
    double resolution_;
    mutable std::mutex counters_;
};

/* The space of an arm's states, set up with both. */
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
