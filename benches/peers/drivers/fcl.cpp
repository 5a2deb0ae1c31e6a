// FCL: trees of the volume given by -DVOLUME (OBB, OBBRSS), compiled as in its package.
#include "peer.h"
#include <cmath>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

using Volume = fcl::VOLUME<double>;
using Model = fcl::BVHModel<Volume>;
using Geometry = fcl::CollisionGeometryd;
using Object = fcl::CollisionObjectd;

const char *peer_version() { return FCL_VERSION; }

static std::vector<fcl::Vector3d> points(const double *vertices, size_t count) {
  std::vector<fcl::Vector3d> points;
  for (size_t i = 0; i < count; i++) points.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
  return points;
}

static std::vector<fcl::Triangle> faces(const uint32_t *triangles, size_t count) {
  std::vector<fcl::Triangle> faces;
  for (size_t i = 0; i < count; i++) faces.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
  return faces;
}

// The object behind the harness's handle.
static Geometry *geometry(void *body) { return static_cast<Geometry *>(body); }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto *model = new Model;
  model->beginModel(static_cast<int>(triangle_count), static_cast<int>(vertex_count));
  model->addSubModel(points(vertices, vertex_count), faces(triangles, triangle_count));
  model->endModel();
  return static_cast<Geometry *>(model);
}

void peer_free(void *body) { delete geometry(body); }

size_t peer_bytes(const void *body) {
  auto *model = dynamic_cast<const Model *>(static_cast<const Geometry *>(body));
  if (!model) return 0;
  return sizeof(Model) + model->getNumBVs() * sizeof(fcl::BVNode<Volume>) + 
         model->num_vertices * sizeof(fcl::Vector3d) + model->num_tris * (sizeof(fcl::Triangle) + sizeof(unsigned int));
}

static fcl::Transform3d transform(const Rows &m) {
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.linear() << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  pose.translation() << m[3], m[7], m[11];
  return pose;
}

bool peer_collide(void *a, void *b, const Rows &rows) {
  const fcl::CollisionRequestd request(1, false);
  fcl::CollisionResultd result;
  fcl::collide(geometry(a), transform(rows), geometry(b), fcl::Transform3d::Identity(), request, result);
  return result.isCollision();
}

#ifdef DISTANCES
double peer_distance(void *a, void *b, const Rows &rows) {
  const fcl::DistanceRequestd request(true);
  fcl::DistanceResultd result;
  fcl::distance(geometry(a), transform(rows), geometry(b), fcl::Transform3d::Identity(), request, result);
  return result.min_distance;
}
#endif

void *peer_box(const double *sides) { return static_cast<Geometry *>(new fcl::Boxd(sides[0], sides[1], sides[2])); }

void *peer_convex(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto sides = std::make_shared<std::vector<int>>();
  for (size_t i = 0; i < triangle_count; i++) {
    sides->push_back(3);
    sides->insert(sides->end(), triangles + 3 * i, triangles + 3 * i + 3);
  }
  auto corners = std::make_shared<const std::vector<fcl::Vector3d>>(points(vertices, vertex_count));
  return static_cast<Geometry *>(new fcl::Convexd(corners, static_cast<int>(triangle_count), sides));
}

// An object of a manager. It does not own the body.
static std::unique_ptr<Object> object(const Placed &placed) {
  auto shared = std::shared_ptr<Geometry>(std::shared_ptr<void>(), geometry(placed.body));
  return std::make_unique<Object>(shared, transform(placed.place));
}

namespace {
struct Scene {
  std::vector<std::unique_ptr<Object>> links, obstacles;
  // links.size() per row.
  std::vector<bool> asked;
  fcl::DynamicAABBTreeCollisionManagerd robot, world;
};

// Data of a callback.
struct Asked {
  const Scene &scene;
  bool hit = false;

  static bool meet(Object *a, Object *b, void *data) {
    const fcl::CollisionRequestd request(1, false);
    fcl::CollisionResultd result;
    fcl::collide(a, b, request, result);
    return static_cast<Asked *>(data)->hit = result.isCollision();
  }

  static bool meet_if_asked(Object *a, Object *b, void *data) {
    const Scene &scene = static_cast<Asked *>(data)->scene;
    const auto index = [](Object *link) { return reinterpret_cast<size_t>(link->getUserData()); };
    return scene.asked[index(a) * scene.links.size() + index(b)] && meet(a, b, data);
  }
};
} // namespace

void *peer_scene(const Placed *links, size_t link_count, const bool *asked, const Placed *obstacles,
                 size_t obstacle_count) {
  auto *scene = new Scene;
  scene->asked.assign(asked, asked + link_count * link_count);
  for (size_t i = 0; i < link_count; i++) {
    scene->links.push_back(object(links[i]));
    scene->links[i]->setUserData(reinterpret_cast<void *>(i));
    scene->robot.registerObject(scene->links[i].get());
  }
  for (size_t i = 0; i < obstacle_count; i++) {
    scene->obstacles.push_back(object(obstacles[i]));
    scene->world.registerObject(scene->obstacles[i].get());
  }
  scene->robot.setup();
  scene->world.setup();
  return scene;
}

void peer_scene_free(void *scene) { delete static_cast<Scene *>(scene); }

bool peer_scene_collide(void *data, const Rows *places) {
  Scene &scene = *static_cast<Scene *>(data);
  for (size_t i = 0; i < scene.links.size(); i++) {
    scene.links[i]->setTransform(transform(places[i]));
    scene.links[i]->computeAABB();
  }
  scene.robot.update();
  Asked asked{scene};
  scene.robot.collide(&scene.world, &asked, Asked::meet);
  if (!asked.hit) scene.robot.collide(&asked, Asked::meet_if_asked);
  return asked.hit;
}

// FCL's own axes and origins of shapes are the harness's.
static Geometry *solid(const Solid &solid) {
  const double *size = solid.size;
  switch (solid.kind) {
  case SPHERE: return new fcl::Sphered(size[0]);
  case CAPSULE: return new fcl::Capsuled(size[0], size[1]);
  case CUBOID: return new fcl::Boxd(size[0], size[1], size[2]);
  case CYLINDER: return new fcl::Cylinderd(size[0], size[1]);
  case CONE: return new fcl::Coned(size[0], size[1]);
  case HALF_SPACE: return new fcl::Halfspaced(fcl::Vector3d(0, 0, 1), 0);
  }
  return nullptr;
}

namespace {
struct Pair {
  std::unique_ptr<Geometry> a, b;
  // Distances of half-spaces are in FCL's table, but their support functions are null pointers.
  bool has_distance;
};
} // namespace

void *peer_pair(const Solid *a, const Solid *b) {
  const bool has_distance = a->kind != HALF_SPACE && b->kind != HALF_SPACE;
  return new Pair{std::unique_ptr<Geometry>(solid(*a)), std::unique_ptr<Geometry>(solid(*b)), has_distance};
}

void peer_pair_free(void *pair) { delete static_cast<Pair *>(pair); }

bool peer_pair_collide(void *pair, const Rows &rows) {
  const Pair &solids = *static_cast<Pair *>(pair);
  return peer_collide(solids.a.get(), solids.b.get(), rows);
}

double peer_pair_distance(void *pair, const Rows &rows, double *at) {
  const Pair &solids = *static_cast<Pair *>(pair);
  if (!solids.has_distance) return -INFINITY;
  const fcl::DistanceRequestd request(true);
  fcl::DistanceResultd result;
  try {
    fcl::distance(solids.a.get(), transform(rows), solids.b.get(), fcl::Transform3d::Identity(), request, result);
  } catch (const std::exception &) {
    return NAN;
  }
  for (size_t i = 0; i < 6; i++) at[i] = result.nearest_points[i / 3][i % 3];
  return result.min_distance;
}
