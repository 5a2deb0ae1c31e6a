/* From a URDF and an SRDF file to a plan: first_plan arm.urdf arm.srdf. The arm passes a post. */
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <simdop_ompl.hpp>

#include <iostream>

int main(int, char **arguments) {
    namespace planning = simdop::planning_with_ompl;
    simdop::planner planner = simdop::planner::load(arguments[1], arguments[2]);
    const simdop::body post = simdop::body::shape(simdop::cylinder(0.05, 2));
    planner.insert(post, simdop::translation(0.45, 0, 1), simdop::fixed());
    const auto arm = std::make_shared<planning::arm>(std::move(planner));

    ompl::geometric::SimpleSetup setup(planning::information_of(arm));
    ompl::base::ScopedState<> start(setup.getStateSpace()), goal(setup.getStateSpace());
    start = std::vector<double>{-1, 1.2, 0.3, 0};
    goal = std::vector<double>{1, 1.2, 0.3, 0};
    setup.setStartAndGoalStates(start, goal);
    setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
    const auto solved = setup.solve(10);
    std::cout << solved.asString() << ", " << setup.getSolutionPath().getStateCount() << " states\n";
    return solved == ompl::base::PlannerStatus::EXACT_SOLUTION ? 0 : 1;
}
