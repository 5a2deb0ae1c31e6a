/*
 * Tests simdop_ompl.hpp: OMPL gets the planner's verdicts, with and without bounds, on one thread and on eight:
 *
 *     verdicts arm.urdf arm.srdf FOLDER
 *
 * Writes a robot with a continuous joint to the folder. Exits with 0 only if all checks hold.
 */
#include "../examples/obj.hpp"
#include <ompl/base/ScopedState.h>
#include <simdop_ompl.hpp>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>
#include <thread>

namespace base = ompl::base;
namespace planning = simdop::planning_with_ompl;
using values = std::vector<double>;

namespace {

#define EXPECT(is_so)                                                                                                  \
    if (!(is_so)) {                                                                                                    \
        std::cerr << "line " << __LINE__ << ": " #is_so "\n";                                                          \
        std::exit(EXIT_FAILURE);                                                                                       \
    }

simdop::planner beside_a_post(const std::string &urdf, const std::string &srdf, double cell) {
    simdop::planner planner = simdop::planner::load(urdf, srdf);
    planner.insert(simdop::body::shape(simdop::cylinder(0.05, 2)), simdop::translation(0.45, 0, 1), simdop::fixed());
    if (cell > 0) {
        planner.use_bounds(cell);
    }
    return planner;
}

/* OMPL's queries about two states. */
struct verdicts {
    bool is_valid, is_motion_valid, is_all_valid;
    double clearance, share;
    values last;

    bool operator==(const verdicts &other) const {
        return is_valid == other.is_valid && is_motion_valid == other.is_motion_valid &&
               is_all_valid == other.is_all_valid && clearance == other.clearance && share == other.share &&
               last == other.last;
    }
};

verdicts ask(const base::SpaceInformationPtr &information, const values &from, const values &to) {
    base::ScopedState<> start(information), end(information), last(information);
    start = from;
    end = to;
    last = from;
    std::pair<base::State *, double> last_valid(last.get(), 1);
    const auto &motions = information->getMotionValidator();
    verdicts found{};
    found.is_valid = information->isValid(start.get());
    found.clearance = information->getStateValidityChecker()->clearance(start.get());
    found.is_motion_valid = motions->checkMotion(start.get(), end.get());
    found.is_all_valid = motions->checkMotion(start.get(), end.get(), last_valid);
    found.share = last_valid.second;
    found.last = last.reals();
    return found;
}

values between(const values &from, const values &to, double share) {
    values there(from);
    for (std::size_t i = 0; i < there.size(); i++) {
        there[i] += share * (to[i] - from[i]);
    }
    return there;
}

/* Checks that OMPL's verdicts are those of the planner, to which `information` belongs. Returns them. */
std::vector<verdicts> check(const base::SpaceInformationPtr &information, const simdop::planner &planner,
                            const std::vector<values> &states) {
    auto workspace = planner.make_workspace();
    const auto limits = planner.limits();
    const auto is_within = [&](const values &state) {
        for (std::size_t i = 0; i < state.size(); i++) {
            if (state[i] < limits[i][0] || state[i] > limits[i][1]) {
                return false;
            }
        }
        return true;
    };
    std::vector<verdicts> all;
    std::array<int, 3> seen{};
    for (std::size_t i = 0; i + 1 < states.size(); i++) {
        const values &from = states[i], &to = states[i + 1];
        const verdicts found = ask(information, from, to);
        all.push_back(found);
        EXPECT(found.is_motion_valid == found.is_all_valid);
        EXPECT(found.is_motion_valid == (found.share == 1));
        if (!is_within(from)) {
            EXPECT(!found.is_valid && !found.is_motion_valid && found.clearance == 0 && found.share == 0);
            seen[0]++;
            continue;
        }
        EXPECT(found.is_valid == (planner.within(workspace, from).verdict == SIMDOP_VERDICT_FREE));
        EXPECT(found.clearance == planner.clearance(workspace, from).lower);
        if (!is_within(to)) {
            EXPECT(!found.is_motion_valid && found.share == 0);
            continue;
        }
        const auto is_free = [&](double share) {
            return planner.check_motion(workspace, from, between(from, to, share)).verdict ==
                   SIMDOP_MOTION_VERDICT_FREE;
        };
        EXPECT(found.is_motion_valid == is_free(1));
        seen[found.is_motion_valid ? 1 : 2]++;
        if (!found.is_motion_valid) {
            EXPECT(found.last == between(from, to, found.share));
            EXPECT(found.share == 0 ? !found.is_valid || !is_free(2.0 / 1024) : is_free(found.share));
            EXPECT(!is_free(std::min(1.0, found.share + 2.0 / 1024)));
        }
    }
    /* States out of limits, free, and not free. */
    EXPECT(seen[0] > 20 && seen[1] > 20 && seen[2] > 20);
    return all;
}

void on_eight_threads(const base::SpaceInformationPtr &information, const std::vector<values> &states,
                      const std::vector<verdicts> &expected) {
    std::vector<std::thread> threads;
    std::array<int, 8> wrong{};
    for (std::size_t thread = 0; thread < 8; thread++) {
        threads.emplace_back([&, thread] {
            for (std::size_t i = 0; i < expected.size(); i++) {
                wrong[thread] += ask(information, states[i], states[i + 1]) == expected[i] ? 0 : 1;
            }
        });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }
    EXPECT((wrong == std::array<int, 8>{}));
}

/* The waist turns the shorter way around, away from the post, if its joint is continuous. */
void with_a_continuous_joint(const std::string &urdf, const std::string &srdf, const std::string &folder) {
    std::string text = text_of(urdf);
    const std::string before = "name=\"waist\" type=\"revolute\"";
    text.replace(text.find(before), before.size(), "name=\"waist\" type=\"continuous\"");
    const std::string path = folder + "/continuous.urdf";
    std::ofstream(path) << text;
    const auto arm = std::make_shared<planning::arm>(beside_a_post(path, srdf, 0));
    const auto turning = planning::information_of(arm);
    const auto limited =
        planning::information_of(std::make_shared<planning::arm>(beside_a_post(urdf, srdf, 0)));
    const values from{2.8, 1.2, 0.3, 0}, to{-2.8, 1.2, 0.3, 0};
    EXPECT(ask(turning, from, to).is_motion_valid);
    EXPECT(!ask(limited, from, to).is_motion_valid);
    EXPECT(turning->getStateSpace()->getDimension() == 4);
    /* Towards the post: the last valid state is on OMPL's motion, at the planner's share. */
    const values start{-2.8, 1.2, 0.3, 0}, post{0.2, 1.2, 0.3, 0}, around{2.8 - 6.283185307179586, 1.2, 0.3, 0};
    EXPECT(ask(turning, around, start).is_motion_valid);
    const verdicts stopped = ask(turning, start, post);
    EXPECT(!stopped.is_motion_valid && stopped.share > 0.5 && stopped.share < 1);
    EXPECT(std::abs(stopped.last[0] - (start[0] + stopped.share * (post[0] - start[0]))) < 1e-12);
    EXPECT(ask(turning, start, stopped.last).is_motion_valid);
}

int run(const std::string &urdf, const std::string &srdf, const std::string &folder) {
    std::mt19937 random(1);
    std::vector<values> states;
    for (int i = 0; i < 300; i++) {
        /* The waist is within 3.6, but its limit is 2.9. Some motions are short. */
        values state;
        for (const double most : {3.6, 2.0, 2.4, 2.0}) {
            state.push_back(std::uniform_real_distribution<double>(-most, most)(random));
        }
        states.push_back(i % 3 == 0 ? state : between(states.back(), state, 0.2));
    }
    std::vector<verdicts> plain;
    for (const double cell : {0.0, 0.05}) {
        const auto arm = std::make_shared<planning::arm>(beside_a_post(urdf, srdf, cell));
        const auto information = planning::information_of(arm);
        const auto found = check(information, arm->planner(), states);
        on_eight_threads(information, states, found);
        if (plain.empty()) {
            plain = found;
        }
        for (std::size_t i = 0; i < found.size(); i++) {
            EXPECT(found[i].is_valid == plain[i].is_valid && found[i].is_motion_valid == plain[i].is_motion_valid);
            EXPECT(std::abs(found[i].share - plain[i].share) < 2.0 / 1024);
        }
    }
    with_a_continuous_joint(urdf, srdf, folder);
    std::cout << "as expected: " << plain.size() << " motions\n";
    return EXIT_SUCCESS;
}

} // namespace

int main(int count, char **arguments) {
    if (count != 4) {
        std::cerr << "usage: verdicts arm.urdf arm.srdf FOLDER\n";
        return EXIT_FAILURE;
    }
    try {
        return run(arguments[1], arguments[2], arguments[3]);
    } catch (const std::exception &error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
