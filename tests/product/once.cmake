# cmake -DROOT=... -P once.cmake: in kernels/ a mesh is prepared, and its masses are measured, in one place each of the
# stages (and those of segments under a tensor field, the surface without doubled faces that distances of points are
# measured from, and the grid over a parametric surface that its samples move on). Tests of the stages see that the
# results are used, not made again; this sees that no stage makes them twice.
set(EXPECTED "kernels/model/stages_of.cpp:measure_of(" "kernels/model/stages_of.cpp:prepare_mesh("
             "kernels/model/tensor_segments.cpp:measure_of(" "kernels/sample/query_points.cpp:prepare_mesh("
             "kernels/surface/relax_on_surface.cpp:measure_of(" "kernels/surface/relax_on_surface.cpp:prepare_mesh(")
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/kernels/*.cpp)
list(REMOVE_ITEM sources kernels/mesh/prepare_mesh.cpp kernels/density/density.cpp)
set(calls "")
foreach(source ${sources})
  file(READ ${ROOT}/${source} text)
  string(REGEX REPLACE "//[^\n]*" "" text "${text}")
  string(REGEX MATCHALL "[^a-z_](prepare_mesh|measure_of)\\(" found "${text}")
  foreach(call ${found})
    string(SUBSTRING ${call} 1 -1 name)
    list(APPEND calls "${source}:${name}")
  endforeach()
endforeach()
list(SORT calls)
if(NOT "${calls}" STREQUAL "${EXPECTED}")
  list(JOIN calls "\n  " calls)
  message(FATAL_ERROR "meshes are prepared and masses measured by\n  ${calls}")
endif()
