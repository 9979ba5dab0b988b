// OMPL's RRTConnect with Cranny's checks: a state is valid if the cell is free there, a motion if all of it is proven free.
// The path is printed as lines of comma-separated joint values, the form that campaigns read (docs/exec_protocol.md):
//
//   ompl_planner 021 1 10
//   cranny bench run --scenarios 021 --planner "ompl=exec:./ompl_planner {cranny} {seed} {time_limit_s}" -o results.db
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <cranny/cranny.hpp>

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace {

// Share of the time limit for the search for goals. Where most grasps lie beyond a wall, the best ones alone are not enough.
constexpr double kGoalShare = 0.2;

// Maximum length of a motion of the trees, in radians and metres: proofs of longer ones fail among obstacles.
constexpr double kRange = 0.3;

// Seconds of the time limit that are reserved for the end of the process.
constexpr double kReserve_s = 0.1;

// The values of a state are contiguous in memory, as Cranny reads them.
cranny::span<const double> row(const ob::State* state, std::size_t dof) {
  return {state->as<ob::RealVectorStateSpace::StateType>()->values, dof};
}

// Accepts a motion only if all of it is proven free.
class Proof : public ob::MotionValidator {
 public:
  Proof(const ob::SpaceInformationPtr& space, cranny::Cell cell)
      : MotionValidator(space), cell_(std::move(cell)), dof_(space->getStateDimension()) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return cell_.motion_is_free(row(a, dof_), row(b, dof_));
  }

  // For planners that stop at an obstacle: the last state before it.
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last_valid) const override {
    const cranny::Motion motion = cell_.motion(row(a, dof_), row(b, dof_));
    if (motion) return true;
    // The motion up to that state was not proven by itself: try half of it, otherwise keep only the start.
    last_valid.second = std::isnan(motion.at) ? 0 : 0.5 * motion.at;
    ob::ScopedState<> half(si_->getStateSpace());
    si_->getStateSpace()->interpolate(a, b, last_valid.second, half.get());
    if (!checkMotion(a, half.get())) last_valid.second = 0;
    if (last_valid.first) si_->getStateSpace()->interpolate(a, b, last_valid.second, last_valid.first);
    return false;
  }

 private:
  cranny::Cell cell_;
  std::size_t dof_;
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// One configuration for each grasp that has one, the best grasps first, within a time limit.
cranny::Rows goals(const cranny::Scenario& scenario, const cranny::Cell& cell, unsigned seed, double limit_s) {
  const Clock::time_point begin = Clock::now();
  const cranny::Robot robot = scenario.robot();
  const cranny::Grasps grasps = scenario.grasps();
  cranny::Rows found;
  for (const std::size_t grasp : grasps.by_score()) {
    if (found.rows() > 0 && seconds_since(begin) > limit_s) break;
    // A seed for each, or all would be solved from the same side.
    const cranny::Rows q = robot.ik(grasps.pose(grasp), 1, &cell, seed * grasps.size() + grasp, 100);
    if (q.rows() == 1) found.push_back(q[0]);
  }
  return found;
}

ob::StateSpacePtr space_of(const cranny::Robot& robot) {
  const auto space = std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(robot.dof()));
  const cranny::Robot::Limits limits = robot.limits();
  ob::RealVectorBounds bounds(static_cast<unsigned>(robot.dof()));
  bounds.low = limits.lower;
  bounds.high = limits.upper;
  space->setBounds(bounds);
  return space;
}

}  // namespace

int main(int count, char** words) try {
  const Clock::time_point begin = Clock::now();
  const std::string what = count > 1 ? words[1] : "021";
  const auto seed = static_cast<unsigned>(count > 2 ? std::strtoul(words[2], nullptr, 10) : 0);
  const double limit_s = count > 3 ? std::strtod(words[3], nullptr) : 10;
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  ompl::RNG::setSeed(seed + 1);

  const cranny::Scenario scenario(what);
  const cranny::Robot robot = scenario.robot();
  const cranny::Cell cell = scenario.cell();
  const std::size_t dof = robot.dof();
  const cranny::Rows ends = goals(scenario, cell, seed, kGoalShare * limit_s);
  if (ends.rows() == 0) return 0;

  og::SimpleSetup setup(space_of(robot));
  const ob::SpaceInformationPtr space = setup.getSpaceInformation();
  setup.setStateValidityChecker([&](const ob::State* state) { return cell.is_free(row(state, dof)); });
  space->setMotionValidator(std::make_shared<Proof>(space, cell));

  const auto state = [&](cranny::span<const double> q) {
    ob::ScopedState<> state(space);
    for (std::size_t joint = 0; joint < dof; ++joint) state[joint] = q[joint];
    return state;
  };
  // OMPL grows trees from all its starts at once, but adds a goal only after the tree of the others has grown, which it never
  // does where the first one is enclosed. So the search is backwards: its starts are the grasps, its goal is the start.
  for (std::size_t end = 0; end < ends.rows(); ++end) setup.addStartState(state(ends[end]));
  setup.setGoalState(state(scenario.start()));
  const auto planner = std::make_shared<og::RRTConnect>(space);
  planner->setRange(kRange);
  setup.setPlanner(planner);

  setup.solve(std::max(0.01, limit_s - kReserve_s - seconds_since(begin)));
  if (!setup.haveExactSolutionPath()) return 0;
  setup.getSolutionPath().reverse();
  for (const ob::State* reached : setup.getSolutionPath().getStates()) {
    const auto q = row(reached, dof);
    for (std::size_t joint = 0; joint < dof; ++joint) std::printf("%s%.17g", joint ? "," : "", q[joint]);
    std::printf("\n");
  }
  return 0;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "ompl_planner: %s\n", fault.what());
  return 1;
}
