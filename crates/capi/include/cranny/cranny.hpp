// Cranny for C++17: the C API of cranny.h with owners, exceptions, views and, where Eigen is found, maps.
//
// Every failure throws cranny::Error with the text of the library; a negative result (not free, not found, not valid) is no
// failure. Objects own what they refer to and may be destroyed in any order. A Robot, Scenario, Grasps, Plan, Verification or
// Samples never changes; copies are cheap and share it, also between threads. Copy a Cell for each thread.
//
// Configurations are rows: `Rows` owns them, `RowsView` refers to those of the caller (as std::span does), and an Eigen matrix
// with rows in memory order converts to a view. Poses are 4 x 4 matrices, row by row, in the planning frame. Units: m, rad, s.
#ifndef CRANNY_HPP
#define CRANNY_HPP

#include <cranny/detail/arrays.hpp>
#include <cranny/detail/cell.hpp>
#include <cranny/detail/error.hpp>
#include <cranny/detail/options.hpp>
#include <cranny/detail/planning.hpp>

#endif
