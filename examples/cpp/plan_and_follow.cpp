// Plans a scenario and follows its trajectory, as a control loop would:
//
//   plan_and_follow 021
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <utility>

#include <cranny/cranny.hpp>

// Stands in for the interface to the drives of your robot: it only stores the commanded position.
class Driver {
 public:
  explicit Driver(cranny::Configuration start) : position_(std::move(start)) {}
  void command(const cranny::State& state) { position_ = state.position; }
  const cranny::Configuration& position() const { return position_; }

 private:
  cranny::Configuration position_;
};

int main(int count, char** words) try {
  const cranny::Scenario scenario(count > 1 ? words[1] : "021");
  const cranny::Plan plan = cranny::plan(scenario, {{"seed", 7}, {"margin_m", 0.001}, {"time_limit_s", 10.0}});
  if (!plan) {
    std::printf("%s: %s\n", scenario.id().c_str(), plan.outcome().c_str());
    return 1;
  }
  std::printf("%s: grasp %lld by %s, %zu way points, %.2f s, %.2f mm clear along the whole path\n", scenario.id().c_str(),
              static_cast<long long>(plan.grasp()), plan.planner().c_str(), plan.path().rows(), plan.duration_s(),
              1e3 * plan.clearance_m());

  // The loop: every 8 ms the state of that instant. The trajectory keeps the limits of speed, acceleration and jerk.
  const cranny::Cell cell = scenario.cell();
  Driver driver(scenario.start());
  std::size_t cycles = 0;
  for (double time_s = 0; time_s < plan.duration_s() + 0.008; time_s += 0.008, ++cycles) {
    driver.command(plan.at(time_s));
    if (!cell.is_free(driver.position())) throw std::runtime_error("a state of the trajectory is not free");
  }

  // At the end of the trajectory, the hand is at the grasp.
  const cranny::Pose hand = scenario.robot().fk(driver.position());
  const cranny::Pose grasp = scenario.grasps().pose(static_cast<std::size_t>(plan.grasp()));
  std::printf("%zu cycles; the hand is %.2f mm from the grasp\n", cycles,
              1e3 * std::hypot(hand[3] - grasp[3], hand[7] - grasp[7], hand[11] - grasp[11]));
  return 0;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "plan_and_follow: %s\n", fault.what());
  return 1;
}
