/*
 * MotionBenchMaker's problems for the Panda: a start, a goal, and boxes and cylinders as obstacles.
 */
#ifndef SIMDOP_OMPL_PROBLEMS_HPP
#define SIMDOP_OMPL_PROBLEMS_HPP

#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <simdop.hpp>

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

struct obstacle {
    bool is_box;
    /* For a cylinder: height and radius. */
    std::array<double, 3> dims;
    simdop::pose pose;
};

struct problem {
    std::string set;
    std::vector<double> start, goal;
    std::vector<obstacle> obstacles;
};

inline std::vector<double> numbers_of(const boost::property_tree::ptree &list) {
    std::vector<double> found;
    for (const auto &item : list) {
        found.push_back(item.second.get_value<double>());
    }
    return found;
}

inline obstacle obstacle_of(const boost::property_tree::ptree &json) {
    const auto type = json.get<std::string>("type");
    if (type != "box" && type != "cylinder") {
        throw std::runtime_error("an obstacle that is a " + type);
    }
    auto dims = numbers_of(json.get_child("dims")), at = numbers_of(json.get_child("pos")),
         q = numbers_of(json.get_child("quat_xyzw"));
    dims.resize(3);
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return {type == "box",
            {dims[0], dims[1], dims[2]},
            simdop::from_quaternion({q[0] / length, q[1] / length, q[2] / length, q[3] / length},
                                    {at[0], at[1], at[2]})};
}

/* Reads a line of the file: values of the variables that the planner plans for. */
inline problem read_problem(const std::string &line, const simdop::planner &planner) {
    std::istringstream stream(line);
    boost::property_tree::ptree json;
    boost::property_tree::read_json(stream, json);
    problem made{json.get<std::string>("set"), {}, {}, {}};
    const auto &start = json.get_child("start"), &goal = json.get_child("goals").front().second;
    for (std::size_t i = 0; i < planner.variables(); i++) {
        const std::string name = planner.variable(i).name;
        made.start.push_back(start.get<double>(name));
        made.goal.push_back(goal.get<double>(name));
    }
    for (const auto &item : json.get_child("obstacles")) {
        made.obstacles.push_back(obstacle_of(item.second));
    }
    return made;
}

#endif
