# Targets of Cranny: cranny::cranny (the C API, a shared library), cranny::static (the same, to be linked into a program) and
# cranny::cpp (the wrapper for C++17). The folder may be moved as a whole.
get_filename_component(cranny_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET cranny::cranny)
  add_library(cranny::cranny SHARED IMPORTED)
  set_target_properties(cranny::cranny PROPERTIES
    IMPORTED_LOCATION "${cranny_PREFIX}/lib/libcranny.so.@MINOR_VERSION@"
    IMPORTED_SONAME "libcranny.so.@MINOR_VERSION@"
    INTERFACE_INCLUDE_DIRECTORIES "${cranny_PREFIX}/include")

  add_library(cranny::static STATIC IMPORTED)
  set_target_properties(cranny::static PROPERTIES
    IMPORTED_LOCATION "${cranny_PREFIX}/lib/libcranny.a"
    INTERFACE_INCLUDE_DIRECTORIES "${cranny_PREFIX}/include"
    INTERFACE_LINK_LIBRARIES "@NATIVE_LIBRARIES@")

  add_library(cranny::cpp INTERFACE IMPORTED)
  set_target_properties(cranny::cpp PROPERTIES
    INTERFACE_COMPILE_FEATURES cxx_std_17
    INTERFACE_LINK_LIBRARIES cranny::cranny)
  # Maps of Eigen are there for programs that find it.
  find_package(Eigen3 QUIET NO_MODULE)
  if(TARGET Eigen3::Eigen)
    set_property(TARGET cranny::cpp APPEND PROPERTY INTERFACE_LINK_LIBRARIES Eigen3::Eigen)
  endif()
endif()

set(cranny_FOUND TRUE)
