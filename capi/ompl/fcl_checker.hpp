/*
 * A validity checker for OMPL by FCL, for a robot of meshes among boxes and cylinders. simdop reads the robot's files,
 * selects the pairs of links to test, and computes the poses of the links.
 */
#ifndef SIMDOP_OMPL_FCL_CHECKER_HPP
#define SIMDOP_OMPL_FCL_CHECKER_HPP

#include "../examples/obj.hpp"
#include "problems.hpp"
#include <fcl/fcl.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <algorithm>
#include <memory>
#include <utility>

/* The robot, which all problems share. */
struct fcl_robot {
    simdop::description description;
    std::vector<std::shared_ptr<fcl::CollisionGeometryd>> links;
    std::vector<std::pair<std::size_t, std::size_t>> pairs;

    static fcl_robot read(const std::string &urdf, const std::string &srdf) {
        fcl_robot made{simdop::description::read(text_of(urdf)), {}, {}};
        const std::string folder = urdf.substr(0, urdf.rfind('/') + 1);
        simdop::scene scene = simdop::scene::create();
        std::vector<simdop::body_id> ids;
        for (std::size_t i = 0; i < made.description.bodies(); i++) {
            const simdop_described_body body = made.description.described_body(i);
            if (body.mesh_file == nullptr) {
                throw std::runtime_error("a link that is not a mesh");
            }
            const triangles mesh = read_obj(folder + body.mesh_file, body.mesh_scale);
            made.links.push_back(model_of(mesh));
            ids.push_back(scene.insert(body_of(mesh)));
        }
        made.description.select_pairs(text_of(srdf), scene, ids);
        for (std::size_t i = 0; i < ids.size(); i++) {
            for (std::size_t j = i + 1; j < ids.size(); j++) {
                if (scene.is_asked(ids[i], ids[j])) {
                    made.pairs.emplace_back(i, j);
                }
            }
        }
        return made;
    }

  private:
    static std::shared_ptr<fcl::CollisionGeometryd> model_of(const triangles &mesh) {
        std::vector<fcl::Vector3d> vertices;
        std::vector<fcl::Triangle> faces;
        for (const simdop::vec3 &v : mesh.vertices) {
            vertices.emplace_back(v[0], v[1], v[2]);
        }
        for (const simdop::triangle &f : mesh.faces) {
            faces.emplace_back(f[0], f[1], f[2]);
        }
        auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
        model->beginModel();
        model->addSubModel(vertices, faces);
        model->endModel();
        return model;
    }
};

/* For use by one thread. */
class fcl_checker : public ompl::base::StateValidityChecker {
  public:
    fcl_checker(const ompl::base::SpaceInformationPtr &information, const fcl_robot &robot, const problem &problem)
        : ompl::base::StateValidityChecker(information), pairs_(robot.pairs),
          kinematics_(robot.description.build_robot()), poses_(robot.links.size()) {
        for (const auto &model : robot.links) {
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
    }

    bool isValid(const ompl::base::State *state) const override {
        const double *values = state->as<ompl::base::RealVectorStateSpace::StateType>()->values;
        if (simdop_robot_poses(kinematics_.get(), values, poses_.data()) != SIMDOP_ERROR_NONE) {
            return false;
        }
        for (std::size_t i = 0; i < links_.size(); i++) {
            links_[i]->setTransform(transform_of(poses_[i]));
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

    std::vector<std::pair<std::size_t, std::size_t>> pairs_;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> links_, obstacles_;
    simdop::robot kinematics_;
    mutable std::vector<simdop::pose> poses_;
};

#endif
