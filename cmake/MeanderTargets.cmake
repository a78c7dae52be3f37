# Flags that every target of the project shares.
#
# A fixed baseline (hot kernels dispatch at run time); contraction of a*b+c is off and there is no fast-math, so that the
# bytes are the same on every machine.
add_library(meander_flags INTERFACE)
target_compile_options(meander_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  set(MEANDER_X86 ON)
  target_compile_options(meander_flags INTERFACE -march=x86-64-v2)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  # char as on x86; without the macro Eigen does not contract by intrinsics either.
  target_compile_options(meander_flags INTERFACE -march=armv8-a+crc -fsigned-char -U__ARM_FEATURE_FMA)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Vectors of OpenMesh that it copies before they have values, and a change of GCC 10.1 that concerns nobody.
    target_compile_options(meander_flags INTERFACE -Wno-maybe-uninitialized -Wno-psabi)
  endif()
else()
  message(FATAL_ERROR "Meander is built for x86-64 and AArch64, not for ${CMAKE_SYSTEM_PROCESSOR}")
endif()
if(NOT MEANDER_SANITIZE)
  # So that the linker can leave out what is not called, and the libraries that only that needs: of HDF5, whose archive
  # is for programs alone, libmeander.so calls nothing.
  target_compile_options(meander_flags INTERFACE -ffunction-sections -fdata-sections)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 reports overlapping copies inside std::string concatenation that cannot happen (GCC bug 105651).
  target_compile_options(meander_flags INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # Members and templates of one source that nothing calls. GCC, and -Wall of either, tell of functions alone.
  target_compile_options(meander_flags INTERFACE -Wunused-member-function -Wunused-template)
endif()
if(CMAKE_UNITY_BUILD)
  # Among the sources of a unity, a local name may be that of another source's constant.
  target_compile_options(meander_flags INTERFACE
    -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local;-Wno-subobject-linkage>)
endif()
if(MEANDER_WERROR)
  target_compile_options(meander_flags INTERFACE -Werror)
endif()
if(MEANDER_SANITIZE)
  target_compile_options(meander_flags INTERFACE -fsanitize=${MEANDER_SANITIZE} -fno-omit-frame-pointer
                                                 -fno-sanitize-recover=all)
  target_link_options(meander_flags INTERFACE -fsanitize=${MEANDER_SANITIZE})
  # The distribution's TBB is built without type information for its tasks: every downcast in its headers would be reported.
  target_compile_options(meander_flags INTERFACE -fno-sanitize=vptr)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Instrumented code hides from GCC that variables are set (GCC manual, -fsanitize): the release build still warns.
    target_compile_options(meander_flags INTERFACE -Wno-maybe-uninitialized)
  elseif(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    target_compile_options(meander_flags INTERFACE
      -fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/sanitize_ignore.txt)
    # The tests are nearly sixty programs of some 50 MB each: lld links one in a quarter of the time.
    find_program(MEANDER_LLD ld.lld)
    mark_as_advanced(MEANDER_LLD)
    if(MEANDER_LLD)
      target_link_options(meander_flags INTERFACE -fuse-ld=lld)
    endif()
  endif()
endif()

# meander_library(NAME): a static library of the project, exported as meander::NAME.
function(meander_library name)
  add_library(meander_${name} STATIC)
  add_library(meander::${name} ALIAS meander_${name})
  set_target_properties(meander_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(meander_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(meander_${name} PUBLIC cxx_std_20)
  target_link_libraries(meander_${name} PRIVATE $<BUILD_INTERFACE:meander_flags>)
endfunction()

# meander_group_sources(TARGET...): in a unity build (CMAKE_UNITY_BUILD), about sixteen sources are compiled together:
# those of one folder, and those of neighboring folders of a target that have fewer than eight each, since what they all
# include takes two seconds to read. Sources of one group must not give two meanings to one name. Every other build compiles
# each source for itself.
function(meander_group_sources)
  foreach(target ${ARGN})
    get_target_property(sources ${target} SOURCES)
    get_target_property(base ${target} SOURCE_DIR)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
    set(paths)
    set(folders)
    foreach(source IN LISTS sources)
      cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${base} NORMALIZE)
      cmake_path(GET source PARENT_PATH folder)
      cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
      list(APPEND paths "${source}")
      list(APPEND folders "${folder}")
    endforeach()
    set(neighborhoods)
    foreach(folder IN LISTS folders)
      meander_count(size "${folder}" ${folders})
      if(size LESS 8)
        if(folder MATCHES "/")
          cmake_path(GET folder PARENT_PATH folder)
        endif()
        string(APPEND folder "_small")
      endif()
      string(MAKE_C_IDENTIFIER "${folder}" folder)
      list(APPEND neighborhoods "${folder}")
      set(count_${folder} 0)
    endforeach()
    foreach(source folder IN ZIP_LISTS paths neighborhoods)
      meander_count(size "${folder}" ${neighborhoods})
      math(EXPR groups "(${size} + 8) / 16")
      math(EXPR group "${count_${folder}} * ${groups} / ${size}")
      math(EXPR count_${folder} "${count_${folder}} + 1")
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${folder}_${group})
    endforeach()
  endforeach()
endfunction()

# meander_count(RESULT ITEM LIST...): how often the item is in the list.
function(meander_count result item)
  set(alike ${ARGN})
  list(FILTER alike INCLUDE REGEX "^${item}$")
  list(LENGTH alike size)
  set(${result} ${size} PARENT_SCOPE)
endfunction()

# What most sources include, or headers of theirs do. Compiled once for the sources of a target in a unity build, it takes
# two fifths off the time of tests. Other builds (preset product) find what a source forgets to include.
set(MEANDER_COMMON_HEADERS
  <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <filesystem> <functional> <limits> <map> <memory> <mutex> <numeric>
  <optional> <random> <set> <span> <stdexcept> <string> <string_view> <utility> <vector>
  <oneapi/tbb/blocked_range.h> <oneapi/tbb/parallel_for.h> <oneapi/tbb/task_arena.h> <oneapi/tbb/task_group.h>)

# meander_precompile(TARGET [HEADERS...]): these and the common headers.
function(meander_precompile target)
  if(CMAKE_UNITY_BUILD)
    target_precompile_headers(${target} PRIVATE ${MEANDER_COMMON_HEADERS} ${ARGN})
  endif()
endfunction()

# meander_precompile_as(TARGET OWNER): what OWNER, which has the same flags, has compiled.
function(meander_precompile_as target owner)
  if(CMAKE_UNITY_BUILD)
    target_precompile_headers(${target} REUSE_FROM ${owner})
  endif()
endfunction()

# meander_laboratory_library(NAME): a meander_library for a library that the product must not need (MeanderLaboratory.cmake).
function(meander_laboratory_library name)
  meander_library(${name})
  set_property(GLOBAL APPEND PROPERTY MEANDER_LABORATORY_TARGETS meander_${name})
endfunction()
