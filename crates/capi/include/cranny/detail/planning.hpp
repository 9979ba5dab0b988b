// Grasps, scenarios, plans, verifications and trajectories.
#ifndef CRANNY_DETAIL_PLANNING_HPP
#define CRANNY_DETAIL_PLANNING_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cranny/detail/cell.hpp>

namespace cranny {

/// Set of grasps of an object.
class Grasps {
 public:
  explicit Grasps(const std::vector<Pose>& poses, const std::vector<double>& scores = {})
      : Grasps([&](CrannyGrasps** grasps) {
          if (!scores.empty() && scores.size() != poses.size())
            throw Error(CRANNY_STATUS_ARGUMENT, "poses and scores have different lengths");
          const double* first = poses.empty() ? nullptr : poses.front().data();
          return cranny_grasps_new(first, scores.empty() ? nullptr : scores.data(), poses.size(), grasps);
        }) {}
  static Grasps load(const std::string& path) {
    return Grasps([&](CrannyGrasps** grasps) { return cranny_grasps_load(path.c_str(), grasps); });
  }
  /// Antipodal grasps of a mesh: `vertices` of 3 numbers each, `triangles` of 3 indices each.
  static Grasps sample(span<const double> vertices, span<const std::uint32_t> triangles, const Options& options = {}) {
    return Grasps([&](CrannyGrasps** grasps) {
      return cranny_grasps_sample(vertices.data(), vertices.size() / 3, triangles.data(), triangles.size() / 3,
                                  options.c_str(), grasps);
    });
  }

  std::size_t size() const { return cranny_grasps_count(c()); }
  /// Pose of the gripper frame.
  Pose pose(std::size_t grasp) const {
    if (grasp >= size()) throw Error(CRANNY_STATUS_ARGUMENT, "there is no grasp of this index");
    Pose pose;
    const double* rows = cranny_grasps_poses(c()) + 16 * grasp;
    for (std::size_t i = 0; i < 16; ++i) pose[i] = rows[i];
    return pose;
  }
  span<const double> scores() const { return {cranny_grasps_scores(c()), size()}; }
  /// Indices in the order of falling score.
  span<const std::size_t> by_score() const { return {cranny_grasps_by_score(c()), size()}; }
  void save(const std::string& path) const { detail::check(cranny_grasps_save(c(), path.c_str())); }

  const CrannyGrasps* c() const { return handle_.get(); }

 private:
  friend class Scenario;
  template <class Make, class = decltype(std::declval<Make>()(static_cast<CrannyGrasps**>(nullptr)))>
  explicit Grasps(Make make) : handle_(detail::shared<CrannyGrasps>(cranny_grasps_free, make)) {}
  std::shared_ptr<const CrannyGrasps> handle_;
};

/// Task: a robot, its surroundings, the object to grasp and its grasps, or goal configurations.
class Scenario {
 public:
  /// Opens a built-in scenario by its id, or a folder or an archive by its path.
  explicit Scenario(const std::string& what, const Options& options = {})
      : Scenario([&](CrannyScenario** scenario) {
          detail::require_abi();
          return cranny_scenario_open(what.c_str(), options.c_str(), scenario);
        }) {}
  /// Makes a scenario of a robot in a world; an empty start is the robot's own.
  Scenario(const Robot& robot, const World& world, span<const double> start = {}, const std::string& target = {},
           const Grasps* grasps = nullptr)
      : Scenario([&](CrannyScenario** scenario) {
          return cranny_scenario_new(robot.c(), world.c(), start.empty() ? nullptr : start.data(), start.size(),
                                     detail::c_str(target), grasps ? grasps->c() : nullptr, scenario);
        }) {}
  /// Opens a planning scene and a motion plan request of MoveIt.
  static Scenario from_moveit(const std::string& scene, const std::string& request, const Options& options = {}) {
    detail::require_abi();
    return Scenario([&](CrannyScenario** scenario) {
      return cranny_scenario_from_moveit(scene.c_str(), request.c_str(), options.c_str(), scenario);
    });
  }

  std::string id() const { return cranny_scenario_id(c()); }
  /// Differences between the scenario and MoveIt's files, a sentence in each line.
  std::string notes() const { return cranny_scenario_notes(c()); }
  Robot robot() const {
    return Robot::make([&](CrannyRobot** robot) { return cranny_scenario_robot(c(), robot); });
  }
  Cell cell(double margin_m = 0, double grasp_margin_m = 0) const {
    return Cell([&](CrannyCell** cell) { return cranny_scenario_cell(c(), margin_m, grasp_margin_m, cell); });
  }
  Grasps grasps() const {
    return Grasps([&](CrannyGrasps** grasps) { return cranny_scenario_grasps(c(), grasps); });
  }
  Configuration start() const {
    Configuration q(robot().dof());
    detail::check(cranny_scenario_start(c(), q.data(), q.size()));
    return q;
  }
  Scenario with_start(span<const double> start) const {
    return Scenario([&](CrannyScenario** altered) {
      return cranny_scenario_with_start(c(), start.data(), start.size(), altered);
    });
  }
  Scenario with_goals(RowsView goals) const {
    return Scenario([&](CrannyScenario** altered) {
      return cranny_scenario_with_goals(c(), goals.data(), goals.rows(), goals.columns(), altered);
    });
  }
  Scenario with_grasps(const Grasps& grasps) const {
    return Scenario(
        [&](CrannyScenario** altered) { return cranny_scenario_with_grasps(c(), grasps.c(), altered); });
  }

  const CrannyScenario* c() const { return handle_.get(); }

 private:
  template <class Make, class = decltype(std::declval<Make>()(static_cast<CrannyScenario**>(nullptr)))>
  explicit Scenario(Make make) : handle_(detail::shared<CrannyScenario>(cranny_scenario_free, make)) {}
  std::shared_ptr<const CrannyScenario> handle_;
};

/// Verdict on a path; true if it meets the criterion.
class Verification {
 public:
  explicit operator bool() const { return is_valid(); }
  bool is_valid() const { return cranny_verification_is_valid(c()); }
  /// Proven least clearance in metres; NaN without a proof.
  double clearance_m() const { return cranny_verification_clearance_m(c()); }
  std::vector<std::string> violations() const {
    std::vector<std::string> violations(cranny_verification_violation_count(c()));
    for (std::size_t i = 0; i < violations.size(); ++i) violations[i] = cranny_verification_violation(c(), i);
    return violations;
  }
  std::string json() const { return cranny_verification_json(c()); }

  const CrannyVerification* c() const { return handle_.get(); }

 private:
  friend class Plan;
  friend Verification verify_path(const Scenario&, RowsView, const Options&);
  template <class Make>
  explicit Verification(Make make) : handle_(detail::shared<CrannyVerification>(cranny_verification_free, make)) {}
  std::shared_ptr<const CrannyVerification> handle_;
};

/// Verdict on a path from any source.
inline Verification verify_path(const Scenario& scenario, RowsView path, const Options& options = {}) {
  return Verification([&](CrannyVerification** verification) {
    return cranny_verify_path(scenario.c(), path.data(), path.rows(), path.columns(), options.c_str(), verification);
  });
}

/// Trajectory at equal intervals. The views are valid as long as one copy of it exists.
class Samples {
 public:
  std::size_t size() const { return cranny_samples_count(c()); }
  span<const double> times() const { return {cranny_samples_times(c()), size()}; }
  RowsView positions() const { return {cranny_samples_positions(c()), size(), cranny_samples_dof(c())}; }
  RowsView velocities() const { return {cranny_samples_velocities(c()), size(), cranny_samples_dof(c())}; }
  RowsView accelerations() const { return {cranny_samples_accelerations(c()), size(), cranny_samples_dof(c())}; }
  /// Distances between the fingers in metres; empty if they do not close on an object.
  span<const double> openings() const {
    const double* first = cranny_samples_openings(c());
    return {first, first ? size() : 0};
  }

  const CrannySamples* c() const { return handle_.get(); }

 private:
  friend class Plan;
  template <class Make>
  explicit Samples(Make make) : handle_(detail::shared<CrannySamples>(cranny_samples_free, make)) {}
  std::shared_ptr<const CrannySamples> handle_;
};

/// State of a trajectory at an instant.
struct State {
  Configuration position, velocity, acceleration;
};

/// Result of planning; true if a path was found and verified. Views are valid as long as one copy of it exists.
class Plan {
 public:
  static Plan load(const std::string& path, const Scenario& scenario) {
    return Plan([&](CrannyPlan** plan) { return cranny_plan_load(path.c_str(), scenario.c(), plan); });
  }

  explicit operator bool() const { return is_solved(); }
  bool is_solved() const { return cranny_plan_is_solved(c()); }
  std::string outcome() const { return cranny_plan_outcome(c()); }
  std::string planner() const { return cranny_plan_planner(c()); }
  RowsView path() const { return {cranny_plan_path(c()), cranny_plan_waypoint_count(c()), dof()}; }
  std::size_t dof() const { return cranny_plan_dof(c()); }
  /// Index of the grasp at the end of the path, or -1.
  std::int64_t grasp() const { return cranny_plan_grasp(c()); }
  /// Proven least clearance in metres; NaN without a proof.
  double clearance_m() const { return cranny_plan_clearance_m(c()); }
  /// Duration in seconds; NaN without a trajectory.
  double duration_s() const { return cranny_plan_duration_s(c()); }
  bool has_trajectory() const { return !std::isnan(duration_s()); }
  std::string json() const { return cranny_plan_json(c()); }
  void save(const std::string& path) const { detail::check(cranny_plan_save(c(), path.c_str())); }
  Verification verify() const {
    return Verification([&](CrannyVerification** verification) { return cranny_plan_verify(c(), verification); });
  }
  Samples sample(double rate_hz = 100) const {
    return Samples([&](CrannySamples** samples) { return cranny_plan_sample(c(), rate_hz, samples); });
  }
  /// State `time_s` seconds after the beginning of the trajectory.
  State at(double time_s) const {
    const Configuration empty(dof());
    State state{empty, empty, empty};
    detail::check(cranny_plan_state_at(c(), time_s, dof(), state.position.data(), state.velocity.data(),
                                       state.acceleration.data()));
    return state;
  }

  const CrannyPlan* c() const { return handle_.get(); }

 private:
  friend Plan plan(const Scenario&, const Options&, std::function<bool()>);
  template <class Make>
  explicit Plan(Make make) : handle_(detail::shared<CrannyPlan>(cranny_plan_free, make)) {}
  std::shared_ptr<const CrannyPlan> handle_;
};

namespace detail {

/// The question whether a search shall end, and the exception that its answer threw.
struct Stop {
  std::function<bool()> should_stop;
  std::exception_ptr thrown;
};

// An exception must not pass through the library: it ends the search, and is thrown again after it.
extern "C" inline bool cranny_detail_should_stop(void* context) noexcept {
  auto& stop = *static_cast<Stop*>(context);
  try {
    return stop.should_stop();
  } catch (...) {
    stop.thrown = std::current_exception();
    return true;
  }
}

}  // namespace detail

/// Plans a scenario. A search without a result is no failure: see Plan::outcome. `should_stop`, if given, is asked between the
/// iterations of the search, in this thread, and ends it by true or by an exception.
inline Plan plan(const Scenario& scenario, const Options& options = {}, std::function<bool()> should_stop = {}) {
  detail::Stop stop{std::move(should_stop), nullptr};
  const CrannyShouldStop ask = stop.should_stop ? detail::cranny_detail_should_stop : nullptr;
  const auto rethrow = [&] {
    if (stop.thrown) std::rethrow_exception(stop.thrown);
  };
  try {
    Plan found([&](CrannyPlan** plan) { return cranny_plan(scenario.c(), options.c_str(), ask, &stop, plan); });
    rethrow();
    return found;
  } catch (const Error&) {
    rethrow();
    throw;
  }
}

}  // namespace cranny

#endif
