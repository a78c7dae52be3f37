# cmake -DROOT=... -DINCLUDES=regex -P includes.cmake: no source of the product includes a header of the laboratory.
file(GLOB_RECURSE sources RELATIVE ${ROOT}
     ${ROOT}/kernels/*.h ${ROOT}/kernels/*.cpp ${ROOT}/io/*.h ${ROOT}/io/*.cpp
     ${ROOT}/pipeline/*.h ${ROOT}/pipeline/*.cpp ${ROOT}/jobs/*.h ${ROOT}/jobs/*.cpp)
list(FILTER sources EXCLUDE REGEX "^(kernels/(analyse|pointset|render)|io/plot|jobs/laboratory)/")
list(LENGTH sources count)
if(count LESS 100)
  message(FATAL_ERROR "only ${count} sources of the product were found in ${ROOT}")
endif()
set(problems "")
foreach(source ${sources})
  file(STRINGS ${ROOT}/${source} found REGEX "${INCLUDES}")
  foreach(line ${found})
    string(APPEND problems "${source}: ${line}\n")
  endforeach()
endforeach()
if(problems)
  message(FATAL_ERROR "the product includes the laboratory:\n${problems}")
endif()
