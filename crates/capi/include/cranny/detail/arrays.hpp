// Arrays of numbers: views, rows, poses and, where Eigen is found, maps.
#ifndef CRANNY_DETAIL_ARRAYS_HPP
#define CRANNY_DETAIL_ARRAYS_HPP

#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

#if __has_include(<span>) && __cplusplus >= 202002L
#include <span>
#endif
#if !defined(CRANNY_NO_EIGEN) && __has_include(<Eigen/Geometry>)
#include <Eigen/Geometry>
#define CRANNY_HAS_EIGEN 1
#endif

namespace cranny {

#ifdef __cpp_lib_span
using std::span;
#else
/// The part of std::span that this wrapper needs.
template <class T>
class span {
 public:
  span() = default;
  span(T* data, std::size_t size) : data_(data), size_(size) {}
  template <class C, class = decltype(static_cast<T*>(std::declval<C&>().data()))>
  span(C&& values) : data_(values.data()), size_(values.size()) {}
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* begin() const { return data_; }
  T* end() const { return data_ + size_; }
  T& operator[](std::size_t index) const { return data_[index]; }
  T& front() const { return data_[0]; }
  T& back() const { return data_[size_ - 1]; }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};
#endif

using Configuration = std::vector<double>;

/// Homogeneous matrix target_from_source, row by row, in metres.
using Pose = std::array<double, 16>;

/// Pose without rotation.
inline Pose translation(double x, double y, double z) { return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1}; }

/// Rows of numbers that belong to somebody else.
class RowsView {
 public:
  RowsView() = default;
  RowsView(const double* data, std::size_t rows, std::size_t columns) : data_(data), rows_(rows), columns_(columns) {}
  const double* data() const { return data_; }
  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  span<const double> operator[](std::size_t row) const { return {data_ + row * columns_, columns_}; }
  Configuration row(std::size_t row) const { return {data_ + row * columns_, data_ + (row + 1) * columns_}; }

 private:
  const double* data_ = nullptr;
  std::size_t rows_ = 0, columns_ = 0;
};

/// Rows of numbers.
class Rows {
 public:
  Rows() = default;
  Rows(std::size_t rows, std::size_t columns) : values_(rows * columns), rows_(rows), columns_(columns) {}
  explicit Rows(RowsView view)
      : values_(view.data(), view.data() + view.rows() * view.columns()), rows_(view.rows()), columns_(view.columns()) {}
  operator RowsView() const { return {values_.data(), rows_, columns_}; }
  double* data() { return values_.data(); }
  const double* data() const { return values_.data(); }
  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  span<double> operator[](std::size_t row) { return {values_.data() + row * columns_, columns_}; }
  span<const double> operator[](std::size_t row) const { return {values_.data() + row * columns_, columns_}; }

  /// Appends a row; the first one decides the number of columns.
  void push_back(span<const double> row) {
    if (rows_ == 0) columns_ = row.size();
    if (row.size() != columns_) throw std::invalid_argument("cranny::Rows: a row of another length");
    values_.insert(values_.end(), row.data(), row.data() + row.size());
    ++rows_;
  }

  /// Keeps the first rows.
  void truncate(std::size_t rows) {
    rows_ = rows < rows_ ? rows : rows_;
    values_.resize(rows_ * columns_);
  }

 private:
  std::vector<double> values_;
  std::size_t rows_ = 0, columns_ = 0;
};

#ifdef CRANNY_HAS_EIGEN
/// Matrix of Eigen with rows in memory order, as Cranny's arrays.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Map of rows as a matrix, without a copy.
inline Eigen::Map<const RowMatrix> map(RowsView rows) {
  return {rows.data(), static_cast<Eigen::Index>(rows.rows()), static_cast<Eigen::Index>(rows.columns())};
}
inline Eigen::Map<RowMatrix> map(Rows& rows) {
  return {rows.data(), static_cast<Eigen::Index>(rows.rows()), static_cast<Eigen::Index>(rows.columns())};
}

/// View of a matrix, whose rows are configurations, without a copy.
inline RowsView view(const RowMatrix& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())};
}

/// Map of a configuration as a vector, without a copy.
inline Eigen::Map<const Eigen::VectorXd> map(span<const double> q) {
  return {q.data(), static_cast<Eigen::Index>(q.size())};
}

inline Pose pose(const Eigen::Isometry3d& target_from_source) {
  Pose rows;
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data()) = target_from_source.matrix();
  return rows;
}

inline Eigen::Isometry3d isometry(const Pose& rows) {
  Eigen::Isometry3d pose;
  pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data());
  return pose;
}
#endif

}  // namespace cranny

#endif
