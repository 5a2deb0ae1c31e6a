/*
 * Solves MotionBenchMaker's problems with simdop, with and without bounds, and for comparison with FCL, if built with
 * it:
 *
 *     solve panda.urdf panda.srdf mbm_panda.jsonl [SECONDS OF A PROBLEM [EVERY [PLANNER [SEED]]]]
 *
 * EVERY n: only each n-th line. PLANNER: RRTConnect, or RRTstar, which uses all seconds for each problem. SEED: that of
 * OMPL's random numbers. With FCL, OMPL's motion validator samples motions at its default resolution, 1 % of the space.
 * Then simdop checks the edges of all paths at all times. Prints a row for each set of problems and library. Times are
 * CPU times. The set-up is what a library computes from the obstacles, and is timed separately; what it computes from
 * the robot alone is computed once, before.
 */
#include "problems.hpp"
#ifdef SOLVE_WITH_FCL
#include "fcl_checker.hpp"
#endif
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#include <simdop_ompl.hpp>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <numeric>

namespace base = ompl::base;
namespace planning = simdop::planning_with_ompl;

namespace {

/* Width of the cells of the bounds, in metres. */
constexpr double CELL = 0.02;

/* CPU time, since the machine may be busy. */
double seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct outcome {
    int problems = 0, solved = 0, edges = 0, wrong = 0, wrong_paths = 0;
    std::vector<double> milliseconds, set_ups, lengths;

    void add(const outcome &other) {
        problems += other.problems;
        solved += other.solved;
        edges += other.edges;
        wrong += other.wrong;
        wrong_paths += other.wrong_paths;
        milliseconds.insert(milliseconds.end(), other.milliseconds.begin(), other.milliseconds.end());
        set_ups.insert(set_ups.end(), other.set_ups.begin(), other.set_ups.end());
        lengths.insert(lengths.end(), other.lengths.begin(), other.lengths.end());
    }
};

/* The outcomes of one library, for each set of problems. */
using outcomes = std::map<std::string, outcome>;

struct options {
    double seconds = 1;
    int every = 1;
    bool is_star = false;
    std::uint_fast32_t seed = 1;
};

/* The robot among the obstacles of a problem. */
base::SpaceInformationPtr with_simdop(const simdop::planner &robot, const problem &problem, bool has_bounds) {
    simdop::planner planner = robot.copy();
    for (const obstacle &obstacle : problem.obstacles) {
        const auto &dims = obstacle.dims;
        const simdop_shape shape =
            obstacle.is_box ? simdop::cuboid(dims[0], dims[1], dims[2]) : simdop::cylinder(dims[1], dims[0]);
        planner.insert(simdop::body::shape(shape), obstacle.pose, simdop::fixed());
    }
    if (has_bounds) {
        planner.use_bounds(CELL);
    }
    return planning::information_of(std::make_shared<planning::arm>(std::move(planner)));
}

base::PlannerPtr planner_of(const base::SpaceInformationPtr &information, const options &options) {
    if (options.is_star) {
        return std::make_shared<ompl::geometric::RRTstar>(information);
    }
    return std::make_shared<ompl::geometric::RRTConnect>(information);
}

/* Solves a problem, and checks the path's edges at all times. */
void solve(const base::SpaceInformationPtr &information, const base::SpaceInformationPtr &certain,
           const problem &problem, const options &options, outcome &outcome) {
    ompl::geometric::SimpleSetup setup(information);
    base::ScopedState<> start(setup.getStateSpace()), goal(setup.getStateSpace());
    start = problem.start;
    goal = problem.goal;
    setup.setStartAndGoalStates(start, goal);
    setup.setPlanner(planner_of(information, options));
    setup.setup();
    const double begin = seconds();
    const base::PlannerTerminationCondition is_over([&] { return seconds() - begin > options.seconds; });
    const bool is_solved = setup.solve(is_over) == base::PlannerStatus::EXACT_SOLUTION;
    outcome.milliseconds.push_back(1e3 * (seconds() - begin));
    outcome.problems++;
    if (!is_solved) {
        return;
    }
    outcome.solved++;
    auto &path = setup.getSolutionPath();
    outcome.lengths.push_back(path.length());
    int wrong = 0;
    for (unsigned i = 1; i < path.getStateCount(); i++) {
        outcome.edges++;
        wrong += certain->checkMotion(path.getState(i - 1), path.getState(i)) ? 0 : 1;
    }
    outcome.wrong += wrong;
    outcome.wrong_paths += wrong > 0 ? 1 : 0;
}

/* The number below which this share of the numbers lies. */
double percentile(std::vector<double> numbers, double share) {
    if (numbers.empty()) {
        return std::nan("");
    }
    std::sort(numbers.begin(), numbers.end());
    return numbers[static_cast<std::size_t>(share * static_cast<double>(numbers.size() - 1) + 0.5)];
}

/* The sum of times in milliseconds, in seconds. */
double total(const std::vector<double> &milliseconds) {
    return 1e-3 * std::accumulate(milliseconds.begin(), milliseconds.end(), 0.0);
}

void print(const std::string &set, const std::string &library, const outcome &outcome) {
    std::cout << "| " << set << " | " << library << " | " << outcome.solved << " of " << outcome.problems << " | "
              << percentile(outcome.milliseconds, 0.5) << " | " << percentile(outcome.milliseconds, 0.95) << " | "
              << percentile(outcome.set_ups, 0.5) << " | " << total(outcome.milliseconds) << " | "
              << total(outcome.set_ups) << " | " << percentile(outcome.lengths, 0.5) << " | "
              << outcome.wrong << " of " << outcome.edges << " | " << outcome.wrong_paths << " |" << std::endl;
}

void print_all(const std::map<std::string, outcomes> &libraries) {
    std::cout << "| problems | library | solved | median, ms | 95 %, ms | set-up, median, ms | total, s | total of "
                 "set-ups, s | length | edges not free | paths not free |\n"
                 "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const auto &[library, sets] : libraries) {
        outcome all;
        for (const auto &[set, outcome] : sets) {
            all.add(outcome);
            print(set, library, outcome);
        }
        print("all", library, all);
    }
}

int run(int count, char **arguments) {
    if (count < 4) {
        std::cerr << "usage: solve panda.urdf panda.srdf mbm_panda.jsonl [SECONDS OF A PROBLEM [EVERY [PLANNER "
                     "[SEED]]]]\n";
        return EXIT_FAILURE;
    }
    options options;
    options.seconds = count > 4 ? std::atof(arguments[4]) : 1;
    options.every = count > 5 ? std::max(1, std::atoi(arguments[5])) : 1;
    options.is_star = count > 6 && std::string(arguments[6]) == "RRTstar";
    options.seed = count > 7 ? static_cast<std::uint_fast32_t>(std::max(1, std::atoi(arguments[7]))) : 1;
    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    ompl::RNG::setSeed(options.seed);
    const simdop::planner robot = simdop::planner::load(arguments[1], arguments[2]);
    double begin = seconds();
    /* All copies share the bounds. */
    robot.copy().use_bounds(CELL);
    std::cout << "bounds of the robot: " << seconds() - begin << " s\n";
#ifdef SOLVE_WITH_FCL
    const fcl_robot fcl = fcl_robot::read(arguments[1], arguments[2]);
#endif
    std::map<std::string, outcomes> libraries;
    std::ifstream file(arguments[3]);
    int number = 0;
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || number++ % options.every != 0) {
            continue;
        }
        const problem problem = read_problem(line, robot);
        base::SpaceInformationPtr certain;
        const auto solve_with = [&](const char *library, auto set_up) {
            outcome &outcome = libraries[library][problem.set];
            begin = seconds();
            const base::SpaceInformationPtr information = set_up();
            outcome.set_ups.push_back(1e3 * (seconds() - begin));
            certain = certain ? certain : information;
            solve(information, certain, problem, options, outcome);
        };
        solve_with("simdop", [&] { return with_simdop(robot, problem, false); });
        solve_with("simdop with bounds", [&] { return with_simdop(robot, problem, true); });
#ifdef SOLVE_WITH_FCL
        solve_with("FCL", [&] {
            auto sampled = std::make_shared<base::SpaceInformation>(certain->getStateSpace());
            sampled->setStateValidityChecker(std::make_shared<fcl_checker>(sampled, fcl, problem));
            sampled->setup();
            return sampled;
        });
#endif
    }
    print_all(libraries);
    return EXIT_SUCCESS;
}

} // namespace

int main(int count, char **arguments) {
    try {
        return run(count, arguments);
    } catch (const std::exception &error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
