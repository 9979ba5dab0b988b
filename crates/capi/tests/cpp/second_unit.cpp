// A second file with the wrapper: its functions are inline, so that a program of several files links.
#include <cranny/cranny.hpp>

std::size_t joints_of(const cranny::Robot& robot) { return robot.dof(); }
