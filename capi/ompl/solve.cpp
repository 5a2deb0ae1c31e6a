/*
 * Solves MotionBenchMaker's problems with simdop, and beside it with FCL if it was built with it:
 *
 *     solve panda.urdf panda.srdf mbm_panda.jsonl [SECONDS OF A PROBLEM [EVERY [PLANNER]]]
 *
 * EVERY: only each so many lines. PLANNER: RRTConnect, or RRTstar, which has all seconds for each problem. With FCL,
 * states are checked by OMPL's motion validator at samples, at its default resolution, 1 % of the space. The edges of
 * its paths are then checked by simdop at all times. Prints a row for each set of problems and library. Times are of
 * the processor.
 */
#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#include <simdop_ompl.hpp>
#ifdef SOLVE_WITH_FCL
#include <fcl/fcl.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

namespace base = ompl::base;
namespace planning = simdop::planning_with_ompl;
using tree = boost::property_tree::ptree;

namespace {

std::string text_of(const std::string &path) {
    std::ifstream file(path);
    if (!file) {
        throw std::runtime_error(path + " cannot be read");
    }
    return std::string(std::istreambuf_iterator<char>(file), {});
}

struct triangles {
    std::vector<simdop::vec3> vertices;
    std::vector<simdop::triangle> faces;
};

/* The vertices and faces of an OBJ file. */
triangles read_obj(const std::string &path, const double *scale) {
    triangles mesh;
    std::istringstream text(text_of(path));
    for (std::string line; std::getline(text, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            simdop::vec3 v{};
            words >> v[0] >> v[1] >> v[2];
            mesh.vertices.push_back({v[0] * scale[0], v[1] * scale[1], v[2] * scale[2]});
        } else if (word == "f") {
            std::vector<std::uint32_t> corners;
            for (std::string corner; words >> corner;) {
                corners.push_back(static_cast<std::uint32_t>(std::stoul(corner) - 1));
            }
            for (std::size_t i = 2; i < corners.size(); i++) {
                mesh.faces.push_back({corners[0], corners[i - 1], corners[i]});
            }
        }
    }
    return mesh;
}

/* A solid if it is closed. */
simdop::body body_of(const triangles &mesh) {
    try {
        return simdop::body::solid({mesh.vertices, mesh.faces});
    } catch (const simdop::error &) {
        return simdop::body::surface({mesh.vertices, mesh.faces});
    }
}

struct panda {
    simdop::description description;
    std::string srdf;
    std::vector<triangles> meshes;
    std::vector<simdop::body> links;
};

panda read_panda(const std::string &urdf, const std::string &srdf) {
    panda made{simdop::description::read(text_of(urdf)), text_of(srdf), {}, {}};
    const std::string folder = urdf.substr(0, urdf.rfind('/') + 1);
    for (std::size_t i = 0; i < made.description.bodies(); i++) {
        const simdop_described_body body = made.description.described_body(i);
        if (body.mesh_file == nullptr) {
            throw std::runtime_error("a link that is not a mesh");
        }
        made.meshes.push_back(read_obj(folder + body.mesh_file, body.mesh_scale));
        made.links.push_back(body_of(made.meshes.back()));
    }
    return made;
}

struct obstacle {
    bool is_box;
    std::array<double, 3> dims;
    simdop::pose pose;
};

struct problem {
    std::string set;
    std::vector<double> start, goal;
    std::vector<obstacle> obstacles;
};

std::vector<double> numbers(const tree &list) {
    std::vector<double> found;
    for (const auto &item : list) {
        found.push_back(item.second.get_value<double>());
    }
    return found;
}

problem read_problem(const std::string &line, const panda &panda) {
    std::istringstream stream(line);
    tree json;
    boost::property_tree::read_json(stream, json);
    problem made{json.get<std::string>("set"), {}, {}, {}};
    const tree &start = json.get_child("start"), &goal = json.get_child("goals").front().second;
    for (std::size_t i = 0; i < panda.description.variables(); i++) {
        const std::string name = panda.description.variable(i).name;
        made.start.push_back(start.get<double>(name));
        made.goal.push_back(goal.get<double>(name));
    }
    for (const auto &item : json.get_child("obstacles")) {
        const auto type = item.second.get<std::string>("type");
        if (type != "box" && type != "cylinder") {
            throw std::runtime_error("an obstacle that is a " + type);
        }
        auto dims = numbers(item.second.get_child("dims")), at = numbers(item.second.get_child("pos")),
             q = numbers(item.second.get_child("quat_xyzw"));
        dims.resize(3);
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        made.obstacles.push_back({type == "box",
                                  {dims[0], dims[1], dims[2]},
                                  simdop::from_quaternion({q[0] / length, q[1] / length, q[2] / length, q[3] / length},
                                                          {at[0], at[1], at[2]})});
    }
    return made;
}

std::shared_ptr<const planning::arm> arm_of(const panda &panda, const problem &problem) {
    const auto add = [&](simdop::scene &scene) {
        for (const obstacle &obstacle : problem.obstacles) {
            const auto &dims = obstacle.dims;
            /* Cylinders have height and radius. */
            const simdop_shape shape =
                obstacle.is_box ? simdop::cuboid(dims[0], dims[1], dims[2]) : simdop::cylinder(dims[1], dims[0]);
            scene.insert(simdop::body::shape(shape), obstacle.pose, simdop::fixed());
        }
    };
    return std::make_shared<planning::arm>(panda.description, panda.links, add, panda.srdf);
}

#ifdef SOLVE_WITH_FCL
/* The same robot among the same obstacles with FCL, at poses computed by simdop. */
class fcl_checker : public base::StateValidityChecker {
  public:
    fcl_checker(const base::SpaceInformationPtr &information, const panda &panda, const problem &problem,
                std::shared_ptr<const planning::arm> arm)
        : base::StateValidityChecker(information), arm_(std::move(arm)) {
        for (const triangles &mesh : panda.meshes) {
            auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
            std::vector<fcl::Vector3d> vertices;
            std::vector<fcl::Triangle> faces;
            for (const simdop::vec3 &v : mesh.vertices) {
                vertices.emplace_back(v[0], v[1], v[2]);
            }
            for (const simdop::triangle &f : mesh.faces) {
                faces.emplace_back(f[0], f[1], f[2]);
            }
            model->beginModel();
            model->addSubModel(vertices, faces);
            model->endModel();
            links_.push_back(std::make_unique<fcl::CollisionObjectd>(model));
        }
        for (const obstacle &obstacle : problem.obstacles) {
            const auto &dims = obstacle.dims;
            std::shared_ptr<fcl::CollisionGeometryd> shape;
            if (obstacle.is_box) {
                shape = std::make_shared<fcl::Boxd>(dims[0], dims[1], dims[2]);
            } else {
                shape = std::make_shared<fcl::Cylinderd>(dims[1], dims[0]);
            }
            obstacles_.push_back(std::make_unique<fcl::CollisionObjectd>(shape, transform_of(obstacle.pose)));
            obstacles_.back()->computeAABB();
        }
        auto &here = arm_->here();
        for (std::size_t i = 0; i < links_.size(); i++) {
            for (std::size_t j = i + 1; j < links_.size(); j++) {
                if (here.scene.is_asked(here.ids[i], here.ids[j])) {
                    pairs_.emplace_back(i, j);
                }
            }
        }
    }

    bool isValid(const base::State *state) const override {
        auto &here = arm_->here();
        if (simdop_robot_poses(here.robot.get(), planning::arm::values(state), here.poses.data()) !=
            SIMDOP_ERROR_NONE) {
            return false;
        }
        for (std::size_t i = 0; i < links_.size(); i++) {
            links_[i]->setTransform(transform_of(here.poses[i]));
            links_[i]->computeAABB();
        }
        for (const auto &link : links_) {
            for (const auto &obstacle : obstacles_) {
                if (do_meet(*link, *obstacle)) {
                    return false;
                }
            }
        }
        return std::none_of(pairs_.begin(), pairs_.end(), [this](const auto &pair) {
            return do_meet(*links_[pair.first], *links_[pair.second]);
        });
    }

  private:
    static fcl::Transform3d transform_of(const simdop::pose &pose) {
        fcl::Transform3d made = fcl::Transform3d::Identity();
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 4; j++) {
                made(i, j) = pose.rows[i][j];
            }
        }
        return made;
    }

    static bool do_meet(const fcl::CollisionObjectd &a, const fcl::CollisionObjectd &b) {
        if (!a.getAABB().overlap(b.getAABB())) {
            return false;
        }
        const fcl::CollisionRequestd request;
        fcl::CollisionResultd result;
        return fcl::collide(&a, &b, request, result) > 0;
    }

    std::shared_ptr<const planning::arm> arm_;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> links_, obstacles_;
    std::vector<std::pair<std::size_t, std::size_t>> pairs_;
};
#endif

struct outcome {
    int problems = 0, solved = 0, edges = 0, wrong = 0, wrong_paths = 0;
    std::vector<double> milliseconds, lengths;
};

/* Of processor time: the machine may be busy. */
double seconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct options {
    double seconds = 1;
    int every = 1;
    bool is_star = false;
};

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
    for (std::size_t i = 1; i < path.getStateCount(); i++) {
        outcome.edges++;
        wrong += certain->checkMotion(path.getState(static_cast<unsigned>(i - 1)),
                                      path.getState(static_cast<unsigned>(i)))
                     ? 0
                     : 1;
    }
    outcome.wrong += wrong;
    outcome.wrong_paths += wrong > 0 ? 1 : 0;
}

/* The number below which this share of the others is. */
double percentile(std::vector<double> numbers, double share) {
    if (numbers.empty()) {
        return std::nan("");
    }
    std::sort(numbers.begin(), numbers.end());
    return numbers[static_cast<std::size_t>(share * static_cast<double>(numbers.size() - 1) + 0.5)];
}

void print(const std::string &set, const char *library, const outcome &outcome) {
    std::cout << "| " << set << " | " << library << " | " << outcome.solved << " of " << outcome.problems << " | "
              << percentile(outcome.milliseconds, 0.5) << " | " << percentile(outcome.milliseconds, 0.95) << " | "
              << percentile(outcome.lengths, 0.5) << " | " << outcome.wrong << " of " << outcome.edges << " | "
              << outcome.wrong_paths << " |" << std::endl;
}

int run(int count, char **arguments) {
    if (count < 4) {
        std::cerr << "usage: solve panda.urdf panda.srdf mbm_panda.jsonl [SECONDS OF A PROBLEM [EVERY [PLANNER]]]\n";
        return EXIT_FAILURE;
    }
    options options;
    options.seconds = count > 4 ? std::atof(arguments[4]) : 1;
    options.every = count > 5 ? std::max(1, std::atoi(arguments[5])) : 1;
    options.is_star = count > 6 && std::string(arguments[6]) == "RRTstar";
    ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
    ompl::RNG::setSeed(1);
    const panda panda = read_panda(arguments[1], arguments[2]);
    std::map<std::string, outcome> by_simdop, by_fcl;
    std::istringstream text(text_of(arguments[3]));
    int number = 0;
    for (std::string line; std::getline(text, line);) {
        if (line.empty() || number++ % options.every != 0) {
            continue;
        }
        const problem problem = read_problem(line, panda);
        const auto arm = arm_of(panda, problem);
        const auto certain = planning::information_of(arm);
        solve(certain, certain, problem, options, by_simdop[problem.set]);
#ifdef SOLVE_WITH_FCL
        auto sampled = std::make_shared<base::SpaceInformation>(arm->space());
        sampled->setStateValidityChecker(std::make_shared<fcl_checker>(sampled, panda, problem, arm));
        sampled->setup();
        solve(sampled, certain, problem, options, by_fcl[problem.set]);
#endif
    }
    std::cout << "| problems | library | solved | median, ms | 95 %, ms | length | edges not free | paths not free |\n"
                 "|---|---|--:|--:|--:|--:|--:|--:|\n";
    const auto print_all = [](const char *library, std::map<std::string, outcome> &sets) {
        outcome all;
        for (auto &[set, outcome] : sets) {
            all.problems += outcome.problems;
            all.solved += outcome.solved;
            all.edges += outcome.edges;
            all.wrong += outcome.wrong;
            all.wrong_paths += outcome.wrong_paths;
            all.milliseconds.insert(all.milliseconds.end(), outcome.milliseconds.begin(), outcome.milliseconds.end());
            all.lengths.insert(all.lengths.end(), outcome.lengths.begin(), outcome.lengths.end());
            print(set, library, outcome);
        }
        if (all.problems > 0) {
            print("all", library, all);
        }
    };
    print_all("simdop", by_simdop);
    print_all("FCL", by_fcl);
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
