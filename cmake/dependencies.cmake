# Every library prehend builds with, as one imported target each. What each is for: README.md.
# All are global, so that a project that adds this one can link what links them.

set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)
set(CMAKE_THREAD_PREFER_PTHREAD ON)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Protobuf REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(embree 3 REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(Ceres REQUIRED)
if(PREHEND_BUILD_TESTS)
  find_package(GTest REQUIRED)
endif()
if(PREHEND_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()

pkg_check_modules(EIGEN REQUIRED IMPORTED_TARGET GLOBAL eigen3)
pkg_check_modules(ZMQ REQUIRED IMPORTED_TARGET GLOBAL libzmq)
# "-isystem folder" among its flags: the first configuration makes it an include folder, later ones,
# from the cache, an option, and a third of the tree would be compiled anew.
set_target_properties(PkgConfig::ZMQ PROPERTIES INTERFACE_COMPILE_OPTIONS "")
get_target_property(ZMQ_FOLDERS PkgConfig::ZMQ INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER ZMQ_FOLDERS EXCLUDE REGEX "mit-krb5|NOTFOUND")
set_target_properties(PkgConfig::ZMQ PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ZMQ_FOLDERS}")
pkg_check_modules(FLANN REQUIRED IMPORTED_TARGET GLOBAL flann)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET GLOBAL fftw3f)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET GLOBAL liblz4)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET GLOBAL libzstd)
pkg_check_modules(ASSIMP REQUIRED IMPORTED_TARGET GLOBAL assimp)
pkg_check_modules(FCL REQUIRED IMPORTED_TARGET GLOBAL fcl)
pkg_check_modules(URDFDOM REQUIRED IMPORTED_TARGET GLOBAL urdfdom)
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET GLOBAL sqlite3)
pkg_check_modules(CRYPTO REQUIRED IMPORTED_TARGET GLOBAL libcrypto)
pkg_check_modules(HIGHWAY REQUIRED IMPORTED_TARGET GLOBAL libhwy)
pkg_check_modules(MODBUS REQUIRED IMPORTED_TARGET GLOBAL libmodbus)
pkg_check_modules(NCURSES REQUIRED IMPORTED_TARGET GLOBAL ncurses)
# What it defines g++ defines, too, and precompiled headers do not.
set_target_properties(PkgConfig::NCURSES PROPERTIES INTERFACE_COMPILE_OPTIONS "")
pkg_check_modules(OPENNI REQUIRED IMPORTED_TARGET GLOBAL libopenni2)

# PCL's and OpenCV's own CMake packages drag in VTK and Qt; only these single libraries are used.
# prehend_find_library(target header-folder probe-header library): an INTERFACE target.
function(prehend_find_library TARGET INCLUDE_FOLDER PROBE LIBRARY)
  string(MAKE_C_IDENTIFIER ${TARGET} VARIABLE)
  find_path(${VARIABLE}_INCLUDE ${PROBE} PATH_SUFFIXES ${INCLUDE_FOLDER} REQUIRED)
  find_library(${VARIABLE}_LIBRARY ${LIBRARY} REQUIRED)
  add_library(${TARGET} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${TARGET} SYSTEM INTERFACE ${${VARIABLE}_INCLUDE})
  target_link_libraries(${TARGET} INTERFACE ${${VARIABLE}_LIBRARY} ${ARGN})
endfunction()

prehend_find_library(glpk "" glpk.h glpk)
prehend_find_library(qhull "" libqhull_r/qhull_ra.h qhull_r)
prehend_find_library(ompl ompl-1.5 ompl/base/Planner.h ompl)
prehend_find_library(bullet::linear_math bullet LinearMath/btConvexHullComputer.h LinearMath)
prehend_find_library(bullet::collision bullet BulletCollision/NarrowPhaseCollision/btGjkEpa2.h
                     BulletCollision bullet::linear_math)
prehend_find_library(bullet::hacd bullet HACD/hacdHACD.h HACD bullet::linear_math)
prehend_find_library(bullet::convex_decomposition bullet
                     ConvexDecomposition/ConvexDecomposition.h ConvexDecomposition
                     bullet::linear_math)
foreach(module core imgproc calib3d imgcodecs videoio aruco)
  prehend_find_library(opencv::${module} opencv4 opencv2/${module}.hpp opencv_${module})
endforeach()
foreach(module common io kdtree search sample_consensus filters features segmentation surface)
  prehend_find_library(pcl::${module} pcl-1.13 pcl/pcl_base.h pcl_${module} PkgConfig::EIGEN)
endforeach()
