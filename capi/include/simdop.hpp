/*
 * simdop for C++17: RAII, views and errors over simdop.h, which has the rules for units, threads and verdicts.
 *
 * Errors. By default, a failure throws simdop::error. With SIMDOP_EXPECTED defined, nothing throws: functions return
 * simdop::result<T>, which has a value or an error.
 *
 * Lifetimes. A body, cloud or robot is a handle that shares one object, and is cheap to copy. A scene keeps the bodies
 * and clouds that were inserted into it. The bytes behind body::open() must outlive all copies of the body.
 *
 * Views. simdop::view<T> is a pointer and a length: it converts from arrays, std::vector, std::array, std::span, and
 * from anything else that has std::data() and std::size().
 *
 * Eigen. With SIMDOP_EIGEN defined, simdop::pose_of() and simdop::isometry_of() convert poses.
 *
 * URDF. simdop::description is declared if SIMDOP_URDF is defined, as it is by the CMake targets.
 */
#ifndef SIMDOP_HPP
#define SIMDOP_HPP

#include "simdop.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#ifdef SIMDOP_EIGEN
#include <Eigen/Geometry>
#endif

namespace simdop {

using vec3 = std::array<double, 3>;
using point = std::array<float, 3>;
using triangle = std::array<std::uint32_t, 3>;
/* x, y, z, radius. */
using sphere = std::array<double, 4>;
using pose = simdop_pose;
using body_id = simdop_body_id;

inline constexpr std::uint64_t no_budget = std::numeric_limits<std::uint64_t>::max();

/* Whether this header matches the library: before version 1, major and minor numbers must be equal. */
inline bool is_compatible() noexcept {
    return simdop_version() / 1000 == SIMDOP_VERSION / 1000;
}

/* ---- Errors ---- */

/* A failure: its code, and the library's message. */
class error : public std::runtime_error {
  public:
    error(simdop_error code, const std::string &message) : std::runtime_error(message), code_(code) {}

    simdop_error code() const noexcept {
        return code_;
    }

    /* The last failure on this thread. */
    static error last(simdop_error code) {
        return error(code, simdop_last_error());
    }

  private:
    simdop_error code_;
};

#ifdef SIMDOP_EXPECTED

/* A value or an error. Reading the one that is absent ends the program. */
template <class T> class [[nodiscard]] result {
  public:
    result(T value) : value_(std::make_unique<T>(std::move(value))) {}
    result(simdop::error error) : error_(std::make_unique<simdop::error>(std::move(error))) {}

    bool has_value() const noexcept {
        return value_ != nullptr;
    }
    explicit operator bool() const noexcept {
        return has_value();
    }
    T &value() & {
        return value_ ? *value_ : (std::terminate(), *value_);
    }
    T &&value() && {
        return std::move(value());
    }
    const T &value() const & {
        return value_ ? *value_ : (std::terminate(), *value_);
    }
    T &operator*() & {
        return value();
    }
    T &&operator*() && {
        return std::move(value());
    }
    T *operator->() {
        return &value();
    }
    const simdop::error &error() const {
        return error_ ? *error_ : (std::terminate(), *error_);
    }

  private:
    std::unique_ptr<T> value_;
    std::unique_ptr<simdop::error> error_;
};

template <> class [[nodiscard]] result<void> {
  public:
    result() = default;
    result(simdop::error error) : error_(std::make_unique<simdop::error>(std::move(error))) {}

    bool has_value() const noexcept {
        return error_ == nullptr;
    }
    explicit operator bool() const noexcept {
        return has_value();
    }
    const simdop::error &error() const {
        return error_ ? *error_ : (std::terminate(), *error_);
    }

  private:
    std::unique_ptr<simdop::error> error_;
};

#else

template <class T> using result = T;

#endif

namespace detail {

#ifdef SIMDOP_EXPECTED
inline error failure(simdop_error code) {
    return error::last(code);
}
#else
/* Converts to any result, but never returns. */
struct never {
    template <class T> [[noreturn]] operator T() const {
        std::terminate();
    }
};

[[noreturn]] inline never failure(simdop_error code) {
    throw error::last(code);
}
#endif

/* The value that a function writes through its last pointer. */
template <class T, class Ask> result<T> answer(Ask ask) {
    T value{};
    const simdop_error code = ask(&value);
    if (code != SIMDOP_ERROR_NONE) {
        return failure(code);
    }
    return value;
}

inline result<void> done(simdop_error code) {
#ifdef SIMDOP_EXPECTED
    return code == SIMDOP_ERROR_NONE ? result<void>() : result<void>(failure(code));
#else
    if (code != SIMDOP_ERROR_NONE) {
        failure(code);
    }
#endif
}

/* A handle whose copies share one object. */
template <class Raw, void (*Destroy)(Raw *)> class shared {
  public:
    Raw *get() const noexcept {
        return raw_.get();
    }

  protected:
    shared() = default;
    std::shared_ptr<Raw> raw_;

    void own(Raw *raw) {
        raw_.reset(raw, Destroy);
    }
};

/* Makes an owner from a function that writes a handle. */
template <class Owner, class Raw, class Make> result<Owner> make(Make make) {
    Raw *raw = nullptr;
    const simdop_error code = make(&raw);
    if (code != SIMDOP_ERROR_NONE) {
        return failure(code);
    }
    return Owner(raw);
}

/* Calls a function of the caller from C. It may return nothing, or whether to go on. An exception is rethrown after
   the query. */
template <class Call> class callback {
  public:
    explicit callback(Call &call) : call_(call) {}

    template <class... Arguments> int operator()(Arguments &&...arguments) noexcept {
        try {
            if constexpr (std::is_void_v<std::invoke_result_t<Call &, Arguments...>>) {
                call_(std::forward<Arguments>(arguments)...);
                return 0;
            } else {
                return call_(std::forward<Arguments>(arguments)...) ? 0 : 1;
            }
        } catch (...) {
            thrown_ = std::current_exception();
            return 1;
        }
    }

    void rethrow() const {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
    }

  private:
    Call &call_;
    std::exception_ptr thrown_;
};

} // namespace detail

/* ---- Views ---- */

/* A pointer and a length. Owns nothing. */
template <class T> class view {
  public:
    constexpr view() noexcept = default;
    constexpr view(T *data, std::size_t size) noexcept : data_(data), size_(size) {}

    template <class Items,
              class = std::enable_if_t<!std::is_same_v<std::decay_t<Items>, view> &&
                                       std::is_convertible_v<decltype(std::data(std::declval<Items &>())), T *>>>
    constexpr view(Items &&items) : data_(std::data(items)), size_(std::size(items)) {}

    constexpr T *begin() const noexcept {
        return data_;
    }
    constexpr T *end() const noexcept {
        return data_ + size_;
    }
    constexpr std::size_t size() const noexcept {
        return size_;
    }
    constexpr T &operator[](std::size_t i) const {
        return data_[i];
    }
    /* Never NULL, not even for an empty view, as the C functions require. */
    T *data() const noexcept {
        static std::remove_const_t<T> nothing{};
        return data_ != nullptr ? data_ : &nothing;
    }

  private:
    T *data_ = nullptr;
    std::size_t size_ = 0;
};

/* ---- Poses ---- */

inline pose translation(double x, double y, double z) noexcept {
    return pose{{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
}

inline pose identity() noexcept {
    return translation(0, 0, 0);
}

/* The pose of a quaternion (x, y, z, w) and a translation. */
inline result<pose> from_quaternion(const std::array<double, 4> &xyzw, const vec3 &at) {
    return detail::answer<pose>(
        [&](pose *pose) { return simdop_pose_from_quaternion(xyzw.data(), at.data(), pose); });
}

#ifdef SIMDOP_EIGEN
template <int Mode> pose pose_of(const Eigen::Transform<double, 3, Mode> &transform) {
    pose made{};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            made.rows[i][j] = transform(i, j);
        }
    }
    return made;
}

inline Eigen::Isometry3d isometry_of(const pose &pose) {
    Eigen::Isometry3d made = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            made(i, j) = pose.rows[i][j];
        }
    }
    return made;
}
#endif

/* ---- Shapes and bodies ---- */

namespace detail {
inline simdop_shape shape(simdop_shape_kind kind, double x, double y, double z, double w, const pose &at) noexcept {
    return simdop_shape{static_cast<std::uint32_t>(kind), {x, y, z, w}, 0, at};
}
} // namespace detail

inline simdop_shape ball(double radius, const pose &at = identity()) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_SPHERE, radius, 0, 0, 0, at);
}
/* Along z; `length` is between the centres of its hemispheres. */
inline simdop_shape capsule(double radius, double length, const pose &at = identity()) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_CAPSULE, radius, length, 0, 0, at);
}
inline simdop_shape cuboid(double x, double y, double z, const pose &at = identity()) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_CUBOID, x, y, z, 0, at);
}
inline simdop_shape cylinder(double radius, double height, const pose &at = identity()) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_CYLINDER, radius, height, 0, 0, at);
}
inline simdop_shape cone(double radius, double height, const pose &at = identity()) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_CONE, radius, height, 0, 0, at);
}
/* All points p with normal . p <= offset. */
inline simdop_shape half_space(const vec3 &normal, double offset) noexcept {
    return detail::shape(SIMDOP_SHAPE_KIND_HALF_SPACE, normal[0], normal[1], normal[2], offset, identity());
}

/* Triangles over vertices. */
struct mesh {
    view<const vec3> vertices;
    view<const triangle> triangles;
};

class body : public detail::shared<simdop_body, simdop_body_destroy> {
  public:
    /* Takes over a handle. */
    explicit body(simdop_body *raw) {
        own(raw);
    }

    /* From the bytes of a baked tree, aligned to 64, which must outlive the body. */
    static result<body> open(view<const std::uint8_t> bytes) {
        return made([&](simdop_body **body) { return simdop_body_open(bytes.data(), bytes.size(), body); });
    }

    static result<body> surface(const mesh &mesh, simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return of_triangles(mesh, 0, storage);
    }

    static result<body> solid(const mesh &mesh, simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return of_triangles(mesh, 1, storage);
    }

    /* A solid whose holes, up to a width, are capped. */
    static result<body> solid_with_caps(const mesh &mesh, double width,
                                        simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return made([&](simdop_body **body) {
            return simdop_body_build_solid_with_caps(mesh.vertices.data()->data(), mesh.vertices.size(),
                                                     mesh.triangles.data()->data(), mesh.triangles.size(), width,
                                                     storage, body);
        });
    }

    /* The convex hull of points. */
    static result<body> hull(view<const vec3> points, simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return made([&](simdop_body **body) {
            return simdop_body_build_hull_as(points.data()->data(), points.size(), storage, body);
        });
    }

    static result<body> spheres(view<const sphere> spheres, simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return made([&](simdop_body **body) {
            return simdop_body_build_spheres_as(spheres.data()->data(), spheres.size(), storage, body);
        });
    }

    /* A copy of a solid mesh that carries spheres inside it, such as those of pack(): depth() is closer with them. */
    result<body> packed(view<const sphere> spheres) const {
        return made([&](simdop_body **packed) {
            return simdop_body_build_packed(get(), spheres.data()->data(), spheres.size(), packed);
        });
    }

    static result<body> shape(const simdop_shape &shape) {
        return made([&](simdop_body **body) { return simdop_body_build_shape(&shape, body); });
    }

    static result<body> shapes(view<const simdop_shape> shapes, simdop_storage storage = SIMDOP_STORAGE_FIXED) {
        return made([&](simdop_body **body) {
            return simdop_body_build_shapes_as(shapes.data(), shapes.size(), storage, body);
        });
    }

    /* The tree's bytes, which live as long as the body. */
    result<view<const std::uint8_t>> bytes() const {
        const std::uint8_t *first = nullptr;
        std::size_t count = 0;
        const simdop_error code = simdop_body_bytes(get(), &first, &count);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return view<const std::uint8_t>(first, count);
    }

    result<simdop_caps> caps() const {
        return detail::answer<simdop_caps>([&](simdop_caps *caps) { return simdop_body_caps(get(), caps); });
    }

    /* Proves that the volumes of the tree contain its primitives. */
    result<void> verify() const {
        return detail::done(simdop_body_verify(get()));
    }

  private:
    template <class Make> static result<body> made(Make make) {
        return detail::make<body, simdop_body>(make);
    }

    static result<body> of_triangles(const mesh &mesh, int is_solid, simdop_storage storage) {
        return made([&](simdop_body **body) {
            return simdop_body_build_triangles_as(mesh.vertices.data()->data(), mesh.vertices.size(),
                                                  mesh.triangles.data()->data(), mesh.triangles.size(), is_solid,
                                                  storage, body);
        });
    }
};

/* ---- Two bodies ---- */

inline result<simdop_answer> collide(const body &a, const body &b, const pose &a_in_b,
                                     std::uint64_t budget = no_budget) {
    return detail::answer<simdop_answer>(
        [&](simdop_answer *answer) { return simdop_collide(a.get(), b.get(), &a_in_b, budget, answer); });
}

inline result<simdop_answer> within(const body &a, const body &b, const pose &a_in_b, double margin,
                                    std::uint64_t budget = no_budget) {
    return detail::answer<simdop_answer>(
        [&](simdop_answer *answer) { return simdop_within(a.get(), b.get(), &a_in_b, margin, budget, answer); });
}

inline result<simdop_distance_answer> distance(const body &a, const body &b, const pose &a_in_b,
                                               double tolerance = 0,
                                               double cutoff = std::numeric_limits<double>::infinity(),
                                               std::uint64_t budget = no_budget) {
    return detail::answer<simdop_distance_answer>([&](simdop_distance_answer *answer) {
        return simdop_distance_up_to(a.get(), b.get(), &a_in_b, tolerance, cutoff, budget, answer);
    });
}

/* At each of many poses, into as many answers. */
inline result<void> collide(const body &a, const body &b, view<const pose> a_in_b, view<simdop_answer> answers,
                            std::uint64_t budget = no_budget) {
    const std::size_t count = a_in_b.size() < answers.size() ? a_in_b.size() : answers.size();
    return detail::done(
        simdop_collide_at_poses(a.get(), b.get(), a_in_b.data(), count, budget, answers.data()));
}

/* What a query found. Speeds up the next query of the same bodies at a nearby pose. */
class hint {
  public:
    result<simdop_answer> collide(const body &a, const body &b, const pose &a_in_b,
                                  std::uint64_t budget = no_budget) {
        return detail::answer<simdop_answer>([&](simdop_answer *answer) {
            return simdop_collide_with_hint(a.get(), b.get(), &a_in_b, budget, &hint_, answer);
        });
    }

    result<simdop_answer> within(const body &a, const body &b, const pose &a_in_b, double margin,
                                 std::uint64_t budget = no_budget) {
        return detail::answer<simdop_answer>([&](simdop_answer *answer) {
            return simdop_within_with_hint(a.get(), b.get(), &a_in_b, margin, budget, &hint_, answer);
        });
    }

    result<simdop_distance_answer> distance(const body &a, const body &b, const pose &a_in_b, double tolerance = 0,
                                            double cutoff = std::numeric_limits<double>::infinity(),
                                            std::uint64_t budget = no_budget) {
        return detail::answer<simdop_distance_answer>([&](simdop_distance_answer *answer) {
            return simdop_distance_with_hint(a.get(), b.get(), &a_in_b, tolerance, cutoff, budget, &hint_, answer);
        });
    }

  private:
    simdop_hint hint_ = SIMDOP_NO_HINT;
};

/* Calls `visit(simdop_pair)` with each pair of primitives that meet. It returns nothing, or whether to go on. */
template <class Visit>
result<simdop_pairs> each_pair(const body &a, const body &b, const pose &a_in_b, Visit visit,
                               std::uint64_t budget = no_budget) {
    detail::callback<Visit> callback(visit);
    const auto on_pair = [](void *user, const simdop_pair *pair) -> int {
        return (*static_cast<detail::callback<Visit> *>(user))(*pair);
    };
    simdop_pairs pairs{};
    const simdop_error code = simdop_each_pair(a.get(), b.get(), &a_in_b, budget, on_pair, &callback, &pairs);
    callback.rethrow();
    if (code != SIMDOP_ERROR_NONE) {
        return detail::failure(code);
    }
    return pairs;
}

inline result<simdop_penetration_answer> penetration(const body &a, const body &b, const pose &a_in_b,
                                                     std::uint64_t budget = no_budget) {
    return detail::answer<simdop_penetration_answer>([&](simdop_penetration_answer *answer) {
        return simdop_penetration(a.get(), b.get(), &a_in_b, budget, answer);
    });
}

/* How deeply two bodies overlap. */
inline result<simdop_depth_answer> depth(const body &a, const body &b, const pose &a_in_b,
                                         std::uint64_t budget = no_budget) {
    return detail::answer<simdop_depth_answer>(
        [&](simdop_depth_answer *answer) { return simdop_depth(a.get(), b.get(), &a_in_b, budget, answer); });
}

/* How far A must be translated along a direction so that it does not meet B there or anywhere beyond. */
inline result<double> depth_along(const body &a, const body &b, const pose &a_in_b, const vec3 &direction,
                                  std::uint64_t budget = no_budget) {
    return detail::answer<double>([&](double *depth) {
        return simdop_depth_along(a.get(), b.get(), &a_in_b, direction.data(), budget, depth);
    });
}

inline result<simdop_signed_distance_answer> signed_distance(const body &a, const body &b, const pose &a_in_b,
                                                             double tolerance = 0,
                                                             std::uint64_t budget = no_budget) {
    return detail::answer<simdop_signed_distance_answer>([&](simdop_signed_distance_answer *answer) {
        return simdop_signed_distance(a.get(), b.get(), &a_in_b, tolerance, budget, answer);
    });
}

/* Writes contacts of triangles, as many as fit. */
inline result<simdop_contacts_answer> contacts(const body &a, const body &b, const pose &a_in_b,
                                               view<simdop_contact> into, std::uint64_t budget = no_budget) {
    return detail::answer<simdop_contacts_answer>([&](simdop_contacts_answer *answer) {
        return simdop_contacts(a.get(), b.get(), &a_in_b, budget, into.data(), into.size(), answer);
    });
}

/* ---- Spheres inside meshes and around them ---- */

struct packing {
    std::vector<sphere> spheres;
    double volume = 0;
    double share = 0;
};

/* At most `count` disjoint spheres inside a closed mesh. */
inline result<packing> pack(const mesh &mesh, std::size_t count) {
    packing made;
    made.spheres.resize(count);
    simdop_packing packed{};
    const simdop_error code = simdop_pack(
        mesh.vertices.data()->data(), mesh.vertices.size(), mesh.triangles.data()->data(), mesh.triangles.size(),
        view<sphere>(made.spheres).data()->data(), count, nullptr, nullptr, &packed);
    if (code != SIMDOP_ERROR_NONE) {
        return detail::failure(code);
    }
    made.spheres.resize(packed.count);
    made.volume = packed.volume;
    made.share = packed.share;
    return made;
}

/* Spheres that contain a mesh, and nothing farther than `most` from it. Computed twice if `room` is too small. */
inline result<std::vector<sphere>> cover(const mesh &mesh, double most, bool is_solid, std::size_t room = 1024) {
    std::vector<sphere> spheres;
    for (;;) {
        spheres.resize(room);
        std::size_t count = 0;
        const simdop_error code = simdop_cover(mesh.vertices.data()->data(), mesh.vertices.size(),
                                               mesh.triangles.data()->data(), mesh.triangles.size(), most, is_solid,
                                               view<sphere>(spheres).data()->data(), room, &count);
        if (code != SIMDOP_ERROR_NONE && code != SIMDOP_ERROR_BUFFER) {
            return detail::failure(code);
        }
        room = count;
        if (code == SIMDOP_ERROR_NONE) {
            spheres.resize(count);
            return spheres;
        }
    }
}

/* ---- Clouds ---- */

struct neighbours {
    std::vector<simdop_list> lists;
    std::vector<std::uint32_t> indices;

    view<const std::uint32_t> of(std::size_t query) const {
        return {indices.data() + lists[query].start, lists[query].count};
    }
};

/* Copies share one cloud: a change of one is a change of all. A cloud must not change while it is in a scene. */
class cloud : public detail::shared<simdop_cloud, simdop_cloud_destroy> {
  public:
    explicit cloud(simdop_cloud *raw) {
        own(raw);
    }

    static result<cloud> build(view<const point> points) {
        return detail::make<cloud, simdop_cloud>([&](simdop_cloud **cloud) {
            return simdop_cloud_build(points.data()->data(), points.size(), cloud);
        });
    }

    static result<cloud> with_room(view<const point> points, std::uint32_t bucket_size, std::size_t capacity) {
        return detail::make<cloud, simdop_cloud>([&](simdop_cloud **cloud) {
            return simdop_cloud_build_with_room(points.data()->data(), points.size(), bucket_size, capacity, cloud);
        });
    }

    result<double> refit(view<const point> points) {
        return detail::answer<double>([&](double *ratio) {
            return simdop_cloud_refit(get(), points.data()->data(), points.size(), ratio);
        });
    }

    result<void> rebuild() {
        return detail::done(simdop_cloud_rebuild(get()));
    }

    result<void> insert(std::uint32_t index, const point &point) {
        return detail::done(simdop_cloud_insert(get(), index, point.data()));
    }

    result<void> remove(std::uint32_t index) {
        return detail::done(simdop_cloud_remove(get(), index));
    }

    simdop_cloud_size size() const {
        simdop_cloud_size size{};
        (void)simdop_cloud_get_size(get(), &size);
        return size;
    }

    result<bool> any_within(const point &centre, float radius) const {
        int is_any = 0;
        const simdop_error code = simdop_cloud_any_within(get(), centre.data(), radius, &is_any);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return is_any != 0;
    }

    /* Calls `visit(std::uint32_t)` with each point. It returns nothing, or whether to go on. */
    template <class Visit>
    result<simdop_range_stats> each_within(const point &centre, float radius, Visit visit) const {
        detail::callback<Visit> callback(visit);
        const auto on_point = [](void *user, std::uint32_t index) -> int {
            return (*static_cast<detail::callback<Visit> *>(user))(index);
        };
        simdop_range_stats stats{};
        const simdop_error code =
            simdop_cloud_each_within(get(), centre.data(), radius, on_point, &callback, &stats);
        callback.rethrow();
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return stats;
    }

    /* The k nearest neighbours of each point, into points.size() * k places. */
    result<void> nearest(view<const point> points, std::size_t k, view<simdop_neighbour> neighbours) const {
        if (k != 0 && neighbours.size() / k < points.size()) {
            return detail::done(SIMDOP_ERROR_BUFFER);
        }
        return detail::done(
            simdop_cloud_nearest(get(), points.data()->data(), points.size(), k, neighbours.data()));
    }

    /* Counts neighbours, into as many numbers as the capacity. */
    result<simdop_range_stats> count(float radius, view<std::uint32_t> counts) const {
        return detail::answer<simdop_range_stats>([&](simdop_range_stats *stats) {
            return simdop_cloud_count(get(), &radius, 1, counts.data(), counts.size(), stats);
        });
    }

    /* The points within a radius of each point of the cloud. Buffers grow as needed, and may be used again. */
    result<simdop_range_stats> find(float radius, neighbours &into) const {
        return filled(into, size().capacity, [&](simdop_neighbour_lists *lists, simdop_range_stats *stats) {
            return simdop_cloud_neighbours(get(), &radius, 1, lists, stats);
        });
    }

    /* The points within a radius of each of other points. */
    result<simdop_range_stats> find(view<const point> points, float radius, neighbours &into) const {
        std::vector<std::uint64_t> memory(points.size() + 1);
        return filled(into, points.size(), [&](simdop_neighbour_lists *lists, simdop_range_stats *stats) {
            return simdop_cloud_neighbours_of(get(), points.data()->data(), points.size(), &radius, 1, memory.data(),
                                              lists, stats);
        });
    }

  private:
    template <class Fill>
    static result<simdop_range_stats> filled(neighbours &into, std::size_t queries, Fill fill) {
        into.lists.resize(queries);
        for (;;) {
            simdop_neighbour_lists lists{view<simdop_list>(into.lists).data(), queries,
                                         view<std::uint32_t>(into.indices).data(), into.indices.size(), 0};
            simdop_range_stats stats{};
            const simdop_error code = fill(&lists, &stats);
            if (code == SIMDOP_ERROR_BUFFER && lists.needed > into.indices.size()) {
                into.indices.resize(static_cast<std::size_t>(lists.needed));
            } else if (code != SIMDOP_ERROR_NONE) {
                return detail::failure(code);
            } else {
                return stats;
            }
        }
    }
};

/* ---- Robots ---- */

class robot : public detail::shared<simdop_robot, simdop_robot_free> {
  public:
    explicit robot(simdop_robot *raw) {
        own(raw);
    }

    static result<robot> build(const pose &base, view<const simdop_joint> joints,
                               view<const simdop_link_body> bodies, view<const std::array<double, 2>> limits) {
        return detail::make<robot, simdop_robot>([&](simdop_robot **robot) {
            return simdop_robot_new(&base, joints.data(), joints.size(), bodies.data(), bodies.size(),
                                    limits.data()->data(), limits.size(), robot);
        });
    }

    /* Forward kinematics. Not const: it writes to memory of the robot, which copies share. */
    result<void> poses(view<const double> values, view<pose> poses) {
        return detail::done(simdop_robot_poses(get(), values.data(), poses.data()));
    }
};

/* ---- Scenes ---- */

/* Scenes are not copied: each thread has its own, with shared bodies. */
class scene {
  public:
    static result<scene> create() {
        return detail::make<scene, simdop_scene>([](simdop_scene **scene) { return simdop_scene_create(scene); });
    }

    static result<scene> create(simdop_storage storage) {
        return detail::make<scene, simdop_scene>(
            [&](simdop_scene **scene) { return simdop_scene_create_as(storage, scene); });
    }

    /* Takes over an empty scene. */
    explicit scene(simdop_scene *raw) : raw_(raw) {}

    scene(scene &&) = default;

    /* Destroys the former scene before the bodies that it kept. */
    scene &operator=(scene &&other) noexcept {
        raw_ = std::move(other.raw_);
        bodies_ = std::move(other.bodies_);
        return *this;
    }

    simdop_scene *get() const noexcept {
        return raw_.get();
    }

    result<body_id> insert(const body &body, const pose &world = identity(),
                           const simdop_role &role = simdop_role_default()) {
        body_id id = SIMDOP_NO_BODY;
        const simdop_error code = simdop_scene_insert(get(), body.get(), &role, &world, &id);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        bodies_.insert_or_assign(id, kept{body, nullptr});
        return id;
    }

    result<body_id> insert(const cloud &cloud, const pose &world = identity(),
                           const simdop_role &role = simdop_role_default()) {
        body_id id = SIMDOP_NO_BODY;
        const simdop_error code = simdop_scene_insert_cloud(get(), cloud.get(), &role, &world, &id);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        bodies_.insert_or_assign(id, kept{body(nullptr), std::make_shared<simdop::cloud>(cloud)});
        return id;
    }

    result<void> remove(body_id id) {
        const simdop_error code = simdop_scene_remove(get(), id);
        if (code == SIMDOP_ERROR_NONE) {
            bodies_.erase(id);
        }
        return detail::done(code);
    }

    result<void> place(body_id id, const pose &world) {
        return detail::done(simdop_scene_place(get(), id, &world));
    }

    result<void> place(view<const body_id> ids, view<const pose> worlds) {
        const std::size_t count = ids.size() < worlds.size() ? ids.size() : worlds.size();
        return detail::done(simdop_scene_place_all(get(), ids.data(), worlds.data(), count));
    }

    result<pose> world_pose(body_id id) const {
        return detail::answer<pose>([&](pose *world) { return simdop_scene_world_pose(get(), id, world); });
    }

    result<void> attach(body_id id, body_id to) {
        return detail::done(simdop_scene_attach(get(), id, to));
    }
    result<void> detach(body_id id) {
        return detail::done(simdop_scene_detach(get(), id));
    }
    result<void> allow_collision(body_id a, body_id b) {
        return detail::done(simdop_scene_allow_collision(get(), a, b));
    }
    result<void> forbid_collision(body_id a, body_id b) {
        return detail::done(simdop_scene_forbid_collision(get(), a, b));
    }

    result<bool> is_asked(body_id a, body_id b) const {
        int is_asked = 0;
        const simdop_error code = simdop_scene_is_asked(get(), a, b, &is_asked);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return is_asked != 0;
    }

    result<simdop_scene_answer> collide(std::uint64_t budget = no_budget) const {
        return detail::answer<simdop_scene_answer>(
            [&](simdop_scene_answer *answer) { return simdop_scene_collide(get(), budget, answer); });
    }

    result<simdop_scene_answer> within(double margin, std::uint64_t budget = no_budget) const {
        return detail::answer<simdop_scene_answer>(
            [&](simdop_scene_answer *answer) { return simdop_scene_within(get(), margin, budget, answer); });
    }

    result<simdop_scene_clearance_answer> clearance(double tolerance = 0,
                                                    double cutoff = std::numeric_limits<double>::infinity(),
                                                    std::uint64_t budget = no_budget) const {
        return detail::answer<simdop_scene_clearance_answer>([&](simdop_scene_clearance_answer *answer) {
            return simdop_scene_clearance(get(), tolerance, cutoff, budget, answer);
        });
    }

    /* The least distance, or minus the depth of the pair that overlaps most deeply. */
    result<simdop_scene_signed_answer> signed_clearance(double tolerance = 0,
                                                        double cutoff = std::numeric_limits<double>::infinity(),
                                                        std::uint64_t budget = no_budget) const {
        return detail::answer<simdop_scene_signed_answer>([&](simdop_scene_signed_answer *answer) {
            return simdop_scene_signed_clearance(get(), tolerance, cutoff, budget, answer);
        });
    }

    /* Calls `visit(simdop_scene_hit)` with each two bodies within a margin. It returns nothing, or whether to go on. */
    template <class Visit>
    result<simdop_scene_hits> each_hit(double margin, Visit visit, std::uint64_t budget = no_budget) const {
        detail::callback<Visit> callback(visit);
        const auto on_hit = [](void *user, const simdop_scene_hit *hit) -> int {
            return (*static_cast<detail::callback<Visit> *>(user))(*hit);
        };
        simdop_scene_hits hits{};
        const simdop_error code = simdop_scene_each_hit(get(), margin, budget, on_hit, &callback, &hits);
        callback.rethrow();
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return hits;
    }

    /* Which configurations are free? `poses` has a pose of each moving body for each byte of `free`. */
    result<simdop_states_answer> check_states(view<const body_id> moving, view<const pose> poses,
                                              view<std::uint8_t> free, std::uint64_t budget = no_budget) {
        if (moving.size() * free.size() > poses.size()) {
            return detail::failure(SIMDOP_ERROR_BUFFER);
        }
        return detail::answer<simdop_states_answer>([&](simdop_states_answer *answer) {
            return simdop_scene_check_states(get(), moving.data(), moving.size(), poses.data(), free.size(), budget,
                                             free.data(), answer);
        });
    }

    /* The same for values of a robot's variables: one for each variable and each byte of `free`. */
    result<simdop_states_answer> check_states(view<const body_id> moving, const robot &robot,
                                              view<const double> values, view<std::uint8_t> free,
                                              std::uint64_t budget = no_budget) {
        return detail::answer<simdop_states_answer>([&](simdop_states_answer *answer) {
            return simdop_scene_check_joint_states(get(), moving.data(), moving.size(), robot.get(), values.data(),
                                                   free.size(), budget, free.data(), answer);
        });
    }

    /* Is the straight motion of a robot's variables free at all times? */
    result<simdop_motion_answer> check_motion(view<const body_id> moving, const robot &robot,
                                              view<const double> from, view<const double> to, double resolution,
                                              std::uint64_t budget = no_budget) {
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_scene_check_joint_motion(get(), moving.data(), moving.size(), robot.get(), from.data(),
                                                   to.data(), resolution, budget, answer);
        });
    }

    /* Is the screw motion of a body free at all times? */
    result<simdop_motion_answer> check_motion(body_id id, const pose &from, const pose &to, double resolution,
                                              std::uint64_t budget = no_budget) {
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_scene_check_screw(get(), id, &from, &to, resolution, budget, answer);
        });
    }

    /* Is a motion given by callbacks free at all times? */
    result<simdop_motion_answer> check_motion(view<const body_id> moving, const simdop_motion &motion,
                                              double resolution, std::uint64_t budget = no_budget) {
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_scene_check_motion(get(), moving.data(), moving.size(), &motion, resolution, budget, answer);
        });
    }

    /* The same, but only at parts + 1 times. */
    result<simdop_motion_answer> check_motion_discrete(view<const body_id> moving, const simdop_motion &motion,
                                                       std::uint32_t parts, std::uint64_t budget = no_budget) {
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_scene_check_motion_discrete(get(), moving.data(), moving.size(), &motion, parts, budget,
                                                      answer);
        });
    }

    /* Writes values of the variables at which two bodies meet, and values at which they do not. */
    result<simdop_pair_report> classify_pair(view<const body_id> moving, const robot &robot, body_id a, body_id b,
                                             std::size_t boxes, view<double> meeting, view<double> free) {
        return detail::answer<simdop_pair_report>([&](simdop_pair_report *report) {
            return simdop_scene_classify_pair(get(), moving.data(), moving.size(), robot.get(), a, b, boxes,
                                              meeting.data(), free.data(), report);
        });
    }

  private:
    struct destroy {
        void operator()(simdop_scene *scene) const noexcept {
            simdop_scene_destroy(scene);
        }
    };
    struct kept {
        simdop::body body;
        std::shared_ptr<simdop::cloud> cloud;
    };

    /* Destroyed after the scene, which is the last member. */
    std::unordered_map<body_id, kept> bodies_;
    std::unique_ptr<simdop_scene, destroy> raw_;
};

/* The role of a body that stands still. */
inline simdop_role fixed() noexcept {
    simdop_role role = simdop_role_default();
    role.is_fixed = 1;
    return role;
}

/* The role of a body that includes everything within a radius of it. */
inline simdop_role padded(double radius) noexcept {
    simdop_role role = simdop_role_default();
    role.radius = radius;
    return role;
}

/* ---- URDF ---- */

#ifdef SIMDOP_URDF
class description : public detail::shared<simdop_description, simdop_description_destroy> {
  public:
    explicit description(simdop_description *raw) {
        own(raw);
    }

    /* From the text of a URDF file. */
    static result<description> read(std::string_view urdf, bool is_visual = false) {
        return detail::make<description, simdop_description>([&](simdop_description **description) {
            return simdop_description_read(urdf.empty() ? "" : urdf.data(), urdf.size(), is_visual, description);
        });
    }

    std::size_t variables() const {
        return size().variables;
    }
    std::size_t bodies() const {
        return size().bodies;
    }

    result<simdop_variable> variable(std::size_t index) const {
        return detail::answer<simdop_variable>([&](simdop_variable *variable) {
            return simdop_description_get_variable(get(), index, variable);
        });
    }

    result<simdop_described_body> described_body(std::size_t index) const {
        return detail::answer<simdop_described_body>([&](simdop_described_body *body) {
            return simdop_description_get_body(get(), index, body);
        });
    }

    /* Builds the body of an index, if it is a shape. */
    result<body> build_body(std::size_t index) const {
        return detail::make<body, simdop_body>(
            [&](simdop_body **body) { return simdop_description_build_body(get(), index, body); });
    }

    result<robot> build_robot(const pose &base = identity()) const {
        return detail::make<robot, simdop_robot>(
            [&](simdop_robot **robot) { return simdop_description_build_robot(get(), &base, robot); });
    }

    /* Tests the pairs of bodies that joints move and the text of an SRDF file, if any, does not disable. */
    result<void> select_pairs(std::string_view srdf, scene &scene, view<const body_id> ids) const {
        return detail::done(simdop_description_select_pairs(get(), srdf.empty() ? nullptr : srdf.data(),
                                                            srdf.size(), scene.get(), ids.data(), ids.size()));
    }

  private:
    simdop_description_size size() const {
        simdop_description_size size{};
        (void)simdop_description_get_size(get(), &size);
        return size;
    }
};
#endif

/* ---- Planners ---- */

#ifdef SIMDOP_PLANNING
/* A robot among objects, queried by joint values. Copies share all trees. */
class planner {
  public:
    /* Memory for the queries of one thread. */
    class workspace {
      public:
        simdop_workspace *get() const noexcept {
            return raw_.get();
        }

      private:
        friend class planner;
        workspace(simdop_workspace *raw, std::shared_ptr<std::vector<body>> kept)
            : kept_(std::move(kept)), raw_(raw) {}

        struct destroy {
            void operator()(simdop_workspace *workspace) const noexcept {
                simdop_workspace_destroy(workspace);
            }
        };
        /* Destroyed after the workspace, whose copy of the scene may refer to them. */
        std::shared_ptr<std::vector<body>> kept_;
        std::unique_ptr<simdop_workspace, destroy> raw_;
    };

    /* From the paths of a URDF file and an SRDF file, which may be empty. Also reads the meshes that they name. */
    static result<planner> load(const std::string &urdf, const std::string &srdf = {}, double cap = 0) {
        return detail::make<planner, simdop_planner>([&](simdop_planner **planner) {
            return simdop_planner_load(urdf.c_str(), srdf.empty() ? nullptr : srdf.c_str(), cap, planner);
        });
    }

    /* Takes over a handle. */
    explicit planner(simdop_planner *raw) : raw_(raw) {}

    result<planner> copy() const {
        simdop_planner *raw = nullptr;
        const simdop_error code = simdop_planner_copy(get(), &raw);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        planner made(raw);
        *made.kept_ = *kept_;
        return result<planner>(std::move(made));
    }

    simdop_planner *get() const noexcept {
        return raw_.get();
    }

    result<workspace> make_workspace() const {
        simdop_workspace *raw = nullptr;
        const simdop_error code = simdop_workspace_create(get(), &raw);
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return workspace(raw, kept_);
    }

    std::size_t variables() const {
        std::size_t count = 0;
        (void)simdop_planner_variables(get(), &count);
        return count;
    }

    /* Lower and upper limits of the variables that are planned for. */
    result<std::vector<std::array<double, 2>>> limits() const {
        std::vector<std::array<double, 2>> limits(variables());
        const simdop_error code =
            simdop_planner_limits(get(), view<std::array<double, 2>>(limits).data()->data());
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return limits;
    }

    /* A variable that is planned for: its name and limits. The name is valid as long as the planner. */
    result<simdop_variable> variable(std::size_t index) const {
        return detail::answer<simdop_variable>([&](simdop_variable *variable) {
            return simdop_planner_get_variable(get(), index, variable);
        });
    }

    /* The names of the groups of joints in the SRDF file. */
    result<std::vector<std::string>> groups() const {
        std::size_t count = 0;
        (void)simdop_planner_groups(get(), &count);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < count; i++) {
            const char *name = nullptr;
            const simdop_error code = simdop_planner_get_group(get(), i, &name);
            if (code != SIMDOP_ERROR_NONE) {
                return detail::failure(code);
            }
            names.emplace_back(name);
        }
        return names;
    }

    result<void> select_group(const std::string &name, view<const double> rest) {
        return detail::done(simdop_planner_select_group(get(), name.c_str(), rest.data(), rest.size()));
    }
    result<void> place_base(const pose &world) {
        return detail::done(simdop_planner_place_base(get(), &world));
    }
    /* The shortest interval of time that a motion, from 0 to 1, is split into. */
    result<void> set_resolution(double resolution) {
        return detail::done(simdop_planner_set_resolution(get(), resolution));
    }
    result<void> set_budget(std::uint64_t budget) {
        return detail::done(simdop_planner_set_budget(get(), budget));
    }
    /* Speeds up queries of configurations and motions, by bounds in cells of this width. */
    result<void> use_bounds(double cell) {
        return detail::done(simdop_planner_use_bounds(get(), cell));
    }
    std::size_t bound_bytes() const {
        std::size_t bytes = 0;
        (void)simdop_planner_bound_bytes(get(), &bytes);
        return bytes;
    }

    /* The body is kept until the planner and all its copies and workspaces are gone. */
    result<body_id> insert(const body &body, const pose &world, const simdop_role &role) {
        kept_->push_back(body);
        return detail::answer<body_id>(
            [&](body_id *id) { return simdop_planner_insert(get(), body.get(), &role, &world, id); });
    }

    result<void> place(body_id object, const pose &world) {
        return detail::done(simdop_planner_place(get(), object, &world));
    }
    result<void> remove(body_id object) {
        return detail::done(simdop_planner_remove(get(), object));
    }
    result<body_id> link(const std::string &name) const {
        return detail::answer<body_id>([&](body_id *id) { return simdop_planner_link(get(), name.c_str(), id); });
    }
    result<void> attach(body_id object, const std::string &link, view<const double> values) {
        return detail::done(
            simdop_planner_attach(get(), object, link.c_str(), values.data(), values.size()));
    }
    result<void> detach(body_id object, const pose &world) {
        return detail::done(simdop_planner_detach(get(), object, &world));
    }
    result<void> allow_collision(body_id a, body_id b) {
        return detail::done(simdop_planner_allow_collision(get(), a, b));
    }
    result<void> forbid_collision(body_id a, body_id b) {
        return detail::done(simdop_planner_forbid_collision(get(), a, b));
    }

    result<simdop_scene_answer> within(workspace &workspace, view<const double> values, double margin = 0) const {
        if (values.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<simdop_scene_answer>([&](simdop_scene_answer *answer) {
            return simdop_planner_within(get(), workspace.get(), values.data(), margin, answer);
        });
    }

    /* Which configurations are free? Returns how many. */
    result<std::size_t> check_states(workspace &workspace, view<const double> values,
                                     view<std::uint8_t> free) const {
        if (values.size() != variables() * free.size()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<std::size_t>([&](std::size_t *count) {
            return simdop_planner_check_states(get(), workspace.get(), values.data(), free.size(), free.data(), count);
        });
    }

    /* Which points, three numbers each, are within the margin of the robot? Returns how many. */
    result<std::size_t> near_robot(workspace &workspace, view<const double> values, view<const float> points,
                                   double margin, view<std::uint8_t> near) const {
        if (values.size() != variables() || points.size() != 3 * near.size()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<std::size_t>([&](std::size_t *count) {
            return simdop_planner_near_robot(get(), workspace.get(), values.data(), points.data(), near.size(), margin,
                                             near.data(), count);
        });
    }

    /* Is the straight motion free at all times? */
    result<simdop_motion_answer> check_motion(workspace &workspace, view<const double> from,
                                              view<const double> to) const {
        if (from.size() != variables() || to.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_planner_check_motion(get(), workspace.get(), from.data(), to.data(), answer);
        });
    }

    /* The same, but only at parts + 1 times. */
    result<simdop_motion_answer> check_motion_discrete(workspace &workspace, view<const double> from,
                                                       view<const double> to, std::uint32_t parts) const {
        if (from.size() != variables() || to.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<simdop_motion_answer>([&](simdop_motion_answer *answer) {
            return simdop_planner_check_motion_discrete(get(), workspace.get(), from.data(), to.data(), parts, answer);
        });
    }

    /* Which straight motions are free at all times? `ends` has the values of both ends of each. Returns how many. */
    result<std::size_t> check_motions(workspace &workspace, view<const double> ends, view<std::uint8_t> free) const {
        if (ends.size() != 2 * variables() * free.size()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<std::size_t>([&](std::size_t *count) {
            return simdop_planner_check_motions(get(), workspace.get(), ends.data(), free.size(), free.data(), count);
        });
    }

    /* The share of a straight motion, from its start, that is free at all times. */
    result<double> free_share(workspace &workspace, view<const double> from, view<const double> to) const {
        if (from.size() != variables() || to.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<double>([&](double *share) {
            return simdop_planner_free_share(get(), workspace.get(), from.data(), to.data(), share);
        });
    }

    /* Calls `visit(simdop_scene_hit)` with each two bodies within a margin. It returns nothing, or whether to go on. */
    template <class Visit>
    result<simdop_scene_hits> each_hit(workspace &workspace, view<const double> values, double margin,
                                       Visit visit) const {
        if (values.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        detail::callback<Visit> callback(visit);
        const auto on_hit = [](void *user, const simdop_scene_hit *hit) -> int {
            return (*static_cast<detail::callback<Visit> *>(user))(*hit);
        };
        simdop_scene_hits hits{};
        const simdop_error code =
            simdop_planner_each_hit(get(), workspace.get(), values.data(), margin, on_hit, &callback, &hits);
        callback.rethrow();
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        return hits;
    }

    /* A path of straight motions that are free at all times, from `start` to one of the goals, which follow each other:
       its configurations, one after the other. Empty if none was found. */
    result<std::vector<double>> plan(workspace &workspace, view<const double> start, view<const double> goals,
                                     const simdop_plan_settings &settings = simdop_plan_settings_default()) const {
        const std::size_t count = variables();
        if (start.size() != count || count == 0 || goals.size() % count != 0) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        std::vector<double> path(64 * count);
        for (;;) {
            simdop_planned_path found{};
            const simdop_error code = simdop_planner_plan(get(), workspace.get(), start.data(), goals.data(),
                                                          goals.size() / count, &settings,
                                                          view<double>(path).data(), path.size() / count, &found);
            if (code != SIMDOP_ERROR_NONE && code != SIMDOP_ERROR_BUFFER) {
                return detail::failure(code);
            }
            path.resize(found.count * count);
            if (code == SIMDOP_ERROR_NONE) {
                return path;
            }
        }
    }

    /* A random free configuration, from numbers in [0, 1) that `random()` returns. Empty after `tries` failures. */
    template <class Random>
    result<std::vector<double>> random_free(workspace &workspace, Random random, std::size_t tries) const {
        std::exception_ptr thrown;
        auto next = [&]() noexcept -> double {
            try {
                return thrown ? 0 : random();
            } catch (...) {
                thrown = std::current_exception();
                return 0;
            }
        };
        const auto call = [](void *user) -> double { return (*static_cast<decltype(next) *>(user))(); };
        std::vector<double> values(variables());
        int is_found = 0;
        const simdop_error code = simdop_planner_random_free(get(), workspace.get(), call, &next, tries,
                                                             view<double>(values).data(), &is_found);
        if (thrown) {
            std::rethrow_exception(thrown);
        }
        if (code != SIMDOP_ERROR_NONE) {
            return detail::failure(code);
        }
        values.resize(is_found != 0 ? values.size() : 0);
        return values;
    }

    result<simdop_scene_clearance_answer> clearance(
        workspace &workspace, view<const double> values, double tolerance = 0,
        double cutoff = std::numeric_limits<double>::infinity()) const {
        if (values.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<simdop_scene_clearance_answer>([&](simdop_scene_clearance_answer *answer) {
            return simdop_planner_clearance(get(), workspace.get(), values.data(), tolerance, cutoff, answer);
        });
    }

    /* The derivative of `near` by each variable; `near` must answer the workspace's last query. */
    result<void> clearance_gradient(workspace &workspace, const simdop_scene_clearance_answer &near,
                                    view<double> gradient) const {
        if (gradient.size() != variables()) {
            return detail::done(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::done(simdop_planner_clearance_gradient(get(), workspace.get(), &near, gradient.data()));
    }

    /* Where a point of a body is in the last configuration of the workspace. */
    result<vec3> to_world(const workspace &workspace, body_id id, const vec3 &point) const {
        return detail::answer<vec3>([&](vec3 *world) {
            return simdop_planner_to_world(get(), workspace.get(), id, point.data(), world->data());
        });
    }

    /* Like scene::classify_pair(): writes a number for each variable of the robot. */
    result<simdop_pair_report> classify_pair(workspace &workspace, body_id a, body_id b, std::size_t boxes,
                                             view<double> meeting, view<double> free) const {
        return detail::answer<simdop_pair_report>([&](simdop_pair_report *report) {
            return simdop_planner_classify_pair(get(), workspace.get(), a, b, boxes, meeting.data(), free.data(),
                                                report);
        });
    }

    /* Like scene::signed_clearance(); `gradient` gets the derivative by each variable. */
    result<simdop_scene_signed_answer> signed_clearance(
        workspace &workspace, view<const double> values, view<double> gradient, double tolerance = 0,
        double cutoff = std::numeric_limits<double>::infinity()) const {
        if (values.size() != variables() || gradient.size() != variables()) {
            return detail::failure(SIMDOP_ERROR_MOTION_LENGTH);
        }
        return detail::answer<simdop_scene_signed_answer>([&](simdop_scene_signed_answer *answer) {
            return simdop_planner_signed_clearance(get(), workspace.get(), values.data(), tolerance, cutoff,
                                                   gradient.data(), answer);
        });
    }

  private:
    struct destroy {
        void operator()(simdop_planner *planner) const noexcept {
            simdop_planner_destroy(planner);
        }
    };

    std::shared_ptr<std::vector<body>> kept_ = std::make_shared<std::vector<body>>();
    std::unique_ptr<simdop_planner, destroy> raw_;
};
#endif

} // namespace simdop

#endif /* SIMDOP_HPP */
