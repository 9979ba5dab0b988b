// Failures as exceptions, and owners of handles.
#ifndef CRANNY_DETAIL_ERROR_HPP
#define CRANNY_DETAIL_ERROR_HPP

#include <memory>
#include <stdexcept>
#include <string>

#include <cranny/cranny.h>

namespace cranny {

/// Failure of a call, with the text of the library.
class Error : public std::runtime_error {
 public:
  Error(CrannyStatus status, const char* text) : std::runtime_error(text), status_(status) {}
  CrannyStatus status() const { return status_; }

 private:
  CrannyStatus status_;
};

namespace detail {

inline void check(CrannyStatus status) {
  if (status != CRANNY_STATUS_OK) throw Error(status, cranny_last_error());
}

inline void require_abi() {
  if (cranny_abi_version() != CRANNY_ABI_VERSION)
    throw Error(CRANNY_STATUS_ARGUMENT, "libcranny has another binary interface than the cranny.h of this program");
}

/// Shared owner of the handle that `make` writes.
template <class T, class Make>
std::shared_ptr<const T> shared(void (*free)(T*), Make make) {
  T* handle = nullptr;
  check(make(&handle));
  return std::shared_ptr<const T>(handle, [free](const T* own) { free(const_cast<T*>(own)); });
}

inline const char* c_str(const std::string& text) { return text.empty() ? nullptr : text.c_str(); }

}  // namespace detail

}  // namespace cranny

#endif
