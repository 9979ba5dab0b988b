// Robots, worlds and cells.
#ifndef CRANNY_DETAIL_CELL_HPP
#define CRANNY_DETAIL_CELL_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cranny/detail/arrays.hpp>
#include <cranny/detail/error.hpp>
#include <cranny/detail/options.hpp>

namespace cranny {

inline std::string version() { return cranny_version(); }

class Cell;

/// Robot: links, and the group of joints that moves them.
class Robot {
 public:
  struct Limits {
    Configuration lower, upper, velocity, acceleration;
  };

  static Robot builtin(const std::string& name) {
    detail::require_abi();
    return make([&](CrannyRobot** robot) { return cranny_robot_builtin(name.c_str(), robot); });
  }
  static Robot from_urdf(const std::string& path, const Options& options = {}) {
    detail::require_abi();
    return make([&](CrannyRobot** robot) { return cranny_robot_from_urdf(path.c_str(), options.c_str(), robot); });
  }
  static Robot from_urdf_text(const std::string& text, const Options& options = {}) {
    detail::require_abi();
    return make([&](CrannyRobot** robot) { return cranny_robot_from_urdf_text(text.c_str(), options.c_str(), robot); });
  }

  std::string name() const { return cranny_robot_name(c()); }
  std::string tip() const { return cranny_robot_tip(c()); }
  std::size_t dof() const { return cranny_robot_dof(c()); }
  std::vector<std::string> joint_names() const {
    std::vector<std::string> names(dof());
    for (std::size_t joint = 0; joint < names.size(); ++joint) names[joint] = cranny_robot_joint_name(c(), joint);
    return names;
  }
  std::vector<std::string> link_names() const {
    std::vector<std::string> names(cranny_robot_link_count(c()));
    for (std::size_t link = 0; link < names.size(); ++link) names[link] = cranny_robot_link_name(c(), link);
    return names;
  }
  Limits limits() const {
    const Configuration empty(dof());
    Limits of{empty, empty, empty, empty};
    detail::check(cranny_robot_limits(c(), dof(), of.lower.data(), of.upper.data(), of.velocity.data(),
                                      of.acceleration.data()));
    return of;
  }
  Configuration start() const {
    Configuration q(dof());
    detail::check(cranny_robot_start(c(), q.data(), q.size()));
    return q;
  }

  /// Pose of a link (the tip if empty).
  Pose fk(span<const double> q, const std::string& link = {}) const {
    Pose pose;
    detail::check(cranny_robot_fk(c(), detail::c_str(link), q.data(), 1, q.size(), pose.data()));
    return pose;
  }
  /// Jacobian of a link (the tip if empty): 6 rows.
  Rows jacobian(span<const double> q, const std::string& link = {}) const {
    Rows jacobian(6, dof());
    detail::check(cranny_robot_jacobian(c(), detail::c_str(link), q.data(), 1, q.size(), jacobian.data()));
    return jacobian;
  }
  Rows sample(std::size_t count, std::uint64_t seed = 0) const {
    Rows q(count, dof());
    detail::check(cranny_robot_sample(c(), seed, q.data(), count, dof()));
    return q;
  }
  /// At most `count` configurations at a pose of the tip, free in `cell` if there is one.
  inline Rows ik(const Pose& pose, std::size_t count = 1, const Cell* cell = nullptr, std::uint64_t seed = 0,
                 std::size_t attempts = 200) const;
  /// The configuration at a pose of the tip that a search from `start` finds: one row or none.
  inline Rows ik_from(const Pose& pose, span<const double> start, const Cell* cell = nullptr) const;

  const CrannyRobot* c() const { return handle_.get(); }

 private:
  friend class Cell;
  friend class Scenario;
  template <class Make>
  static Robot make(Make make) {
    Robot robot;
    robot.handle_ = detail::shared<CrannyRobot>(cranny_robot_free, make);
    return robot;
  }
  Robot() = default;
  std::shared_ptr<const CrannyRobot> handle_;
};

/// Bodies around a robot, added one by one.
class World {
 public:
  World() {
    detail::require_abi();
    CrannyWorld* world = nullptr;
    detail::check(cranny_world_new(&world));
    handle_.reset(world);
  }
  static World from_moveit_scene(const std::string& path, const Robot& robot) {
    CrannyWorld* read = nullptr;
    detail::check(cranny_world_from_moveit_scene(path.c_str(), robot.c(), &read));
    World world;
    world.handle_.reset(read);
    return world;
  }

  World& add_box(const std::string& name, const std::array<double, 3>& size, const Pose& pose) {
    return added(cranny_world_add_box(c(), name.c_str(), size.data(), pose.data()));
  }
  World& add_sphere(const std::string& name, double radius_m, const Pose& pose) {
    return added(cranny_world_add_sphere(c(), name.c_str(), radius_m, pose.data()));
  }
  World& add_cylinder(const std::string& name, double radius_m, double length_m, const Pose& pose) {
    return added(cranny_world_add_cylinder(c(), name.c_str(), radius_m, length_m, pose.data()));
  }
  World& add_capsule(const std::string& name, double radius_m, double length_m, const Pose& pose) {
    return added(cranny_world_add_capsule(c(), name.c_str(), radius_m, length_m, pose.data()));
  }
  /// Adds a closed mesh, or the convex hull of its vertices: `vertices` of 3 numbers each, `triangles` of 3 indices each.
  World& add_mesh(const std::string& name, span<const double> vertices, span<const std::uint32_t> triangles,
                  const Pose& pose, bool hull = false) {
    return added(cranny_world_add_mesh(c(), name.c_str(), vertices.data(), vertices.size() / 3, triangles.data(),
                                       triangles.size() / 3, hull, pose.data()));
  }
  World& add_floor(double height_m = 0) { return added(cranny_world_add_floor(c(), height_m)); }
  std::size_t size() const { return cranny_world_body_count(c()); }

  CrannyWorld* c() const { return handle_.get(); }

 private:
  World& added(CrannyStatus status) {
    detail::check(status);
    return *this;
  }
  struct Free {
    void operator()(CrannyWorld* world) const { cranny_world_free(world); }
  };
  std::unique_ptr<CrannyWorld, Free> handle_;
};

/// Pair that violates its required clearance.
struct Contact {
  std::string first, second;
  double clearance_m, required_m, depth_m;
  /// NaN if they are only too close.
  std::array<double, 3> point_m;

  static Contact of(const CrannyContact& from) {
    return {from.first ? from.first : "",
            from.second ? from.second : "",
            from.clearance_m,
            from.required_m,
            from.depth_m,
            {from.point_m[0], from.point_m[1], from.point_m[2]}};
  }
};

/// Proof of a motion, or the obstruction to it; true if it is proven.
struct Motion {
  CrannyMotionKind kind;
  /// Position in [0, 1]; NaN without one.
  double at;
  /// Its names are empty if no pair is the obstruction.
  Contact contact;
  /// Joint out of limits, or bound of the tool.
  std::string name;
  explicit operator bool() const { return kind == CRANNY_MOTION_KIND_PROVEN; }

  static Motion of(const CrannyMotion& from) {
    return {from.kind, from.at, Contact::of(from.contact), from.name ? from.name : ""};
  }
};

/// Robot in a world. A copy shares the geometry and has its own memory to compute in: one for each thread.
class Cell {
 public:
  Cell(const Robot& robot, const World& world, double margin_m = 0)
      : Cell([&](CrannyCell** cell) { return cranny_cell_new(robot.c(), world.c(), margin_m, cell); }) {}
  Cell(const Cell& other) : Cell([&](CrannyCell** cell) { return cranny_cell_clone(other.c(), cell); }) {}
  Cell(Cell&&) = default;
  Cell& operator=(const Cell& other) { return *this = Cell(other); }
  Cell& operator=(Cell&&) = default;

  Robot robot() const {
    return Robot::make([&](CrannyRobot** robot) { return cranny_cell_robot(c(), robot); });
  }

  bool is_free(span<const double> q) const {
    bool is_free = false;
    detail::check(cranny_cell_is_free(c(), q.data(), q.size(), &is_free));
    return is_free;
  }
  /// Verdicts on the rows of `q`, into `verdicts`, which has room for them.
  void are_free(RowsView q, bool* verdicts) const {
    detail::check(cranny_cell_are_free(c(), q.data(), q.rows(), q.columns(), verdicts));
  }
  std::vector<bool> are_free(RowsView q) const {
    const std::unique_ptr<bool[]> verdicts(new bool[q.rows()]);
    are_free(q, verdicts.get());
    return std::vector<bool>(verdicts.get(), verdicts.get() + q.rows());
  }
  /// Least distance over all pairs, in metres.
  double clearance_m(span<const double> q) const { return clearances_m({q.data(), 1, q.size()}).front(); }
  std::vector<double> clearances_m(RowsView q) const {
    std::vector<double> clearances(q.rows());
    detail::check(cranny_cell_clearances(c(), q.data(), q.rows(), q.columns(), clearances.data()));
    return clearances;
  }
  /// First pair that violates its clearance; its names are empty if there is none.
  Contact first_contact(span<const double> q) const {
    CrannyContact contact;
    detail::check(cranny_cell_first_contact(c(), q.data(), q.size(), &contact));
    return Contact::of(contact);
  }

  /// Proof of the straight motion from `a` to `b`.
  Motion motion(span<const double> a, span<const double> b) const {
    CrannyMotion motion;
    detail::check(cranny_cell_motion(c(), a.data(), b.data(), same(a.size(), b.size()), &motion));
    return Motion::of(motion);
  }
  bool motion_is_free(span<const double> a, span<const double> b) const {
    bool is_free = false;
    detail::check(cranny_cell_motions_are_free(c(), a.data(), b.data(), 1, same(a.size(), b.size()), &is_free));
    return is_free;
  }
  /// Number of the first edge of a path that is not proven, with the reason.
  std::pair<std::size_t, Motion> path(RowsView path) const {
    std::size_t edge = 0;
    CrannyMotion motion;
    detail::check(cranny_cell_path(c(), path.data(), path.rows(), path.columns(), &edge, &motion));
    return {edge, Motion::of(motion)};
  }
  bool path_is_free(RowsView way_points) const { return static_cast<bool>(path(way_points).second); }
  double least_clearance_m(span<const double> a, span<const double> b) const {
    double clearance_m = 0;
    detail::check(cranny_cell_least_clearance(c(), a.data(), b.data(), same(a.size(), b.size()), &clearance_m));
    return clearance_m;
  }

  const CrannyCell* c() const { return handle_.get(); }

 private:
  friend class Scenario;
  template <class Make, class = decltype(std::declval<Make>()(static_cast<CrannyCell**>(nullptr)))>
  explicit Cell(Make make) : handle_(detail::shared<CrannyCell>(cranny_cell_free, make)) {}
  static std::size_t same(std::size_t a, std::size_t b) {
    if (a != b) throw Error(CRANNY_STATUS_ARGUMENT, "a and b have different lengths");
    return a;
  }
  std::shared_ptr<const CrannyCell> handle_;
};

inline Rows Robot::ik(const Pose& pose, std::size_t count, const Cell* cell, std::uint64_t seed,
                      std::size_t attempts) const {
  Rows q(count, dof());
  std::size_t found = 0;
  detail::check(cranny_robot_ik(c(), pose.data(), cell ? cell->c() : nullptr, attempts, seed, q.data(), count, dof(),
                                &found));
  q.truncate(found);
  return q;
}

inline Rows Robot::ik_from(const Pose& pose, span<const double> start, const Cell* cell) const {
  Rows q(1, start.size());
  std::size_t found = 0;
  detail::check(cranny_robot_ik_from(c(), pose.data(), start.data(), cell ? cell->c() : nullptr, q.data(),
                                     start.size(), &found));
  q.truncate(found);
  return q;
}

}  // namespace cranny

#endif
