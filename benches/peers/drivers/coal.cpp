// Coal: trees of the volume given by -DVOLUME, compiled as in its wheel.
#include "peer.h"
#include <cmath>
#include <coal/BVH/BVH_model.h>
#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

using Model = coal::BVHModel<coal::VOLUME>;
using Geometry = coal::CollisionGeometry;
using Object = coal::CollisionObject;

const char *peer_version() { return COAL_VERSION; }

static std::vector<coal::Vec3s> points(const double *vertices, size_t count) {
  std::vector<coal::Vec3s> points;
  for (size_t i = 0; i < count; i++) points.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
  return points;
}

static std::vector<coal::Triangle> faces(const uint32_t *triangles, size_t count) {
  std::vector<coal::Triangle> faces;
  for (size_t i = 0; i < count; i++) faces.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
  return faces;
}

// The object behind the harness's handle.
static Geometry *geometry(void *body) { return static_cast<Geometry *>(body); }

void *peer_build(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto *model = new Model;
  model->beginModel(static_cast<unsigned>(triangle_count), static_cast<unsigned>(vertex_count));
  model->addSubModel(points(vertices, vertex_count), faces(triangles, triangle_count));
  model->endModel();
  return static_cast<Geometry *>(model);
}

void peer_free(void *body) { delete geometry(body); }

size_t peer_bytes(const void *body) {
  auto *model = dynamic_cast<const Model *>(static_cast<const Geometry *>(body));
  if (!model) return 0;
  return sizeof(Model) + model->getNumBVs() * sizeof(coal::BVNode<coal::VOLUME>) +
         model->num_vertices * sizeof(coal::Vec3s) + model->num_tris * (sizeof(coal::Triangle) + sizeof(unsigned int));
}

static coal::Transform3s transform(const Rows &m) {
  coal::Matrix3s rotation;
  rotation << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return coal::Transform3s(rotation, coal::Vec3s(m[3], m[7], m[11]));
}

// The first hit, without its position.
static coal::CollisionRequest first_hit() {
  coal::CollisionRequest request;
  request.num_max_contacts = 1;
  request.enable_contact = false;
  // Visits nodes nearer than this even if they are separated, for a better bound on the distance: by default 1e-3, in
  // any unit.
  request.break_distance = 0;
  return request;
}

bool peer_collide(void *a, void *b, const Rows &rows) {
  coal::CollisionResult result;
  coal::collide(geometry(a), transform(rows), geometry(b), coal::Transform3s::Identity(), first_hit(), result);
  return result.isCollision();
}

#ifdef DISTANCES
double peer_distance(void *a, void *b, const Rows &rows) {
  const coal::DistanceRequest request;
  coal::DistanceResult result;
  return coal::distance(geometry(a), transform(rows), geometry(b), coal::Transform3s::Identity(), request, result);
}
#endif

void *peer_box(const double *sides) { return static_cast<Geometry *>(new coal::Box(sides[0], sides[1], sides[2])); }

void *peer_convex(const double *vertices, size_t vertex_count, const uint32_t *triangles, size_t triangle_count) {
  auto corners = std::make_shared<std::vector<coal::Vec3s>>(points(vertices, vertex_count));
  auto sides = std::make_shared<std::vector<coal::Triangle>>(faces(triangles, triangle_count));
  return static_cast<Geometry *>(new coal::Convex<coal::Triangle>(corners, static_cast<unsigned>(vertex_count), sides,
                                                                  static_cast<unsigned>(triangle_count)));
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
  coal::DynamicAABBTreeCollisionManager robot, world;
};

// A link and an obstacle.
struct Meet : coal::CollisionCallBackBase {
  const coal::CollisionRequest request = first_hit();
  bool hit = false;

  bool collide(Object *a, Object *b) override {
    coal::CollisionResult result;
    coal::collide(a, b, request, result);
    return hit = result.isCollision();
  }
};

// Two links.
struct MeetIfAsked : Meet {
  const Scene &scene;
  explicit MeetIfAsked(const Scene &scene) : scene(scene) {}

  bool collide(Object *a, Object *b) override {
    const auto index = [](Object *link) { return reinterpret_cast<size_t>(link->getUserData()); };
    return scene.asked[index(a) * scene.links.size() + index(b)] && Meet::collide(a, b);
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
  Meet among_obstacles;
  scene.robot.collide(&scene.world, &among_obstacles);
  if (among_obstacles.hit) return true;
  MeetIfAsked among_links(scene);
  scene.robot.collide(&among_links);
  return among_links.hit;
}

// Coal's own axes and origins of shapes are the harness's.
static Geometry *solid(const Solid &solid) {
  const double *size = solid.size;
  switch (solid.kind) {
  case SPHERE: return new coal::Sphere(size[0]);
  case CAPSULE: return new coal::Capsule(size[0], size[1]);
  case CUBOID: return new coal::Box(size[0], size[1], size[2]);
  case CYLINDER: return new coal::Cylinder(size[0], size[1]);
  case CONE: return new coal::Cone(size[0], size[1]);
  case HALF_SPACE: return new coal::Halfspace(coal::Vec3s(0, 0, 1), 0);
  }
  return nullptr;
}

namespace {
// Coal's functors look up the pair's functions once.
struct Pair {
  std::unique_ptr<Geometry> a, b;
  coal::ComputeCollision collision;
  coal::ComputeDistance distance;
  Pair(Geometry *a, Geometry *b) : a(a), b(b), collision(a, b), distance(a, b) {}
};
} // namespace

void *peer_pair(const Solid *a, const Solid *b) { return new Pair(solid(*a), solid(*b)); }

void peer_pair_free(void *pair) { delete static_cast<Pair *>(pair); }

bool peer_pair_collide(void *pair, const Rows &rows) {
  coal::CollisionResult result;
  static_cast<Pair *>(pair)->collision(transform(rows), coal::Transform3s::Identity(), first_hit(), result);
  return result.isCollision();
}

double peer_pair_distance(void *pair, const Rows &rows, double *at) {
  // Without the depth of bodies that meet.
  const coal::DistanceRequest request(true, false);
  coal::DistanceResult result;
  try {
    static_cast<Pair *>(pair)->distance(transform(rows), coal::Transform3s::Identity(), request, result);
  } catch (const std::exception &) {
    return NAN;
  }
  for (size_t i = 0; i < 6; i++) at[i] = result.nearest_points[i / 3][i % 3];
  return result.min_distance;
}
