/*
 * The C++ part of configurations.rs, which says how to build it. Until its input ends, `configurations PANDA_FOLDER`
 * reads the number of a row, checks its configurations, and writes the seconds of CPU time and how many configurations
 * are free.
 */
#include "obj.hpp"
#include "simdop.hpp"

#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

namespace {

constexpr std::size_t COUNT = 4096;
constexpr double CELL = 0.02;

/* Side lengths and positions of boxes. */
const std::array<std::array<double, 6>, 5> OBSTACLES = {{{1.2, 0.6, 0.05, 0.7, 0.0, 0.2},
                                                         {0.05, 0.6, 0.8, 0.9, 0.0, 0.6},
                                                         {0.4, 0.6, 0.03, 0.75, 0.0, 0.6},
                                                         {0.3, 0.3, 0.3, 0.0, 0.6, 0.15},
                                                         {0.2, 0.2, 0.6, -0.4, -0.4, 0.3}}};

template <class Insert> void insert_obstacles(Insert insert) {
    for (const auto &[x, y, z, at_x, at_y, at_z] : OBSTACLES) {
        insert(simdop::body::shape(simdop::cuboid(x, y, z)), simdop::translation(at_x, at_y, at_z));
    }
}

/* The robot's bodies among the obstacles. */
struct panda {
    simdop::robot robot;
    simdop::scene scene = simdop::scene::create();
    std::vector<simdop::body_id> ids;
    std::vector<simdop::pose> poses;

    panda(const simdop::description &description, const std::string &folder)
        : robot(description.build_robot()), poses(description.bodies()) {
        for (std::size_t i = 0; i < description.bodies(); i++) {
            const simdop_described_body body = description.described_body(i);
            ids.push_back(scene.insert(body_of(read_obj(folder + body.mesh_file, body.mesh_scale))));
        }
        description.select_pairs(text_of(folder + "panda.srdf"), scene, ids);
        insert_obstacles([this](const simdop::body &body, const simdop::pose &world) {
            scene.insert(body, world, simdop::fixed());
        });
    }
};

std::vector<double> values_of(const simdop::description &description) {
    std::uint64_t state = 1;
    std::vector<double> values;
    for (std::size_t i = 0; i < COUNT * description.variables(); i++) {
        const simdop_variable variable = description.variable(i % description.variables());
        state = state * 6364136223846793005U + 1442695040888963407U;
        const double random = std::ldexp(static_cast<double>(state >> 11), -53);
        values.push_back(variable.lower + random * (variable.upper - variable.lower));
    }
    return values;
}

int run(const std::string &folder) {
    const auto description = simdop::description::read(text_of(folder + "panda.urdf"));
    const std::size_t variables = description.variables();
    const std::vector<double> values = values_of(description);
    std::vector<std::uint8_t> free(COUNT);
    panda one(description, folder), many(description, folder);
    simdop::planner planner = simdop::planner::load(folder + "panda.urdf", folder + "panda.srdf");
    insert_obstacles([&](const simdop::body &body, const simdop::pose &world) {
        planner.insert(body, world, simdop::fixed());
    });
    simdop::planner bounded = planner.copy();
    bounded.use_bounds(CELL);
    auto workspace = planner.make_workspace(), bounded_workspace = bounded.make_workspace();

    const std::array<std::function<std::size_t()>, 4> rows = {
        [&] {
            std::size_t count = 0;
            for (std::size_t i = 0; i < COUNT; i++) {
                one.robot.poses({values.data() + i * variables, variables}, one.poses);
                one.scene.place(one.ids, one.poses);
                count += one.scene.collide().verdict == SIMDOP_VERDICT_FREE ? 1 : 0;
            }
            return count;
        },
        [&] { return many.scene.check_states(many.ids, many.robot, values, free).free; },
        [&] { return planner.check_states(workspace, values, free); },
        [&] { return bounded.check_states(bounded_workspace, values, free); },
    };
    for (std::size_t row = 0; std::cin >> row;) {
        const std::clock_t begin = std::clock();
        const std::size_t count = rows.at(row)();
        std::cout << static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC << ' ' << count << std::endl;
    }
    return EXIT_SUCCESS;
}

} // namespace

int main(int count, char **arguments) {
    try {
        if (count == 2) {
            return run(std::string(arguments[1]) + "/");
        }
        std::cerr << "usage: configurations PANDA_FOLDER\n";
    } catch (const std::exception &error) {
        std::cerr << error.what() << '\n';
    }
    return EXIT_FAILURE;
}
